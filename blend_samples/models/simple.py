"""Six simpler assets: a gear, a vase, a column, a helmet, a rock and a low-poly house."""

import math
from collections.abc import Sequence
from itertools import pairwise

import bmesh
import bpy
import numpy as np

from .parts import build, place, ramp, rough
from .solids import Part, Solid, box, cone, disk, ellipsoid, joined, ring


def gear() -> bpy.types.Object:
    """A machined gear 1 wide in large flat faces: teeth, a rim, six holes, a hub with a bore and a key."""
    teeth, circle = 24, 144
    turns = 2 * np.pi * np.arange(circle) / circle
    tooth = np.array([0.5, 0.5, 0.485, 0.44, 0.44, 0.485])[np.arange(circle) % (circle // teeth)]
    outer = np.stack([tooth * np.cos(turns), tooth * np.sin(turns)], axis=1)
    made = prism("gear", outer, -0.07, 0.07)
    for z in (-0.1, 0.1):
        cut(made, prism("well", lathe_circle(0.37, 96), z - 0.06, z + 0.06))
    add(made, prism("hub", lathe_circle(0.16, 96), -0.11, 0.11))
    cut(made, prism("bore", lathe_circle(0.08, 64), -0.2, 0.2))
    cut(made, prism("key", np.array([[-0.02, 0], [0.02, 0], [0.02, 0.105], [-0.02, 0.105]]), -0.2, 0.2))
    for k in range(6):
        middle = 0.265 * np.array([math.cos(k * math.pi / 3), math.sin(k * math.pi / 3)])
        cut(made, prism("hole", middle + lathe_circle(0.06, 48), -0.2, 0.2))
    bevel = made.modifiers.new("bevel", "BEVEL")
    bevel.width, bevel.segments, bevel.limit_method, bevel.angle_limit = 0.006, 2, "ANGLE", math.radians(35)
    bpy.ops.object.modifier_apply(modifier=bevel.name)
    made.rotation_euler = (math.radians(90), 0, 0)
    return made


def lathe_circle(radius: float, sides: int) -> np.ndarray:
    """(sides, 2) points of a circle."""
    turns = 2 * np.pi * np.arange(sides) / sides
    return radius * np.stack([np.cos(turns), np.sin(turns)], axis=1)


def prism(name: str, outline: np.ndarray, low: float, high: float) -> bpy.types.Object:
    """A flat outline (n, 2) between two heights."""
    count = len(outline)
    points = [(*point, z) for z in (low, high) for point in outline]
    sides = [(k, (k + 1) % count, count + (k + 1) % count, count + k) for k in range(count)]
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(points, [], [*sides, tuple(range(count))[::-1], tuple(range(count, 2 * count))])
    return place(name, mesh)


def cut(made: bpy.types.Object, other: bpy.types.Object, operation: str = "DIFFERENCE") -> None:
    """Takes an object away from another, and removes it."""
    bpy.context.view_layer.objects.active = made
    modifier = made.modifiers.new("cut", "BOOLEAN")
    modifier.operation, modifier.solver, modifier.object = operation, "EXACT", other
    bpy.ops.object.modifier_apply(modifier=modifier.name)
    bpy.data.meshes.remove(other.data)
    made.select_set(True)


def add(made: bpy.types.Object, other: bpy.types.Object) -> None:
    """Unites an object with another, and removes it."""
    cut(made, other, "UNION")


def lathe(name: str, profile: Sequence[tuple[float, float]], sides: int, spacing: float) -> bpy.types.Object:
    """A profile (radius, height) turned around z, closed where its ends lie on the axis; long lines are divided."""
    places = []
    for (a, b), (c, d) in pairwise(profile):
        count = max(round(math.hypot(c - a, d - b) / spacing), 1)
        places += [(a + (c - a) * k / count, b + (d - b) * k / count) for k in range(count)]
    places = [*places, profile[-1]]
    turns = 2 * np.pi * np.arange(sides) / sides
    points = [(r * math.cos(turn), r * math.sin(turn), z) for r, z in places for turn in turns]
    rows = np.arange(len(places) - 1)[:, None, None] * sides
    around = np.arange(sides)[None, :, None]
    ahead = (around + 1) % sides
    quads = np.concatenate([rows + around, rows + ahead, rows + sides + ahead, rows + sides + around], axis=2)
    made = build(name, np.array(points), quads.reshape(-1, 4))
    shape = bmesh.new()
    shape.from_mesh(made.data)
    bmesh.ops.remove_doubles(shape, verts=shape.verts, dist=1e-5)
    shape.to_mesh(made.data)
    shape.free()
    return made


def vase() -> bpy.types.Object:
    """A turned vase 1 high with ribs around its neck and foot, thin walls and a rolled rim."""
    heights = np.linspace(0.05, 0.95, 130)
    belly = (
        0.12
        + 0.26 * ramp(heights, 0.02, 0.5) * (1 - 0.78 * ramp(heights, 0.45, 0.82))
        + 0.09 * ramp(heights, 0.8, 0.97)
    )
    ribs = 0.008 * np.cos(2 * np.pi * heights / 0.035) * (ramp(heights, 0.7, 0.73) * ramp(heights, 0.86, 0.83))
    bands = 0.012 * np.exp(-(((heights - 0.56) / 0.008) ** 2)) + 0.012 * np.exp(-(((heights - 0.36) / 0.008) ** 2))
    outer = belly + ribs + bands
    lip = [
        (outer[-1] + 0.012 + 0.025 * math.cos(turn), 0.965 + 0.02 * math.sin(turn))
        for turn in np.linspace(-1.2, 3.6, 16)
    ]
    inner = [(r - 0.03, z) for r, z in zip(belly[::-1], heights[::-1], strict=True) if z > 0.1]
    foot = [(0, 0.0), (0.15, 0.0), (0.17, 0.01), (0.17, 0.03), (0.15, 0.045)]
    profile = [*foot, *zip(outer, heights, strict=True), *lip, *inner, (0.0, 0.1)]
    return lathe("vase", profile, 160, 0.012)


def column() -> bpy.types.Object:
    """A fluted column 2 high on a round base, with a square plate on top."""
    solid = Solid((-0.36, -0.36, -0.02), (0.36, 0.36, 2.04), 0.0125)
    solid.add(box((0, 0, 0.06), (0.33, 0.33, 0.06), 0.012))
    solid.add(disk((0, 0, 0.17), 2, 0.3, 0.055, 0.05))
    solid.add(disk((0, 0, 0.25), 2, 0.26, 0.04, 0.035))
    shaft = Part(fluted, (-0.26, -0.26, 0.2), (0.26, 0.26, 1.82))
    solid.add(shaft, 0.01)
    solid.add(ring((0, 0, 1.7), 2, 0.2, 0.022), 0.006)
    solid.add(cone((0, 0, 1.76), (0, 0, 1.84), 0.2, 0.24), 0.01)
    solid.add(disk((0, 0, 1.86), 2, 0.28, 0.04, 0.03), 0.01)
    solid.add(box((0, 0, 1.96), (0.32, 0.32, 0.055), 0.012))
    for x, y, z, radius in ((-0.3, -0.32, 0.12, 0.08), (0.32, -0.3, 1.98, 0.07), (0.1, -0.24, 0.9, 0.06)):  # chips
        solid.cut(ellipsoid((x, y, z), (radius, radius, 0.8 * radius)), 0.01)
    points, quads = solid.mesh()
    return build("column", rough(points, quads, ((0.0015, 0.05, 3),)), quads)


def fluted(x: np.ndarray, y: np.ndarray, z: np.ndarray) -> np.ndarray:
    """The distance to the column's shaft, which swells a little."""
    angle, reach = np.arctan2(y, x), np.hypot(x, y)
    radius = 0.245 - 0.04 * np.clip((z - 0.3) / 1.5, 0, 1) ** 2
    hollow = 0.024 * np.abs(np.sin(8 * angle + 0.4)) ** 0.8 * ramp(z, 0.3, 0.36) * ramp(z, 1.66, 1.6)
    return np.maximum(reach - radius + hollow, np.abs(z - 1.01) - 0.81)


def helmet() -> bpy.types.Object:
    """A helmet with a crest, a slit to look through, holes to breathe and a riveted rim."""
    solid = Solid((0, -0.5, -0.5), (0.5, 0.55, 0.62), 0.0115, mirrored=True)
    solid.add(ellipsoid((0, 0.02, 0.06), (0.34, 0.42, 0.42), power=2.3))
    solid.add(cone((0, 0.0, -0.1), (0, -0.02, -0.36), 0.31, 0.27), 0.1)
    solid.cut(ellipsoid((0, 0.02, 0.04), (0.30, 0.38, 0.38), power=2.3))
    solid.cut(cone((0, 0.0, -0.1), (0, 0, -0.6), 0.27, 0.235))
    solid.cut(box((0, 0, -0.5), (1, 1, 0.09)))
    solid.add(ring((0, -0.012, -0.4), 2, 0.275, 0.026), 0.012)
    for a, b in (
        ((0, -0.42, 0.1), (0, -0.24, 0.42)),
        ((0, -0.24, 0.42), (0, 0.1, 0.53)),
        ((0, 0.1, 0.53), (0, 0.42, 0.3)),
    ):
        solid.add(cone(a, b, 0.035, 0.045, (1.6, 1, 1)), 0.02)
    solid.add(cone((0, -0.42, 0.14), (0.33, -0.12, 0.14), 0.035, 0.03), 0.02)
    solid.add(cone((0, -0.43, 0.1), (0, -0.36, -0.36), 0.03, 0.03), 0.02)
    solid.cut(box((0.15, -0.36, 0.055), (0.11, 0.2, 0.022), 0.015, (0, 0, 24)), 0.006)
    for row in range(3):
        for column in range(4):
            solid.cut(ellipsoid((0.075 + 0.05 * column, -0.33, -0.08 - 0.06 * row), (0.014, 0.2, 0.014)), 0.006)
    for k in range(9):
        turn = math.pi * (k + 0.5) / 9 - math.pi / 2
        solid.add(ellipsoid((0.3 * math.cos(turn), 0.3 * math.sin(turn) - 0.012, -0.4), (0.016, 0.016, 0.016)), 0.004)
    return build("helmet", *solid.mesh())


def rock() -> bpy.types.Object:
    """A boulder broken along planes, with cracks and a rough skin."""
    generator = np.random.default_rng(9)
    normals = generator.normal(size=(40, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    heights = generator.uniform(0.38, 0.52, 40)

    def distance(x: np.ndarray, y: np.ndarray, z: np.ndarray) -> np.ndarray:
        deepest = np.float32(-1)
        for (a, b, c), height in zip(normals, heights, strict=True):
            face = a * x + b * y + 1.25 * c * z - height
            deepest = -joined(-deepest, -face, 0.04)
        return deepest

    solid = Solid((-0.75, -0.75, -0.6), (0.75, 0.75, 0.6), 0.0125)
    solid.add(Part(distance, (-0.7, -0.7, -0.55), (0.7, 0.7, 0.55)))
    solid.add(ellipsoid((0.35, -0.2, -0.25), (0.25, 0.2, 0.16), (10, 20, 30), 3), 0.03)
    points, quads = solid.mesh()
    points = rough(points, quads, ((0.04, 0.35, 2), (0.012, 0.08, 4)))
    return build("rock", points, quads)


def house() -> bpy.types.Object:
    """A low-poly house without a single bevel: walls, a roof, a chimney, a porch, windows and a door."""
    shape = bmesh.new()
    blocks = [
        ((0, 0, 0.3), (0.5, 0.36, 0.3)),
        ((0, 0, 0.03), (0.54, 0.4, 0.03)),
        ((0.26, 0.1, 0.86), (0.07, 0.07, 0.24)),
    ]
    blocks += [((0.26, 0.1, 1.11), (0.09, 0.09, 0.025)), ((-0.18, -0.43, 0.04), (0.13, 0.09, 0.04))]
    for x in (-0.3, -0.06):
        blocks.append(((x, -0.48, 0.28), (0.018, 0.018, 0.24)))
    blocks.append(((-0.18, -0.43, 0.53), (0.16, 0.12, 0.02)))
    blocks += window((0.22, -0.36, 0.36), 0) + window((0.5, 0.05, 0.36), 1) + window((-0.5, 0.0, 0.36), 1)
    blocks += [((-0.18, -0.365, 0.28), (0.075, 0.02, 0.2)), ((-0.18, -0.372, 0.275), (0.055, 0.02, 0.165))]
    for center, half in blocks:
        corners = bmesh.ops.create_cube(shape, size=2)["verts"]
        for vertex in corners:
            vertex.co = [c + h * along for c, h, along in zip(center, half, vertex.co, strict=True)]
    add_roof(shape)
    bmesh.ops.recalc_face_normals(shape, faces=shape.faces)
    mesh = bpy.data.meshes.new("house")
    shape.to_mesh(mesh)
    shape.free()
    return place("house", mesh)


def window(center: Sequence[float], axis: int) -> list[tuple]:
    """The boxes of a window in a wall: a frame, bars, a sill; axis: 0 for walls that look along y."""

    def across(u: float, v: float, out: float) -> tuple[float, float, float]:
        return (u, out, v) if axis == 0 else (out, u, v)

    found = []
    frame = ((0, 0.11, 0.1, 0.014), (0, -0.11, 0.1, 0.014), (-0.086, 0, 0.012, 0.11), (0.086, 0, 0.012, 0.11))
    for u, v, wide, high in (*frame, (0, 0, 0.08, 0.007), (0, 0, 0.0065, 0.1)):
        thick = (0.012 if min(wide, high) < 0.01 else 0.02) - 0.002 * (high > wide)
        found.append((tuple(np.array(center) + across(u, v, 0)), across(wide, high, thick)))
    found.append((tuple(np.array(center) + across(0, -0.13, 0)), across(0.115, 0.012, 0.04)))
    return found


def add_roof(shape: bmesh.types.BMesh) -> None:
    """A gable and two thick slopes that stand over the walls."""

    def solid(outline: Sequence[tuple[float, float]], low: float, high: float) -> None:
        ends = [[shape.verts.new((x, y, z)) for y, z in outline] for x in (low, high)]
        shape.faces.new(ends[0])
        shape.faces.new(ends[1][::-1])
        for k in range(len(outline)):
            shape.faces.new((ends[0][k - 1], ends[0][k], ends[1][k], ends[1][k - 1]))

    solid([(-0.36, 0.6), (0.36, 0.6), (0, 0.92)], -0.5, 0.5)
    for side in (-1, 1):
        solid([(side * 0.46, 0.52), (0, 0.929), (0, 0.995), (side * 0.46, 0.586)][::side], -0.57, 0.57)
