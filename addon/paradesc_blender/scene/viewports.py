"""Makes viewports show baked colors in flat light, and restores their former shading.

Undo removes a bake's colors but leaves the viewports as they are, so handlers here update them.
"""

from collections.abc import Iterator

import bpy
from bpy.app.handlers import persistent

from ..settings import preferences
from . import image_preview, node_groups, record

# The custom property of the screen that keeps the former solid shading by the number of the viewport's area, so that a
# saved file can still restore it.
FORMER = "paradesc_color_type"
# The custom property with the numbers of viewports that were solid before they showed materials.
SOLID_BEFORE = "paradesc_solid_before"
# The custom property with the numbers of all viewports at that time. A viewport that is missing in it was split off
# since.
KNOWN = "paradesc_viewports"
# The custom property, in the form of FORMER, with shadings that undo has taken away, for redo or another radius.
UNDONE = "paradesc_undone"
# The custom property with the numbers of viewports whose materials undo has taken away, for redo.
UNWORN = "paradesc_unworn"
ATTRIBUTES = "VERTEX"
# Highlights, shadows and Blender's own cavity shading would be mistaken for values.
PLAIN = {"color_type": ATTRIBUTES, "light": "FLAT", "show_cavity": False, "show_shadows": False}
# In sculpt mode lights stay on, as they show the shape.
LIT = {"color_type": ATTRIBUTES}
Look = dict[str, str | bool]


def shadings(screen: bpy.types.Screen | None) -> Iterator[tuple[str, bpy.types.View3DShading]]:
    """The number and the shading of each 3D viewport of a screen."""
    for number, area in enumerate(screen.areas if screen is not None else ()):
        if area.type == "VIEW_3D":
            yield str(number), area.spaces.active.shading


def formers(screen: bpy.types.Screen) -> dict[str, Look]:
    """The former shadings of viewports, by number."""
    return {number: dict(one) for number, one in screen.get(FORMER, {}).items()}


def settle(screen: bpy.types.Screen) -> None:
    """Gives a viewport that was split off the former shading of the viewport with the same look."""
    shown = {int(number): shading for number, shading in shadings(screen)}
    known = [number for number in screen.get(KNOWN, shown) if number in shown]
    former, solid = formers(screen), list(screen.get(SOLID_BEFORE, []))
    for number in shown.keys() - set(known):
        look = (shown[number].type, look_of(shown[number]))
        twin = next((one for one in known if (shown[one].type, look_of(shown[one])) == look), number)
        former.update({str(number): former[str(twin)]} if str(twin) in former else {})
        solid += [number] * (twin in solid)
    for name, value in ((FORMER, former), (SOLID_BEFORE, sorted(solid)), (KNOWN, sorted(shown))):
        if value:
            screen[name] = value


def look_of(shading: bpy.types.View3DShading) -> Look:
    """The shading settings of a viewport that a bake changes."""
    return {name: getattr(shading, name) for name in PLAIN}


def wanted(context: bpy.types.Context) -> Look:
    """The shading for attributes, which depends on the mode of the active object."""
    active = getattr(context, "active_object", None)  # without a window, as timers are called, there is none
    return LIT if active is not None and active.mode == "SCULPT" else PLAIN


def is_shown(context: bpy.types.Context) -> bool:
    """Returns whether the context's viewport is solid and shows attributes as after a bake."""
    shading, look = context.space_data.shading, wanted(context)
    return all(getattr(shading, name) == look[name] for name in ("color_type", "light") if name in look)


def show_attributes(screen: bpy.types.Screen | None, shading: bpy.types.View3DShading, look: Look = PLAIN) -> None:
    """Makes solid shading show the active color attribute, and remembers its former settings."""
    if screen is not None:
        settle(screen)
    for number, own in shadings(screen):
        if own == shading:
            give_back(shading, {name: one for name, one in formers(screen).get(number, {}).items() if name not in look})
            present, known = look_of(shading), formers(screen).get(number, {})
            kept = {name: known[name] for name in known if present[name] == PLAIN[name]}
            if kept or any(present[name] != look[name] for name in look):
                screen[FORMER] = {**formers(screen), number: {**present, **kept}}
    for name, value in look.items():
        setattr(shading, name, value)


def give_back(shading: bpy.types.View3DShading, former: Look) -> None:
    """Restores the former settings of a viewport, except those that were changed since."""
    for name, value in former.items():
        if name in PLAIN and getattr(shading, name) == PLAIN[name]:
            kind = shading.bl_rna.properties[name]
            if kind.type != "ENUM":
                setattr(shading, name, bool(value))
            elif value in {item.identifier for item in kind.enum_items}:
                setattr(shading, name, value)


def reveal(context: bpy.types.Context) -> None:
    """Makes every solid viewport of the window show the colors, unless the preferences say otherwise.

    A viewport that an earlier bake made show attributes keeps the light that somebody has chosen since.
    """
    if bpy.app.background or not preferences.shows_results():
        return
    image_preview.hide()  # which would lie over them
    screen, look = context.screen, wanted(context)
    if screen is not None:
        settle(screen)
    undone = {} if screen is None else screen.get(UNDONE, {})
    for number, shading in shadings(screen):
        seen = number in formers(screen) and shading.color_type == ATTRIBUTES
        if shading.type == "SOLID" and (look is LIT or not seen):
            show_attributes(screen, shading, dict(undone[number]) if look is PLAIN and number in undone else look)
    if screen is not None and UNDONE in screen:
        del screen[UNDONE]


