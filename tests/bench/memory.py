"""Peak memory of a mesh and its computations, each in a process of its own, beside what the library expects.

    PYTHONPATH=addon python tests/bench/memory.py
    PYTHONPATH=addon python tests/bench/memory.py --triangles 1000000 --buffers 1024 --backend reference

Bytes come on top of what the process had with a context, its programs and the mesh's own arrays. "of expected" has to
stay at or below 1, or the limit would let through what does not fit; native/src/compute/memory.cpp has the constants.
"""

import argparse
import ctypes
import json
import subprocess
import sys
from datetime import date

import numpy as np
import timing
from preprocessing_cache import processor, torus

from paradesc.bridge import Context, Options

DESCRIPTORS = ["mean_curvature"]
CHOICES = (
    (DESCRIPTORS, {"precision": "half"}),
    (DESCRIPTORS, {"radius": 0.1}),
    (DESCRIPTORS, {"evaluate": "texel", "texels": 1024, "samples": 8}),
    (DESCRIPTORS, {"relocation": "paper", "samples": 8, "max_jumps": 1}),
    (["harris"], {"samples": 8}),
    (["geodesic_area", "principal_direction_max", "shape_index", "curvedness", "sphere_volume"], {}),
)


def trim() -> None:
    """Gives back what was freed, so that it does not count as memory in use."""
    ctypes.CDLL(None).malloc_trim(0)


def resident() -> int:
    """Bytes in use now; the peak is counted from here."""
    trim()
    return timing.resident()


def measure(case: dict[str, object]) -> dict[str, float]:
    """Measures one mesh and one computation."""
    options = Options(**case["options"])
    descriptors = case["descriptors"]
    mesh = torus(case["triangles"], *case.get("charts", (10, 6)))
    with Context(case["backend"]) as context:
        context.mesh(torus(2000)).compute(descriptors, options).close()
        before = resident()
        native = context.mesh(mesh)
        created = timing.status_bytes("VmHWM") - before
        trim()
        kept = timing.status_bytes("VmRSS") - before
        expected = native.memory(descriptors, options)
        resident()
        with native.compute(descriptors, options) as field:
            computed = timing.status_bytes("VmHWM") - before
            report = field.report()
    given = (mesh.positions, mesh.corner_vertices, mesh.triangle_corners, mesh.corner_uvs)
    return {
        "triangles": len(mesh.triangle_corners),
        "vertices": len(mesh.positions),
        "input": sum(array.nbytes for array in given),
        "create": created,
        "kept": kept,
        "compute": computed,
        "device": 1e6 * report["buffer_megabytes"],
        **expected,
    }


def cases(arguments: argparse.Namespace) -> list[dict[str, object]]:
    """Every number of triangles with every buffer, and every option that takes memory of its own."""
    plain = [
        {"triangles": count, "backend": arguments.backend, "descriptors": DESCRIPTORS, "options": {"buffer_size": size}}
        for count in arguments.triangles
        for size in arguments.buffers
    ]
    if arguments.backend in ("cpu", "reference"):
        return plain[:: len(arguments.buffers)]
    small = {"triangles": min(arguments.triangles), "backend": arguments.backend}
    chosen = [
        {**small, "descriptors": descriptors, "options": {"buffer_size": min(arguments.buffers), **options}}
        for descriptors, options in CHOICES
    ]
    return [*plain, *chosen, {**chosen[0], "charts": (140, 84)}]


def say(line: str) -> None:
    """Prints one line at once."""
    sys.stdout.write(line + "\n")
    sys.stdout.flush()


def main() -> None:
    """Prints a table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--triangles", type=int, nargs="+", default=[100_000, 1_000_000])
    parser.add_argument("--buffers", type=int, nargs="+", default=[512, 1024, 4096])
    parser.add_argument("--backend", default="software", choices=["cpu", "software", "gpu", "reference"])
    parser.add_argument("--case", help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.case:
        say(json.dumps(measure(json.loads(arguments.case))))
        return
    say(f"{processor()}, {date.today()}; MB of 10^6 bytes\n")
    say("| triangles | buffer | options | input | mesh: peak | kept | compute: peak | expected | of expected |")
    say("| --- | --- | --- | --- | --- | --- | --- | --- | --- |")
    for case in cases(arguments):
        command = [sys.executable, __file__, "--case", json.dumps(case)]
        done = subprocess.run(command, check=True, capture_output=True, text=True)
        row = json.loads(done.stdout.splitlines()[-1])
        options = dict(case["options"])
        size = options.pop("buffer_size")
        said = ", ".join([*(f"{key} {value}" for key, value in options.items()), *case["descriptors"][:1]])
        said += f", {np.prod(case['charts'])} charts" if "charts" in case else ""
        expected = row["total"]
        sizes = " | ".join(f"{row[name] / 1e6:.0f}" for name in ("input", "create", "kept", "compute"))
        share = row["compute"] / expected
        say(f"| {row['triangles']:,} | {size} | {said} | {sizes} | {expected / 1e6:.0f} | {share:.2f} |")


if __name__ == "__main__":
    main()
