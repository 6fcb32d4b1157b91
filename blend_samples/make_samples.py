"""Writes the sample scenes torus.blend (many charts, turned and mirrored), suzanne.blend and rim.blend (unwrapped).

Usage: python make_samples.py FOLDER, with Blender's module bpy; or blender -b -P make_samples.py -- FOLDER.
"""

import sys
from pathlib import Path

import bpy
import numpy as np

# Torus: radii of ring and tube, faces around both, charts around both.
RING, TUBE = 1.0, 0.4
RING_FACES, TUBE_FACES = 160, 80
RING_CHARTS, TUBE_CHARTS = 4, 4
# The part of its cell in the UV map that a chart's circumcircle takes up: the rest keeps charts apart.
CHART_SHARE = 0.94
SUZANNE_LEVELS = 2
# A wheel: windows between spokes, and a hole in its hub. Every hole is a handle of the surface: genus 20.
RIM_WINDOWS = 19
RIM_LEVELS = 2
SPOKE_SHARE = 0.42  # of the angle from one spoke to the next
# Of each circle of the wheel: radius, height of its middle, half of its thickness.
RIM_CIRCLES = np.array(
    [
        [0.15, 0.10, 0.10],
        [0.34, 0.10, 0.13],
        [0.58, 0.05, 0.07],
        [0.80, 0.00, 0.09],
        [0.90, 0.00, 0.20],
        [1.00, 0.00, 0.24],
    ]
)
SPOKES = range(1, 3)  # between the second circle and the fourth


def torus_points() -> np.ndarray:
    """(RING_FACES * TUBE_FACES, 3) positions, ring by ring."""
    ring, tube = np.meshgrid(
        2 * np.pi * np.arange(RING_FACES) / RING_FACES, 2 * np.pi * np.arange(TUBE_FACES) / TUBE_FACES, indexing="ij"
    )
    reach = RING + TUBE * np.cos(tube)
    return np.stack([reach * np.cos(ring), reach * np.sin(ring), TUBE * np.sin(tube)], axis=-1).reshape(-1, 3)


def torus_uvs(generator: np.random.Generator) -> np.ndarray:
    """(RING_FACES, TUBE_FACES, 4, 2) UVs of every face's corners; each chart is turned, scaled and maybe mirrored."""
    ring_step, tube_step = RING_FACES // RING_CHARTS, TUBE_FACES // TUBE_CHARTS
    size = np.array([2 * np.pi * (RING + TUBE) / RING_CHARTS, 2 * np.pi * TUBE / TUBE_CHARTS])
    uvs = np.empty((RING_FACES, TUBE_FACES, 4, 2))
    corners = np.array([[0, 0], [1, 0], [1, 1], [0, 1]])
    places = np.stack(np.meshgrid(np.arange(ring_step), np.arange(tube_step), indexing="ij"), axis=-1)
    local = (places[:, :, None, :] + corners) / (ring_step, tube_step) - 0.5
    for row in range(RING_CHARTS):
        for column in range(TUBE_CHARTS):
            angle, scale = generator.uniform(0, 2 * np.pi), generator.uniform(0.75, 1.0)
            mirror = -1.0 if generator.random() < 0.3 else 1.0
            turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
            cell = np.array([1 / RING_CHARTS, 1 / TUBE_CHARTS])
            chart = local * size * (mirror, 1.0) / np.linalg.norm(size) @ turn.T
            chart = chart * scale * CHART_SHARE * cell + (np.array([row, column]) + 0.5) * cell
            uvs[row * ring_step : (row + 1) * ring_step, column * tube_step : (column + 1) * tube_step] = chart
    return uvs


def make_torus() -> bpy.types.Object:
    """A closed torus whose UV map has RING_CHARTS * TUBE_CHARTS charts."""
    ring, tube = np.meshgrid(np.arange(RING_FACES), np.arange(TUBE_FACES), indexing="ij")
    next_ring, next_tube = (ring + 1) % RING_FACES, (tube + 1) % TUBE_FACES
    faces = np.stack(
        [
            ring * TUBE_FACES + tube,
            next_ring * TUBE_FACES + tube,
            next_ring * TUBE_FACES + next_tube,
            ring * TUBE_FACES + next_tube,
        ],
        axis=-1,
    ).reshape(-1, 4)
    mesh = bpy.data.meshes.new("torus")
    mesh.from_pydata(torus_points().tolist(), [], faces.tolist())
    layer = mesh.uv_layers.new(name="UVMap")
    uvs = torus_uvs(np.random.default_rng(0)).astype(np.float32)
    layer.data.foreach_set("uv", uvs.ravel())
    mesh.polygons.foreach_set("use_smooth", np.ones(len(faces), bool))
    mesh.update()
    return bpy.data.objects.new("torus", mesh)


