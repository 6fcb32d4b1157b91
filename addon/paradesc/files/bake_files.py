"""Runs one bake with its files, images over the UV map and the baked buffers, kept aside until all is done. No bpy."""

import shutil
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from .. import bridge
from ..bridge import ParadescError, abi
from ..core import job, texel_tiles, udim
from ..core.threads import go_on
from . import maps, tile_names
from .results import Baked, file_fault, folder_fault, part_path

# The computation has this share of the progress if files follow.
COMPUTING = 0.8


@dataclass
class Files:
    """The files of one object's bake: where they go, and where they are written first."""

    object_name: str
    matrix_world: np.ndarray  # (4, 4)
    image: Path | None = None
    buffers: Path | None = None
    aside: list[tuple[Path, Path]] = field(default_factory=list)  # pairs of temporary and final place

    @property
    def any(self) -> bool:
        """Whether the bake writes any file."""
        return self.image is not None or self.buffers is not None

    def part(self, path: Path) -> Path:
        """A place beside the final one, where a file or folder is written first."""
        place = part_path(path)
        self.aside.append((place, path))
        return place

    def commit(self) -> list[Path]:
        """Moves all files to their places; returns their paths."""
        placed = []
        for place, path in self.aside:
            if place.is_dir():
                path.mkdir(exist_ok=True)
                for item in place.iterdir():
                    item.replace(path / item.name)
                place.rmdir()
            else:
                place.replace(path)
            placed.append(path)
        self.aside.clear()
        return placed

    def discard(self) -> None:
        """Removes the files that are not in their places yet; earlier files stay."""
        for place, _ in self.aside:
            if place.is_dir():
                shutil.rmtree(place, ignore_errors=True)
            else:
                place.unlink(missing_ok=True)
        self.aside.clear()


def check(files: Files, arrays: bridge.MeshArrays, backend: str) -> None:
    """Raises if the files cannot be written, before anything is computed."""
    if files.image is not None and arrays.map_fault:
        raise refuse(f"The mesh {arrays.map_fault}, and an image needs one; unwrap it, or switch the image off.")
    if files.buffers is not None and backend != "auto" and not bridge.uses_texture_space(backend):
        raise refuse(f"The backend {backend} bakes no buffers to write; choose another device, or switch them off.")
    faults = [file_fault(files.image) if files.image else "", folder_fault(files.buffers) if files.buffers else ""]
    for fault in filter(None, faults):
        raise refuse(fault)


def refuse(sentence: str) -> ParadescError:
    """The error for files that cannot be written."""
    return ParadescError(abi.STATUS_INVALID_ARGUMENT, sentence)


def run(
    files: Files, arrays: bridge.MeshArrays, settings: job.Settings, progress: bridge.ProgressFunction | None
) -> job.Results:
    """Runs job.run(), then writes the files aside; the caller commits or discards them."""
    if not files.any:
        return job.run(arrays, settings, progress)
    tiles = udim.of_mesh(arrays).tiles if files.image is not None else ()
    report = progress or (lambda _stage, _fraction: True)
    part = None if progress is None else lambda stage, fraction: progress(stage, COMPUTING * fraction)
    results = texel_tiles.run_where_asked(arrays, settings, tiles, part, files.buffers is not None)
    try:
        write(files, Baked(files.object_name, results, arrays, files.matrix_world), report)
    except OSError as error:
        raise refuse(f"A file cannot be written ({error.strerror or error}): {error.filename}.") from error
    return results


def write(files: Files, baked: Baked, report: bridge.ProgressFunction) -> None:
    """Writes image and buffers aside; between them it asks whether to go on."""
    go_on(report, "write images", COMPUTING)
    if files.image is not None:
        write_images(files, files.image, baked, report)
    if files.buffers is not None:
        go_on(report, "write buffers", COMPUTING + 0.1)
        maps.write_buffers(files.part(files.buffers), baked)
        go_on(report, "write buffers", 1.0)


def write_images(files: Files, image: Path, baked: Baked, report: bridge.ProgressFunction) -> None:
    """Writes the images of each UDIM tile aside, or the only ones."""
    results, tiling = baked.results, udim.of_mesh(baked.arrays)
    tiles, as_png = tiling.tiles or (None,), image.suffix == ".png"
    writing = job.span_of(report, COMPUTING, COMPUTING + 0.1)
    ends = maps.ends_of_tiles(baked, tiling.tiles, job.span_of(writing, 0.0, 0.0)) if as_png and tiling.tiles else {}
    for number, tile in enumerate(tiles):
        of_tile = job.part_of(writing, number, len(tiles))
        part = replace(baked, results=results.of_tile(tile, job.span_of(of_tile, 0.0, 0.9)))
        shown, paths = maps.cut_of(part, tile), maps.png_paths(image, list(results.values)) if as_png else {}
        for index, (name, path) in enumerate(paths.items()):
            maps.write_png(files.part(tile_names.of_tile(path, tile)), part, name, shown, ends.get(name))
            go_on(of_tile, "write images", 0.9 + 0.1 * (index + 1) / len(paths))
        if not as_png:
            maps.write_exr(files.part(tile_names.of_tile(image, tile)), part, shown)
            go_on(of_tile, "write images", 1.0)
    results.finish_tiles()
    results.tiles = None  # with the mesh that they would be evaluated on
    results.notes += tiling.notes
    results.warnings += [*maps.notes(baked), *tiling.warnings]
