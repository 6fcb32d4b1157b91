"""Draws a colored mesh into a plain picture with numpy: a z-buffer rasterizer that needs no graphics device."""

from dataclasses import dataclass

import lettering
import numpy as np

from paradesc.core import color_maps, legend

BACKGROUND = 0.93
INK = (60, 60, 60)
PANEL = 760  # pixels along a side of one view
LEGEND = 84  # pixels below it
COLUMNS = 3  # views side by side
SUPERSAMPLING = 2
# The camera looks from the front (-Y), a little from the right and from above.
AZIMUTH, ELEVATION = 32.0, 18.0
HALF_FIELD = np.tan(np.radians(14.0))  # tangent of half the field of view
MARGIN = 0.94
# The direction to the light in camera axes (right, up, towards the viewer), and how dark the shadow side is.
LIGHT = np.array([-0.45, 0.65, 0.62])
SHADOW = 0.42
# So many pairs of triangle and pixel are tested at a time, which bounds the memory.
PAIRS_AT_ONCE = 2_000_000
# So many of these are computed at a time that intermediate results stay in the processor's cache.
PAIRS_IN_CACHE = 65_536


@dataclass
class View:
    """One mesh with one set of vertex colors, and its legend."""

    colors: np.ndarray  # (vertex_count, 3) display colors in [0, 1]
    title: str
    shown: color_maps.ValueRange | None  # None of directions, whose colors have no scale
    name: str = ""  # of the descriptor


