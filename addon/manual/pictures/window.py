"""Pictures of Blender's own window: the legend in the viewport, the panel in the sidebar.

Every yield lets Blender draw.
"""

import sys
from collections.abc import Iterator
from pathlib import Path

import bpy
import numpy as np
import screen
import subjects
from bpy_extras import view3d_utils

from paradesc.files import png


def alone() -> Iterator[None]:
    """Lets the viewport fill the window, without what belongs to Blender's interface."""
    window = bpy.context.window_manager.windows[0]
    area = next(area for area in window.screen.areas if area.type == "VIEW_3D")
    with bpy.context.temp_override(window=window, area=area):
        bpy.ops.screen.screen_full_area(use_hide_panels=True)
    yield
    space = next(area for area in window.screen.areas if area.type == "VIEW_3D").spaces[0]
    space.show_region_ui = space.show_region_toolbar = space.show_gizmo = False
    overlay = space.overlay
    overlay.show_floor = overlay.show_ortho_grid = overlay.show_cursor = overlay.show_object_origins = False
    overlay.show_axis_x = overlay.show_axis_y = overlay.show_axis_z = overlay.show_text = False


def from_the_front() -> dict[str, object]:
    """The viewport, in which the selected mesh is seen from the front."""
    window = bpy.context.window_manager.windows[0]
    area = next(area for area in window.screen.areas if area.type == "VIEW_3D")
    place = {"window": window, "area": area, "region": view_of(area)}
    with bpy.context.temp_override(**place):
        bpy.ops.view3d.view_axis(type="FRONT")
        bpy.ops.view3d.view_selected()
        area.spaces[0].region_3d.view_distance *= 0.75
    return place


def screenshot(area: bpy.types.Area, path: str) -> Iterator[None]:
    """Takes the picture of the whole window."""
    yield from drawn(area)
    png.write_png(Path(path), screen.pixels())


def legend_steps(path: str) -> Iterator[None]:
    """Bakes, shows the colors and takes the picture."""
    yield from alone()
    subjects.baked(subjects.creature(), "mean_curvature")
    place = from_the_front()
    with bpy.context.temp_override(**place):
        bpy.ops.paradesc.view_colors()
        bpy.ops.object.select_all(action="DESELECT")
    yield from screenshot(place["area"], path)


def sculpting_steps(path: str) -> Iterator[None]:
    """Masks the edges in sculpt mode and takes the picture."""
    yield from alone()
    subjects.creature()
    bpy.context.scene.paradesc.radius_percent = 3.0
    place = from_the_front()
    with bpy.context.temp_override(**place):
        bpy.ops.object.mode_set(mode="SCULPT")
        bpy.context.tool_settings.sculpt.show_brush = False
        place["area"].spaces[0].overlay.sculpt_mode_mask_opacity = 1.0
        bpy.ops.paradesc.mask_from_shape(mask="edge_wear")
    yield from screenshot(place["area"], path)


# Pixels from the sidebar's top to the middle of our tab, the last of four, and of the button in the panel.
TAB_BELOW_TOP, BUTTON_BELOW_TOP = 175, 168
# And from there down to the one that makes textures.
IMAGE_BELOW_BUTTON = 30
# And to the one that bakes the selected meshes onto the active one.
ONTO_BELOW_BUTTON = 56
# The panel fits one screen, before and after a bake.
MOST_PIXELS = 600