def reveal_materials(context: bpy.types.Context) -> None:
    """Makes every solid viewport show materials, which have just changed, unless the preferences say otherwise."""
    if bpy.app.background or not preferences.shows_results():
        return
    settle(context.screen)
    numbers = set(context.screen.get(SOLID_BEFORE, []))
    for number, shading in shadings(context.screen):
        if shading.type == "SOLID":
            numbers.add(int(number))
            shading.type = "MATERIAL"
    if numbers:
        context.screen[SOLID_BEFORE] = sorted(numbers)
    if UNWORN in context.screen:
        del context.screen[UNWORN]


def can_restore(context: bpy.types.Context) -> bool:
    """Returns whether the former shading of viewports is known."""
    return context.screen is not None and (FORMER in context.screen or SOLID_BEFORE in context.screen)


def restore(screen: bpy.types.Screen) -> None:
    """Restores the former shading of every viewport that a bake changed, if it still shows attributes."""
    image_preview.hide()
    settle(screen)
    former, solid = formers(screen), list(screen.get(SOLID_BEFORE, []))
    for name in (FORMER, SOLID_BEFORE, KNOWN):
        if name in screen:
            del screen[name]
    for number, shading in shadings(screen):
        if int(number) in solid and shading.type == "MATERIAL":
            shading.type = "SOLID"
        give_back(shading, former.get(number, {}))


def yield_to_mask(context: bpy.types.Context) -> None:
    """Restores the shading after a sculpt mask was written, as the mask's dark areas cannot be seen on a black bake."""
    if not bpy.app.background and preferences.shows_results() and can_restore(context):
        restore(context.screen)


# ---- Undo


def visible_meshes(window: bpy.types.Window) -> list[bpy.types.Object]:
    """The mesh objects that a window shows."""
    layer = window.view_layer  # not that of the context, where another window shows another scene
    return [item for item in layer.objects if item.type == "MESH" and item.visible_get(view_layer=layer)]


def has_materials(window: bpy.types.Window) -> bool:
    """Tells whether a visible mesh in the window has a material with nodes of ours."""
    slots = (slot for item in visible_meshes(window) for slot in item.material_slots)
    materials = {slot.material for slot in slots if slot.material is not None}
    return any(node_groups.nodes_of_ours(one.node_tree) for one in materials)


def shows_materials(window: bpy.types.Window) -> bool:
    """Tells whether it does, and was made to show materials for them."""
    return SOLID_BEFORE in window.screen and has_materials(window)


def shows_ours(window: bpy.types.Window) -> bool:
    """Tells whether a visible mesh in the window has active colors from a bake, or a material that a bake made."""
    active = ((item.data, item.data.color_attributes.active_color) for item in visible_meshes(window))
    if any(color is not None and color.name in record.attributes_of(mesh) for mesh, color in active):
        return True
    return shows_materials(window)


def hide_materials(screen: bpy.types.Screen) -> None:
    """Makes the viewports solid again that were so before they showed materials."""
    settle(screen)
    numbers = list(screen.get(SOLID_BEFORE, []))
    for number, shading in shadings(screen):
        if int(number) in numbers and shading.type == "MATERIAL":
            shading.type = "SOLID"
    screen[UNWORN] = numbers
    for name in (SOLID_BEFORE, *(() if FORMER in screen else (KNOWN,))):
        if name in screen:
            del screen[name]


_worn: list[str] = []  # the names of the screens that showed materials of ours when undo began


@persistent
def before_undo(*_ignored: object) -> None:
    """Notes which screens show materials of ours."""
    windows = bpy.context.window_manager.windows
    _worn[:] = [window.screen.name for window in windows if shows_materials(window)]


@persistent
def on_undo(*_ignored: object) -> None:
    """Restores the shading from before the bake, or from before the wear, that was undone."""
    for window in bpy.context.window_manager.windows:
        if window.screen.name in _worn and not shows_materials(window):
            hide_materials(window.screen)
        if (FORMER in window.screen or SOLID_BEFORE in window.screen) and not shows_ours(window):
            shown = [(number, one) for number, one in shadings(window.screen) if one.color_type == ATTRIBUTES]
            window.screen[UNDONE] = {number: look_of(one) for number, one in shown}
            restore(window.screen)


@persistent
def on_redo(*_ignored: object) -> None:
    """Makes viewports show the colors, or the materials, that redo has restored."""
    for window in bpy.context.window_manager.windows:
        with bpy.context.temp_override(window=window):
            if UNDONE in window.screen and shows_ours(window):
                reveal(bpy.context)
            if UNWORN in window.screen and has_materials(window):
                reveal_materials(bpy.context)


HANDLERS = {"undo_pre": before_undo, "undo_post": on_undo, "redo_post": on_redo}
classes = ()
