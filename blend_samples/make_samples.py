"""Writes the sample scenes, each named by what it shows; README.md beside this file says what they are.

Usage: python make_samples.py FOLDER, with Blender's module bpy; or blender -b -P make_samples.py -- FOLDER.
"""

import sys
from collections.abc import Callable
from math import radians
from pathlib import Path

import bpy
import numpy as np
from mathutils import Vector

# The torus: radii of ring and tube, faces around both, charts around both.
RING, TUBE = 1.0, 0.4
RING_FACES, TUBE_FACES = 160, 80
RING_CHARTS, TUBE_CHARTS = 4, 4
# The part of its cell in the UV map that a chart's circumcircle takes; the rest keeps charts apart.
CHART_SHARE = 0.94
SUZANNE_LEVELS = 2
# A wheel: windows between spokes, and a hole in its hub. Every hole is a handle of the surface: genus 20.
RIM_WINDOWS = 19
RIM_LEVELS = 2
SPOKE_SHARE = 0.42  # of the angle from one spoke to the next
# For each circle of the wheel: radius, height of its middle, half of its thickness.
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
# A tube along z that so many bones bend by so much in all, back and forth over so many frames.
TUBE_RADIUS, TUBE_LENGTH, TUBE_COLUMNS, TUBE_ROWS = 0.4, 4.0, 48, 80
BONES, BEND = 10, radians(120)
FRAMES = 24
SPHERE_STEPS = 24  # quads along a side of the cube that became the sphere
LONG = 2.0  # what the shape key multiplies z by
FRAGMENT_SHARE = 0.8  # of its cell that the chart of a single face takes
# A square from -1 to 1 whose image has waves a cos(2 pi x) cos(2 pi y).
SQUARE_STEPS, WAVE_PIXELS, WAVE_HEIGHT = 64, 256, 0.06
WAVE_MIDLEVEL, WAVE_SCALE = 0.5, 0.12


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


def torus_faces() -> np.ndarray:
    """(RING_FACES * TUBE_FACES, 4) vertices of the quads."""
    ring, tube = np.meshgrid(np.arange(RING_FACES), np.arange(TUBE_FACES), indexing="ij")
    next_ring, next_tube = (ring + 1) % RING_FACES, (tube + 1) % TUBE_FACES
    return np.stack(
        [
            ring * TUBE_FACES + tube,
            next_ring * TUBE_FACES + tube,
            next_ring * TUBE_FACES + next_tube,
            ring * TUBE_FACES + next_tube,
        ],
        axis=-1,
    ).reshape(-1, 4)


def build(name: str, points: np.ndarray, faces: np.ndarray, uvs: np.ndarray | None) -> bpy.types.Object:
    """Makes a smooth shaded object of points (n, 3) and faces (m, k), with the UVs (m, k, 2) of their corners."""
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(points.tolist(), [], faces.tolist())
    if uvs is not None:
        layer = mesh.uv_layers.new(name="UVMap")
        layer.data.foreach_set("uv", uvs.astype(np.float32).ravel())
    mesh.polygons.foreach_set("use_smooth", np.ones(len(faces), bool))
    mesh.update()
    return bpy.data.objects.new(name, mesh)


def make_torus() -> bpy.types.Object:
    """Makes a closed torus whose UV map has RING_CHARTS * TUBE_CHARTS charts."""
    return build("torus", torus_points(), torus_faces(), torus_uvs(np.random.default_rng(0)))


def make_bare_torus() -> bpy.types.Object:
    """Makes the same torus without any UV map."""
    return build("torus", torus_points(), torus_faces(), None)


def make_suzanne() -> bpy.types.Object:
    """Makes Blender's monkey, subdivided and unwrapped at an angle at which no chart overlaps itself."""
    bpy.ops.mesh.primitive_monkey_add()
    made = bpy.context.active_object
    made.name = "suzanne"
    subdivide(made, SUZANNE_LEVELS)
    unwrap(made, 0.8)
    return made


def subdivide(made: bpy.types.Object, levels: int) -> None:
    """Replaces the object's mesh by the subdivided surface, smooth shaded."""
    modifier = made.modifiers.new("subdivision", "SUBSURF")
    modifier.levels = levels
    mesh = bpy.data.meshes.new_from_object(made.evaluated_get(bpy.context.evaluated_depsgraph_get()))
    made.modifiers.remove(modifier)
    made.data = mesh
    mesh.name = made.name
    mesh.polygons.foreach_set("use_smooth", np.ones(len(mesh.polygons), bool))


def unwrap(made: bpy.types.Object, angle: float) -> None:
    """Runs Smart UV Project on the whole mesh of the active object; angle: radians within one chart."""
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
    """Makes a wheel of genus 20, standing upright, subdivided and unwrapped into many charts."""
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


