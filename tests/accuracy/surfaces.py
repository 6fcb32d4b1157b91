"""Makes triangle meshes of surfaces with closed forms, with exact normals and curvatures, and UV maps of any charts.

A mesh is made of patches: grids of cells whose vertices are shared where patches or periods meet. A chart is a block of
cells, flattened by the patch's own parameters, turned, and put into a cell of the unit square.
"""

from dataclasses import dataclass, field

import numpy as np

from paradesc import bridge

VERTICES = 12000
JITTER = 0.3  # share of a grid cell; below 0.5 no triangle folds over
GUTTER = 0.94  # the part of its place in the UV map that a chart takes


@dataclass
class Patch:
    """A grid of cells; all arrays are over its (nu + 1, nv + 1) lattice points."""

    vertices: np.ndarray  # index of the mesh's vertex
    places: np.ndarray  # (…, 2) parameters in units of the surface, about isometric
    net: tuple[float, float] = (0.0, 0.0)  # where the patch lies in the net of one chart


@dataclass
class Surface:
    """A mesh and the exact values at its vertices."""

    name: str
    arrays: bridge.MeshArrays
    normals: np.ndarray  # (n, 3)
    mean: np.ndarray  # (n,)
    gaussian: np.ndarray  # (n,)
    boundary_distance: np.ndarray  # (n,) infinite on a closed surface
    directions: dict[str, np.ndarray] = field(default_factory=dict)  # (n, 3) if they have a closed form

    @property
    def diagonal(self):
        return float(np.linalg.norm(np.ptp(self.arrays.positions, axis=0)))

    def exact(self, name, radius):
        """(n,) or (n, 3) values as r → 0, to the first term that depends on curvature; None without a closed form."""
        h, k = self.mean, self.gaussian
        root = np.sqrt(np.maximum(h * h - k, 0.0))
        high, low = h + root, h - root
        disk = np.pi * radius**2
        volume = 2 * np.pi * radius**3 / 3 - np.pi * h * radius**4 / 4
        closed = {
            "mean_curvature": h,
            "gaussian_curvature": k,
            "principal_curvature_max": high,
            "principal_curvature_min": low,
            "curvedness": np.sqrt((high**2 + low**2) / 2),
            "shape_index": 2 / np.pi * np.arctan2(high + low, high - low),
            "local_bending_energy": (high**2 + low**2) / 2,
            "sphere_volume": volume,
            "sphere_volume_normalized": volume / (4 * np.pi * radius**3 / 3),
            "euclidean_area": disk * (1 + (high - low) ** 2 * radius**2 / 32),
            "geodesic_area": disk * (1 - k * radius**2 / 12),
        }
        return closed.get(name, self.directions.get(name))


# ---- Triangulations


