"""The settings of a scene that define how values become colors."""

from collections.abc import Callable

import bpy

from paradesc.core import choices, members
from paradesc.core.color_maps import Look

from . import hooks
from .properties import property_of

PACKED_KINDS = [
    ("FLOAT_COLOR", "Float", "32 bits a channel: exact"),
    ("BYTE_COLOR", "Byte", "8 bits a channel, as vertex paint and most formats have it"),
]
PACKED_DOMAINS = [
    ("POINT", "Vertex", "One color a vertex"),
    ("CORNER", "Face Corner", "One color a face corner, as most formats and older tools want it"),
]
COLORS = members.color_members()
CHANNELS = ("red", "green", "blue", "alpha")
Listener = Callable[[bpy.types.Scene, str], None]
# Functions that are called with the scene whose settings have changed, and the name of the setting. Folders that import
# this one add theirs, so that this one need not import them.
LISTENERS: list[Listener] = []


def listen(listener: Listener) -> None:
    """Adds a listener only once, in place of the same one from an earlier import of the add-on."""
    ignore(listener)
    LISTENERS.append(listener)


def ignore(listener: Listener) -> None:
    """Removes a listener, if it is there."""
    LISTENERS[:] = [one for one in LISTENERS if not hooks.is_same(one, listener)]


def redraw(_group: object = None, _context: object = None) -> None:
    """Draws all viewports again, for the legend or an image."""
    for window in bpy.context.window_manager.windows:
        for area in window.screen.areas:
            if area.type == "VIEW_3D":
                area.tag_redraw()


def of_color(name: str) -> object:
    """The property of a color setting, which calls all listeners when it changes."""

    def changed(group: bpy.types.PropertyGroup, _context: bpy.types.Context) -> None:
        for listener in LISTENERS:
            listener(group.id_data, name)

    return property_of(COLORS[name], update=changed)


class PARADESC_PG_looks(bpy.types.PropertyGroup):
    """The settings of how one scene shows values."""

    color_map: of_color("color_map")
    span: of_color("span")
    percentile: of_color("percentile")
    symmetric: of_color("symmetric")
    minimum: of_color("minimum")
    maximum: of_color("maximum")
    contrast: of_color("contrast")
    brightness: of_color("brightness")
    invert: of_color("invert")
    same_scale: of_color("same_scale")
    use_neutral: of_color("use_neutral")
    neutral: of_color("neutral")
    show_legend: bpy.props.BoolProperty(
        name="Legend",
        description="Show the color map with its numbers in viewports where the active object shows its values",
        default=True,
        update=redraw,
    )
    pack_red: bpy.props.StringProperty(name="Red", description="Values that become red; 0 if empty")
    pack_green: bpy.props.StringProperty(name="Green", description="Values that become green; 0 if empty")
    pack_blue: bpy.props.StringProperty(name="Blue", description="Values that become blue; 0 if empty")
    pack_alpha: bpy.props.StringProperty(name="Alpha", description="Values that become alpha; 1 if empty")
    pack_name: bpy.props.StringProperty(
        name="Name", description="The color attribute that the channels become", default="paradesc_packed", maxlen=60
    )
    pack_kind: bpy.props.EnumProperty(
        name="Type", description="Numbers of the color attribute", items=PACKED_KINDS, default="FLOAT_COLOR"
    )
    pack_domain: bpy.props.EnumProperty(
        name="Domain", description="Part of the mesh that has a color of its own", items=PACKED_DOMAINS, default="POINT"
    )


def scene_look(scene: bpy.types.Scene) -> Look:
    """The look of a scene's settings; the default look if the add-on is not registered."""
    group = getattr(scene, "paradesc_looks", None)
    return Look() if group is None else choices.look_of(group)


classes = (PARADESC_PG_looks,)
GROUPS = {(bpy.types.Scene, "paradesc_looks"): PARADESC_PG_looks}