def panel_steps(path: str) -> Iterator[None]:
    """The sidebar with our tab as a new user finds it, and after one click, beside each other.

    It fails if the click does not leave a grey mask in the viewport, or if the panel does not fit a screen.
    """
    window = bpy.context.window_manager.windows[0]
    area = next(area for area in window.screen.areas if area.type == "VIEW_3D")
    with bpy.context.temp_override(window=window, area=area):
        mesh = subjects.creature().data
        bpy.ops.screen.screen_full_area(use_hide_panels=True)
    yield
    area = next(area for area in window.screen.areas if area.type == "VIEW_3D")
    area.spaces[0].show_region_ui = True
    yield
    sidebar = next(region for region in area.regions if region.type == "UI")
    yield from clicked(window, sidebar.x + sidebar.width - 12, sidebar.y + sidebar.height - TAB_BELOW_TOP)
    yield from drawn(area)
    before = picture_of(sidebar)
    yield from clicked(window, sidebar.x + sidebar.width // 3, sidebar.y + sidebar.height - BUTTON_BELOW_TOP)
    for _ in range(100):
        if "cavity" in mesh.attributes:
            break
        yield
    else:
        png.write_png(Path(path), screen.pixels())
        raise AssertionError("the click baked nothing")
    with bpy.context.temp_override(window=window, area=area, region=view_of(area)):
        bpy.ops.view3d.view_axis(type="FRONT")
        bpy.ops.view3d.view_selected()
    yield from drawn(area)
    view = view_of(area)
    after = picture_of(sidebar)
    seen = picture_of(view)[:, : sidebar.x - view.x]
    height = max(map(panel_height, (before, after)))
    png.write_png(Path(path), np.ascontiguousarray(np.hstack([before, after])[: height + 8]))
    png.write_png(Path(path).with_stem("first_mask"), np.ascontiguousarray(seen))
    assert mesh.color_attributes.active_color.name in ("cavity_color", "convexity_color")
    assert grey_contrast(seen) > 0.2, "no grey mask is seen"
    assert height <= MOST_PIXELS, f"the panel is {height} pixels high"
    yield from one_click_each(window, sidebar, mesh)
    yield from three_clicks_onto(window, area, sidebar)
    sys.stdout.write(
        f"panel: {panel_height(before)} pixels high, {panel_height(after)} after one click and a grey mask; "
        "one click makes a texture, one switches live values on, and three bake a detailed mesh onto another\n"
    )


def one_click_each(window: bpy.types.Window, sidebar: bpy.types.Region, mesh: bpy.types.Mesh) -> Iterator[None]:
    """Switches live values on by one click and makes a texture by another; fails if one of them needs more."""
    live = next(target for target in bpy.data.objects if target.data == mesh).paradesc_live
    height = sidebar.y + sidebar.height - BUTTON_BELOW_TOP
    yield from clicked(window, sidebar.x + sidebar.width * 18 // 25, height)
    yield
    assert live.mode == "LIVE", "one click does not switch live values on"
    live.mode = "OFF"
    yield from clicked(window, sidebar.x + sidebar.width // 3, height - IMAGE_BELOW_BUTTON)
    for _ in range(100):
        if any(image.name.endswith("_cavity") for image in bpy.data.images):
            return
        yield
    raise AssertionError("one click makes no texture")


def three_clicks_onto(window: bpy.types.Window, area: bpy.types.Area, sidebar: bpy.types.Region) -> Iterator[None]:
    """Selects a detailed mesh, then a coarse one, in the viewport, and bakes; fails if the clicks make no texture."""
    subjects.empty()
    for image in list(bpy.data.images):
        bpy.data.images.remove(image)
    apart = 0.3  # so that either can be clicked where the other is not
    for segments, place in ((64, -apart / 2), (16, apart / 2)):
        bpy.ops.mesh.primitive_uv_sphere_add(segments=segments, ring_count=segments // 2, location=(place, 0, 0))
    view = view_of(area)
    with bpy.context.temp_override(window=window, area=area, region=view):
        bpy.ops.object.select_all(action="SELECT")
        bpy.ops.view3d.view_axis(type="FRONT")
        bpy.ops.view3d.view_selected()
        bpy.ops.object.select_all(action="DESELECT")
    yield from drawn(area)
    for shift, side in ((False, -1), (True, 1)):
        rim = (side * (1 + 0.3 * apart), 0, 0)
        x, y = view3d_utils.location_3d_to_region_2d(view, area.spaces[0].region_3d, rim)
        yield from clicked(window, view.x + round(x), view.y + round(y), shift=shift)
        yield from drawn(area)
    button = sidebar.y + sidebar.height - BUTTON_BELOW_TOP - ONTO_BELOW_BUTTON
    yield from clicked(window, sidebar.x + sidebar.width // 3, button)
    for _ in range(100):
        if any(image.name.endswith("_cavity") for image in bpy.data.images):
            return
        yield
    raise AssertionError("three clicks bake nothing onto the coarse mesh")


def view_of(area: bpy.types.Area) -> bpy.types.Region:
    """The region that shows the scene."""
    return next(region for region in area.regions if region.type == "WINDOW")


def clicked(window: bpy.types.Window, x: int, y: int, shift: bool = False) -> Iterator[None]:
    """Moves there, which makes a button active, and presses and releases the left button of the mouse."""
    for _ in range(2):
        window.event_simulate("MOUSEMOVE", "NOTHING", x=x, y=y)
        yield
    for value in ("PRESS", "RELEASE"):
        window.event_simulate("LEFTMOUSE", value, x=x, y=y, shift=shift)
        yield


def drawn(area: bpy.types.Area) -> Iterator[None]:
    """Lets Blender draw the viewport."""
    for _ in range(6):
        area.tag_redraw()
        yield


def picture_of(region: bpy.types.Region) -> np.ndarray:
    """(height, width, 3) uint8 of a region of the window, top row first."""
    pixels = screen.pixels()
    top = len(pixels) - (region.y + region.height)
    return pixels[top : top + region.height, region.x : region.x + region.width]


def panel_height(sidebar: np.ndarray) -> int:
    """The end of the panels, in pixels from the top: half a row below the last row of white text."""
    text = (sidebar[:, 16:190].min(axis=2) > 150).any(axis=1)
    return int(np.flatnonzero(text).max()) + 10


def grey_contrast(seen: np.ndarray) -> float:
    """The range of the greys in the middle of the viewport, from 0 to 1; 0 where most of it is colored."""
    height, width = seen.shape[:2]
    middle = seen[height // 2 - 60 : height // 2 + 60, width // 2 - 60 : width // 2 + 60].astype(int)
    chroma = np.ptp(middle, axis=2)
    return float(np.ptp(middle[chroma < 6]) / 255) if np.median(chroma) < 6 else 0.0


STEPS = {"legend": legend_steps, "panel": panel_steps, "sculpting": sculpting_steps}
