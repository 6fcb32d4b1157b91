"""Results as images over the UV map, 32-bit float EXR and 16-bit PNG; and pictures of the baked buffers."""

from pathlib import Path

import numpy as np

from .. import bridge
from ..bridge import abi
from ..core import color_maps
from . import exr, picture, png
from .results import Baked, write_whole

SUFFIXES = (".exr", ".png")
# Texels around each chart that take the values beside them: filtering and a few mipmaps show no seam then.
GUTTER = 8
# Tiles of the UV plane that one triangle may lie on.
MOST_TILES = 16
WHOLE_16 = 65535


class Raster:
    """Which triangle each texel of a square image shows, by its center, and where in it."""

    def __init__(self, uvs: np.ndarray, size: int) -> None:
        """uvs: (triangle_count, 3, 2), modulo whole tiles as in a repeated texture; the last triangle wins."""
        corners, number = on_one_tile(np.asarray(uvs, np.float64))
        screen = np.ones((3 * len(corners), 3))
        screen[:, :2] = corners.reshape(-1, 2) * size
        screen[:, 2] = np.repeat((np.arange(len(corners)) + 1.0) / max(len(corners), 1), 3)
        shown = picture.rasterize(screen, np.arange(len(screen)).reshape(-1, 3), size)
        self.size = size
        self.texels = np.flatnonzero(shown >= 0)  # (k,) row * size + column, rows from v = 0 up
        x, y = self.texels % size + 0.5, self.texels // size + 0.5
        self.weights = picture.screen_weights(size * corners[shown[self.texels]], x, y)  # (k, 3)
        self.triangles = number[shown[self.texels]]  # (k,)

    def image(self, values: np.ndarray) -> np.ndarray:
        """(k, c) values at the texels as (size, size, c) float32, NaN elsewhere."""
        image = np.full((self.size * self.size, values.shape[1]), np.nan, np.float32)
        image[self.texels] = values
        return image.reshape(self.size, self.size, -1)


