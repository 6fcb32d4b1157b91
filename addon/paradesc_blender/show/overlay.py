"""Draws the legend in the viewport, a color bar with numbers, if the panel's object shows our colors."""

import bpy

from paradesc.core import color_maps, legend

from ..scene import record, targets
from ..settings import translation
from . import recolor, slots

BAR_WIDTH, BAR_HEIGHT, MARGIN, TEXT_SIZE, STEPS = 260, 12, 26, 12, 65
INK, SHADOW = (1.0, 1.0, 1.0, 1.0), (0.0, 0.0, 0.0, 0.9)
BACK = (0.0, 0.0, 0.0, 0.45)
_state: dict[str, object] = {}


def shown_descriptor(context: bpy.types.Context) -> tuple[bpy.types.Object, str] | None:
    """The panel's object and the descriptor that it shows in this viewport, or None."""
    target, space = targets.first(context), context.space_data
    if target is None or not target.visible_get(viewport=space):
        return None
    name = name_in(space.shading.type, space.shading.color_type, target)
    return (target, name) if name else None


def name_in(shading: str, color_type: str, target: bpy.types.Object) -> str:
    """The descriptor that an object shows with this shading, or ""."""
    if shading == "SOLID" and (color_type == "VERTEX" or target.mode == "VERTEX_PAINT"):
        return recolor.shown_name(target.data)
    if shading in {"MATERIAL", "RENDERED"}:
        name = slots.shown_descriptor(target)
        return name if name in recolor.baked_names(target.data) else ""
    return ""


def lines_of(mesh: bpy.types.Mesh, name: str) -> tuple[str, color_maps.ValueRange]:
    """The title of the legend, and the range with its map."""
    drawn = record.read(mesh).get("drawn", {}).get(name, {})
    title = translation.label(legend.label(name)) + legend.in_unit(drawn.get("unit", ""))
    return title, recolor.stored_range(mesh, name)


def draw() -> None:
    """Blender calls this to draw each viewport."""
    context = bpy.context
    group = getattr(context.scene, "paradesc_looks", None)
    if group is None or not group.show_legend or not context.space_data.overlay.show_overlays:
        return
    found = shown_descriptor(context)
    if found is None:
        return
    target, name = found
    if name not in record.read(target.data).get("ranges", {}):
        return
    title, shown = lines_of(target.data, name)
    scale = context.preferences.system.ui_scale
    left, right = free_span(context.area, context.region)
    width = min(BAR_WIDTH * scale, right - left - 2 * MARGIN * scale)
    if width < 80 * scale:
        return
    place, text = (left + MARGIN * scale, MARGIN * scale + below(context.area)), f"{target.name}: {title}"
    if recolor.is_direction(name):
        draw_texts(*place, width, scale, text, [(0.5, translation.label(legend.DIRECTIONS))])
        return
    draw_bar(*place, width, scale, shown)
    draw_texts(*place, width, scale, text, legend.ticks(name, shown))


def below(area: bpy.types.Area) -> float:
    """The height in pixels of the panel of the last operation at the bottom of the viewport."""
    heights = [region.height for region in area.regions if region.type == "HUD" and region.height > 1]
    return float(max(heights, default=0))


def free_span(area: bpy.types.Area, window: bpy.types.Region) -> tuple[float, float]:
    """The horizontal span in pixels that toolbar and sidebar leave free."""
    left, right = 0.0, float(window.width)
    for region in area.regions:
        if region.type == "TOOLS" and region.width > 1 and region.x <= window.x:
            left = max(left, region.x + region.width - window.x)
        if region.type == "UI" and region.width > 1:
            right = min(right, region.x - window.x)
    return left, right


def draw_bar(x: float, y: float, width: float, scale: float, shown: color_maps.ValueRange) -> None:
    """Draws the colors on a dark ground, which holds the texts as well."""
    import gpu
    import numpy as np
    from gpu_extras.batch import batch_for_shader

    y += 16 * scale
    height, pad = BAR_HEIGHT * scale, 8 * scale
    colors = color_maps.colors(np.linspace(shown.minimum, shown.maximum, STEPS), shown)
    places = np.linspace(x, x + width, STEPS)
    shader = gpu.shader.from_builtin("SMOOTH_COLOR" if bpy.app.version >= (4, 0, 0) else "2D_SMOOTH_COLOR")
    gpu.state.blend_set("ALPHA")
    x0, x1, y0, y1 = x - 2.5 * pad, x + width + 2.5 * pad, y - 3 * pad, y + height + 3.4 * pad
    ground = {"pos": [(x0, y0), (x1, y0), (x0, y1), (x1, y1)], "color": [BACK] * 4}
    bar = {
        "pos": [(float(place), level) for place in places for level in (y, y + height)],
        "color": [(*map(float, color), 1.0) for color in colors for _ in range(2)],
    }
    for content in (ground, bar):
        batch_for_shader(shader, "TRI_STRIP", content).draw(shader)
    gpu.state.blend_set("NONE")


def draw_texts(x: float, y: float, width: float, scale: float, title: str, ticks: list[tuple[float, str]]) -> None:
    """Draws the title above the bar and the numbers below it."""
    import blf

    blf.size(0, TEXT_SIZE * scale, *(() if bpy.app.version >= (4, 0, 0) else (72,)))
    blf.color(0, *INK)
    blf.enable(0, blf.SHADOW)
    blf.shadow(0, 3, *SHADOW)
    blf.position(0, x, y + (16 + BAR_HEIGHT + 8) * scale, 0)
    blf.draw(0, title)
    for share, text in ticks:
        blf.position(0, x + share * width - blf.dimensions(0, text)[0] / 2, y, 0)
        blf.draw(0, text)
    blf.disable(0, blf.SHADOW)


classes = ()


def register() -> None:
    """Makes Blender call draw(), except in background mode."""
    if not bpy.app.background:
        _state["handle"] = bpy.types.SpaceView3D.draw_handler_add(draw, (), "WINDOW", "POST_PIXEL")


def unregister() -> None:
    """Stops these calls."""
    handle = _state.pop("handle", None)
    if handle is not None:
        bpy.types.SpaceView3D.draw_handler_remove(handle, "WINDOW")
