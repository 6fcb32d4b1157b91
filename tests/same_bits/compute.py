"""Writes a file of arrays for each mesh: all that one tree's library gives for all cases, on the software device.

Usage: compute.py TREE FOLDER [--quick] [--grid] [--meshes FOLDER] [--only NAMES]
same_bits.sh runs it once for each tree, with that tree's add-on as the way to its library. It needs numpy, not bpy.
"""

import argparse
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np

import cases
import inputs
from paradesc import bridge

ROOT = Path(__file__).resolve().parents[2]
MESHES = ROOT.parent / "shared" / "meshes"
QUICK_MESHES = ("fox", "pirate", "spot")
# These depend on the clock, or forecast memory and are no results.
LEFT_OUT = ("seconds_", "memory_megabytes")
FEW = 1000  # triangles; on smaller meshes every descriptor is also computed alone
SMALL = 6000  # triangles; smaller meshes are also computed by the reference, and with slow options


def arguments() -> argparse.Namespace:
    """Parses the words of the command."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("tree", type=Path)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--grid", action="store_true")
    parser.add_argument("--meshes", type=Path, default=MESHES)
    parser.add_argument("--only", default="")
    return parser.parse_args()


def files(asked: argparse.Namespace) -> list[Path]:
    """The meshes to compute."""
    only = set(filter(None, asked.only.split(","))) or (set(QUICK_MESHES) if asked.quick else set())
    found = sorted(path for path in asked.meshes.rglob("*") if path.suffix in (".obj", ".glb"))
    return [path for path in found if not only or path.stem in only]


class Recorder:
    """Arrays by "case | what", from one mesh of one tree."""

    def __init__(self, contexts: dict[str, bridge.Context], quick: bool, grid: bool) -> None:
        self.contexts, self.quick, self.grid = contexts, quick, grid
        self.arrays: dict[str, np.ndarray] = {}
        self.whole, self.small = (cases.QUICK, cases.QUICK) if quick else (cases.WHOLE, cases.SMALL)
        self.rows = bridge.descriptors()

    def keep(self, case: str, what: str, values: object) -> None:
        """Adds an array; numbers and sentences become arrays."""
        if isinstance(values, str):
            values = np.frombuffer(values.encode(), np.uint8)
        self.arrays[f"{case} | {what}"] = np.asarray(values)

    def keep_report(self, case: str, what: str, report: dict[str, Any]) -> None:
        """Adds a report's members except times."""
        for name, value in report.items():
            if not name.startswith(LEFT_OUT):
                self.keep(case, f"{what}.{name}", value)

    def compute(self, mesh: bridge.Mesh, case: cases.Case) -> None:
        """Adds what one computation gives, or the sentence of its refusal."""
        options = bridge.Options(**case.options)
        texels = options.evaluate == "texel" and case.backend != "reference"
        names = [case.alone] if case.alone else [row.name for row in self.rows if not (texels and row.map_degree)]
        try:
            field = mesh.compute(names, options)
        except bridge.ParadescError as error:
            self.keep(case.name, "status", error.status)
            self.keep(case.name, "sentence of refusal", error.sentence)
            return
        with field:
            self.keep(case.name, "status", 0)
            maps = texels and field.report()["places"] > 0  # else there is no map
            for name in [*names, "coverage"]:
                self.keep(case.name, name, field.values(name))
                if maps:
                    self.keep(case.name, f"map of {name}", field.map(name))
            self.keep(case.name, "mask", field.mask())
            self.keep_report(case.name, "field", field.report())
            self.keep(case.name, "sentences of warning", "\n".join(field.warnings()))
            self.keep(case.name, "warnings", len(field.warnings()))
        if case.buffers:
            self.buffers(mesh, case.name)

    def buffers(self, mesh: bridge.Mesh, case: str) -> None:
        """Adds what was baked."""
        for name in bridge.BUFFERS:
            self.keep(case, f"buffer {name}", mesh.read_buffer(name))
        self.keep(case, "layout", mesh.layout())
        self.keep(case, "near_seam", mesh.near_seam(0.02 * mesh.report()["diagonal"]))

    def on_device(self, arrays: bridge.MeshArrays) -> None:
        """Computes every case of the software device."""
        todo = cases.grid(self.whole)
        slow = not self.quick and len(arrays.triangle_corners) <= SMALL
        if not self.grid:
            todo += cases.others(self.small, tuple(inputs.CHANGES), slow)
        if not self.grid and not self.quick and len(arrays.triangle_corners) <= FEW:
            todo += cases.singly(self.small, [row.name for row in self.rows])
        with self.contexts["software"].mesh(arrays) as mesh:
            self.keep_report("mesh", "report", mesh.report())
            for case in todo:
                if case.change:
                    inputs.CHANGES[case.change](mesh, arrays)
                self.compute(mesh, case)
                if case.change:
                    self.keep_report(case.name, "mesh", mesh.report())
                    inputs.undo(mesh, arrays)
        if not self.grid:
            with self.contexts["software"].mesh(inputs.shaded(arrays)) as mesh:
                for normals in ("fitted", "max"):
                    given = self.small | {"normals": normals}
                    name = f"flat faces and sharp edges, normals {normals}"
                    self.compute(mesh, cases.Case(name, given, buffers=True))

    def on_reference(self, arrays: bridge.MeshArrays) -> None:
        """Computes every case of the reference, on a small mesh."""
        if self.grid or len(arrays.triangle_corners) > (FEW if self.quick else SMALL):
            return
        with self.contexts["reference"].mesh(arrays) as mesh:
            for case in cases.on_reference(self.small):
                self.compute(mesh, case)
            mesh.set_positions(inputs.bent(arrays))
            options = self.small | {"radius": cases.RADII[0]}
            self.compute(mesh, cases.Case("reference, moved", options, backend="reference"))

    def record(self, arrays: bridge.MeshArrays) -> None:
        """Computes everything for one mesh."""
        try:
            self.on_device(arrays)
            self.on_reference(arrays)
        except bridge.InputError as error:
            self.keep("mesh", "status", error.status)
            self.keep("mesh", "sentence of refusal", error.sentence)


