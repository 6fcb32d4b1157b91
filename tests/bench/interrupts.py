"""Measures how long compute() goes on after Ctrl-C at any moment, on a mesh of a million triangles.

    PYTHONPATH=addon python tests/bench/interrupts.py [--triangles 1000000] [--signals 100] [--mesh] [--polygons]

Another process computes again and again and gets SIGINT at random moments, also while the mesh is made. It measures
from the moment at which the signal was sent until KeyboardInterrupt has reached it. --mesh computes frames of one
paradesc.Mesh instead, --polygons gives quads. Every signal has to arrive, as KeyboardInterrupt and nothing else.
"""

import argparse
import contextlib
import multiprocessing
import os
import random
import signal
import sys
import time

import numpy as np

LIMIT = 0.1  # seconds


def torus(triangles, polygons):
    """Positions and faces of a torus with about so many triangles."""
    along = int(triangles**0.5)
    around = max(3, triangles // (2 * along))
    u, v = np.meshgrid(np.arange(along), np.arange(around), indexing="ij")
    a, b = 2 * np.pi * u / along, 2 * np.pi * v / around
    ring = 1 + 0.4 * np.cos(b)
    points = np.stack([ring * np.cos(a), ring * np.sin(a), 0.4 * np.sin(b)], axis=2).reshape(-1, 3)

    def index(i, j):
        return (i % along) * around + j % around

    quads = np.stack([index(u, v), index(u + 1, v), index(u + 1, v + 1), index(u, v + 1)], axis=2).reshape(-1, 4)
    return points, quads if polygons else np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])


def work(channel, triangles, kept, polygons):
    """Computes until told to stop; answers each signal with the moment at which it was caught, and what was caught."""
    import paradesc

    signal.signal(signal.SIGINT, signal.default_int_handler)
    points, faces = torus(triangles, polygons)
    channel.send("ready")
    while channel.recv() == "go":
        caught = "nothing"
        try:
            mesh = paradesc.Mesh(points, faces) if kept else None
            channel.send("begun")
            while True:
                if kept:
                    mesh.positions = points * 1.01
                    mesh.compute(radius=0.02)
                else:
                    paradesc.compute(points, faces, radius=0.02)
        except BaseException as error:  # noqa: BLE001 (what it is, is the question)
            caught = type(error).__name__
        channel.send((time.monotonic(), caught))


def measure(triangles, signals, seed, kept, polygons):
    """(seconds, what was caught) of each signal."""
    source, context = random.Random(seed), multiprocessing.get_context("spawn")
    ours, theirs = context.Pipe()
    process = context.Process(target=work, args=(theirs, triangles, kept, polygons), daemon=True)
    process.start()
    assert ours.recv() == "ready"
    found = []
    whole = 6.0 * triangles / 1e6
    for _ in range(signals):
        ours.send("go")
        assert ours.poll(60), "the process stands still"
        assert ours.recv() == "begun"
        # half of them while the mesh is made and its arrays are checked
        time.sleep(source.uniform(0, whole if source.random() < 0.5 else whole / 6))
        sent = time.monotonic()
        os.kill(process.pid, signal.SIGINT)
        if not ours.poll(10):
            found.append((10.0, "nothing"))
            break
        at, caught = ours.recv()
        found.append((at - sent, caught))
    with contextlib.suppress(BrokenPipeError):
        ours.send("stop")
    process.join(5)
    process.kill()
    return found


def main(words=None):
    """Prints the longest, and gives 1 if one was too long or caught wrongly."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--triangles", type=int, default=1_000_000)
    parser.add_argument("--signals", type=int, default=100)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--mesh", action="store_true")
    parser.add_argument("--polygons", action="store_true")
    given = parser.parse_args(words)
    found = measure(given.triangles, given.signals, given.seed, given.mesh, given.polygons)
    waits = sorted(seconds for seconds, _ in found)
    wrong = [caught for _, caught in found if caught != "KeyboardInterrupt"]
    sys.stdout.write(
        f"{len(found)} signals: median {1000 * waits[len(waits) // 2]:.0f} ms, "
        f"95 % within {1000 * waits[int(0.95 * len(waits))]:.0f} ms, longest {1000 * waits[-1]:.0f} ms; "
        f"{len(wrong)} not caught as KeyboardInterrupt {sorted(set(wrong))}\n"
    )
    return int(bool(wrong) or waits[-1] > LIMIT)


if __name__ == "__main__":
    sys.exit(main())
