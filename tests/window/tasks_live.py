"""Live: what it shows, while sculpting, in renders of animations, and from the cache."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

import bpy
import numpy as np
import person
from scenes import as_found, baked, clicked, idle, monkey, shading, undo_step

from paradesc_blender.scene import arrays, mesh_io, sculpt_masks

if TYPE_CHECKING:
    from drive import Run

BRUSH = "brushes/essentials_brushes-mesh_sculpt.blend/Brush/Draw"
DARKER = 0.8  # of the brightness without a mask


def values(name: str = "cavity") -> np.ndarray:
    """The values of the active mesh; none if there are none."""
    mesh = bpy.context.object.data
    return arrays.attribute_values(mesh.attributes[name]) if name in mesh.attributes else np.zeros(0)


def fresh(run: "Run") -> Iterator[None]:
    """A monkey with a Subdivision that is not applied: Live, then Bake."""
    made = monkey(2)
    as_found()
    shading().light, shading().color_type = "STUDIO", "MATERIAL"
    yield from person.drawn(2)
    yield from person.press("paradesc_live.follows")
    yield from person.wait(lambda: baked("cavity"), 60)
    yield from person.drawn(8)
    file = yield from run.picture("live")
    run.saw("clicks", "live takes 1 click", made.paradesc_live.mode == "LIVE")
    run.saw("B1", f"Live switches the viewport to {shading().color_type}, light {shading().light}", shading().color_type == "VERTEX" and shading().light == "FLAT", file)
    live = values()
    span = dict(made.data["paradesc"].to_dict().get("ranges", {}))
    yield from clicked()
    file = yield from run.picture("bake_beside_live")
    both = values()
    same = live.shape == both.shape and np.abs(live - both).max() < 0.05
    run.saw("B2", f"values of Live and Bake differ by {np.abs(live - both).max() if live.shape == both.shape else 'their number'}", bool(same), file)
    run.saw("C9", f"range of Live {span}, of Bake {dict(made.data['paradesc'].to_dict()['ranges'])}")
    made.paradesc_live.mode = "OFF"


def stroke(made: bpy.types.Object) -> None:
    """One stroke of the brush in the middle of the viewport, which looks along y."""
    region = person.region("WINDOW")
    x, y = region.width / 2, region.height / 2
    place = made.ray_cast((0, -9, 0), (0, 1, 0))[1]
    dot = {"name": "", "location": place, "mouse": (x, y), "mouse_event": (x, y), "pressure": 1.0, "size": 60.0}
    dot.update(pen_flip=False, x_tilt=0.0, y_tilt=0.0, time=0.0)
    dots = [{**dot, "is_start": number == 0, "mouse": (x + 12 * number, y), "mouse_event": (x + 12 * number, y), "time": 0.1 * number} for number in range(6)]
    person.in_view(bpy.ops.sculpt.brush_stroke, "EXEC_DEFAULT", True, stroke=dots)


def sculpt(run: "Run") -> Iterator[None]:
    """A stroke with Live on; then the mask of sculpt mode over a shown bake."""
    made = monkey(3, applied=True)
    as_found()
    yield from person.press("paradesc_live.follows")
    yield from person.wait(lambda: baked("cavity"), 60)
    person.in_view(bpy.ops.object.mode_set, mode="SCULPT")
    yield from person.drawn(3)
    if (yield from has_brush(run)):
        before, places = values().copy(), mesh_io.read_positions(made.data)
        stroke(made)
        yield from person.drawn(25)
        file = yield from run.picture("sculpt_stroke")
        moved = np.abs(mesh_io.read_positions(made.data) - places).max()
        changed = float(np.abs(values() - before).max()) if len(values()) == len(before) else -1.0
        run.saw("B3", f"a stroke moved the surface by {moved:.3f}, values changed by {changed:.3f} in {made.mode} mode", changed > 0.01, file)
    for live in (True, False):
        made.paradesc_live.mode = "LIVE" if live else "OFF"
        yield from masked(run, made, live)
    person.in_view(bpy.ops.object.mode_set, mode="OBJECT")


def masked(run: "Run", made: bpy.types.Object, live: bool) -> Iterator[None]:
    """The mask of sculpt mode over a shown bake: it is there, and it is seen as darker places."""
    person.in_view(bpy.ops.paint.mask_flood_fill, mode="VALUE", value=0)
    yield from person.press("paradesc.mask_from_shape")
    yield from person.drawn(10)
    yield from person.wait(idle)
    yield from person.drawn(10)
    file = yield from run.picture("sculpt_mask")
    found, masked_view = sculpt_masks.values(made.data), middle()
    share = float((found > 0.5).mean()) if found is not None else 0.0
    person.in_view(bpy.ops.paint.mask_flood_fill, mode="VALUE", value=0)
    yield from person.drawn(10)
    darker = (masked_view < DARKER * middle()).mean()
    text = f"Live {live}: {share:.1%} of the vertices are masked by more than half, {darker:.2%} of the middle of the viewport is darker by a fifth"
    run.saw("C2", text, share > 0.005 and darker > 0.002, file)


def middle() -> np.ndarray:
    """(height, width) brightness of the middle of the viewport."""
    seen = person.seen("WINDOW").max(axis=2).astype(float)
    height, width = seen.shape
    return seen[height // 4 : 3 * height // 4, width // 4 : 3 * width // 4]


def has_brush(run: "Run") -> Iterator[bool]:
    """Takes the brush Draw; without it, says so."""
    if bpy.app.version >= (4, 3, 0):
        try:
            person.in_view(bpy.ops.brush.asset_activate, asset_library_type="ESSENTIALS", relative_asset_identifier=BRUSH)
        except RuntimeError as error:
            run.saw("B3", f"this Blender was packed without its brushes: {error}")
            return False
        yield from person.drawn(3)
    return True


def bend(run: "Run") -> Iterator[None]:
    """Render Animation with a keyframed Simple Deform, without and with Live: the mesh bends in both."""
    made = monkey(1, applied=True)
    as_found()
    deform = made.modifiers.new("Bend", "SIMPLE_DEFORM")
    deform.deform_method = "BEND"
    scene = bpy.context.scene
    for frame, angle in ((1, 0.0), (4, 2.5)):
        deform.angle = angle
        deform.keyframe_insert("angle", frame=frame)
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    bpy.context.collection.objects.link(camera)
    camera.location, camera.rotation_euler = (0, -7, 0), (1.5708, 0, 0)
    scene.camera, scene.frame_start, scene.frame_end = camera, 1, 4
    scene.render.engine = "BLENDER_WORKBENCH"
    scene.render.resolution_x = scene.render.resolution_y = 200
    seen = {}
    for live in (False, True):
        made.paradesc_live.mode = "LIVE" if live else "OFF"
        yield from person.drawn(5)
        scene.render.filepath = str(run.folder / f"bend_{live}_")
        bpy.ops.render.render(animation=True)
        yield from person.drawn(2)
        seen[live] = [person.screen.pixels_of(str(run.folder / f"bend_{live}_{frame:04}.png")) for frame in (1, 4)]
    shape = [[np.abs(image - image[:1, :1].astype(int)).max(axis=2) > 8 for image in seen[live]] for live in (False, True)]
    off = float(np.mean(shape[0][1] != shape[1][1]))
    bends = float(np.mean(shape[1][0] != shape[1][1]))
    run.saw("A1", f"rendered animation: with Live the last frame differs from the first in {bends:.1%} of the pixels, from that without Live in {off:.1%}", off < 0.005 < bends)
    made.paradesc_live.mode = "OFF"
    undo_step()


def cache(run: "Run") -> Iterator[None]:
    """Bake Frames and Cache have the colors of a bake."""
    made = bpy.context.object
    scene = bpy.context.scene
    bpy.ops.wm.save_as_mainfile(filepath=str(run.folder / "cache.blend"))
    yield from clicked()
    before = shown_colors(made)
    person.in_view(bpy.ops.paradesc.bake_frames, "EXEC_DEFAULT")
    yield from person.drawn(5)
    made.paradesc_live.mode = "CACHE"
    scene.frame_set(2)
    scene.frame_set(1)
    yield from person.drawn(5)
    after = shown_colors(made)
    file = yield from run.picture("cache")
    grey = [float(np.ptp(colors[:, :3], axis=1).max()) if len(colors) else -1.0 for colors in (before, after)]
    run.saw("B14", f"how colored the mask is: baked {grey[0]:.3f}, from the cache {grey[1]:.3f}", 0 <= grey[1] < 0.01, file)
    made.paradesc_live.mode = "OFF"


def shown_colors(made: bpy.types.Object) -> np.ndarray:
    """(n, 4) the active colors."""
    active = made.data.color_attributes.active_color
    return np.zeros((0, 4)) if active is None else arrays.attribute_values(made.data.attributes[active.name])


def steps(run: "Run") -> Iterator[None]:
    """One after another."""
    yield from person.alone()
    yield from person.open_tab()
    for point, task in (("B1", fresh), ("B3", sculpt), ("A1", bend), ("B14", cache)):
        yield from run.tried(point, task(run))