def compute_file(path: Path, folder: Path, contexts: dict[str, bridge.Context], asked: argparse.Namespace) -> None:
    """Writes the file of one mesh, which appears only when it is whole."""
    start = time.perf_counter()
    recorder = Recorder(contexts, asked.quick, asked.grid)
    recorder.record(inputs.read(path))
    part = folder / f"{path.stem}.part"
    with part.open("wb") as file:
        np.savez(file, **recorder.arrays)
    part.rename(folder / f"{path.stem}.npz")
    sys.stdout.write(f"  {path.stem}: {len(recorder.arrays):,d} arrays in {time.perf_counter() - start:.1f} s\n")
    sys.stdout.flush()


def main() -> int:
    """Writes a file for each mesh that has none yet."""
    asked = arguments()
    used = Path(bridge.__file__).resolve()
    if not used.is_relative_to(asked.tree.resolve()):
        sys.stderr.write(f"The add-on of {asked.tree} is wanted, but Python found {used}.\n")
        return 2
    paths = files(asked)
    if not paths:
        sys.stderr.write(f"There is no mesh in {asked.meshes}.\n")
        return 2
    asked.folder.mkdir(parents=True, exist_ok=True)
    np.seterr(all="ignore")  # malformed meshes cause them
    with bridge.Context("software") as software, bridge.Context("reference") as reference:
        sys.stdout.write(f"{asked.tree}: {software.device}\n")
        for path in paths:
            if not (asked.folder / f"{path.stem}.npz").is_file():
                compute_file(path, asked.folder, {"software": software, "reference": reference}, asked)
    return 0


if __name__ == "__main__":
    sys.exit(main())
