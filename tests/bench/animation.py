"""Measures frames per second of baking an armature's frames into a cache, by stage, on a cylinder of 35,000 vertices.

PYTHONPATH=addon python tests/bench/animation.py --json animation.json
PYTHONPATH=addon python tests/bench/animation.py --rings 64 --sides 64 --frames 5 --samples 64

depsgraph is Blender's evaluation; read turns the evaluated mesh into arrays; upload checks positions and hands them to
the library; prepare, bake and evaluate are the library's own; write makes the frame's file. The first frame has a row
of its own, because it builds adjacency and charts, and compiles.
"""

import argparse
import json
import os
import sys
import tempfile
from pathlib import Path

import numpy as np

sys.path[:0] = [str(Path(__file__).resolve().parents[1] / "addon")]

import bpy  # noqa: E402

from animated import bent_cylinder  # noqa: E402
from paradesc import bridge  # noqa: E402
from paradesc.commands.animate import STAGES  # noqa: E402
from paradesc.core import job  # noqa: E402
from paradesc_blender.animation import frames  # noqa: E402


def parse() -> argparse.Namespace:
    """Parses the words of the command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rings", type=int, default=175)
    parser.add_argument("--sides", type=int, default=200)
    parser.add_argument("--frames", type=int, default=20)
    parser.add_argument("--descriptors", default="mean_curvature")
    parser.add_argument("--radius", type=float, default=0.02)
    parser.add_argument("--samples", type=int, default=256)
    parser.add_argument("--buffer", type=int, default=1024)
    parser.add_argument("--normals", default="fitted")
    parser.add_argument("--backend", default="auto")
    parser.add_argument("--json", type=Path)
    return parser.parse_args()


def measure(arguments: argparse.Namespace) -> dict[str, object]:
    """Bakes the frames; gives all times in seconds."""
    target = bent_cylinder(arguments.rings, arguments.sides)
    options = bridge.Options(
        radius=arguments.radius,
        samples=arguments.samples,
        buffer_size=arguments.buffer,
        normals=arguments.normals,
    )
    settings = job.Settings(tuple(arguments.descriptors.split(",")), options, arguments.backend)
    done = []
    with tempfile.TemporaryDirectory() as folder:
        request = frames.FrameRequest(settings, Path(folder))
        with frames.FrameBaker(bpy.context.scene, target, request) as baker:
            for frame in range(1, arguments.frames + 1):
                done.append(baker.run(baker.prepare(frame)))
            size = done[-1].path.stat().st_size
    later = [one.seconds for one in done[1:]]
    median = {stage: float(np.median([seconds[stage] for seconds in later])) for stage in STAGES}
    totals = [sum(seconds.values()) for seconds in later]
    return {
        "vertices": len(target.data.vertices),
        "triangles": len(target.data.loop_triangles),
        "settings": settings.as_dict(),
        "device": done[0].device,
        "blender": bpy.app.version_string,
        "load": os.getloadavg()[0],
        "cores": os.cpu_count(),
        "first_frame": done[0].seconds,
        "median_seconds": median,
        "median_frames_per_second": 1 / float(np.median(totals)),
        "best_frames_per_second": 1 / min(totals),
        "file_bytes": size,
        "meshes_made": baker.stream.made,
    }


def say(line: str) -> None:
    """Prints one line of the table."""
    sys.stdout.write(line + "\n")


def main() -> None:
    """Prints the table."""
    arguments = parse()
    found = measure(arguments)
    say(f"{found['vertices']:,} vertices, {found['device']}, load {found['load']:.1f} on {found['cores']} cores")
    for stage in STAGES:
        first, later = found["first_frame"][stage], found["median_seconds"][stage]
        say(f"  {stage:10}{1000 * later:9.1f} ms   first {1000 * first:9.1f} ms")
    say(f"median {found['median_frames_per_second']:.2f} frames/s, best {found['best_frames_per_second']:.2f}")
    if arguments.json:
        arguments.json.write_text(json.dumps(found, indent=2) + "\n")


if __name__ == "__main__":
    main()
