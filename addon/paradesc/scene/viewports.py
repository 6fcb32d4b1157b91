"""Lets the viewports show what a bake painted, and brings back how they looked before."""

from collections.abc import Iterator

import bpy

from ..settings import preferences
from . import image_preview

# A custom property of the screen: what solid shading showed before, by the number of the viewport's area, so that a
# saved file still can bring it back. Earlier versions kept one word for all of them.
FORMER = "paradesc_color_type"
ATTRIBUTES = "VERTEX"


def shadings(screen: bpy.types.Screen | None) -> Iterator[tuple[str, bpy.types.View3DShading]]:
    """The number and the shading of each 3D viewport of a screen."""
    for number, area in enumerate(screen.areas if screen is not None else ()):
        if area.type == "VIEW_3D":
            yield str(number), area.spaces.active.shading


def formers(screen: bpy.types.Screen) -> dict[str, str]:
    """What viewports showed before, by number."""
    kept = screen.get(FORMER, {})
    return dict.fromkeys((number for number, _ in shadings(screen)), kept) if isinstance(kept, str) else dict(kept)


def show_attributes(screen: bpy.types.Screen | None, shading: bpy.types.View3DShading) -> None:
    """Lets solid shading show the active color attribute, and keeps in mind what it showed before."""
    if shading.color_type == ATTRIBUTES:
        return
    for number, own in shadings(screen):
        if own == shading:
            screen[FORMER] = {**formers(screen), number: shading.color_type}
    shading.color_type = ATTRIBUTES


def reveal(context: bpy.types.Context) -> None:
    """After a bake: every solid viewport of the window shows the colors, unless the preferences say otherwise."""
    if bpy.app.background or not preferences.shows_results():
        return
    image_preview.hide()  # which lies over them
    for _, shading in shadings(context.screen):
        if shading.type == "SOLID":
            show_attributes(context.screen, shading)


def reveal_materials(context: bpy.types.Context) -> None:
    """After materials were changed: every solid viewport shows them, unless the preferences say otherwise."""
    if bpy.app.background or not preferences.shows_results():
        return
    for _, shading in shadings(context.screen):
        if shading.type == "SOLID":
            shading.type = "MATERIAL"


def can_restore(context: bpy.types.Context) -> bool:
    """Whether it is known how the viewports looked before."""
    return context.screen is not None and FORMER in context.screen


def restore(screen: bpy.types.Screen) -> None:
    """Gives every viewport that a bake has made show attributes what it showed before, if it shows them still."""
    former = formers(screen)
    del screen[FORMER]
    for number, shading in shadings(screen):
        known = {item.identifier for item in shading.bl_rna.properties["color_type"].enum_items}
        if shading.color_type == ATTRIBUTES and former.get(number) in known:
            shading.color_type = former[number]