def grid(columns: int, rows: int) -> tuple[np.ndarray, np.ndarray]:
    """Places (n, 2) from 0 to 1, row by row, and the quads (m, 4) between them."""
    u, v = np.meshgrid(np.linspace(0, 1, columns + 1), np.linspace(0, 1, rows + 1))
    first = (np.arange(rows)[:, None] * (columns + 1) + np.arange(columns)).reshape(-1, 1)
    return np.stack([u.ravel(), v.ravel()], axis=-1), first + np.array([0, 1, columns + 2, columns + 1])


def make_bent_tube() -> bpy.types.Object:
    """Makes an open tube whose bones bend it into an arc and back by the action Bend."""
    places, quads = grid(TUBE_COLUMNS, TUBE_ROWS)
    angle = 2 * np.pi * places[:, 0]
    points = np.stack([np.cos(angle), np.sin(angle), places[:, 1]], axis=-1) * (TUBE_RADIUS, TUBE_RADIUS, TUBE_LENGTH)
    kept = np.arange(len(places)) % (TUBE_COLUMNS + 1) != TUBE_COLUMNS  # the last column is the first
    index = np.where(kept, np.cumsum(kept) - 1, np.roll(np.cumsum(kept) - 1, TUBE_COLUMNS))
    uvs = (0.02 + 0.96 * places * (2 * np.pi * TUBE_RADIUS / TUBE_LENGTH, 1))[quads]
    tube = build("cylinder", points[kept], index[quads], uvs)
    bpy.context.collection.objects.link(tube)
    armature = make_armature()
    tube.parent = armature
    tube.modifiers.new("Armature", "ARMATURE").object = armature
    for index, weights in enumerate(bone_weights(points[kept][:, 2] / TUBE_LENGTH)):
        group = tube.vertex_groups.new(name=f"Bone.{index:02}")
        for vertex in np.flatnonzero(weights):
            group.add([int(vertex)], weights[vertex], "REPLACE")
    return tube


def bone_weights(height: np.ndarray) -> np.ndarray:
    """(BONES, n) influences at heights (n,) from 0 to 1: cubic B-splines, at most four bones a vertex."""
    away = np.abs(height * BONES - 0.5 - np.arange(BONES)[:, None])
    weights = np.where(away < 1, 2 / 3 - away**2 + away**3 / 2, np.maximum(2 - away, 0) ** 3 / 6)
    return weights / weights.sum(axis=0)


