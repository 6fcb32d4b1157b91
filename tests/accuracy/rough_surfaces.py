"""Makes surfaces that are not smooth: folded, noisy, stepped, decimated ones of known curvature, and solids with known edges."""

import numpy as np
from surfaces import JITTER, cube_directions, rectangle

RADIUS, TUBE = 1.0, 0.4  # of the torus
SEMIAXES = {"sphere": np.ones(3), "ellipsoid": np.array([1.5, 1.0, 0.7])}
CURVATURES = ("mean_curvature", "gaussian_curvature", "principal_curvature_max", "principal_curvature_min")


def triangles_of(patch):
    """(2 * cells, 3) triangles of a patch, all cells cut along the same diagonal, so that some fold where vertices move far."""
    place = patch.vertices
    a, b, c, d = place[:-1, :-1], place[1:, :-1], place[1:, 1:], place[:-1, 1:]
    return np.concatenate([np.stack(part, -1).reshape(-1, 3) for part in ((a, b, c), (a, c, d))])


def torus(vertices, moved=0.0, seed=0):
    """A torus whose vertices are moved along it by up to this share of a cell: points, triangles."""
    parameters, patch = rectangle((RADIUS, TUBE), (True, True), vertices, moved / JITTER, seed)
    u, v = 2 * np.pi * parameters.T
    ring = RADIUS + TUBE * np.cos(v)
    return np.stack([ring * np.cos(u), ring * np.sin(u), TUBE * np.sin(v)], 1), triangles_of(patch)


def round_body(axes, vertices, moved=0.0, seed=0):
    """A sphere or an ellipsoid in six patches, whose inner vertices are moved along it by up to this share of a cell."""
    directions, patches = cube_directions(vertices, moved / JITTER, seed)
    return directions * axes, np.concatenate([triangles_of(patch) for patch in patches])


def made(body, vertices, moved=0.0, seed=0):
    """Points and triangles of a torus, a sphere or an ellipsoid."""
    if body == "torus":
        return torus(vertices, moved, seed)
    return round_body(SEMIAXES[body], vertices, moved, seed)


def exact(body, points):
    """The curvatures and the (n, 3) normals of a body at its points that are nearest to these: (n,) by name."""
    if body == "torus":
        around = np.hypot(points[:, 0], points[:, 1])
        v = np.arctan2(points[:, 2], around - RADIUS)
        low = np.cos(v) / (RADIUS + TUBE * np.cos(v))
        normals = np.column_stack([points[:, :2] * (np.cos(v) / around)[:, None], np.sin(v)])
        mean, gaussian = (1 / TUBE + low) / 2, low / TUBE
    else:
        squares = SEMIAXES[body] ** 2
        near = nearest(squares, points)
        normals = near / squares
        height = 1 / np.linalg.norm(normals, axis=1)
        normals *= height[:, None]
        mean = (squares.sum() - (near**2).sum(1)) * height**3 / (2 * np.prod(squares))
        gaussian = height**4 / np.prod(squares)
    root = np.sqrt(np.maximum(mean**2 - gaussian, 0))
    found = (mean, gaussian, mean + root, mean - root)
    return dict(zip(CURVATURES, found, strict=True)) | {"normals": normals}


def nearest(squares, points):
    """The points of an ellipsoid with these squares of its semiaxes that are nearest to (n, 3) points about it.

    They are a² y / (a² + t), with the t that lays them on the ellipsoid, by Newton's method.
    """
    t = np.zeros(len(points))
    for _ in range(20):
        place = points / (squares + t[:, None])
        above = (squares * place**2).sum(1) - 1
        t += above / (2 * squares * place**2 / (squares + t[:, None])).sum(1)
    return squares * points / (squares + t[:, None])


def mean_edge(points, faces):
    """The mean length of the triangles' sides."""
    return np.mean([np.linalg.norm(points[faces[:, k]] - points[faces[:, k - 1]], axis=1) for k in range(3)])


def noisy(points, faces, amount, seed=0, ways=None):
    """The points, each coordinate moved by a normal deviate of so many mean edges; or along (n, 3) ways alone."""
    generator = np.random.default_rng(seed + 100)
    shift = generator.normal(size=points.shape if ways is None else (len(points), 1))
    return points + shift * (1 if ways is None else ways) * amount * mean_edge(points, faces)


