"""Writes the sample scenes torus.blend (many charts, turned, scaled and mirrored) and suzanne.blend (unwrapped).

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
    """Blender's monkey, subdivided and unwrapped by Smart UV Project, at an angle at which no chart overlaps itself."""
    bpy.ops.mesh.primitive_monkey_add()
    made = bpy.context.active_object
    modifier = made.modifiers.new("subdivision", "SUBSURF")
    modifier.levels = SUZANNE_LEVELS
    mesh = bpy.data.meshes.new_from_object(made.evaluated_get(bpy.context.evaluated_depsgraph_get()))
    made.modifiers.remove(modifier)
    made.data = mesh
    made.name = mesh.name = "suzanne"
    mesh.polygons.foreach_set("use_smooth", np.ones(len(mesh.polygons), bool))
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="SELECT")
    bpy.ops.uv.smart_project(angle_limit=0.8, island_margin=0.01)
    bpy.ops.object.mode_set(mode="OBJECT")
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
    for name, make in (("torus", make_torus), ("suzanne", make_suzanne)):
        bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
        bpy.context.preferences.filepaths.save_version = 0
        save(make(), folder / f"{name}.blend")


if __name__ == "__main__":
    main()