def make_armature() -> bpy.types.Object:
    """Makes a chain of bones along z, with the action Bend."""
    made = bpy.data.objects.new("armature", bpy.data.armatures.new("armature"))
    bpy.context.collection.objects.link(made)
    bpy.context.view_layer.objects.active = made
    bpy.ops.object.mode_set(mode="EDIT")
    former = None
    for index in range(BONES):
        bone = made.data.edit_bones.new(f"Bone.{index:02}")
        bone.head = (0, 0, TUBE_LENGTH * index / BONES)
        bone.tail = (0, 0, TUBE_LENGTH * (index + 1) / BONES)
        bone.parent, bone.use_connect = former, former is not None
        former = bone
    bpy.ops.object.mode_set(mode="OBJECT")
    for index, bone in enumerate(made.pose.bones):
        bone.rotation_mode = "XYZ"
        for frame, share in ((1, 0.0), (FRAMES // 2, 1.0), (FRAMES, 0.0)):
            bone.rotation_euler.z = 0.0
            bone.rotation_euler.x = share * BEND / (BONES - 1) * (index > 0)
            bone.keyframe_insert("rotation_euler", frame=frame)
    made.animation_data.action.name = "Bend"
    return made


def quad_sphere(steps: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A sphere of radius 1: points (n, 3), quads (m, 4), their corners' places (m, 4, 2) on six squares from 0 to 1.

    The squares' quads follow each other, m / 6 of each.
    """
    places, quads = grid(steps, steps)
    across, along = np.tan((places.T - 0.5) * np.pi / 2)
    sides = []
    for axis in range(3):
        for sign in (1.0, -1.0):
            side = np.full((len(places), 3), sign)
            side[:, (axis + 1) % 3], side[:, (axis + 2) % 3] = across, sign * along
            sides.append(side / np.linalg.norm(side, axis=1, keepdims=True))
    points = np.concatenate(sides)
    faces = np.concatenate([quads + len(places) * side for side in range(6)])
    _, first, shared = np.unique(np.round(points, 6) + 0.0, axis=0, return_index=True, return_inverse=True)
    return points[first], shared.reshape(-1)[faces], np.tile(places[quads], (6, 1, 1))


def six_cells(places: np.ndarray) -> np.ndarray:
    """(m, 4, 2) UVs of a quad_sphere's places: three squares beside each other and three above, each in a cell of 1."""
    side = np.repeat(np.arange(6), len(places) // 6)[:, None, None]
    return 0.05 + 0.9 * places + np.concatenate([side % 3, side // 3], axis=2)


def make_shape_key() -> bpy.types.Object:
    """Makes a sphere that a shape key turns into an ellipsoid and back."""
    points, faces, places = quad_sphere(SPHERE_STEPS)
    made = build("ellipsoid", points, faces, six_cells(places) / (3, 2))
    made.shape_key_add(name="Basis")
    key = made.shape_key_add(name="Long")
    key.data.foreach_set("co", (points * (1, 1, LONG)).astype(np.float32).ravel())
    for frame, value in ((1, 0.0), (FRAMES // 2, 1.0), (FRAMES, 0.0)):
        key.value = value
        key.keyframe_insert("value", frame=frame)
    key.value = 0.0
    made.data.shape_keys.animation_data.action.name = "Stretch"
    return made


def make_udim() -> bpy.types.Object:
    """Makes a sphere whose six charts lie on the tiles 1001 to 1003 and 1011 to 1013."""
    points, faces, places = quad_sphere(SPHERE_STEPS)
    return build("sphere", points, faces, six_cells(places))


def make_fragmented() -> bpy.types.Object:
    """Makes a sphere whose faces are charts of their own, as in a lightmap."""
    points, faces, places = quad_sphere(SPHERE_STEPS)
    columns = int(np.ceil(np.sqrt(len(faces))))
    corners = places - places.mean(axis=1, keepdims=True)
    local = 0.5 + corners / np.ptp(corners, axis=(0, 1)) * FRAGMENT_SHARE
    cell = np.stack(np.divmod(np.arange(len(faces)), columns), axis=-1)
    return build("sphere", points, faces, (local + cell[:, None, :]) / columns)


def make_mirrored() -> bpy.types.Object:
    """Makes the monkey of two halves that share one half of a UV map, as artists do to save texels."""
    bpy.ops.mesh.primitive_monkey_add()
    made = bpy.context.active_object
    made.name = "suzanne"
    subdivide(made, SUZANNE_LEVELS)
    keep_half(made)
    unwrap(made, 0.8)
    modifier = made.modifiers.new("Mirror", "MIRROR")
    modifier.merge_threshold = 1e-5
    bpy.ops.object.modifier_apply(modifier=modifier.name)
    return made


def keep_half(made: bpy.types.Object) -> None:
    """Deletes what lies at negative x, and moves the seam to 0."""
    points = np.empty(3 * len(made.data.vertices), np.float32)
    made.data.vertices.foreach_get("co", points)
    points = points.reshape(-1, 3)
    points[np.abs(points[:, 0]) < 1e-4, 0] = 0
    made.data.vertices.foreach_set("co", points.ravel())
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="DESELECT")
    bpy.ops.object.mode_set(mode="OBJECT")
    made.data.vertices.foreach_set("select", points[:, 0] < 0)
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.delete(type="VERT")
    bpy.ops.object.mode_set(mode="OBJECT")


def wave_slopes(x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Height of the waves at (x, y), and its derivatives along both."""
    turn = 2 * np.pi
    return (
        WAVE_HEIGHT * np.cos(turn * x) * np.cos(turn * y),
        -WAVE_HEIGHT * turn * np.sin(turn * x) * np.cos(turn * y),
        -WAVE_HEIGHT * turn * np.cos(turn * x) * np.sin(turn * y),
    )


def make_square(name: str) -> bpy.types.Object:
    """Makes a flat square from -1 to 1 that fills the UV map."""
    places, quads = grid(SQUARE_STEPS, SQUARE_STEPS)
    return build(name, np.append(2 * places - 1, np.zeros((len(places), 1)), axis=1), quads, places[quads])


def pixel_places() -> tuple[np.ndarray, np.ndarray]:
    """Both coordinates, each (WAVE_PIXELS, WAVE_PIXELS), of the square's pixels, rows bottom-up."""
    middle = 2 * (np.arange(WAVE_PIXELS) + 0.5) / WAVE_PIXELS - 1
    return tuple(np.meshgrid(middle, middle))


def add_material(made: bpy.types.Object, name: str, pixels: np.ndarray) -> tuple[bpy.types.NodeTree, bpy.types.Node]:
    """Adds a material with an Image Texture; pixels: (n, n, 3) floats, which are packed into the file."""
    image = bpy.data.images.new(name, WAVE_PIXELS, WAVE_PIXELS, float_buffer=True)
    image.colorspace_settings.name = "Non-Color"
    rgba = np.ones((WAVE_PIXELS, WAVE_PIXELS, 4), np.float32)
    rgba[..., :3] = pixels
    image.pixels.foreach_set(rgba.ravel())
    image.pack()
    material = bpy.data.materials.new(name)
    if material.node_tree is None:  # before Blender 5.0
        material.use_nodes = True
    made.data.materials.append(material)
    texture = material.node_tree.nodes.new("ShaderNodeTexImage")
    texture.image = image
    return material.node_tree, texture


def make_displaced() -> bpy.types.Object:
    """Makes a flat square whose material displaces it into waves, by an image."""
    made = make_square("waves")
    height, _, _ = wave_slopes(*pixel_places())
    tree, texture = add_material(made, "heights", (WAVE_MIDLEVEL + height / WAVE_SCALE)[..., None])
    node = tree.nodes.new("ShaderNodeDisplacement")
    node.inputs["Midlevel"].default_value = WAVE_MIDLEVEL
    node.inputs["Scale"].default_value = WAVE_SCALE
    tree.links.new(texture.outputs["Color"], node.inputs["Height"])
    tree.links.new(node.outputs[0], tree.get_output_node("ALL").inputs["Displacement"])
    return made


def make_normal_mapped() -> bpy.types.Object:
    """Makes a flat square whose material gives it the waves' normals, by an image."""
    made = make_square("waves")
    _, across, along = wave_slopes(*pixel_places())
    normals = np.stack([-across, -along, np.ones_like(across)], axis=-1)
    normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
    tree, texture = add_material(made, "normals", 0.5 + 0.5 * normals)
    node = tree.nodes.new("ShaderNodeNormalMap")
    tree.links.new(texture.outputs["Color"], node.inputs["Color"])
    shader = next(node for node in tree.nodes if node.type == "BSDF_PRINCIPLED")
    tree.links.new(node.outputs[0], shader.inputs["Normal"])
    return made


SAMPLES: dict[str, Callable[[], bpy.types.Object]] = {
    "01_curvature_suzanne": make_suzanne,
    "02_charts_torus": make_torus,
    "03_genus_20_rim": make_rim,
    "04_armature_cylinder": make_bent_tube,
    "05_shape_key_ellipsoid": make_shape_key,
    "06_udim_sphere": make_udim,
    "07_mirrored_suzanne": make_mirrored,
    "08_displaced_waves": make_displaced,
    "09_normal_mapped_waves": make_normal_mapped,
    "10_no_uv_map_torus": make_bare_torus,
    "11_fragmented_sphere": make_fragmented,
}


def add_camera(made: bpy.types.Object) -> None:
    """Adds a camera that sees all of the object, a sun from its left, and a grey background, so that it renders."""
    corners = np.array([made.matrix_world @ Vector(corner) for corner in made.bound_box])
    middle, diagonal = corners.mean(axis=0), np.linalg.norm(np.ptp(corners, axis=0))
    contents = {"camera": bpy.data.cameras.new("camera"), "sun": bpy.data.lights.new("sun", "SUN")}
    for (name, content), away in zip(contents.items(), ((0.45, -1.0, 0.6), (-0.5, -0.8, 1.0)), strict=True):
        placed = bpy.data.objects.new(name, content)
        direction = Vector(away).normalized()
        placed.location = Vector(middle) + 2.0 * float(diagonal) * direction
        placed.rotation_euler = direction.to_track_quat("Z", "Y").to_euler()
        bpy.context.collection.objects.link(placed)
    bpy.context.scene.camera = bpy.data.objects["camera"]
    contents["sun"].energy = 3.0
    world = bpy.data.worlds.new("world")
    if world.node_tree is None:  # before Blender 5.0
        world.use_nodes = True
    world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.3, 0.3, 0.3, 1.0)
    bpy.context.scene.world = world


def make(name: str) -> bpy.types.Object:
    """Makes a sample in an empty scene of its own; its object is active, and the first frame is shown."""
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    made = SAMPLES[name]()
    if made.name not in bpy.context.collection.objects:
        bpy.context.collection.objects.link(made)
    bpy.context.view_layer.objects.active = made
    made.select_set(True)
    scene = bpy.context.scene
    scene.frame_end = FRAMES
    scene.frame_set(1)
    add_camera(made)
    return made


def write_all(folder: Path) -> None:
    """Writes every sample into the folder."""
    for name in SAMPLES:
        make(name)
        bpy.context.preferences.filepaths.save_version = 0
        bpy.ops.wm.save_as_mainfile(filepath=str(folder / f"{name}.blend"), check_existing=False, compress=True)


def main() -> None:
    """Writes every sample into the folder of the command line, or beside this file."""
    words = sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else sys.argv[1:]
    write_all(Path(words[0]).resolve() if words else Path(__file__).resolve().parent)


if __name__ == "__main__":
    main()
