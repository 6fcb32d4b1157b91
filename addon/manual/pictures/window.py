"""Pictures of Blender's own window: the legend in the viewport, the panel in the sidebar.

Every yield lets Blender draw.
"""

from collections.abc import Iterator
from pathlib import Path

import bpy
import numpy as np
import subjects

from paradesc.files import png


def legend_steps(path: str) -> Iterator[None]:
    """Bakes, shows the colors and takes the picture."""
    window = bpy.context.window_manager.windows[0]
    area = next(area for area in window.screen.areas if area.type == "VIEW_3D")
    with bpy.context.temp_override(window=window, area=area):
        bpy.ops.screen.screen_full_area(use_hide_panels=True)
    yield
    area = next(area for area in window.screen.areas if area.type == "VIEW_3D")
    region = next(region for region in area.regions if region.type == "WINDOW")
    space = area.spaces[0]
    with bpy.context.temp_override(window=window, area=area, region=region):
        subjects.baked_monkey("mean_curvature")
        bpy.ops.paradesc.view_colors()
        bpy.ops.view3d.view_axis(type="FRONT")
        bpy.ops.view3d.view_selected()
        space.region_3d.view_distance *= 0.75
        bpy.ops.object.select_all(action="DESELECT")
        space.show_region_ui = space.show_region_toolbar = space.show_gizmo = False
        overlay = space.overlay
        overlay.show_floor = overlay.show_ortho_grid = overlay.show_cursor = overlay.show_object_origins = False
        overlay.show_axis_x = overlay.show_axis_y = overlay.show_axis_z = overlay.show_text = False
        for _ in range(6):
            area.tag_redraw()
            yield
        bpy.ops.screen.screenshot(filepath=path)
        png.write_png(Path(path), subjects.pixels_of(path))


def panel_steps(path: str) -> Iterator[None]:
    """The sidebar with our tab, as a new user finds it, cut out of the window."""
    window = bpy.context.window_manager.windows[0]
    area = next(area for area in window.screen.areas if area.type == "VIEW_3D")
    with bpy.context.temp_override(window=window, area=area):
        subjects.monkey()
        bpy.ops.screen.screen_full_area(use_hide_panels=True)
    yield
    area = next(area for area in window.screen.areas if area.type == "VIEW_3D")
    area.spaces[0].show_region_ui = True
    yield
    sidebar = next(region for region in area.regions if region.type == "UI")
    for value in ("PRESS", "RELEASE"):  # on our tab, the last of four
        window.event_simulate("LEFTMOUSE", value, x=sidebar.x + sidebar.width - 12, y=sidebar.y + sidebar.height - 175)
        yield
    for _ in range(6):
        area.tag_redraw()
        yield
    bpy.ops.screen.screenshot(filepath=path)
    pixels = subjects.pixels_of(path)
    top = len(pixels) - (sidebar.y + sidebar.height)
    cut = pixels[top : top + sidebar.height, sidebar.x : sidebar.x + sidebar.width]
    png.write_png(Path(path), np.ascontiguousarray(cut))
