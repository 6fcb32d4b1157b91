"""Three assets in three masks, all grey: Blender's Dirty Vertex Colors, Cycles' Pointiness, Paradesc's mean curvature.

Prints the seconds that the first and the last took, without creases too, and how far each mask's grey spreads over a
box in few faces and in many.
"""

import math
import sys
import time
from pathlib import Path

import bmesh
import bpy
import numpy as np
import studio
from PIL import Image
from studio import View

BUNNY = Path(__file__).resolve().parents[4] / "shared" / "meshes" / "stanford-bunny.obj"
# The values at which Pointiness is black, the grey that a screen shows halfway, and white; flat surfaces have 0.5.
RAMP = ((0.45, 0.0), (0.5, 0.214), (0.55, 1.0))
COLUMNS = ("Dirty Vertex Colors", "Pointiness", "Paradesc")
SIZE, SAMPLES = (620, 480), 24
TURNS = {"monkey": (-12, 0, 20), "box": (0, 0, 32), "bunny": (90, 0, 0)}
DIVISIONS = (2, 3, 4)  # of the box, so that its flat faces have vertices; each makes four faces of one
SHOWN = 3  # the divisions of the box in the picture


def draw_beside(path: str) -> None:
    """Every asset in a row, every mask in a column."""
    rows = {"monkey": make_monkey, "box": make_box}
    if BUNNY.is_file():
        rows["bunny"] = read_bunny
    else:
        sys.stdout.write(f"The bunny is left out: there is no {BUNNY.name} in shared/meshes beside the checkout.\n")
    studio.clear()
    tiles = [tile for name, make in rows.items() for tile in masked(make(), name)]
    for divisions in DIVISIONS:
        print_spread(masked(make_box(divisions), "box"), divisions)
    print_without_creases()
    studio.save(studio.sheet(tiles, COLUMNS * len(rows), len(COLUMNS)), path)


def masked(item: bpy.types.Object, name: str) -> list[Image.Image]:
    """An object with each mask, without light or shade; then the object is removed."""
    item.name, tiles = name, []
    item.rotation_euler = [math.radians(turn) for turn in TURNS[name]]
    for mask in (paint_dirt, show_pointiness, bake_curvature):
        mask(item)
        tiles.append(studio.tile([item], SIZE, View(0, 32 if name == "box" else 6), SAMPLES, lit=False))
    bpy.data.objects.remove(item)
    return tiles


def print_spread(tiles: list[Image.Image], divisions: int) -> None:
    """Prints the standard deviation of each mask's grey on the box."""
    greys = [np.asarray(tile)[..., 0] for tile in tiles]
    spreads = [grey[grey != studio.GROUND[0]].std() for grey in greys]
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


# ---- Masks


def paint_dirt(item: bpy.types.Object) -> None:
    """Dirty Vertex Colors with its default settings."""
    begin = time.perf_counter()
    bpy.ops.paint.vertex_color_dirt()
    print_time(item, "Dirty Vertex Colors", begin)
    node = studio.emit(item, "ShaderNodeVertexColor")
    node.layer_name = item.data.color_attributes[0].name


def show_pointiness(item: bpy.types.Object) -> None:
    """Pointiness through a Color Ramp."""
    ramp = studio.emit(item, "ShaderNodeValToRGB")
    ramp.color_ramp.elements.new(0.5)
    for element, (place, tone) in zip(ramp.color_ramp.elements, RAMP, strict=True):
        element.position, element.color = place, (tone, tone, tone, 1)
    tree = ramp.id_data
    tree.links.new(tree.nodes.new("ShaderNodeNewGeometry").outputs["Pointiness"], ramp.inputs["Fac"])


def bake_curvature(item: bpy.types.Object) -> None:
    """Paradesc's mean curvature at a radius of 2 %, in the color map cavity."""
    scene = bpy.context.scene
    scene.paradesc.radius_percent = 2.0
    scene.paradesc.descriptors, scene.paradesc_looks.color_map = {"mean_curvature"}, "cavity"
    item.data.materials.clear()
    begin = time.perf_counter()
    bpy.ops.paradesc.bake()
    print_time(item, "Paradesc", begin)
    studio.show_color(item, "mean_curvature_color")


def print_time(item: bpy.types.Object, tool: str, begin: float) -> None:
    """Prints how long a mask took."""
    seconds = time.perf_counter() - begin
    sys.stdout.write(f"{item.name}, {len(item.data.vertices)} vertices: {tool} took {seconds:.2f} s\n")