def on_one_tile(uvs: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Triangles (n, 3, 2) moved by whole tiles so that they meet [0, 1]²; once for every tile, with their numbers."""
    uvs = np.nan_to_num(uvs)
    low = np.floor(uvs.min(axis=1))
    extent = np.clip(np.ceil(uvs.max(axis=1)) - low, 1, MOST_TILES).astype(np.int64)
    counts = extent.prod(axis=1)
    number = np.repeat(np.arange(len(uvs)), counts)
    place = np.arange(len(number)) - np.repeat(np.cumsum(counts) - counts, counts)
    tile = np.stack([place % extent[number, 0], place // extent[number, 0]], axis=1) + low[number]
    return uvs[number] - tile[:, None, :], number


def blended(values: np.ndarray, weights: np.ndarray, direction: bool) -> np.ndarray:
    """(k, m, c) values with weights (k, m) to (k, c), of those that are defined; directions have no sign."""
    defined = np.isfinite(values).all(axis=2)
    weights = np.where(defined, np.maximum(weights, 0.0), 0.0)
    values = np.where(defined[:, :, None], values, 0.0)
    if direction:
        leader = np.take_along_axis(values, weights.argmax(axis=1)[:, None, None], axis=1)
        weights = np.where((values * leader).sum(axis=2) < 0, -weights, weights)
    total = (values * weights[:, :, None]).sum(axis=1)
    size = np.linalg.norm(total, axis=1) if direction else weights.sum(axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(size[:, None] > 1e-9, total / size[:, None], np.nan)


def user_uvs(baked: Baked) -> np.ndarray:
    """(triangle_count, 3, 2) of the mesh's UV map."""
    if baked.arrays.corner_uvs is None:
        sentence = "The mesh has no UV map to make an image in; unwrap it."
        raise bridge.ParadescError(abi.STATUS_INVALID_ARGUMENT, sentence)
    return baked.arrays.corner_uvs[baked.arrays.triangle_corners]


def from_vertices(raster: Raster, baked: Baked, name: str) -> np.ndarray:
    """(k, c) values of the vertices, linear over each triangle."""
    values = baked.results.values[name]
    values = values.reshape(len(values), -1).astype(np.float64)
    corners = baked.arrays.triangle_vertices[raster.triangles]
    return blended(values[corners], raster.weights, values.shape[1] == 3)


def from_map(raster: Raster, baked: Baked, name: str) -> np.ndarray:
    """(k, c) values of the map that was evaluated, at the same places of the layout; NaN where it has none near."""
    source = baked.results.maps[name]
    size = len(source)
    source = source.reshape(size, size, -1).astype(np.float64)
    uv = (baked.results.layout[raster.triangles] * raster.weights[:, :, None]).sum(axis=1) * size - 0.5
    low = np.floor(uv + 1e-4).astype(np.int64)  # a texel's own center is that texel alone
    share = np.clip(uv - low, 0.0, 1.0)
    values, weights = [], []
    for right, up in ((0, 0), (1, 0), (0, 1), (1, 1)):
        column, row = low[:, 0] + right, low[:, 1] + up
        inside = (column >= 0) & (row >= 0) & (column < size) & (row < size)
        values.append(source[np.clip(row, 0, size - 1), np.clip(column, 0, size - 1)])
        weight = np.abs(1 - right - share[:, 0]) * np.abs(1 - up - share[:, 1])
        weights.append(np.where(inside & (weight > 1e-3), weight, 0.0))
    return blended(np.stack(values, axis=1), np.stack(weights, axis=1), source.shape[2] == 3)


def drawn(raster: Raster, baked: Baked, name: str) -> np.ndarray:
    """(N, N, 1 or 3) float32 of a descriptor: from the map that was evaluated if there is one, else from vertices."""
    values = from_vertices(raster, baked, name)
    if name in baked.results.maps:
        looked_up = from_map(raster, baked, name)
        values = np.where(np.isfinite(looked_up), looked_up, values)
    return raster.image(values)


def image_of(baked: Baked, name: str) -> np.ndarray:
    """(N, N, 1 or 3) float32 of a descriptor over the mesh's UV map, rows from v = 0 up; NaN off the surface."""
    return drawn(Raster(user_uvs(baked), baked.results.settings.options.texels), baked, name)


def fill_gutter(image: np.ndarray, steps: int = GUTTER) -> np.ndarray:
    """(N, N, c) with undefined texels filled ring by ring by the mean of those beside them, and 0 beyond the gutter."""
    image = image.copy()
    for _ in range(steps):
        defined = np.isfinite(image).all(axis=2)
        padded = np.pad(np.where(defined[:, :, None], image, 0.0), ((1, 1), (1, 1), (0, 0)))
        counted = np.pad(defined.astype(np.float32), 1)
        total, count = np.zeros_like(image), np.zeros(defined.shape, np.float32)
        height, width = defined.shape
        for y in range(3):
            for x in range(3):
                total += padded[y : y + height, x : x + width]
                count += counted[y : y + height, x : x + width]
        ring = ~defined & (count > 0)
        image[ring] = total[ring] / count[ring][:, None]
    return np.nan_to_num(image, nan=0.0, posinf=0.0, neginf=0.0)


def notes(baked: Baked) -> list[str]:
    """What limits the images."""
    if baked.arrays.layout is not None:
        return [
            "Images show the layout that was made for the computation: they fit no UV map of the mesh; unwrap it first."
        ]
    if not baked.results.field_report["private_layout"]:
        return []
    return ["Charts of the UV map share texture space: where several lie at one texel, an image shows the last one."]


def channels_of(baked: Baked) -> dict[str, np.ndarray]:
    """(N, N) float32 channels, top row first. One descriptor: Y, or R G B. Several: a layer each, .V or .X .Y .Z."""
    names = list(baked.results.values)
    channels = {}
    for name in names:
        image = fill_gutter(image_of(baked, name))[::-1]
        wide = image.shape[2] == 3
        parts = ("RGB" if wide else "Y") if len(names) == 1 else ("XYZ" if wide else "V")
        for number, part in enumerate(parts):
            channels[part if len(names) == 1 else f"{name}.{part}"] = image[:, :, number]
    return channels


def write_exr(path: Path, baked: Baked) -> None:
    """Writes every descriptor into one EXR file."""
    exr.write_exr(path, channels_of(baked))


def png_paths(path: Path, names: list[str]) -> dict[str, Path]:
    """Where each descriptor's PNG goes: the path itself for one, else <stem>_<descriptor>.png."""
    if len(names) == 1:
        return {names[0]: path}
    return {name: path.with_name(f"{path.stem}_{name}{path.suffix}") for name in names}


def stored_range(values: np.ndarray, components: int) -> tuple[float, float]:
    """The values that 0 and 65535 stand for: -1 and 1 of a direction, else the smallest and the largest there are."""
    finite = values[np.isfinite(values)]
    if components == 3:
        return -1.0, 1.0
    if finite.size == 0:
        return 0.0, 1.0
    low, high = float(finite.min()), float(finite.max())
    return (low, high) if high > low else (low, low + 1.0)


def write_png(path: Path, baked: Baked, name: str) -> dict[str, object]:
    """Writes one descriptor as a 16-bit PNG; gives what the JSON report says of it."""
    image = image_of(baked, name)
    low, high = stored_range(image, image.shape[2])
    share = np.clip((fill_gutter(image)[::-1].astype(np.float64) - low) / (high - low), 0.0, 1.0)
    unit = baked.unit(name)
    meaning = f"{name} = {low!r} + ({high!r} - {low!r}) * pixel / {WHOLE_16}" + (f" [{unit}]" if unit else "")
    png.write_png16(path, np.round(WHOLE_16 * share).astype(np.uint16), {"Description": meaning})
    return {"descriptor": name, "minimum": low, "maximum": high}


# ---- The baked buffers as pictures (paper Fig. 1)


def chart_colors(charts: np.ndarray) -> np.ndarray:
    """(…) chart numbers to (…, 3) display colors: one at random each, dark grey for -1."""
    number = np.asarray(charts, np.int64)
    colors = np.random.default_rng(1).uniform(0.25, 1.0, (max(int(number.max()), 0) + 1, 3))
    return np.where(number[..., None] < 0, 0.12, colors[np.maximum(number, 0)])


def widened(numbers: np.ndarray) -> np.ndarray:
    """(N, N) numbers with -1 for none, each a texel wider on every side: a line of one texel is hard to see."""
    padded = np.pad(numbers, 1, constant_values=-1)
    height, width = numbers.shape
    return np.max([padded[y : y + height, x : x + width] for y in range(3) for x in range(3)], axis=0)


def pictures_of(baked: Baked) -> dict[str, np.ndarray]:
    """Every buffer and descriptor as (N, N, 3) display colors, rows from v = 0 up."""
    buffers = baked.results.buffers
    none = (buffers["chart"] < 0)[:, :, None]
    position = buffers["position"]
    low, high = np.nanmin(position, axis=(0, 1)), np.nanmax(position, axis=(0, 1))
    dim = 0.25 * chart_colors(buffers["chart"])
    neighbor = widened(buffers["neighbor"])
    stretch = buffers["distortion"][:, :, :2]
    largest = np.nanpercentile(stretch, 97.5)
    angle = np.mod(buffers["distortion"][:, :, 2:3] / np.pi, 1.0)  # of a line: half a turn is none
    views = {
        "position": np.where(none, 0.12, (position - low) / max(float((high - low).max()), 1e-30)),
        "normal": np.where(none, 0.12, 0.5 + 0.5 * buffers["normal"]),
        "charts": chart_colors(buffers["chart"]),
        "adjacency": np.where((neighbor >= 0)[:, :, None], chart_colors(neighbor), dim),
        "distortion": np.where(none, 0.12, np.concatenate([stretch / max(largest, 1e-30), angle], axis=2)),
    }
    raster = Raster(baked.results.layout, len(buffers["chart"]))
    for name in baked.results.values:
        values = drawn(raster, baked, name)
        shown = values if values.shape[2] == 3 else color_maps.colors(values.reshape(-1), baked.shown(name))
        shown = 0.5 + 0.5 * shown if values.shape[2] == 3 else shown.reshape(*values.shape[:2], 3)
        views[name] = np.where(np.isfinite(values).all(axis=2)[:, :, None], shown, 0.12)
    return views


def write_buffers(folder: Path, baked: Baked) -> list[Path]:
    """Writes buffers.npz, rows from v = 0 up, and a PNG of every buffer and descriptor; gives their paths."""
    folder.mkdir(exist_ok=True)
    paths = [folder / "buffers.npz"]
    write_whole(paths[0], baked, write_raw_buffers)
    for name, view in pictures_of(baked).items():
        paths.append(folder / f"{name}.png")
        pixels = np.round(255 * np.clip(np.nan_to_num(view[::-1]), 0.0, 1.0)).astype(np.uint8)
        write_whole(paths[-1], pixels, png.write_png)
    return paths


def write_raw_buffers(path: Path, baked: Baked) -> None:
    """Writes what was baked, the layout and the maps as a .npz file."""
    with path.open("wb") as file:
        np.savez_compressed(file, **baked.results.buffers, layout=baked.results.layout, **baked.results.maps)
