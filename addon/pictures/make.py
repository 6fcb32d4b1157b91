"""Draws one picture of the manual inside Blender, for make.sh: make.py -- KIND FILE, kinds as in main()."""

import math
import sys
import tempfile
import traceback
from collections.abc import Iterator
from pathlib import Path

import bpy
import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
import paradesc
from paradesc.core import color_maps
from paradesc.files import lettering, png

RADIUS_PERCENT, BUFFER = 2.5, 1024


def monkey() -> bpy.types.Object:
    """Blender's monkey, subdivided twice, with curvature, cavity and convexity, alone in the scene."""
    for item in list(bpy.data.objects):
        bpy.data.objects.remove(item)
    bpy.ops.mesh.primitive_monkey_add()
    made = bpy.context.active_object
    made.name = "Suzanne"
    bpy.ops.object.shade_smooth()
    made.modifiers.new("subdivision", "SUBSURF").levels = 2
    bpy.ops.object.modifier_apply(modifier="subdivision")
    made.rotation_euler = (math.radians(-12), 0, math.radians(20))
    settings = bpy.context.scene.paradesc
    settings.descriptors = {"mean_curvature", "cavity", "convexity"}
    settings.radius_percent, settings.buffer_size = RADIUS_PERCENT, BUFFER
    bpy.ops.paradesc.bake()
    return made


def render_cavity(path: str) -> None:
    """The ready cavity material in Cycles, with one lamp and a light sky."""
    scene = bpy.context.scene
    made = monkey()
    bpy.ops.paradesc.make_material(kind="cavity")
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    camera.location, camera.rotation_euler = (0.0, -6.4, 0.7), (math.radians(84), 0, 0)
    camera.data.lens = 82
    lamp = bpy.data.objects.new("lamp", bpy.data.lights.new("lamp", "AREA"))
    lamp.location, lamp.rotation_euler = (-2.5, -3.5, 3.5), (math.radians(48), 0, math.radians(-35))
    lamp.data.energy, lamp.data.size = 190, 1.2
    for item in (camera, lamp):
        scene.collection.objects.link(item)
    scene.camera = camera
    scene.world = bpy.data.worlds.new("sky")
    scene.world.use_nodes = True
    scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.42, 0.46, 0.52, 1)
    scene.render.engine, scene.cycles.device, scene.cycles.samples = "CYCLES", "CPU", 96
    scene.cycles.use_denoising = False
    scene.view_settings.view_transform = "Standard"
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = 400, 360, 100
    scene.render.image_settings.color_mode = "RGB"
    scene.render.image_settings.compression = 100
    scene.render.filepath = path
    made.select_set(False)
    bpy.ops.render.render(write_still=True)


def steps(path: str) -> Iterator[None]:
    """Bakes, shows the colors and takes the picture; every yield lets Blender draw."""
    window = bpy.context.window_manager.windows[0]
    area = next(area for area in window.screen.areas if area.type == "VIEW_3D")
    with bpy.context.temp_override(window=window, area=area):
        bpy.ops.screen.screen_full_area(use_hide_panels=True)
    yield
    area = next(area for area in window.screen.areas if area.type == "VIEW_3D")
    region = next(region for region in area.regions if region.type == "WINDOW")
    space = area.spaces[0]
    with bpy.context.temp_override(window=window, area=area, region=region):
        monkey()
        bpy.ops.paradesc.show(name="mean_curvature")
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
        compress(path)


def panel_steps(path: str) -> Iterator[None]:
    """The sidebar with our tab, as a new user finds it, cut out of the window."""
    window = bpy.context.window_manager.windows[0]
    area = next(area for area in window.screen.areas if area.type == "VIEW_3D")
    with bpy.context.temp_override(window=window, area=area):
        monkey()
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
    image = bpy.data.images.load(path)
    width, height = image.size
    pixels = np.array(image.pixels[:], np.float32).reshape(height, width, 4)[::-1]
    bpy.data.images.remove(image)
    top = height - (sidebar.y + sidebar.height)
    cut = pixels[top : top + sidebar.height, sidebar.x : sidebar.x + sidebar.width, :3]
    png.write_png(Path(path), np.round(255 * cut).astype(np.uint8))


