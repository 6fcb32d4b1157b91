"""The settings of a scene that say how values become colors, and what they mean for the color maps."""

from collections.abc import Callable

import bpy

from ..core.color_maps import AUTOMATIC, CLIPPED_PERCENT, MAPS, Look

COLOR_MAPS = [
    (AUTOMATIC, "Automatic", "Grey for masks; blue, white, red for values with a sign; viridis for all others"),
    *((row.name, row.label, row.description) for row in MAPS.values()),
]
SPANS = [
    (
        "auto",
        "Automatic",
        "Masks up to nearly their largest value, others over the descriptor's own range where it has one, else from "
        "the 2.5th to the 97.5th percentile",
    ),
    ("percentile", "Percentiles", "All values but a percentage on either side"),
    ("fixed", "Fixed", "From minimum to maximum, the same on every mesh"),
]
PACKED_KINDS = [
    ("FLOAT_COLOR", "Float", "32 bits a channel: exact"),
    ("BYTE_COLOR", "Byte", "8 bits a channel, as vertex paint and most formats have it"),
]
PACKED_DOMAINS = [
    ("POINT", "Vertex", "One color a vertex"),
    ("CORNER", "Face Corner", "One color a face corner, as most formats and older tools want it"),
]
CHANNELS = ("red", "green", "blue", "alpha")
# Called with the scene whose settings were changed. Folders that come later add themselves, unknown to this one.
LISTENERS: list[Callable[[bpy.types.Scene], None]] = []


def redraw(_group: bpy.types.PropertyGroup, context: bpy.types.Context) -> None:
    """Draws the viewports again, for the legend."""
    for area in context.screen.areas if context.screen is not None else ():
        if area.type == "VIEW_3D":
            area.tag_redraw()


def changed(group: bpy.types.PropertyGroup, _context: bpy.types.Context) -> None:
    """Recolors live values at once; baked values wait for Recolor."""
    for listener in LISTENERS:
        listener(group.id_data)


class PARADESC_PG_looks(bpy.types.PropertyGroup):
    """How values are shown in one scene."""

    color_map: bpy.props.EnumProperty(
        name="Color Map", description="The colors that values get", items=COLOR_MAPS, default=AUTOMATIC, update=changed
    )
    span: bpy.props.EnumProperty(
        name="Range", description="The values at the ends of the color map", items=SPANS, default="auto", update=changed
    )
    percentile: bpy.props.FloatProperty(
        name="Left Out",
        description="Share of the values left outside the range on either side",
        default=CLIPPED_PERCENT,
        min=0.0,
        max=49.0,
        precision=1,
        subtype="PERCENTAGE",
        update=changed,
    )
    symmetric: bpy.props.BoolProperty(
        name="Symmetric",
        description="Of values with a sign: the same range on both sides of the neutral value",
        default=True,
        update=changed,
    )
    minimum: bpy.props.FloatProperty(
        name="Minimum",
        description="The value at the lower end, in the descriptor's unit",
        default=-1.0,
        precision=4,
        update=changed,
    )
    maximum: bpy.props.FloatProperty(
        name="Maximum",
        description="The value at the upper end, in the descriptor's unit",
        default=1.0,
        precision=4,
        update=changed,
    )
    use_neutral: bpy.props.BoolProperty(
        name="Own Neutral Value",
        description="Choose the value in the middle of maps with two sides, instead of the descriptor's own",
        default=False,
        update=changed,
    )
    neutral: bpy.props.FloatProperty(
        name="Neutral",
        description="The value in the middle of maps with two sides",
        default=0.0,
        precision=4,
        update=changed,
    )
    show_legend: bpy.props.BoolProperty(
        name="Legend",
        description="Show the color map with its numbers in viewports where the active object shows its values",
        default=True,
        update=redraw,
    )
    pack_red: bpy.props.StringProperty(name="Red", description="The values that become red; empty: 0")
    pack_green: bpy.props.StringProperty(name="Green", description="The values that become green; empty: 0")
    pack_blue: bpy.props.StringProperty(name="Blue", description="The values that become blue; empty: 0")
    pack_alpha: bpy.props.StringProperty(name="Alpha", description="The values that become alpha; empty: 1")
    pack_name: bpy.props.StringProperty(
        name="Name", description="The color attribute that the channels become", default="paradesc_packed", maxlen=60
    )
    pack_kind: bpy.props.EnumProperty(
        name="Type", description="Numbers of the color attribute", items=PACKED_KINDS, default="FLOAT_COLOR"
    )
    pack_domain: bpy.props.EnumProperty(
        name="Domain", description="What each color of the attribute belongs to", items=PACKED_DOMAINS, default="POINT"
    )


def fault(group: bpy.types.PropertyGroup) -> str:
    """One sentence about what is wrong with the settings, or ""."""
    if group.span == "fixed" and not group.maximum > group.minimum:
        return f"The range ends at {group.maximum:g}, which is not above {group.minimum:g}; set a larger maximum."
    return ""


def look_of(group: bpy.types.PropertyGroup) -> Look:
    """The settings as the color maps take them; an invalid range counts as automatic."""
    fixed = group.span == "fixed" and not fault(group)
    return Look(
        color_map=group.color_map,
        percentile=group.percentile if group.span == "percentile" else None,
        ranges={"": (group.minimum, group.maximum)} if fixed else {},
        symmetric=group.symmetric,
        neutral=group.neutral if group.use_neutral else None,
    )


def scene_look(scene: bpy.types.Scene) -> Look:
    """The look that a scene asks for; the default look if the add-on is not registered."""
    group = getattr(scene, "paradesc_looks", None)
    return Look() if group is None else look_of(group)


classes = (PARADESC_PG_looks,)


def register() -> None:
    """Gives every scene its settings."""
    bpy.types.Scene.paradesc_looks = bpy.props.PointerProperty(type=PARADESC_PG_looks)


def unregister() -> None:
    """Removes them."""
    del bpy.types.Scene.paradesc_looks
