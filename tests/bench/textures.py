"""Times the textures of a mesh as Bake to Image makes them, and compares them with those of evaluating each texel.

    PYTHONPATH=addon python tests/bench/textures.py human.obj
    PYTHONPATH=addon python tests/bench/textures.py human.obj --each --descriptors cavity,convexity,ambient_openness

Each turn computes anew from arrays, and ends with the bytes of the files. Seconds are by the clock and of all cores
together, because other programs may use these cores too.
"""

import argparse
import sys
import time
from pathlib import Path

import numpy as np
from sampling_choices import read_obj

from paradesc.bridge import MeshArrays, Options
from paradesc.core import job, texel_centers
from paradesc.files import image_files
from paradesc.files.results import Baked


def now() -> np.ndarray:
    """Seconds by the clock, and of all cores."""
    return np.array([time.perf_counter(), time.process_time()])


def turn(arrays: MeshArrays, settings: job.Settings, size: int) -> tuple[Baked, list[bytes], np.ndarray]:
    """The results and files, and the seconds (3, 2) of computing, of drawing and packing, and of both."""
    times = [now()]
    baked = Baked("", texel_centers.run(arrays, settings, size), arrays, np.eye(4))
    times.append(now())
    made = [image_files.encoded(baked, [name], size).content for name in settings.descriptors]
    times.append(now())
    steps = np.diff(times, axis=0)
    return baked, made, np.concatenate([steps, steps.sum(axis=0, keepdims=True)])


def compare(few: Baked, each: Baked, size: int) -> None:
    """Prints how far the pixels of both are apart, in percent of white."""
    for name in few.results.values:
        one, other = (image_files.drawn(baked, name, size) for baked in (few, each))
        apart = np.abs(one.values.astype(np.float32) - other.values)[one.filled] / 655.35
        far = np.percentile(apart, 99)
        sys.stdout.write(
            f"{name}: {apart.mean():.4f} % of white apart in the mean, {far:.3f} % in the 99th percentile\n"
        )


def main() -> None:
    """Prints the medians of both ways, and their difference."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("mesh", type=Path)
    parser.add_argument("--descriptors", default="mean_curvature", metavar="A,B,C")
    parser.add_argument("--radius", type=float, default=0.02)
    parser.add_argument("--samples", type=int, default=256)
    parser.add_argument("--texels", type=int, default=4096)
    parser.add_argument("--turns", type=int, default=3)
    parser.add_argument("--each", action="store_true", help="also evaluate each texel, and compare")
    given = parser.parse_args()
    arrays = read_obj(given.mesh)
    found = {}
    for evaluate in ("vertex", "texel")[: 1 + given.each]:
        options = Options(radius=given.radius, samples=given.samples, evaluate=evaluate)
        settings = job.Settings(tuple(given.descriptors.split(",")), options, "cpu")
        turns = [turn(arrays, settings, given.texels) for _ in range(given.turns if evaluate == "vertex" else 1)]
        baked, made, _ = turns[-1]
        found[evaluate] = baked
        seconds = np.median([times for _, _, times in turns], axis=0)
        title = "fewer centers" if evaluate == "vertex" else "each texel"
        sys.stdout.write(
            f"{title}: {baked.results.field_report['places']:,} places, {sum(map(len, made)) / 1e6:.1f} MB\n"
        )
        for step, (clock, cores) in zip(("compute", "draw and pack", "together"), seconds, strict=True):
            sys.stdout.write(f"  {step}: {clock:.2f} s, of all cores {cores:.2f} s\n")
    if given.each:
        compare(found["vertex"], found["texel"], given.texels)


if __name__ == "__main__":
    main()