def rectangle(lengths, periodic, vertices, irregular, seed):
    """Makes a patch over [0, 1]² of about that many vertices: its vertices' parameters (n, 2), and the patch."""
    generator = np.random.default_rng(seed)
    nu = max(4, round(np.sqrt(vertices * lengths[0] / lengths[1])))
    nv = max(4, round(vertices / nu))
    columns, rows = (nu if periodic[0] else nu + 1), (nv if periodic[1] else nv + 1)
    i, j = np.meshgrid(np.arange(columns), np.arange(rows), indexing="ij")
    shift = generator.uniform(-JITTER, JITTER, (columns, rows, 2)) * irregular
    if not periodic[0]:
        shift[[0, -1], :, 0] = 0
    if not periodic[1]:
        shift[:, [0, -1], 1] = 0
    parameters = (np.stack([i, j], axis=-1) + shift) / (nu, nv)
    i, j = np.meshgrid(np.arange(nu + 1), np.arange(nv + 1), indexing="ij")
    index = i % columns * rows + j % rows
    places = parameters[i % columns, j % rows] + np.stack([i // columns, j // rows], axis=-1)
    return parameters.reshape(-1, 2), Patch(index, places * lengths)


def cube_directions(vertices, irregular, seed):
    """Projects six patches of a cube to the sphere by equal angles: unit directions (n, 3), and the patches."""
    generator = np.random.default_rng(seed)
    n = max(4, round(np.sqrt(vertices / 6)))
    side = np.arange(n + 1)
    a, b = np.meshgrid(side, side, indexing="ij")
    inner = (a > 0) & (a < n) & (b > 0) & (b < n)
    x, y, z = np.eye(3)
    # Normal, and the directions of u and v, with the place in the cube's net: each face continues the one beside it.
    faces = [(x, y, z, (0, 1)), (y, -x, z, (1, 1)), (-x, -y, z, (2, 1)), (-y, x, z, (3, 1))]
    faces += [(z, y, -x, (0, 2)), (-z, y, x, (0, 0))]
    points, patches = [], []
    for normal, du, dv, net in faces:
        shift = generator.uniform(-JITTER, JITTER, (n + 1, n + 1, 2)) * inner[..., None] * irregular
        place = (np.stack([a, b], axis=-1) + shift) / n
        u, v = np.moveaxis(np.tan(np.pi / 4 * (2 * place - 1)), -1, 0)
        points.append((normal + u[..., None] * du + v[..., None] * dv).reshape(-1, 3))
        patches.append(Patch(np.arange((n + 1) ** 2).reshape(n + 1, n + 1), place, net))
    points = np.concatenate(points)
    _, first, shared = np.unique(np.round(points, 9), axis=0, return_index=True, return_inverse=True)
    shared = shared.reshape(6, n + 1, n + 1)
    for number, patch in enumerate(patches):
        patch.vertices = shared[number]
    points = points[first]
    return points / np.linalg.norm(points, axis=1, keepdims=True), patches


def triangulate(patch, points, irregular):
    """(cells, 2, 3) lattice corners of a patch's triangles: one diagonal everywhere, or the better one if irregular."""
    index = np.arange(patch.vertices.size).reshape(patch.vertices.shape)
    a, b, c, d = (part.reshape(-1) for part in (index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]))
    one = np.stack([np.stack([a, b, c], -1), np.stack([a, c, d], -1)], 1)
    if not irregular:
        return one
    other = np.stack([np.stack([a, b, d], -1), np.stack([b, c, d], -1)], 1)
    place = points[patch.vertices.reshape(-1)]
    turn = angle_at(place, b, a, c) + angle_at(place, d, a, c) > np.pi
    return np.where(turn[:, None, None], other, one)


def angle_at(points, tip, left, right):
    """(n,) angle at the tips of the triangles."""
    u, v = points[left] - points[tip], points[right] - points[tip]
    cosine = (u * v).sum(1) / np.linalg.norm(u, axis=1) / np.linalg.norm(v, axis=1)
    return np.arccos(np.clip(cosine, -1, 1))


# ---- UV maps


def lay_out(patches, charts, seed):
    """For each patch the chart of every cell, and each chart's affine map; charts: blocks along a patch's sides."""
    generator = np.random.default_rng(seed)
    total = len(patches) * charts[0] * charts[1]
    grid = int(np.ceil(np.sqrt(total)))
    result, number = [], 0
    for patch in patches:
        nu, nv = (size - 1 for size in patch.vertices.shape)
        block_u, block_v = np.arange(nu) * charts[0] // nu, np.arange(nv) * charts[1] // nv
        chart = np.add.outer(block_u * charts[1], block_v).reshape(-1)
        boxes = []
        for block in range(charts[0] * charts[1]):
            rows = np.flatnonzero(block_u == block // charts[1])
            columns = np.flatnonzero(block_v == block % charts[1])
            box = patch.places[rows[0] : rows[-1] + 2, columns[0] : columns[-1] + 2].reshape(-1, 2)
            place = np.array([number % grid, number // grid])
            boxes.append(chart_map(box, place, grid, generator))
            number += 1
        result.append((chart, boxes))
    return result


def chart_map(box, place, grid, generator):
    """(2, 3) affine map of places (k, 2) into a cell of the unit square, turned by a random angle."""
    angle = generator.uniform(0, 2 * np.pi)
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    turned = box @ turn.T
    low, size = turned.min(0), np.ptp(turned, axis=0).max()
    scale = GUTTER / grid / size
    middle = low + np.ptp(turned, axis=0) / 2
    return np.column_stack([scale * turn, (place + 0.5) / grid - scale * middle])


def build(points, patches, charts, irregular, seed):
    """The mesh of the patches; charts: 1 for one chart (the net of all patches), else blocks along a patch's sides."""
    vertices, uvs = [], []
    maps = None if charts == 1 else lay_out(patches, charts, seed)
    net = np.concatenate([(patch.places + patch.net).reshape(-1, 2) for patch in patches])
    low, size = net.min(0), np.ptp(net, axis=0).max()
    for number, patch in enumerate(patches):
        corners = triangulate(patch, points, irregular)
        vertices.append(patch.vertices.reshape(-1)[corners].reshape(-1, 3))
        place = patch.places.reshape(-1, 2)[corners]
        if maps is None:
            uvs.append(((place + patch.net - low) / size * 0.98 + 0.01).reshape(-1, 3, 2))
            continue
        chart, boxes = maps[number]
        affine = np.array(boxes)[chart]
        flat = np.einsum("cij,ctkj->ctki", affine[:, :, :2], place) + affine[:, None, None, :, 2]
        uvs.append(flat.reshape(-1, 3, 2))
    return as_arrays(points, np.concatenate(vertices), np.concatenate(uvs))


def as_arrays(points, triangles, uvs=None):
    """Triangles (t, 3) and the UVs of their corners (t, 3, 2) as the native library reads them."""
    return bridge.MeshArrays(
        positions=points.astype(np.float32),
        corner_vertices=triangles.reshape(-1).astype(np.int32),
        triangle_corners=np.arange(triangles.size, dtype=np.int32).reshape(-1, 3),
        corner_uvs=None if uvs is None else uvs.reshape(-1, 2).astype(np.float32),
    )


def distance_to_boundary(points, patch, open_sides):
    """(n,) distance to the nearest vertex of the sides of the patch that are open."""
    border = []
    if open_sides[0]:
        border += [patch.vertices[0], patch.vertices[-1]]
    if open_sides[1]:
        border += [patch.vertices[:, 0], patch.vertices[:, -1]]
    if not border:
        return np.full(len(points), np.inf)
    rim = points[np.unique(np.concatenate(border))]
    nearest = [np.linalg.norm(some[:, None] - rim, axis=2).min(1) for some in np.array_split(points, 64)]
    return np.concatenate(nearest)


# ---- Surfaces


def sphere(vertices=VERTICES, irregular=True, charts=1, seed=1):
    return ellipsoid(vertices, irregular, charts, seed, axes=(1.0, 1.0, 1.0), name="sphere")


def ellipsoid(vertices=VERTICES, irregular=True, charts=1, seed=1, axes=(1.0, 0.75, 0.5), name="ellipsoid"):
    directions, patches = cube_directions(vertices, irregular, seed)
    axes = np.array(axes)
    points = directions * axes
    slope = np.linalg.norm(points / axes**2, axis=1)
    product = np.prod(axes**2)
    mean = ((axes**2).sum() - (points**2).sum(1)) / (2 * product * slope**3)
    arrays = build(points, patches, charts if charts == 1 else (charts, charts), irregular, seed)
    normals = points / axes**2 / slope[:, None]
    return Surface(name, arrays, normals, mean, 1 / (product * slope**4), np.full(len(points), np.inf))


def of_rectangle(name, lengths, periodic, charts, vertices, irregular, seed, shape):
    """A surface over [0, 1]²: shape(u, v) gives points, normals, H, K and principal directions by name."""
    parameters, patch = rectangle(np.array(lengths), periodic, vertices, irregular, seed)
    points, normals, mean, gaussian, directions = shape(parameters[:, 0], parameters[:, 1])
    arrays = build(points, [patch], charts, irregular, seed)
    distance = distance_to_boundary(points, patch, [not closed for closed in periodic])
    return Surface(name, arrays, normals, mean, gaussian, distance, directions)


def torus(vertices=VERTICES, irregular=True, charts=1, seed=1, ring=1.0, tube=0.4):
    def shape(u, v):
        t, p = 2 * np.pi * u, 2 * np.pi * v
        normals = np.stack([np.cos(p) * np.cos(t), np.cos(p) * np.sin(t), np.sin(p)], -1)
        reach = ring + tube * np.cos(p)
        points = np.stack([reach * np.cos(t), reach * np.sin(t), tube * np.sin(p)], -1)
        around = np.stack([-np.sin(p) * np.cos(t), -np.sin(p) * np.sin(t), np.cos(p)], -1)
        along = np.stack([-np.sin(t), np.cos(t), 0 * t], -1)
        low = np.cos(p) / reach
        directions = {"principal_direction_max": around, "principal_direction_min": along}
        return points, normals, (1 / tube + low) / 2, low / tube, directions

    lengths = (2 * np.pi * ring, 2 * np.pi * tube)
    blocks = charts if charts == 1 else (2 * charts, charts)
    return of_rectangle("torus", lengths, (True, True), blocks, vertices, irregular, seed, shape)


def cylinder(vertices=VERTICES, irregular=True, charts=1, seed=1, radius=0.5, height=2.0):
    def shape(u, v):
        t = 2 * np.pi * u
        normals = np.stack([np.cos(t), np.sin(t), 0 * t], -1)
        points = normals * radius + np.stack([0 * t, 0 * t, height * (v - 0.5)], -1)
        axis = np.broadcast_to([0.0, 0.0, 1.0], points.shape)
        around = np.stack([-np.sin(t), np.cos(t), 0 * t], -1)
        directions = {"principal_direction_max": around, "principal_direction_min": axis}
        return points, normals, np.full(len(u), 0.5 / radius), np.zeros(len(u)), directions

    blocks = charts if charts == 1 else (charts, charts)
    lengths = (2 * np.pi * radius, height)
    return of_rectangle("cylinder", lengths, (True, False), blocks, vertices, irregular, seed, shape)


def saddle(vertices=VERTICES, irregular=True, charts=1, seed=1):
    def shape(u, v):
        x, y = 2 * u - 1, 2 * v - 1
        slope = np.sqrt(1 + x * x + y * y)
        normals = np.stack([-y, -x, np.ones_like(x)], -1) / slope[:, None]
        return np.stack([x, y, x * y], -1), normals, x * y / slope**3, -1 / slope**4, {}

    blocks = charts if charts == 1 else (charts, charts)
    return of_rectangle("saddle", (2.0, 2.0), (False, False), blocks, vertices, irregular, seed, shape)


def catenoid(vertices=VERTICES, irregular=True, charts=1, seed=1, neck=0.5, half=0.6):
    def shape(u, v):
        t, s = 2 * np.pi * u, half * (2 * v - 1)
        reach = neck * np.cosh(s / neck)
        points = np.stack([reach * np.cos(t), reach * np.sin(t), s], -1)
        rise = np.sinh(s / neck)
        normals = np.stack([np.cos(t), np.sin(t), -rise], -1) / np.cosh(s / neck)[:, None]
        return points, normals, np.zeros(len(u)), -1 / (neck**2 * np.cosh(s / neck) ** 4), {}

    blocks = charts if charts == 1 else (charts, charts)
    lengths = (2 * np.pi * neck * np.cosh(half / neck / 2), 2 * neck * np.sinh(half / neck))
    return of_rectangle("catenoid", lengths, (True, False), blocks, vertices, irregular, seed, shape)


SURFACES = {
    "sphere": sphere,
    "torus": torus,
    "ellipsoid": ellipsoid,
    "cylinder": cylinder,
    "saddle": saddle,
    "catenoid": catenoid,
}
