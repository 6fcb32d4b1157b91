"""Wear in one click on the artist's own material, its looks, and the assets in Blender's browser."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

import bpy
import person
from scenes import as_found, idle, imported, rendered, shading

if TYPE_CHECKING:
    from drive import Run


def wear(run: "Run") -> Iterator[None]:
    """A blue material on the beast, then one click."""
    as_found()
    (made,) = imported("beast.obj")
    material = bpy.data.materials.new("Paint")
    material.use_nodes = True
    material.node_tree.nodes["Principled BSDF"].inputs["Base Color"].default_value = (0.02, 0.1, 0.45, 1)
    made.data.materials.clear()
    made.data.materials.append(material)
    made.select_set(True)
    bpy.context.view_layer.objects.active = made
    yield from person.drawn(2)
    there = yield from person.press("paradesc.add_wear")
    run.saw("B17", "a button Add Wear to Material on the first level; 1 click", there)
    if not there:
        return
    yield from person.drawn(3)
    yield from person.wait(idle)
    yield from person.drawn(5)
    groups = [node.node_tree.name for node in material.node_tree.nodes if node.type == "GROUP"]
    inputs = [item.name for node in material.node_tree.nodes if node.type == "GROUP" for item in node.inputs]
    file = yield from run.picture("wear_solid")
    run.saw("B17", f"groups {groups}, inputs {inputs}; attributes {[name for name in made.data.attributes.keys() if not name.startswith('.')]}", bool(groups), file)
    shading().type = "SOLID"
    yield
    run.saw("B17", "the beast with wear, in Cycles", None, rendered(run, "wear_first"))


def looks(run: "Run") -> Iterator[None]:
    """The three looks."""
    import paradesc_blender

    names = [item.identifier for item in bpy.ops.paradesc.add_wear.get_rna_type().properties["look"].enum_items]
    run.saw("item 6", f"looks of Add Wear: {names}; files {sorted(path.name for path in person.Path(paradesc_blender.__file__).parent.rglob('*.blend'))}", len(names) >= 3)
    for name in names:
        person.in_view(bpy.ops.paradesc.add_wear, "INVOKE_DEFAULT", look=name)
        yield from person.drawn(3)
        yield from person.wait(idle)
        shading().type = "SOLID"
        yield
        run.saw("item 6", f"look {name}", None, rendered(run, f"wear_{name}"))


def browser(run: "Run") -> Iterator[None]:
    """The Asset Browser with the add-on's library."""
    bpy.ops.paradesc.asset_library()
    libraries = [(item.name, item.path) for item in bpy.context.preferences.filepaths.asset_libraries]
    run.saw("item 6", f"asset libraries: {libraries}", any("aradesc" in name for name, _ in libraries))
    area = person.viewport()
    area.ui_type = "ASSETS"
    yield from person.drawn(10)
    space = area.spaces.active
    name = next((name for name, _ in libraries if "aradesc" in name), "")
    if name and space.params is not None:
        word = "asset_library_ref" if hasattr(space.params, "asset_library_ref") else "asset_library_reference"
        setattr(space.params, word, name)
    yield from person.drawn(60)
    file = yield from run.picture("asset_browser")
    area.ui_type = "VIEW_3D"
    yield from person.drawn(3)
    run.saw("item 6", "the Asset Browser with thumbnails", None, file)


def steps(run: "Run") -> Iterator[None]:
    """One after another."""
    yield from person.alone()
    yield from person.open_tab()
    for point, task in (("B17", wear), ("item 6", looks), ("item 6", browser)):
        yield from run.tried(point, task(run))
