"""Writes results as images over the UV map (32-bit float EXR, 16-bit PNG), and pictures of the baked buffers."""

import zipfile
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np

from .. import bridge
from ..core import color_maps, udim
from . import mask_image, png, tile_names
from .results import Baked, write_arrays, write_whole

SUFFIXES = (".exr", ".png")
# So many texels around each chart repeat its border, so that filtering and a few mipmaps show no seam.
GUTTER = 8
LAYOUT_OVERLAPS = 1  # pdesc_layout in the library: charts of the UV map overlap
STACKED = "Charts of the UV map share texture space: where several lie at one texel, an image shows the last one."


def user_uvs(baked: Baked) -> np.ndarray:
    """(triangle_count, 3, 2) UV coordinates of the mesh's UV map."""
    if baked.arrays.corner_uvs is None:
        lacking = baked.arrays.map_fault
        sentence = f"The mesh {lacking}, and an image needs a usable one that is active; unwrap it, or choose another."
        raise bridge.unusable(sentence)
    return baked.arrays.corner_uvs[baked.arrays.triangle_corners]


def drawn(
    uvs: np.ndarray,
    size: int,
    baked: Baked,
    name: str,
    at_vertices: np.ndarray | None = None,
    progress: bridge.ProgressFunction | None = None,
    shown: udim.Cut | None = None,
) -> np.ndarray:
    """(N, N, 1 or 3) float32 of a descriptor: from the map that was evaluated if there is one, else from vertices.

    at_vertices: instead of the descriptor's own values there. Values from other surfaces are drawn already.
    shown: the UDIM tile that is drawn, if it is one of several.
    """
    results = baked.results
    if results.transfer is not None:
        return results.transfer.images[name].copy()
    layout = results.layout if name in results.maps else None
    values = results.values[name] if at_vertices is None else at_vertices
    corners = baked.arrays.triangle_vertices
    if shown is not None:
        uvs, (corners, values) = shown.uvs, shown.values(corners, values)
        layout = None if layout is None else shown.at_corners(layout)
    texels = None if layout is None else bridge.TexelMap(results.maps[name], layout)
    return bridge.draw_uv_image(uvs, corners, values, size, texels, progress)


def cut_of(baked: Baked, tile: int | None) -> udim.Cut | None:
    """The triangles in a UDIM tile; None where there is a single image."""
    return None if tile is None else udim.cut(user_uvs(baked), tile)


def image_of(baked: Baked, name: str, shown: udim.Cut | None = None) -> np.ndarray:
    """(N, N, 1 or 3) float32 of a descriptor over the mesh's UV map, rows from v = 0 up; NaN off the surface."""
    return drawn(user_uvs(baked), baked.results.settings.options.texels, baked, name, shown=shown)


def notes(baked: Baked) -> list[str]:
    """Notes about the limits of the images."""
    if baked.arrays.layout is not None:
        return [
            "Images show the layout that was made for the computation: they fit no UV map of the mesh; unwrap it first."
        ]
    if baked.results.transfer is not None or baked.results.field_report["private_layout"] != LAYOUT_OVERLAPS:
        return []
    return [STACKED]


def channels_of(baked: Baked, shown: udim.Cut | None = None) -> dict[str, np.ndarray]:
    """(N, N) float32 channels, top row first: Y, or R G B, for one descriptor; .V or .X .Y .Z for each of several."""
    names = list(baked.results.values)
    channels = {}
    for name in names:
        image = bridge.fill_gutter(image_of(baked, name, shown), GUTTER)[::-1]
        wide = image.shape[2] == 3
        parts = ("RGB" if wide else "Y") if len(names) == 1 else ("XYZ" if wide else "V")
        for number, part in enumerate(parts):
            channels[part if len(names) == 1 else f"{name}.{part}"] = image[:, :, number]
    return channels


def png_paths(path: Path, names: list[str]) -> dict[str, Path]:
    """The path of each descriptor's PNG: the given path if there is one descriptor, else <stem>_<descriptor>.png."""
    if len(names) == 1:
        return {names[0]: path}
    return {name: tile_names.with_word(path, name) for name in names}


def stored_range(values: np.ndarray, components: int) -> tuple[float, float]:
    """The values of pixels 0 and 65535: -1 and 1 for directions, else the smallest and the largest value."""
    finite = values[np.isfinite(values)]
    if components == 3:
        return -1.0, 1.0
    if finite.size == 0:
        return 0.0, 1.0
    low, high = float(finite.min()), float(finite.max())
    return (low, high) if high > low else (low, low + 1.0)