def make_suzanne() -> bpy.types.Object:
    """Blender's monkey, subdivided and unwrapped at an angle at which no chart overlaps itself."""
    bpy.ops.mesh.primitive_monkey_add()
    made = bpy.context.active_object
    made.name = "suzanne"
    subdivide(made, SUZANNE_LEVELS)
    unwrap(made, 0.8)
    return made


def subdivide(made: bpy.types.Object, levels: int) -> None:
    """Puts the subdivided surface, smooth shaded, in the place of the object's mesh."""
    modifier = made.modifiers.new("subdivision", "SUBSURF")
    modifier.levels = levels
    mesh = bpy.data.meshes.new_from_object(made.evaluated_get(bpy.context.evaluated_depsgraph_get()))
    made.modifiers.remove(modifier)
    made.data = mesh
    mesh.name = made.name
    mesh.polygons.foreach_set("use_smooth", np.ones(len(mesh.polygons), bool))


def unwrap(made: bpy.types.Object, angle: float) -> None:
    """Smart UV Project over the whole mesh of the active object; angle: radians within one chart."""
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="SELECT")
    bpy.ops.uv.smart_project(angle_limit=angle, island_margin=0.01)
    bpy.ops.object.mode_set(mode="OBJECT")


def rim_cage() -> tuple[np.ndarray, list[list[int]]]:
    """Positions (n, 3) and quads of the wheel before it is subdivided: Euler characteristic 2 - 2 (RIM_WINDOWS + 1)."""
    columns, circles = 2 * RIM_WINDOWS, len(RIM_CIRCLES)
    turn = (np.arange(columns) // 2 + SPOKE_SHARE * (np.arange(columns) % 2)) * 2 * np.pi / RIM_WINDOWS
    radius, middle, half = RIM_CIRCLES.T
    x, y = np.outer(np.cos(turn), radius), np.outer(np.sin(turn), radius)
    sides = [np.stack([x, y, np.broadcast_to(height, x.shape)], axis=-1) for height in (middle + half, middle - half)]
    quads = []

    def vertex(column: int, circle: int, side: int) -> int:
        return (side * columns + column % columns) * circles + circle

    def solid(column: int, circle: int) -> bool:
        return 0 <= circle < circles - 1 and (circle not in SPOKES or column % 2 == 0)

    for column in range(columns):
        for circle in filter(lambda circle: solid(column, circle), range(circles - 1)):
            corners = [(column, circle), (column, circle + 1), (column + 1, circle + 1), (column + 1, circle)]
            beyond = [(column - 1, circle), (column, circle + 1), (column + 1, circle), (column, circle - 1)]
            quads.append([vertex(*corner, 0) for corner in corners])
            quads.append([vertex(*corner, 1) for corner in reversed(corners)])
            for a, b, other in zip(corners, corners[1:] + corners[:1], beyond, strict=True):
                if not solid(*other):
                    quads.append([vertex(*b, 0), vertex(*a, 0), vertex(*a, 1), vertex(*b, 1)])
    return np.concatenate([side.reshape(-1, 3) for side in sides]), quads


def make_rim() -> bpy.types.Object:
    """A wheel of genus 20, standing upright, subdivided and unwrapped into many charts."""
    points, quads = rim_cage()
    points = points[:, [0, 2, 1]] * (1, -1, 1)  # its front looks along -Y, where the pictures look from
    mesh = bpy.data.meshes.new("rim")
    mesh.from_pydata(points.tolist(), [], quads)
    mesh.update()
    made = bpy.data.objects.new("rim", mesh)
    bpy.context.collection.objects.link(made)
    bpy.context.view_layer.objects.active = made
    subdivide(made, RIM_LEVELS)
    unwrap(made, 0.8)
    return made


def save(made: bpy.types.Object, path: Path) -> None:
    """Saves the scene with the object in it and active."""
    if made.name not in bpy.context.collection.objects:
        bpy.context.collection.objects.link(made)
    bpy.context.view_layer.objects.active = made
    bpy.ops.wm.save_as_mainfile(filepath=str(path), check_existing=False)


def main() -> None:
    """Makes each sample in an empty scene of its own."""
    words = sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else sys.argv[1:]
    folder = Path(words[0]).resolve() if words else Path(__file__).resolve().parent
    for name, make in (("torus", make_torus), ("suzanne", make_suzanne), ("rim", make_rim)):
        bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
        bpy.context.preferences.filepaths.save_version = 0
        save(make(), folder / f"{name}.blend")


if __name__ == "__main__":
    main()
