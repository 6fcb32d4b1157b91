"""Tells which UDIM tiles a UV map lies in, and cuts its triangles along a tile's square. Never imports bpy.

Tile 1001 + column + 10 row is the unit square that begins at (column, row); there are ten columns and a hundred rows.
"""

from dataclasses import dataclass, replace

import numpy as np

from ..bridge import MeshArrays
from .polygons import listed

COLUMNS, ROWS = 10, 100
FIRST = 1001
# A map that reaches into a square by no more than this, four texels of 1024, only does so by rounding.
SPILL = 1 / 256
# UV maps of textures that repeat lie over more squares than anyone paints tiles for.
MOST_TILES = 100
# Coordinates beyond this are mistakes, and squares that far out have no whole numbers to count them by.
FARTHEST = 1e6
KEY_STEP = 1 << 24  # tells squares of one row from those of the next, wherever a map lies
# Reasons for a single image where tiles may be expected.
OUTSIDE = "Parts of the UV map lie outside of the UDIM tiles (U from 0 to 10, V from 0 to 100); move them into tiles."
REPEATS = "Most of the UV map crosses borders of UDIM tiles, as for a texture that repeats."


@dataclass(frozen=True)
class Tiling:
    """The tiles of a UV map; none if it makes a single image."""

    tiles: tuple[int, ...] = ()  # numbers in ascending order
    crossing: int = 0  # how many triangles lie in several
    why: str = ""  # reason for a single image where tiles may be expected
    first: bool = False  # whether there is a single image because the whole map lies in tile 1001

    @property
    def warnings(self) -> list[str]:
        """A warning with the reason for a single image where tiles may be expected."""
        return [f"{self.why} All of it was drawn into a single image."] if self.why else []

    @property
    def notes(self) -> list[str]:
        """A note about triangles that cross the borders of tiles."""
        if not self.crossing:
            return []
        count = self.crossing
        what = f"{count:,} triangle crosses" if count == 1 else f"{count:,} triangles cross"
        return [f"In the UV map {what} the borders of UDIM tiles; each tile shows its part of them."]


def too_many(count: int) -> str:
    """The reason for a single image: the UV map lies over too many tiles."""
    return f"The UV map lies over {count:,} UDIM tiles, more than {MOST_TILES}; use fewer."