def ends_of_tiles(
    baked: Baked, tiles: tuple[int, ...], progress: bridge.ProgressFunction | None = None
) -> dict[str, tuple[float, float]]:
    """The range that PNGs of several tiles share, by descriptor. All tiles are drawn once to find it."""
    found: dict[str, list[float]] = {name: [] for name in baked.results.values}
    for tile in tiles:
        part = replace(baked, results=baked.results.of_tile(tile, progress))
        shown = cut_of(part, tile)
        for name, ends in found.items():
            image = image_of(part, name, shown)
            finite = image[np.isfinite(image)]
            ends += [float(finite.min()), float(finite.max())] if finite.size else []
    wide = {name: 3 if baked.results.values[name].ndim == 2 else 1 for name in found}
    return {name: stored_range(np.array(ends), wide[name]) for name, ends in found.items()}


def write_png(
    path: Path,
    baked: Baked,
    name: str,
    shown: udim.Cut | None = None,
    ends: tuple[float, float] | None = None,
) -> dict[str, object]:
    """Writes one descriptor as a 16-bit PNG, whose ends are its values' unless given; returns its row of the report."""
    image = image_of(baked, name, shown)
    low, high = stored_range(image, image.shape[2]) if ends is None else ends
    share = np.clip((bridge.fill_gutter(image, GUTTER)[::-1].astype(np.float64) - low) / (high - low), 0.0, 1.0)
    meaning = mask_image.Scale(low, high, outside=0).meaning(name, baked.unit(name))
    png.write_png(path, np.round(mask_image.WHOLE * share).astype(np.uint16), {"Description": meaning})
    return {"descriptor": name, "minimum": low, "maximum": high}


# ---- The baked buffers as pictures (paper Fig. 1)


def chart_colors(charts: np.ndarray) -> np.ndarray:
    """Turns (…) chart numbers into (…, 3) display colors: a random one each, dark grey for -1."""
    number = np.asarray(charts, np.int64)
    colors = np.random.default_rng(1).uniform(0.25, 1.0, (max(int(number.max()), 0) + 1, 3))
    return np.where(number[..., None] < 0, 0.12, colors[np.maximum(number, 0)])


def pictures_of(baked: Baked) -> dict[str, np.ndarray]:
    """Every buffer and descriptor as (N, N, 3) display colors, rows from v = 0 up."""
    buffers = baked.results.buffers
    none = (buffers["chart"] < 0)[:, :, None]
    position = buffers["position"]
    low, high = np.nanmin(position, axis=(0, 1)), np.nanmax(position, axis=(0, 1))
    dim = 0.25 * chart_colors(buffers["chart"])
    # Lines are made a texel wider on every side, because a line of one texel is hard to see.
    wide = np.lib.stride_tricks.sliding_window_view(np.pad(buffers["neighbor"], 1, constant_values=-1), (3, 3))
    neighbor = wide.max(axis=(2, 3))
    stretch = buffers["distortion"][:, :, :2]
    largest = np.nanpercentile(stretch, 97.5)
    angle = np.mod(buffers["distortion"][:, :, 2:3] / np.pi, 1.0)  # a line's: half a turn changes nothing
    views = {
        "position": np.where(none, 0.12, (position - low) / max(float((high - low).max()), 1e-30)),
        "normal": np.where(none, 0.12, 0.5 + 0.5 * buffers["normal"]),
        "charts": chart_colors(buffers["chart"]),
        "adjacency": np.where((neighbor >= 0)[:, :, None], chart_colors(neighbor), dim),
        "distortion": np.where(none, 0.12, np.concatenate([stretch / max(largest, 1e-30), angle], axis=2)),
    }
    for name in baked.results.values:
        values = drawn(baked.results.layout, len(buffers["chart"]), baked, name)
        if values.shape[2] == 3:
            shown = 0.5 + 0.5 * values
        else:
            shown = color_maps.colors(values.reshape(-1), baked.results.shown(name)).reshape(*values.shape[:2], 3)
        views[name] = np.where(np.isfinite(values).all(axis=2)[:, :, None], shown, 0.12)
    return views


def write_buffers(folder: Path, baked: Baked) -> list[Path]:
    """Writes buffers.npz, rows from v = 0 up, and a PNG of every buffer and descriptor; returns their paths."""
    folder.mkdir(exist_ok=True)
    paths = [folder / "buffers.npz"]
    content = {**baked.results.buffers, "layout": baked.results.layout, **baked.results.maps}
    write_whole(paths[0], content, partial(write_arrays, packing=zipfile.ZIP_DEFLATED))
    for name, view in pictures_of(baked).items():
        paths.append(folder / f"{name}.png")
        pixels = np.round(255 * np.clip(np.nan_to_num(view[::-1]), 0.0, 1.0)).astype(np.uint8)
        write_whole(paths[-1], pixels, png.write_png)
    return paths