def staircase(body, cell):
    """Marching cubes of the voxels whose centers lie in a body: points, triangles."""
    import vtk
    from vtk.util import numpy_support

    reach = SEMIAXES.get(body, np.array([RADIUS + TUBE, RADIUS + TUBE, TUBE])) + 2 * cell
    ways = [np.arange(-far, far + cell, cell) for far in reach]
    place = np.meshgrid(*ways, indexing="ij")
    if body == "torus":
        inside = (np.hypot(place[0], place[1]) - RADIUS) ** 2 + place[2] ** 2 < TUBE**2
    else:
        inside = sum((way / axis) ** 2 for way, axis in zip(place, SEMIAXES[body], strict=True)) < 1
    image = vtk.vtkImageData()
    image.SetDimensions(*(len(way) for way in ways))
    image.SetSpacing(cell, cell, cell)
    image.SetOrigin(*(way[0] for way in ways))
    image.GetPointData().SetScalars(numpy_support.numpy_to_vtk(inside.astype(np.float32).ravel(order="F"), deep=True))
    cubes = vtk.vtkMarchingCubes()
    cubes.SetInputData(image)
    cubes.SetValue(0, 0.5)
    cubes.Update()
    return arrays_of(cubes.GetOutput())


def arrays_of(surface):
    """Points and triangles of VTK's surface, wound outwards."""
    from vtk.util import numpy_support

    points = numpy_support.vtk_to_numpy(surface.GetPoints().GetData()).astype(float)
    faces = numpy_support.vtk_to_numpy(surface.GetPolys().GetData()).reshape(-1, 4)[:, 1:].astype(int)
    corners = points[faces]
    volume = np.einsum("ij,ij->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2]))
    return points, faces if volume > 0 else faces[:, ::-1]


def box(cells):
    """A cube with so many cells along a side: points, triangles."""
    side = 2 * np.arange(cells + 1) / cells - 1
    a, b = (part.reshape(-1) for part in np.meshgrid(side, side, indexing="ij"))
    place = np.arange((cells + 1) ** 2).reshape(cells + 1, -1)
    corners = [part.reshape(-1) for part in (place[:-1, :-1], place[1:, :-1], place[1:, 1:], place[:-1, 1:])]
    triangles = np.concatenate([np.stack([corners[0], corners[k], corners[k + 1]], 1) for k in (1, 2)])
    points, faces = [], []
    for axis in range(3):
        for sign in (1, -1):
            points.append(np.stack([np.full_like(a, sign), sign * a, b], 1)[:, np.argsort(np.roll(range(3), -axis))])
            faces.append(triangles + len(faces) * len(a))
    points, faces = np.concatenate(points), np.concatenate(faces)
    _, first, shared = np.unique(np.round(points, 6), axis=0, return_index=True, return_inverse=True)
    return points[first], shared.reshape(-1)[faces]


def ridge(bend, rows=24):
    """A bar whose section is a triangle; its upper edge bends by so many degrees: points, triangles."""
    height = 0.5 * np.tan(np.radians(bend) / 2)
    section = np.array([[-0.5, 0], [0.5, 0], [0, height]])
    sides = np.roll(section, -1, 0) - section
    counts = np.maximum(1, np.round(np.linalg.norm(sides, axis=1) * rows)).astype(int)
    ring = np.concatenate(
        [start + side * np.arange(n)[:, None] / n for start, side, n in zip(section, sides, counts, strict=True)]
    )
    n, layers = len(ring), max(1, int(counts.min()) // 3)
    middle = section.mean(0)

    def place(points, y):
        return np.stack([points[:, 0], np.full(len(points), y), points[:, 1]], 1)

    rings = [place(middle + (ring - middle) * k / layers, 0.0) for k in range(1, layers)]
    rings += [place(ring, y) for y in np.linspace(0, 1, rows + 1)]
    rings += [place(middle + (ring - middle) * k / layers, 1.0) for k in range(layers - 1, 0, -1)]
    i, j = np.meshgrid(np.arange(len(rings) - 1), np.arange(n), indexing="ij")
    a, b = i * n + j, i * n + (j + 1) % n
    faces = [np.stack([a, b + n, b], -1).reshape(-1, 3), np.stack([a, a + n, b + n], -1).reshape(-1, 3)]
    total, own, after = n * len(rings), np.arange(n), np.roll(np.arange(n), -1)
    faces.append(np.stack([own, after, np.full(n, total)], 1))
    faces.append(np.stack([after + total - n, own + total - n, np.full(n, total + 1)], 1))
    ends = np.stack([place(middle[None], y)[0] for y in (0.0, 1.0)])
    return np.concatenate([*rings, ends]), np.concatenate(faces)