def compose(points: np.ndarray, triangles: np.ndarray, views: list[View]) -> np.ndarray:
    """Puts the views side by side with their legends: (height, width, 3) uint8. points: (n, 3) in world space."""
    drawn = Drawing(points, triangles, PANEL)
    columns = min(len(views), COLUMNS)
    rows = -(-len(views) // columns)
    height = PANEL + LEGEND
    image = np.full((rows * height, columns * PANEL, 3), round(255 * BACKGROUND), np.uint8)
    for index, view in enumerate(views):
        top, left = index // columns * height, index % columns * PANEL
        image[top : top + PANEL, left : left + PANEL] = drawn.paint(view.colors)
        draw_legend(image[top + PANEL : top + height, left : left + PANEL], view)
    return image


def draw_legend(area: np.ndarray, view: View) -> None:
    """Draws the color bar with its numbers, and the title, into the (LEGEND, PANEL, 3) strip below a view."""
    if view.shown is None:
        for text, top in ((view.title, 8), (legend.DIRECTIONS, 34)):
            lettering.draw_text(area, text, (area.shape[1] - lettering.text_width(text, 2)) // 2, top, 2, INK)
        return
    bar_width, bar_height, scale = 420, 16, 2
    left = (area.shape[1] - bar_width) // 2
    values = np.linspace(view.shown.minimum, view.shown.maximum, bar_width)
    area[4 : 4 + bar_height, left : left + bar_width] = np.round(255 * color_maps.colors(values, view.shown))
    for share, text in legend.ticks(view.name, view.shown):
        place = left + round(share * bar_width) - lettering.text_width(text, scale) // 2
        lettering.draw_text(area, text, place, 6 + bar_height, scale, INK)
    place = (area.shape[1] - lettering.text_width(view.title, scale)) // 2
    lettering.draw_text(area, view.title, place, 34 + bar_height, scale, INK)


class Drawing:
    """A mesh seen by the camera: which triangle each pixel shows, found once, and painted with any vertex colors."""

    def __init__(self, points: np.ndarray, triangles: np.ndarray, size: int) -> None:
        self.size = size
        self.triangles = triangles[np.isfinite(points[triangles]).all(axis=(1, 2))]
        camera, screen = project(points, self.triangles, size * SUPERSAMPLING)
        shown = rasterize(screen, self.triangles, size * SUPERSAMPLING)
        self.pixels = np.flatnonzero(shown >= 0)
        self.corners = self.triangles[shown[self.pixels]]
        self.weights = perspective_weights(screen, self.corners, self.pixels, size * SUPERSAMPLING)
        self.shading = shade(camera, self.triangles, self.corners, self.weights, faces_viewer(screen, self.corners))

    def paint(self, colors: np.ndarray) -> np.ndarray:
        """Turns (n, 3) display colors of the vertices into a (size, size, 3) uint8 image."""
        side = self.size * SUPERSAMPLING
        image = np.full((side * side, 3), BACKGROUND, np.float32)
        image[self.pixels] = blend(colors.astype(np.float32), self.corners, self.weights) * self.shading[:, None]
        image = image.reshape(self.size, SUPERSAMPLING, self.size, SUPERSAMPLING, 3).mean(axis=(1, 3))
        return np.round(255 * np.clip(image, 0, 1)).astype(np.uint8)


def camera_axes() -> np.ndarray:
    """(3, 3): rows are the camera's right, up and towards-the-viewer in world space."""
    azimuth, elevation = np.radians(AZIMUTH), np.radians(ELEVATION)
    back = np.array([np.sin(azimuth) * np.cos(elevation), -np.cos(azimuth) * np.cos(elevation), np.sin(elevation)])
    right = np.cross([0.0, 0.0, 1.0], back)
    right /= np.linalg.norm(right)
    return np.stack([right, np.cross(back, right), back])


def project(points: np.ndarray, triangles: np.ndarray, size: int) -> tuple[np.ndarray, np.ndarray]:
    """Projects world points (n, 3): camera axes, and screen (x, y in pixels from the top left, 1/distance)."""
    camera = np.nan_to_num(points.astype(np.float64), posinf=0, neginf=0) @ camera_axes().T
    used = camera[np.unique(triangles)] if len(triangles) else np.zeros((1, 3))
    center = (used.min(axis=0) + used.max(axis=0)) / 2
    camera -= center
    used = used - center
    reach = HALF_FIELD * MARGIN
    distance = max((used[:, 2] + np.abs(used[:, :2]).max(axis=1) / reach).max(), 1e-12)
    depth = np.maximum(distance - camera[:, 2], 1e-3 * distance)  # vertices without a face may lie behind the camera
    flat = camera[:, :2] / (depth[:, None] * HALF_FIELD)
    x, y = (1 + flat[:, 0]) * size / 2, (1 - flat[:, 1]) * size / 2
    return camera, np.stack([x, y, distance / depth], axis=1)


def rasterize(screen: np.ndarray, triangles: np.ndarray, size: int) -> np.ndarray:
    """(size * size,) int32: the triangle nearest to the viewer at each pixel's center, or -1."""
    corners = screen[triangles]  # (t, 3, 3)
    first = np.clip(np.ceil(corners[:, :, :2].min(axis=1) - 0.5), 0, size).astype(np.int64)
    last = np.clip(np.floor(corners[:, :, :2].max(axis=1) - 0.5), -1, size - 1).astype(np.int64)
    extent = np.maximum(last - first + 1, 0)
    counts = extent.prod(axis=1)
    seen = np.flatnonzero(counts)
    nearest = np.zeros(size * size, np.float32)
    shown = np.full(size * size, -1, np.int32)
    ends = np.cumsum(counts[seen])
    start = 0
    while start < len(seen):
        base = ends[start - 1] if start else 0
        stop = max(int(np.searchsorted(ends, base + PAIRS_AT_ONCE, side="right")), start + 1)
        some = seen[start:stop]
        rasterize_some(some, corners[some], first[some], extent[some], nearest, shown)
        start = stop
    return shown


def rasterize_some(
    numbers: np.ndarray,
    corners: np.ndarray,
    first: np.ndarray,
    extent: np.ndarray,
    nearest: np.ndarray,
    shown: np.ndarray,
) -> None:
    """Tests all pixels in the boxes of some triangles (k,) and writes the nearest hits to nearest and shown."""
    size = round(np.sqrt(len(shown)))
    counts = extent.prod(axis=1)
    ends = np.cumsum(counts)
    starts = range(0, int(ends[-1]), PAIRS_IN_CACHE)
    found = [hits(start, min(start + PAIRS_IN_CACHE, int(ends[-1])), ends, corners, first, extent) for start in starts]
    owner, column, row, depth = map(np.concatenate, zip(*found, strict=True))
    pixel = row * size + column
    nearer = depth > nearest[pixel]
    owner, pixel, depth = owner[nearer], pixel[nearer], depth[nearer]
    order = np.argsort(depth, kind="stable")  # of several hits of one pixel the last, nearest one stays
    nearest[pixel[order]] = depth[order]
    shown[pixel[order]] = numbers[owner[order]]


def hits(
    start: int, stop: int, ends: np.ndarray, corners: np.ndarray, first: np.ndarray, extent: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """The pairs from start to stop that hit: triangle, column, row, depth, each (k,); ends: (t,) of the pairs."""
    pair = np.arange(start, stop)
    owner = np.searchsorted(ends, pair, side="right")
    place = pair - (ends - extent.prod(axis=1))[owner]
    column = first[owner, 0] + place % extent[owner, 0]
    row = first[owner, 1] + place // extent[owner, 0]
    weights = screen_weights(corners[owner, :, :2], column + 0.5, row + 0.5)
    inside = np.flatnonzero((weights[:, 0] >= 0) & (weights[:, 1] >= 0) & (weights[:, 2] >= 0))
    owner = owner[inside]
    depth = (weights[inside] * corners[owner, :, 2]).sum(axis=1).astype(np.float32)
    return owner, column[inside], row[inside], depth


def screen_weights(corners: np.ndarray, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """(k, 3) barycentric weights of points x, y (k,) in triangles (k, 3, 2) of either winding; NaN without area."""
    (ax, ay), (bx, by), (cx, cy) = ((corners[:, index, 0] - x, corners[:, index, 1] - y) for index in range(3))
    parts = (bx * cy - by * cx, cx * ay - cy * ax, ax * by - ay * bx)
    whole = parts[0] + parts[1] + parts[2]
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.stack([part / whole for part in parts], axis=1)


def cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """(k,) z of the cross products of (k, 2) vectors."""
    return a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]


def perspective_weights(screen: np.ndarray, corners: np.ndarray, pixels: np.ndarray, size: int) -> np.ndarray:
    """(k, 3) float32 weights of the corners (k, 3) at the pixels (k,), correct in space and not just on the screen."""
    weights = screen_weights(screen[corners][:, :, :2], pixels % size + 0.5, pixels // size + 0.5)
    weights *= screen[corners][:, :, 2]
    return (weights / weights.sum(axis=1, keepdims=True)).astype(np.float32)


def blend(values: np.ndarray, corners: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """(k, 3): vertex values (n, 3) weighted at the corners (k, 3)."""
    return sum(values[corners[:, index]] * weights[:, index, None] for index in range(3))


def faces_viewer(screen: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """(k,) bool: which of the triangles (k, 3) show their front."""
    a, b, c = (screen[corners[:, index], :2] for index in range(3))
    return cross(b - a, c - a) < 0  # y points down


def shade(
    camera: np.ndarray, triangles: np.ndarray, corners: np.ndarray, weights: np.ndarray, front: np.ndarray
) -> np.ndarray:
    """(k,) brightness of the pixels: soft Lambert light on smooth normals, both sides of a face alike.

    The face decides which side is seen: near silhouettes, smooth normals of visible faces may point away.
    """
    normals = blend(smooth_normals(camera, triangles), corners, weights)
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)
    normals[~front] *= -1
    light = LIGHT / np.linalg.norm(LIGHT)
    soft = 0.5 + 0.5 * normals @ light
    return (SHADOW + (1 - SHADOW) * soft**1.5).astype(np.float32)


def smooth_normals(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """(n, 3) float32 area-weighted normals; points at one place share a normal."""
    _, place = np.unique(points, axis=0, return_inverse=True)
    place = place.reshape(-1)
    corners = points[triangles]
    faces = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    total = np.zeros((place.max() + 1, 3)) if len(place) else np.zeros((0, 3))
    for index in range(3):
        for axis in range(3):
            total[:, axis] += np.bincount(place[triangles[:, index]], faces[:, axis], len(total))
    length = np.linalg.norm(total, axis=1, keepdims=True)
    return (total / np.maximum(length, 1e-30))[place].astype(np.float32)
