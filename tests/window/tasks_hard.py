"""Hard surfaces, modifiers, other kinds of objects, many objects, and modes."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

import bpy
import person
from scenes import added, as_found, baked, clicked, empty, framed, monkey, undo_step

if TYPE_CHECKING:
    from drive import Run


def seen_meshes() -> list[str]:
    """The names of meshes that are seen in the viewport."""
    return [item.name for item in bpy.context.scene.objects if item.type in ("MESH", "FONT", "CURVE") and item.visible_get()]


def bevel(run: "Run") -> Iterator[None]:
    """A cube with a Bevel modifier: no second object lies on the first, and both masks stay."""
    empty()
    as_found()
    cube = added(bpy.ops.mesh.primitive_cube_add)
    cube.modifiers.new("Bevel", "BEVEL").segments = 3
    undo_step()
    yield from person.press("paradesc.mask(name='edge_wear'")
    words = yield from clicked()
    file = yield from run.picture("bevel")
    run.saw("A4", f"after {words}: seen objects {seen_meshes()}, active {bpy.context.object.name}", len(seen_meshes()) == 1, file)
    yield from person.press("paradesc.mask(name='cavity'")
    yield from clicked()
    file = yield from run.picture("bevel_cavity")
    kept = {name for item in bpy.data.objects if item.type == "MESH" for name in item.data.attributes.keys()}
    images = [image.name for image in bpy.data.images]
    run.saw("A4", f"after Cavity, too: attributes {sorted(name for name in kept if name in ('cavity', 'convexity'))}, images {images}, "
        f"seen objects {seen_meshes()}", len(seen_meshes()) == 1, file)  # fmt: skip
    yield from person.press("paradesc_live.follows")
    yield from person.drawn(10)
    file = yield from run.picture("bevel_live")
    run.saw("A4", f"Live on it says: {bpy.context.object.paradesc_live.sentence or 'nothing'}", None, file)


def kinds(run: "Run") -> Iterator[None]:
    """Seven objects, of which one is a text and one a curve."""
    empty()
    as_found()
    text = added(bpy.ops.object.text_add, location=(0, 0, 3))
    curve = added(bpy.ops.curve.primitive_bezier_circle_add, location=(4, 0, 3))
    curve.data.bevel_depth = 0.3
    text.data.extrude = 0.1
    meshes = [added(bpy.ops.mesh.primitive_torus_add, location=(3 * column, 0, 0)) for column in range(3)]
    for item in (text, curve, *meshes):
        item.select_set(True)
    framed()
    yield from person.drawn(3)
    file = yield from run.picture("text_curve", "UI")
    found = yield from person.buttons()
    run.saw("B10", f"3 meshes, a text and a curve selected; a button that converts: {any('convert' in words for words in found)}", any("convert" in words for words in found), file)
    for item in meshes:
        item.select_set(False)
    bpy.context.view_layer.objects.active = text
    curve.select_set(False)
    yield from person.drawn(3)
    pressed = yield from person.press("paradesc.convert")
    yield from person.drawn(4)
    words = yield from clicked()
    file = yield from run.picture("text")
    run.saw("B10", f"a text alone: Convert to Mesh pressed: {pressed}; now {bpy.context.object.type}, {words}", bpy.context.object.type == "MESH", file)


def forty(run: "Run") -> Iterator[None]:
    """Forty monkeys with one click."""
    made = monkey(1, applied=True)
    as_found()
    for number in range(1, 40):
        copy = bpy.data.objects.new(f"Suzanne.{number:03}", made.data.copy())
        copy.location = (3 * (number % 8), 0, 3 * (number // 8))
        bpy.context.collection.objects.link(copy)
        copy.select_set(True)
    framed("FRONT")
    yield from person.drawn(3)
    file = yield from run.picture("forty_panel", "UI")
    found = yield from person.buttons()
    run.saw("B9", f"40 meshes: buttons {', '.join(words.removeprefix('bpy.ops.paradesc.') for words in found if 'bake' in words)}", not any("bake_onto" in words for words in found), file)
    yield from person.press("paradesc.mask(name='edge_wear'")
    yield from clicked()
    count = sum("convexity" in item.data.attributes for item in bpy.data.objects if item.type == "MESH")
    file = yield from run.picture("forty")
    run.saw("B9", f"baked {count} of 40", count == 40, file)


def modes(run: "Run") -> Iterator[None]:
    """Edit mode, shape keys, an uneven scale."""
    made = monkey(2, applied=True)
    as_found()
    person.in_view(bpy.ops.object.mode_set, mode="EDIT")
    yield from person.drawn(2)
    yield from clicked()
    file = yield from run.picture("edit_mode")
    run.saw("edit mode", f"mode {made.mode}, mask: {baked('cavity')}", made.mode == "EDIT" and baked("cavity"), file)
    person.in_view(bpy.ops.object.mode_set, mode="OBJECT")
    made.shape_key_add(name="Basis")
    key = made.shape_key_add(name="Long")
    for point in key.data:
        point.co.z *= 1.6
    key.value = 1.0
    yield from clicked()
    file = yield from run.picture("shape_key")
    run.saw("shape key", "baked as it is shown", None, file)
    empty()
    torus = added(bpy.ops.mesh.primitive_torus_add)
    torus.scale = (1, 1, 3)
    framed()
    yield from person.drawn(3)
    file = yield from run.picture("uneven_scale", "UI")
    run.saw("C7", "scale 1, 1, 3: what the first level of the panel says", None, file)


def steps(run: "Run") -> Iterator[None]:
    """One after another."""
    yield from person.alone()
    yield from person.open_tab()
    for point, task in (("A4", bevel), ("B10", kinds), ("B9", forty), ("edit mode", modes)):
        yield from run.tried(point, task(run))
