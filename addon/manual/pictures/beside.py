"""Three assets in three masks, all grey: Blender's Dirty Vertex Colors, Cycles' Pointiness, Paradesc's mean curvature.

Prints the seconds that the first and the last took, without creases too, and how far each mask's grey spreads over a
box in few faces and in many.
"""

import math
import sys
import tempfile
import time
from pathlib import Path

import bmesh
import bpy
import numpy as np
import renders
import subjects
from mathutils import Vector

from paradesc.files import lettering, png

BUNNY = Path(__file__).resolve().parents[4] / "shared" / "meshes" / "stanford-bunny.obj"
# Where Pointiness is black, the grey that a screen shows halfway, and white; flat surfaces have 0.5.
RAMP = ((0.45, 0.0), (0.5, 0.214), (0.55, 1.0))
COLUMNS = ("dirty vertex colors", "pointiness", "paradesc")
TURNS = {"monkey": (-12, 0, 20), "box": (0, 0, 32), "bunny": (90, 0, 0)}
DIVISIONS = (2, 3, 4)  # of the box, so that its flat faces have vertices; each makes four faces of one
SHOWN = 3  # the divisions of the box in the picture
HEAD, MARGIN = 28, 0.12  # the height of the titles; how far the camera steps back, in lengths of the object


def render_beside(path: str) -> None:
    """Every asset in a row, every mask in a column."""
    rows = {"monkey": make_monkey, "box": make_box}
    if BUNNY.is_file():
        rows["bunny"] = read_bunny
    else:
        sys.stdout.write(f"The bunny is left out: there is no {BUNNY.name} in shared/meshes beside the checkout.\n")
    width, height = renders.WIDTH, renders.HEIGHT
    image = np.full((HEAD + len(rows) * height, len(COLUMNS) * width, 3), renders.NIGHT, np.uint8)
    for column, words in enumerate(COLUMNS):
        middle = column * width + (width - lettering.text_width(words, 2)) // 2
        lettering.draw_text(image, words, middle, 7, 2, renders.WORDS)
    subjects.empty()
    renders.set_up(width, height, 32, clear=True)
    with tempfile.TemporaryDirectory() as folder:
        for row, (name, make) in enumerate(rows.items()):
            tiles = masked(make(), name, folder)
            image[HEAD + row * height :][:height] = np.concatenate(tiles, axis=1)
        for divisions in DIVISIONS:
            print_spread(masked(make_box(divisions), "box", folder), divisions)
    print_without_creases()
    png.write_png(Path(path), image)


def masked(item: bpy.types.Object, name: str, folder: str) -> list[np.ndarray]:
    """(HEIGHT, WIDTH, 3) uint8 for each mask: an object rendered with it; then the object is removed."""
    item.name, tiles = name, []
    item.rotation_euler = [math.radians(turn) for turn in TURNS[name]]
    aim(item)
    for mask in (paint_dirt, show_pointiness, bake_curvature):
        mask(item)
        file = str(Path(folder) / f"{name}.png")
        renders.render(file)
        tiles.append(renders.over_night(file))
    bpy.data.objects.remove(item)
    return tiles


def print_spread(tiles: list[np.ndarray], divisions: int) -> None:
    """Prints the standard deviation of each mask's grey; the ground is left out, because it is not grey."""
    spreads = [tile[tile[..., 0] == tile[..., 2]][:, 0].std() for tile in tiles]
    words = ", ".join(f"{name} {spread:.1f}" for name, spread in zip(COLUMNS, spreads, strict=True))
    sys.stdout.write(f"The grey of the box, divided {divisions} times, spreads by, of 255: {words}\n")


def print_without_creases() -> None:
    """Prints how long the box of the picture takes if no hard edges are looked for."""
    settings = bpy.context.scene.paradesc
    settings.creases = "none"
    item = make_box()
    begin = time.perf_counter()
    bpy.ops.paradesc.bake()
    print_time(item, "Paradesc without creases", begin)
    bpy.data.objects.remove(item)


# ---- Assets


def make_monkey() -> bpy.types.Object:
    """Blender's monkey with a Subdivision modifier that is not applied."""
    bpy.ops.mesh.primitive_monkey_add()
    item = bpy.context.active_object
    bpy.ops.object.shade_smooth()
    modifier = item.modifiers.new("subdivision", "SUBSURF")
    modifier.levels = modifier.render_levels = 2
    return item


