"""Measures how long a bake goes on after a cancel at any time from start to end, on a mesh of a million triangles.

    PYTHONPATH=addon python tests/bench/cancel.py [--triangles 1000000] [--mesh FILE.obj] [--json FILE]
    PYTHONPATH=addon python tests/bench/cancel.py --backends cpu
    PYTHONPATH=addon python tests/bench/cancel.py --descriptors harris --cancels 40

A cancel is noticed at the next call of the progress callback, so the longest time between two calls bounds the wait.
The first table shows that time for each stage of a whole bake. The second cancels a worker
(addon/paradesc/core/threads.py) at many moments spread over the bake, as Esc does, and measures until its thread has
ended. The numbers mean something on a quiet machine only.
"""

import argparse
import json
import platform
import sys
import time
from dataclasses import asdict, dataclass
from datetime import date
from functools import partial
from itertools import pairwise
from pathlib import Path

import numpy as np
from preprocessing_cache import subdivided, torus
from sampling_choices import read_obj

from paradesc import bridge
from paradesc.bridge import ParadescError
from paradesc.core import job
from paradesc.core.threads import Worker

LIMITS = {"software": 0.1, "cpu": 0.05}  # seconds


@dataclass
class Gap:
    """The longest time without a callback that began in a stage."""

    stage: str
    fraction: float
    seconds: float


@dataclass
class Cancel:
    """One cancelled bake."""

    after: float  # seconds from the start
    stage: str  # the last that was reported
    fraction: float
    seconds: float  # from the cancel to the end of the thread


def gaps(arrays: bridge.MeshArrays, settings: job.Settings) -> tuple[list[Gap], float]:
    """The longest gap of each stage in one whole bake, and how long that took."""
    seen = [("start", 0.0, time.perf_counter())]

    def tell(stage: str, fraction: float) -> bool:
        seen.append((stage, fraction, time.perf_counter()))
        return True

    job.run(arrays, settings, tell)
    seen.append(("end", 1.0, time.perf_counter()))
    longest: dict[str, Gap] = {}
    for (stage, fraction, begin), (*_, end) in pairwise(seen):
        if end - begin > longest.get(stage, Gap(stage, 0, 0)).seconds:
            longest[stage] = Gap(stage, fraction, end - begin)
    return list(longest.values()), seen[-1][2] - seen[0][2]


def cancel_after(arrays: bridge.MeshArrays, settings: job.Settings, seconds: float) -> Cancel | None:
    """Cancels a worker after so many seconds; None if it had ended by then."""
    worker = Worker(partial(job.run, arrays, settings))
    time.sleep(seconds)
    if worker.done:
        return None
    stage, fraction = worker.stage, worker.fraction
    begin = time.perf_counter()
    worker.cancel()
    try:
        worker.result()
    except ParadescError:
        return Cancel(seconds, stage, fraction, time.perf_counter() - begin)
    raise AssertionError("A cancelled worker gave results.")


def main(words: list[str] | None = None) -> int:
    """Prints both tables of every backend; gives 1 if a wait is too long."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--triangles", type=int, default=1_000_000)
    parser.add_argument("--mesh", type=Path, help="a .obj, subdivided, instead of a torus")
    parser.add_argument("--backends", default=",".join(LIMITS))
    parser.add_argument("--descriptors", default="mean_curvature")
    parser.add_argument("--radius", type=float, default=0.02)
    parser.add_argument("--cancels", type=int, default=20)
    parser.add_argument("--json", type=Path)
    asked = parser.parse_args(words)
    arrays = subdivided(read_obj(asked.mesh), asked.triangles) if asked.mesh else torus(asked.triangles)
    options, names = bridge.Options(radius=asked.radius), tuple(asked.descriptors.split(","))
    every = {
        backend: measure(arrays, job.Settings(names, options, backend), asked.cancels)
        for backend in asked.backends.split(",")
    }
    if asked.json:
        machine = platform.processor() or platform.machine()
        asked.json.write_text(json.dumps({"backends": every, "machine": machine}, indent=1))
    return int(any(found["longest"] > LIMITS.get(backend, max(LIMITS.values())) for backend, found in every.items()))


def measure(arrays: bridge.MeshArrays, settings: job.Settings, count: int) -> dict[str, object]:
    """Prints both tables of one backend, and gives them."""
    found, whole = gaps(arrays, settings)
    out = sys.stdout.write
    out(f"{len(arrays.triangle_corners):,} triangles, {settings.backend}, {whole:.2f} s in all, {date.today()}\n\n")
    out("stage      longest without a callback\n")
    for gap in found:
        out(f"{gap.stage:10s} {1000 * gap.seconds:6.0f} ms at {gap.fraction:.2f}\n")
    cancels = []
    out("\ncancelled after   in stage           waited\n")
    for moment in np.linspace(0, whole, count, endpoint=False):
        if cancel := cancel_after(arrays, settings, float(moment)):
            cancels.append(cancel)
            out(
                f"{cancel.after:9.2f} s       {cancel.stage:9s} {cancel.fraction:.2f} {1000 * cancel.seconds:8.0f} ms\n"
            )
            sys.stdout.flush()
    longest = max((cancel.seconds for cancel in cancels), default=0.0)
    out(f"\nlongest wait: {1000 * longest:.0f} ms\n\n")
    return {
        "gaps": [asdict(gap) for gap in found],
        "cancels": [asdict(item) for item in cancels],
        "seconds": whole,
        "longest": longest,
    }


if __name__ == "__main__":
    sys.exit(main())