@dataclass(frozen=True)
class Cut:
    """The triangles that a tile shows, in its unit square; those that cross its border are cut into parts."""

    triangles: np.ndarray  # (n,) int which triangle of the mesh each is, or is a part of
    uvs: np.ndarray  # (n, 3, 2) float32 in the unit square
    parts: np.ndarray  # (k,) int which of them are parts
    weights: np.ndarray  # (k, 3, 3) float64 of the parts' corners, for those of the mesh's triangle

    def at_corners(self, columns: np.ndarray) -> np.ndarray:
        """(n, 3, d) of (triangle_count, 3, d) numbers at the corners of the mesh's triangles."""
        found = columns[self.triangles]
        found[self.parts] = np.einsum("kij,kjd->kid", self.weights, found[self.parts].astype(np.float64))
        return found

    def values(self, triangle_values: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """(n, 3) which value each corner has, and the values (m,) or (m, d), three columns being directions."""
        rows = triangle_values[self.triangles]
        if not len(self.parts):
            return rows, values
        columns = values.reshape(len(values), -1)
        corners = columns[rows[self.parts]].astype(np.float64)
        if corners.shape[2] == 3:  # directions, which have no sign
            along = (corners * corners[:, :1]).sum(axis=2, keepdims=True)
            corners = np.where(along < 0, -corners, corners)
        added = blended(corners, self.weights).reshape(-1, columns.shape[1])
        rows[self.parts] = len(values) + np.arange(len(added)).reshape(-1, 3)
        return rows, np.concatenate([columns, added.astype(values.dtype)]).reshape(-1, *values.shape[1:])


def blended(corners: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """(k, 3, d) blends of (k, 3, d) values at triangles' corners; corners that are not finite have no weight."""
    known = np.isfinite(corners).all(axis=2)
    shares = np.where(known[:, None, :], weights, 0.0)
    with np.errstate(invalid="ignore", divide="ignore"):
        shares = shares / shares.sum(axis=2, keepdims=True)
    return np.einsum("kij,kjd->kid", shares, np.where(known[:, :, None], corners, 0.0))


def square_of(tile: int) -> np.ndarray:
    """(2,) the column and the row of a tile."""
    return np.array([(tile - FIRST) % COLUMNS, (tile - FIRST) // COLUMNS])


def of_mesh(arrays: MeshArrays) -> Tiling:
    """The tiles of a mesh's own UV map."""
    if arrays.map_fault:
        return Tiling()
    return tiling_of(arrays.corner_uvs[arrays.triangle_corners])


def tiling_of(uvs: np.ndarray) -> Tiling:
    """The tiles of (n, 3, 2) UV coordinates. A map in the square of tile 1001 has none, and makes a single image."""
    if in_first(uvs):
        return Tiling(first=True)
    uvs = uvs.astype(np.float64)[with_area(uvs)]
    if not len(uvs) or np.abs(uvs).max() > FARTHEST:
        return Tiling()
    if in_first(uvs):
        return Tiling(first=True)
    met = boxes(uvs)[1].astype(np.float64).prod(axis=1).max()  # in floats, which do not overflow
    if met > MOST_TILES:
        return Tiling(why=too_many(int(met)))
    sure = middles(uvs)
    inside = in_tiles(sure)
    if not inside.all() and (sure[inside] != 0).any():  # a map in meters has too many squares to look at each
        return Tiling(why=OUTSIDE)
    triangles, squares = meetings(uvs)
    least = squares.min(axis=0)
    keys, number = np.unique((squares - least) @ (1, KEY_STEP), return_inverse=True)
    places = least + np.column_stack([keys % KEY_STEP, keys // KEY_STEP])
    number = number.reshape(-1)
    # Squares with no more than a sliver at their borders do not count.
    local = np.clip(uvs[triangles] - squares[:, None], 0.0, 1.0)
    low, high = np.full((len(places), 2), np.inf), np.full((len(places), 2), -np.inf)
    np.minimum.at(low, number, local.min(axis=1))
    np.maximum.at(high, number, local.max(axis=1))
    real = more_than_spilled(low, high)
    found = places[real]
    inside = in_tiles(found)
    tiles = np.sort(FIRST + found[inside] @ (1, COLUMNS))
    if not inside.all():
        return Tiling(why=OUTSIDE if (tiles != FIRST).any() else "")
    if len(tiles) > MOST_TILES:
        return Tiling(why=too_many(len(tiles)))
    if tiles.tolist() == [FIRST]:
        return Tiling(first=True)
    several = np.bincount(triangles[real[number]], minlength=len(uvs)) > 1
    area = areas(uvs)
    if area[several].sum() > 0.5 * area.sum():
        return Tiling(why=REPEATS)
    return Tiling(tuple(tiles.tolist()), int(several.sum()))


def in_first(uvs: np.ndarray) -> bool:
    """Returns whether (n, 3, 2) UV coordinates lie in the square of tile 1001."""
    return len(uvs) > 0 and bool(uvs.min() >= -SPILL and uvs.max() <= 1 + SPILL)


def areas(uvs: np.ndarray) -> np.ndarray:
    """(n,) twice the areas of (n, 3, 2) triangles."""
    one, other = (uvs[:, k].astype(np.float64) - uvs[:, 0] for k in (1, 2))
    with np.errstate(invalid="ignore", over="ignore"):
        return np.abs(one[:, 0] * other[:, 1] - one[:, 1] * other[:, 0])


def with_area(uvs: np.ndarray) -> np.ndarray:
    """(n,) bool: which of (n, 3, 2) triangles can show up in an image."""
    area = areas(uvs)
    return np.isfinite(area) & (area > 0)


def in_tiles(squares: np.ndarray) -> np.ndarray:
    """(n,) bool: which of (n, 2) squares are those of tiles."""
    return ((squares >= 0) & (squares < (COLUMNS, ROWS))).all(axis=1)


def middles(uvs: np.ndarray) -> np.ndarray:
    """(k, 2) squares of the middles of (n, 3, 2) triangles, without those that only hold rounding at borders."""
    squares = np.floor(uvs.mean(axis=1))
    low, high = uvs.min(axis=1) - squares, uvs.max(axis=1) - squares
    return squares[more_than_spilled(low, high)].astype(np.int64)


def boxes(uvs: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(n, 2) the squares in which boxes around (n, 3, 2) triangles begin, and how many columns and rows they meet."""
    first = np.floor(uvs.min(axis=1)).astype(np.int64)
    return first, np.maximum(np.ceil(uvs.max(axis=1)).astype(np.int64) - first, 1)


def meetings(uvs: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(k,) triangles and (k, 2) squares that have an area in common; each of (n, 3, 2) triangles has one at least."""
    first, span = boxes(uvs)
    count = span.prod(axis=1)
    triangles = np.repeat(np.arange(len(uvs)), count)
    step = listed(np.zeros_like(count), count)
    columns = span[triangles, 0]
    squares = first[triangles] + np.column_stack([step % columns, step // columns])
    doubtful = np.flatnonzero(count[triangles] > 1)
    apart = separated(uvs[triangles[doubtful]] - squares[doubtful][:, None])
    kept = np.delete(np.arange(len(triangles)), doubtful[apart])
    return triangles[kept], squares[kept]


def separated(uvs: np.ndarray) -> np.ndarray:
    """(n,) bool: whether a line along an edge of (n, 3, 2) triangles has the unit square on its other side."""
    apart = np.zeros(len(uvs), bool)
    for k in range(3):
        start, end, third = (uvs[:, (k + j) % 3] for j in range(3))
        normal = np.column_stack([start[:, 1] - end[:, 1], end[:, 0] - start[:, 0]])
        normal *= np.sign(((third - start) * normal).sum(axis=1))[:, None]  # it points to the triangle
        farthest = np.maximum(normal, 0.0).sum(axis=1)  # of the square's corners, along it
        apart |= farthest <= (start * normal).sum(axis=1)
    return apart


def more_than_spilled(low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """(n,) bool: whether the boxes from low to high, (n, 2) each, reach into the unit square by more than a sliver."""
    return ((high > SPILL) & (low < 1 - SPILL)).all(axis=1)


# ---- One tile


def shifted(uvs: np.ndarray, tile: int) -> tuple[np.ndarray, np.ndarray]:
    """(k,) which of (n, 3, 2) float32 triangles a tile shows parts of, and (k, 3, 2) float32 where they lie in it."""
    low = square_of(tile).astype(np.float32)
    near = (uvs.max(axis=1) > low).all(axis=1) & (uvs.min(axis=1) < low + 1).all(axis=1) & with_area(uvs)
    found = np.flatnonzero(near)
    uvs = uvs[found] - low  # exact for what lies within the tile
    kept = ~separated(uvs.astype(np.float64))
    return found[kept], uvs[kept]


def cut(uvs: np.ndarray, tile: int) -> Cut:
    """Cuts (n, 3, 2) UV coordinates to a tile; the result keeps the order of the triangles."""
    found, uvs = shifted(uvs, tile)
    crosses = ((uvs < 0) | (uvs > 1)).any(axis=(1, 2))
    number, weights = np.flatnonzero(crosses), np.tile(np.eye(3), (int(crosses.sum()), 1, 1))
    places = uvs[crosses].astype(np.float64)
    for axis, limit, side in ((0, 0.0, 1.0), (0, 1.0, -1.0), (1, 0.0, 1.0), (1, 1.0, -1.0)):
        number, places, weights = beside(number, places, weights, axis, limit, side)
    whole = np.flatnonzero(~crosses)
    order = np.argsort(np.concatenate([whole, number]), kind="stable")
    places = np.clip(places, 0.0, 1.0).astype(np.float32)
    rank = np.empty(len(order), np.int64)
    rank[order] = np.arange(len(order))
    return Cut(
        found[np.concatenate([whole, number])[order]],
        np.concatenate([uvs[whole], places])[order],
        rank[len(whole) :],
        weights,
    )


def beside(
    number: np.ndarray, places: np.ndarray, weights: np.ndarray, axis: int, limit: float, side: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The parts of triangles (k, 3, 2) on one side of a line u = limit or v = limit, their numbers and weights."""
    depth = side * (places[:, :, axis] - limit)
    count = (depth >= 0).sum(axis=1)
    parts = [(number[count == 3], places[count == 3], weights[count == 3])]
    for inside in (1, 2):
        chosen = count == inside
        # The corner that is alone on its side comes first.
        alone = np.argmax((depth[chosen] >= 0) == (inside == 1), axis=1)
        turn = (alone[:, None] + np.arange(3)) % 3
        own, both = np.take_along_axis(depth[chosen], turn, axis=1), np.concatenate([places, weights], axis=2)[chosen]
        both = np.take_along_axis(both, turn[:, :, None], axis=1)
        share = own[:, :1] / (own[:, :1] - own[:, 1:])  # of the way from the first corner to the line
        met = both[:, :1] + share[:, :, None] * (both[:, 1:] - both[:, :1])
        rest = [(both[:, 0], met[:, 0], met[:, 1])]  # of the triangle, inside
        if inside == 2:
            rest = [(met[:, 0], both[:, 1], both[:, 2]), (met[:, 0], both[:, 2], met[:, 1])]
        for corners in (np.stack(three, axis=1) for three in rest):
            parts.append((number[chosen], corners[:, :, :2], corners[:, :, 2:]))
    return tuple(np.concatenate(column) for column in zip(*parts, strict=True))


def unshared(arrays: MeshArrays, corner_uvs: np.ndarray | None = None) -> MeshArrays:
    """The mesh with three corners of its own for each triangle, and with these UV coordinates (n, 3, 2) for them."""
    corners = arrays.triangle_corners.reshape(-1)
    uvs = arrays.corner_uvs[corners] if corner_uvs is None else corner_uvs.reshape(-1, 2)
    return replace(
        arrays,
        corner_vertices=arrays.corner_vertices[corners],
        triangle_corners=np.arange(len(corners), dtype=np.int32).reshape(-1, 3),
        corner_uvs=uvs,
        corner_normals=None if arrays.corner_normals is None else arrays.corner_normals[corners],
    )


def alone(arrays: MeshArrays, tile: int) -> tuple[np.ndarray, MeshArrays]:
    """(k,) which triangles a tile shows, whole across its border, and the mesh with a UV map of these alone."""
    found, uvs = shifted(arrays.corner_uvs[arrays.triangle_corners], tile)
    own = np.empty((len(arrays.triangle_corners), 3, 2), np.float32)
    own[:] = uvs[0, 0]
    own[found] = uvs
    return found, unshared(arrays, own)