def make_box(divisions: int = SHOWN) -> bpy.types.Object:
    """A box with a groove around its top and a sunken panel in front, bevelled, in small faces."""
    shape = bmesh.new()
    bmesh.ops.create_cube(shape, size=2)
    bmesh.ops.scale(shape, vec=(1.0, 0.75, 0.55), verts=shape.verts)
    top = max(shape.faces, key=lambda face: face.calc_center_median().z)
    bmesh.ops.inset_region(shape, faces=[top], thickness=0.2)
    sink(shape, bmesh.ops.inset_region(shape, faces=[top], thickness=0.16)["faces"], (0, 0, -0.16))
    front = min(shape.faces, key=lambda face: face.calc_center_median().y)
    bmesh.ops.inset_region(shape, faces=[front], thickness=0.22)
    sink(shape, [front], (0, 0.12, 0))
    mesh = bpy.data.meshes.new("box")
    shape.to_mesh(mesh)
    shape.free()
    item = bpy.data.objects.new("box", mesh)
    bpy.context.collection.objects.link(item)
    bpy.context.view_layer.objects.active = item
    item.select_set(True)
    bevel, finer = item.modifiers.new("bevel", "BEVEL"), item.modifiers.new("finer", "SUBSURF")
    bevel.width, bevel.segments = 0.03, 2
    finer.subdivision_type, finer.levels = "SIMPLE", divisions
    for name in ("bevel", "finer"):
        bpy.ops.object.modifier_apply(modifier=name)
    bpy.ops.object.shade_smooth()
    return item


def sink(shape: bmesh.types.BMesh, faces: list[bmesh.types.BMFace], way: tuple[float, float, float]) -> None:
    """Moves faces and leaves walls behind them."""
    moved = bmesh.ops.extrude_face_region(shape, geom=faces)["geom"]
    bmesh.ops.translate(shape, vec=way, verts=[part for part in moved if isinstance(part, bmesh.types.BMVert)])
    bmesh.ops.delete(shape, geom=faces, context="FACES")


def read_bunny() -> bpy.types.Object:
    """The scanned bunny."""
    bpy.ops.wm.obj_import(filepath=str(BUNNY))
    bpy.ops.object.shade_smooth()
    return bpy.context.active_object


def aim(item: bpy.types.Object) -> None:
    """Places the camera so that the object fills the picture."""
    camera = bpy.context.scene.camera
    camera.rotation_euler = (math.radians(58 if item.name == "box" else 84), 0, 0)
    graph = bpy.context.evaluated_depsgraph_get()
    shown = item.evaluated_get(graph)
    places = [value for vertex in shown.data.vertices for value in shown.matrix_world @ vertex.co]
    place, _scale = camera.camera_fit_coords(graph, places)
    back = camera.rotation_euler.to_matrix() @ Vector((0, 0, 1))
    camera.location = place + MARGIN * item.dimensions.length * back


# ---- Masks


def paint_dirt(item: bpy.types.Object) -> None:
    """Dirty Vertex Colors with its default settings."""
    begin = time.perf_counter()
    bpy.ops.paint.vertex_color_dirt()
    print_time(item, "Dirty Vertex Colors", begin)
    node = emitted(item, "ShaderNodeVertexColor", "Color")
    node.layer_name = item.data.color_attributes[0].name


def show_pointiness(item: bpy.types.Object) -> None:
    """Pointiness through a Color Ramp."""
    ramp = emitted(item, "ShaderNodeValToRGB", "Color")
    ramp.color_ramp.elements.new(0.5)
    for element, (place, tone) in zip(ramp.color_ramp.elements, RAMP, strict=True):
        element.position, element.color = place, (tone, tone, tone, 1)
    tree = ramp.id_data
    tree.links.new(tree.nodes.new("ShaderNodeNewGeometry").outputs["Pointiness"], ramp.inputs["Fac"])


def bake_curvature(item: bpy.types.Object) -> None:
    """Paradesc's mean curvature with its default settings but for the color map, cavity."""
    scene = bpy.context.scene
    scene.paradesc.descriptors, scene.paradesc_looks.color_map = {"mean_curvature"}, "cavity"
    item.data.materials.clear()
    begin = time.perf_counter()
    bpy.ops.paradesc.bake()
    print_time(item, "Paradesc", begin)
    bpy.ops.paradesc.make_material(kind="flat")


def print_time(item: bpy.types.Object, tool: str, begin: float) -> None:
    """Prints how long a mask took."""
    seconds = time.perf_counter() - begin
    sys.stdout.write(f"{item.name}, {len(item.data.vertices)} vertices: {tool} took {seconds:.2f} s\n")


def emitted(item: bpy.types.Object, kind: str, output: str) -> bpy.types.Node:
    """A node whose output the object's only material emits, without light or shade."""
    material = bpy.data.materials.new("mask")
    material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    node, light, end = (tree.nodes.new(name) for name in (kind, "ShaderNodeEmission", "ShaderNodeOutputMaterial"))
    tree.links.new(node.outputs[output], light.inputs["Color"])
    tree.links.new(light.outputs["Emission"], end.inputs["Surface"])
    item.data.materials.clear()
    item.data.materials.append(material)
    return node