def draw_radii(path: str) -> None:
    """The monkey's mean curvature at three radii, each times the radius."""
    from paradesc.commands.main import main as run

    made, pictures = monkey(), []
    with tempfile.TemporaryDirectory() as folder:
        for radius in (0.01, 0.03, 0.09):
            file = str(Path(folder) / "radius.png")
            words = ["bake", "--object", made.name, "--radius", str(radius), "--output", file, "--quiet"]
            if run(words) != 0:
                raise RuntimeError("the mesh was not baked")
            pictures.append(half_size(file))
    png.write_png(Path(path), np.concatenate(pictures, axis=1))


def half_size(path: str) -> np.ndarray:
    """(height, width, 3) uint8: every second pixel of a picture."""
    image = bpy.data.images.load(path)
    width, height = image.size
    pixels = np.array(image.pixels[:], np.float32).reshape(height, width, 4)[::-1, :, :3]
    bpy.data.images.remove(image)
    return np.round(255 * pixels[::2, ::2]).astype(np.uint8)


def draw_frames(path: str) -> None:
    """The bending tube of the samples at three frames, with one range of colors."""
    sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "blend_samples"))
    import make_samples

    from paradesc.commands.main import main as run

    made = make_samples.make("04_armature_cylinder")
    pictures = []
    with tempfile.TemporaryDirectory() as folder:
        for frame in (1, 6, 12):
            bpy.context.scene.frame_set(frame)
            file = str(Path(folder) / "frame.png")
            words = ["bake", "--object", made.name, "--descriptors", "gaussian_curvature", "--range=-2:2"]
            if run([*words, "--source", "deformed", "--output", file, "--quiet"]) != 0:
                raise RuntimeError("the frame was not baked")
            pictures.append(half_size(file))
    png.write_png(Path(path), np.concatenate(pictures, axis=1))


def compress(path: str) -> None:
    """Writes a picture again, as small as it gets."""
    scene = bpy.context.scene
    scene.view_settings.view_transform = "Standard"
    form = scene.render.image_settings
    form.file_format, form.color_mode, form.compression = "PNG", "RGB", 100
    bpy.data.images.load(path).save_render(path, scene=scene)


def draw_maps(path: str) -> None:
    """Every color map as a bar with its name."""
    width, height, left = 420, 18, 150
    image = np.full((len(color_maps.MAPS) * (height + 4), left + width, 3), 237, np.uint8)
    for index, row in enumerate(color_maps.MAPS.values()):
        top = index * (height + 4) + 2
        colors = np.round(255 * row.function(np.linspace(0, 1, width))).astype(np.uint8)
        image[top : top + height, left:] = colors
        lettering.draw_text(image, row.name, 6, top + 5, 1, (60, 60, 60))
    png.write_png(Path(path), image)


def turn(iterator: Iterator[None]) -> float | None:
    """One step; Blender ends after the last one or the first failure."""
    try:
        next(iterator)
    except StopIteration:
        bpy.ops.wm.quit_blender()
        return None
    except Exception:  # noqa: BLE001 (Blender has to end)
        traceback.print_exc()
        bpy.ops.wm.quit_blender()
        return None
    return 0.3


def main() -> None:
    """Either picture."""
    kind, path = sys.argv[sys.argv.index("--") + 1 :]
    paradesc.register()
    if kind == "maps":
        draw_maps(path)
    elif kind == "cavity":
        render_cavity(path)
    elif kind == "radii":
        draw_radii(path)
    elif kind == "frames":
        draw_frames(path)
    else:
        bpy.context.preferences.view.show_splash = False
        bpy.context.preferences.view.smooth_view = 0
        iterator = steps(path) if kind == "legend" else panel_steps(path)
        bpy.app.timers.register(lambda: turn(iterator), first_interval=1.0)


main()
