"""Textures: three sizes, no UV map, tiles, packed channels, high to low."""

import time
from collections.abc import Iterator
from typing import TYPE_CHECKING

import bpy
import person
from scenes import added, as_found, clicked, empty, framed, idle, imported, monkey, rendered, shading

if TYPE_CHECKING:
    from drive import Run


def pressed(words: str = "paradesc.bake_image(") -> Iterator[float]:
    """Presses that button and waits for the end; gives seconds, or -1 where it is not there."""
    start = time.monotonic()
    there = yield from person.press(words)
    for _ in range(20):
        if not idle():
            break
        yield
    yield from person.wait(idle)
    yield from person.drawn(3)
    return time.monotonic() - start if there else -1.0


def sizes(run: "Run") -> Iterator[None]:
    """1024, 2048 and 4096 texels of a monkey."""
    monkey(2, applied=True)
    as_found()
    for texels in (1024, 2048, 4096):
        bpy.context.scene.paradesc.texels = texels
        before = set(bpy.data.images)
        yield from pressed()
        file = yield from run.picture(f"image_{texels}")
        made = [image for image in bpy.data.images if image not in before] or [image for image in bpy.data.images if "cavity" in image.name]
        sizes = [(image.name, *image.size) for image in made]
        run.saw("B5", f"{sizes}; the viewport shows {shading().color_type}, light {shading().light}", any(texels in size for size in sizes), file)
    found = yield from person.buttons()
    run.saw("B5", f"buttons of the result: {', '.join(words.removeprefix('bpy.ops.paradesc.') for words in found if 'image' in words or 'folder' in words)}",
        any("show_image" in words for words in found), file)  # fmt: skip
    run.saw("clicks", "an image takes 1 click", True)
    bpy.context.scene.paradesc.texels = 1024


def in_material(run: "Run") -> Iterator[None]:
    """Add to Material, with a picture of the shader editor."""
    bpy.context.scene.paradesc.image_to_material = True
    made = bpy.context.object
    for _ in range(2):
        yield from pressed()
    bpy.context.scene.paradesc.image_to_material = False
    tree = made.active_material.node_tree
    nodes = [f"{node.bl_idname.removeprefix('ShaderNode')} \"{node.label or node.name}\"" for node in tree.nodes]
    images = [node for node in tree.nodes if node.type == "TEX_IMAGE"]
    linked = any(output.is_linked for node in images for output in node.outputs)
    area = person.viewport()
    area.ui_type = "ShaderNodeTree"
    yield from person.drawn(5)
    region = next(item for item in area.regions if item.type == "WINDOW")
    with bpy.context.temp_override(window=person.window(), area=area, region=region):
        bpy.ops.node.view_all()
    file = yield from run.picture("shader_editor")
    area.ui_type = "VIEW_3D"
    yield from person.drawn(3)
    run.saw("B6", f"nodes: {', '.join(nodes)}; {len(images)} images, linked: {linked}", len(images) == 2 and linked and all(node.label for node in images), file)


def no_uv(run: "Run") -> Iterator[None]:
    """A mesh without a UV map."""
    as_found()
    imported("fandisk.obj")
    yield from pressed()
    file = yield from run.picture("no_uv")
    images = [image.name for image in bpy.data.images if "fandisk" in image.name]
    run.saw("C5", f"no UV map: images {images}, UV maps {[layer.name for layer in bpy.context.object.data.uv_layers]}", None, file)


def tiles(run: "Run") -> Iterator[None]:
    """Two UDIM tiles."""
    made = monkey(2, applied=True)
    as_found()
    person.in_view(bpy.ops.object.mode_set, mode="EDIT")
    person.in_view(bpy.ops.mesh.select_all, action="SELECT")
    person.in_view(bpy.ops.uv.smart_project, island_margin=0.01)
    person.in_view(bpy.ops.object.mode_set, mode="OBJECT")
    layer = made.data.uv_layers.active.data
    for face in made.data.polygons:
        if face.center.x > 0:
            for corner in face.loop_indices:
                layer[corner].uv.x += 1
    bpy.context.scene.paradesc.image_to_material = True
    yield from pressed()
    bpy.context.scene.paradesc.image_to_material = False
    file = yield from run.picture("udim")
    found = [(image.name, image.source, [tile.number for tile in image.tiles]) for image in bpy.data.images if image.source == "TILED"]
    run.saw("C6", f"two tiles: {found}", bool(found), file)
    run.saw("C6", "the tiles in Cycles: lines along the borders of islands and tiles", None, rendered(run, "udim"))


def packed(run: "Run") -> Iterator[None]:
    """Pack Channels with Edge Wear chosen: openness keeps a radius of its own."""
    monkey(2, applied=True)
    as_found()
    yield from person.press("paradesc.mask(name='edge_wear'")
    bpy.context.scene.paradesc.image_packed = True
    yield from pressed()
    bpy.context.scene.paradesc.image_packed = False
    file = yield from run.picture("packed")
    run.saw("B13", f"packed: {[image.name for image in bpy.data.images][-2:]}", None, file)


def high_to_low(run: "Run") -> Iterator[None]:
    """The beast onto a decimated one, selected in the viewport."""
    as_found()
    (high,) = imported("beast.obj")
    low = high.copy()
    low.data = high.data.copy()
    low.name, high.name = "beast_low", "beast_high"
    bpy.context.collection.objects.link(low)
    bpy.context.view_layer.objects.active = low
    low.modifiers.new("Decimate", "DECIMATE").ratio = 0.1
    person.in_view(bpy.ops.object.modifier_apply, modifier="Decimate")
    person.in_view(bpy.ops.object.select_all, action="DESELECT")
    low.select_set(True)
    person.in_view(bpy.ops.object.mode_set, mode="EDIT")
    person.in_view(bpy.ops.mesh.select_all, action="SELECT")
    person.in_view(bpy.ops.uv.smart_project, island_margin=0.01)
    person.in_view(bpy.ops.object.mode_set, mode="OBJECT")
    high.select_set(True)
    framed()
    yield from person.drawn(3)
    bpy.context.scene.paradesc.texels = 2048
    file = yield from run.picture("onto_panel", "UI")
    seconds = yield from pressed("paradesc.bake_onto(")
    file = yield from run.picture("onto")
    run.saw("B5", f"high to low: {seconds:.0f} s with looking for the button; images {[image.name for image in bpy.data.images if 'low' in image.name]}", seconds > 0, file)


def large_faces(run: "Run") -> Iterator[None]:
    """A crate: the first button that bakes is the one to an image."""
    empty()
    as_found()
    added(bpy.ops.mesh.primitive_cube_add)
    yield from person.press("paradesc.mask(name='edge_wear'")
    words = yield from clicked()
    file = yield from run.picture("cube")
    run.saw("A3", f"a cube's first button: {words}", words.startswith("bake_image"), file)


def steps(run: "Run") -> Iterator[None]:
    """One after another."""
    yield from person.alone()
    yield from person.open_tab()
    for point, task in (("B5", sizes), ("B6", in_material), ("A3", large_faces), ("C5", no_uv), ("C6", tiles), ("B13", packed), ("B5", high_to_low)):
        yield from run.tried(point, task(run))
