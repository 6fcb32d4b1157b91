"""Live values in Blender's window, as a person uses them: edits, playback, undo, F12. run_in_window.sh starts it.

Timers fire here, and F12 renders on a thread of its own while the interface is locked.
"""

import os
import sys
import threading
import time
from collections.abc import Generator, Iterator
from pathlib import Path

import bpy
import numpy as np

words = sys.argv[sys.argv.index("--") + 1 :]
sys.path[:0] = [words[0], str(Path(words[0]).parents[1] / "addon")]
import animated  # noqa: E402
import deforming  # noqa: E402
from paradesc.files import cache  # noqa: E402
from paradesc_blender.animation import live, painting, pausing, sessions  # noqa: E402
from paradesc_blender.bake import modal  # noqa: E402
from paradesc_blender.scene import mesh_io, writing  # noqa: E402
from paradesc_blender.settings import animation as animation_settings  # noqa: E402
from scene import attribute_values  # noqa: E402
from window import PATIENCE, baking, begin, prepare, say, view_context, wait_for  # noqa: E402

NAME, SIZE, STEP = "mean_curvature", 32, 0.1
RENDERED_BY: list[str] = []


def target() -> bpy.types.Object:
    """The object, which undo replaces by another one in memory."""
    return bpy.data.objects["sphere"]


def radius_now() -> float:
    """The radius of the sphere that the values on the mesh are of."""
    return 1.0 / float(np.median(attribute_values(target().data, NAME)))


def follows(radius: float):
    """Makes a condition: the values are of a sphere of this radius."""
    return lambda: abs(radius_now() - radius) < 0.02 * radius


def frame_shown() -> int:
    """The frame that the values on the mesh are of."""
    frame = 1 + round((radius_now() - 2.0) / 0.2)
    assert follows(2.0 + 0.2 * (frame - 1))(), f"a radius of {radius_now()} is of no frame"
    return frame


def edit_steps() -> Iterator[None]:
    """Edits the shape in object mode and in edit mode, and undoes an edit."""
    bpy.ops.ed.undo_push(message="before the edit")  # Bake Frames has left a step at another frame
    key = target().data.shape_keys.key_blocks["Large"]
    key.value = 0.5
    yield from wait_for(follows(3.0))
    say("followed an edit")
    before = sessions.session_at(target()).results
    with bpy.context.temp_override(**view_context()):
        bpy.ops.object.mode_set(mode="EDIT")
        bpy.ops.mesh.select_all(action="SELECT")
        bpy.ops.transform.resize(value=(1.5, 1.5, 1.5))
    for _ in range(8):
        yield
    assert sessions.session_at(target()).results is before, "computed while the mesh was being edited"
    with bpy.context.temp_override(**view_context()):
        bpy.ops.object.mode_set(mode="OBJECT")
    yield from wait_for(lambda: not follows(3.0)())
    say("followed what edit mode left")
    with bpy.context.temp_override(**view_context()):
        bpy.ops.ed.undo_push(message="edited")
        bpy.ops.ed.undo()
    yield from wait_for(follows(2.0))
    assert target().paradesc_live.mode == "LIVE", target().paradesc_live.sentence
    say("undone")


def play_steps() -> Iterator[None]:
    """Plays and stops the animation."""
    scene = bpy.context.scene
    scene.frame_end = 11
    scene.frame_set(1)
    seen = set()
    with bpy.context.temp_override(**view_context()):
        bpy.ops.screen.animation_play()
    start = time.monotonic()
    while len(seen) < 5:
        assert time.monotonic() - start < PATIENCE, "nothing is played"
        expected = 2.0 + 0.2 * (scene.frame_current - 1)
        assert follows(expected)(), f"frame {scene.frame_current}: {radius_now()} instead of {expected}"
        seen.add(scene.frame_current)
        yield
    with bpy.context.temp_override(**view_context()):
        bpy.ops.screen.animation_cancel(restore_frame=False)
    say("every frame that was played had its own values")


def press_space() -> None:
    """Begins or ends playing by its key.

    Within an overridden context Blender 3.4 runs operators without Python's lock, but reads Python's objects all the
    same. It crashes if another thread runs Python meanwhile, as one does that computes.
    """
    window = bpy.context.window_manager.windows[0]
    for value in ("PRESS", "RELEASE"):
        window.event_simulate("SPACE", value, x=700, y=500)


def later_steps() -> Iterator[None]:
    """Plays without waiting: values follow, and those of the frame where it stops are right."""
    scene = bpy.context.scene
    scene.paradesc_live.wait = False
    scene.frame_set(1)
    read, played, shown = [], set(), set()
    read_object = mesh_io.read_object
    mesh_io.read_object = lambda *more: (read.append(1), read_object(*more))[1]
    press_space()

    def four_shown() -> bool:
        played.add(scene.frame_current)
        shown.add(frame_shown())
        return len(shown) >= 4

    yield from wait_for(four_shown)
    assert shown <= played | {1}, f"values of {sorted(shown)}, but frames {sorted(played)} were played"
    assert len(played) <= 8, f"{len(played)} frames were played for values of {len(shown)}"
    assert len(read) <= 1, f"the mesh was read {len(read)} times"  # Blender tells of an edit when playing begins
    press_space()
    yield from wait_for(lambda: not bpy.context.window_manager.windows[0].screen.is_animation_playing)
    yield from wait_for(lambda: follows(2.0 + 0.2 * (scene.frame_current - 1))() and sessions.STATE.edited_at is None)
    mesh_io.read_object = read_object
    scene.frame_set(4)
    assert follows(2.6)(), "a script has to find the values of its frame"
    scene.paradesc_live.wait = True
    say("without waiting, values followed")


def start_frames() -> None:
    """Presses Bake Frames; the panel shows how far it is."""
    with bpy.context.temp_override(**view_context()):
        assert bpy.ops.paradesc.bake_frames("INVOKE_DEFAULT") == {"RUNNING_MODAL"}
    assert baking()
    assert "frame 1 of 1 to 3" in modal.progress_text(modal.ModalJob.running)
    assert not bpy.ops.paradesc.bake.poll()


def cancel_frames(folder: Path) -> Iterator[None]:
    """Ends Bake Frames by Esc midway, which brings the frame back."""
    settings = bpy.context.scene.paradesc
    former, settings.samples = settings.samples, 4096
    start_frames()
    yield
    with bpy.context.temp_override(**view_context()):
        bpy.context.window_manager.windows[0].event_simulate("ESC", "PRESS", x=700, y=500)
    yield from wait_for(lambda: not baking())
    settings.samples = former
    assert len(cache.frames_in(folder)) < 3, "ended before it could be cancelled"
    assert bpy.context.scene.frame_current == 2
    assert not pausing.is_held()
    say("cancelled frames with Esc")


def bake_steps() -> Iterator[None]:
    """Bakes frames beside the window; live values wait, and are right afterwards."""
    scene, computed = bpy.context.scene, []
    group = scene.paradesc_animation
    group.cache_folder, group.use_scene_range = str(Path(bpy.app.tempdir) / "cache"), False
    group.frame_start, group.frame_end = 1, 3
    scene.frame_set(2)
    compute = live.Session.compute
    live.Session.compute = lambda *words: (computed.append(1), compute(*words))[1]
    folder = animation_settings.object_cache(scene, target())
    yield from cancel_frames(folder)
    start_frames()
    yield from wait_for(lambda: len(cache.frames_in(folder)) == 3 and not pausing.is_held())
    for _ in range(5):
        yield
    live.Session.compute = compute
    assert not computed, "live values did not wait"
    assert scene.frame_current == 2
    assert follows(2.2)()
    say("baked frames beside the window")


def prepare_render() -> None:
    """Adds a camera in front and a material that shows the values, and notes on which thread the handler runs."""
    scene = bpy.context.scene
    material = bpy.data.materials.new("shown")
    material.use_nodes = True
    nodes, links = material.node_tree.nodes, material.node_tree.links
    nodes.clear()
    attribute, emission, output = (nodes.new(f"ShaderNode{k}") for k in ("Attribute", "Emission", "OutputMaterial"))
    attribute.attribute_name = f"{NAME}_color"
    links.new(attribute.outputs["Color"], emission.inputs["Color"])
    links.new(emission.outputs["Emission"], output.inputs["Surface"])
    target().data.materials.append(material)
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    camera.data.type, camera.data.ortho_scale, camera.location = "ORTHO", 2.0, (0, 0, 20)
    scene.collection.objects.link(camera)
    scene.camera = camera
    scene.render.resolution_x = scene.render.resolution_y = SIZE
    scene.view_settings.view_transform = "Standard"
    scene.cycles.samples, scene.cycles.use_denoising, scene.eevee.taa_render_samples = 2, False, 2
    refresh = live.Session.refresh

    def watched(session, item, depsgraph, of_scene, *more):
        if depsgraph.mode == "RENDER":
            RENDERED_BY.append(threading.current_thread().name)
            assert bpy.data.scenes[of_scene.name].render.use_lock_interface
        return refresh(session, item, depsgraph, of_scene, *more)

    live.Session.refresh = watched


def render_steps(engine: str, frame: int, found: dict) -> Iterator[None]:
    """Presses F12 at a frame whose shape somebody has changed without a key; notes the color in the middle."""
    scene = bpy.context.scene
    path = Path(bpy.app.tempdir) / f"{engine}{frame}.png"
    scene.render.engine, scene.render.filepath = engine, str(path)
    scene.frame_set(frame)
    key = target().data.shape_keys.key_blocks["Large"]
    key.value = 0.25
    with bpy.context.temp_override(**view_context()):
        assert bpy.ops.render.render("INVOKE_DEFAULT", write_still=True) == {"RUNNING_MODAL"}
    yield from wait_for(lambda: path.is_file() and not sessions.STATE.rendering)
    for _ in range(5):
        yield
    assert key.value == 0.25, f"F12 has made {key.value} of a value without a key"
    found[engine, frame] = picture(path)[SIZE // 2, SIZE // 2, :3]


def picture(path: Path) -> np.ndarray:
    """(SIZE, SIZE, 4) pixels of an image file."""
    image = bpy.data.images.load(str(path))
    return np.array(image.pixels[:]).reshape(SIZE, SIZE, 4)


def animation_steps(engine: str) -> Iterator[None]:
    """Presses Ctrl F12, with live values and without: every frame has the same silhouette.

    The interface is locked without them, too, so that both are rendered in the same way.
    """
    scene, shown = bpy.context.scene, {}
    render, former = scene.render, (scene.frame_start, scene.frame_end, scene.frame_step)
    render.engine, render.film_transparent, render.image_settings.color_mode = engine, True, "RGBA"
    scene.frame_start, scene.frame_end, scene.frame_step = deforming.FIRST, deforming.LAST, 3
    scene.camera.data.ortho_scale = 12.0  # the whole sphere is seen
    for mode in ("OFF", "LIVE"):
        target().paradesc_live.mode = mode
        render.use_lock_interface = True
        render.filepath = str(Path(bpy.app.tempdir) / f"{engine}{mode}")
        paths = [Path(render.frame_path(frame=frame)) for frame in range(scene.frame_start, scene.frame_end + 1, 3)]
        with bpy.context.temp_override(**view_context()):
            assert bpy.ops.render.render("INVOKE_DEFAULT", animation=True) == {"RUNNING_MODAL"}
        yield from wait_for(lambda last=paths[-1]: last.is_file() and not sessions.STATE.rendering)
        for _ in range(5):
            yield
        shown[mode] = [picture(path)[..., 3] for path in paths]
        if mode == "OFF":
            render.use_lock_interface = False
    assert np.abs(shown["OFF"][0] - shown["OFF"][-1]).mean() > 0.02, "nothing moves"
    for frame, (still, live_one) in enumerate(zip(shown["OFF"], shown["LIVE"], strict=True)):
        assert np.abs(still - live_one).mean() < 1 / 255, f"{engine} shows another pose in picture {frame}"
    scene.frame_start, scene.frame_end, scene.frame_step = former


class Meeting:
    """A panel that is being drawn until a render's thread has come somewhere, which waits there until it is drawn."""

    def __init__(self) -> None:
        self.called, self.drawing, self.arrived = (threading.Event() for _ in range(3))

    def arrive(self) -> None:
        """Waits for the panel."""
        self.called.set()
        self.drawing.wait(PATIENCE)


class PROPERTIES_PT_meeting(bpy.types.Panel):
    """Is drawn until somebody has come"""

    bl_label, bl_space_type, bl_region_type, bl_context = "Meeting", "PROPERTIES", "WINDOW", "object"
    meeting: Meeting | None = None

    def draw(self, _context: bpy.types.Context) -> None:
        """Waits for the render's thread, which may not write meanwhile."""
        meeting = self.meeting
        if meeting is not None and meeting.called.is_set() and not meeting.drawing.is_set():
            meeting.drawing.set()
            meeting.arrived.wait(PATIENCE)


class MeetingEngine(bpy.types.RenderEngine):
    """Begins while the panel is drawn, and ends later"""

    bl_idname, bl_label = "PARADESC_MEETING", "Meeting"

    def render(self, _depsgraph: bpy.types.Depsgraph) -> None:
        """Renders nothing."""
        meeting = PROPERTIES_PT_meeting.meeting
        if meeting is not None:
            meeting.arrived.set()
            time.sleep(0.2)


def met_steps(owner: type, name: str, before: bool, frame: int) -> Iterator[None]:
    """Renders a frame whose thread meets the panel before a method writes, or after it."""
    scene, meeting = bpy.context.scene, Meeting()
    PROPERTIES_PT_meeting.meeting, method = meeting, getattr(owner, name)

    def met(*words: object) -> object:
        first = threading.current_thread() is not threading.main_thread() and not meeting.called.is_set()
        if first and before:
            meeting.arrive()
            threading.Timer(0.1, meeting.arrived.set).start()
        result = method(*words)
        if first and not before:
            meeting.arrive()
        return result

    setattr(owner, name, met)
    scene.frame_start = scene.frame_end = frame
    scene.frame_set(1)
    with bpy.context.temp_override(**view_context()):
        assert bpy.ops.render.render("INVOKE_DEFAULT", animation=True) == {"RUNNING_MODAL"}

    def done() -> bool:
        for area in bpy.context.window_manager.windows[0].screen.areas:
            area.tag_redraw()
        return meeting.arrived.is_set() and not sessions.STATE.rendering

    yield from wait_for(done)
    for _ in range(5):
        yield
    setattr(owner, name, method)
    PROPERTIES_PT_meeting.meeting = None
    assert target().paradesc_live.mode == "LIVE", target().paradesc_live.sentence


def timers_may_write() -> Generator[None, None, bool]:
    """Asks a timer, since these steps are taken where they may write."""
    found: list[bool] = []
    bpy.app.timers.register(lambda: found.append(writing.is_allowed()))
    yield from wait_for(lambda: found)
    return found[0]


def drawn_steps() -> Iterator[None]:
    """Renders while a panel is drawn, which takes from handlers, and then from all timers, that they may write."""
    scene = bpy.context.scene
    for cls in (PROPERTIES_PT_meeting, MeetingEngine):
        bpy.utils.register_class(cls)
    former = scene.render.engine, scene.frame_start, scene.frame_end
    scene.render.engine = MeetingEngine.bl_idname
    yield from met_steps(painting.Painter, "paint", before=True, frame=6)
    say("wrote although a panel was drawn")
    yield from met_steps(live.Session, "refresh", before=False, frame=11)
    scene.render.engine, scene.frame_start, scene.frame_end = former
    may_write = yield from timers_may_write()
    assert may_write == (bpy.app.version >= (5, 0, 0))
    say("goes on where timers may " + ("write" if may_write else "not write"))


def mend_steps() -> Iterator[None]:
    """Gives timers back that they may write: an engine that begins while one may brings that back when it ends."""
    scene = bpy.context.scene
    scene.render.engine = MeetingEngine.bl_idname
    meeting = PROPERTIES_PT_meeting.meeting = Meeting()
    with bpy.context.temp_override(**view_context()):
        assert bpy.ops.render.render("INVOKE_DEFAULT") == {"RUNNING_MODAL"}
    assert meeting.arrived.wait(PATIENCE)
    yield from wait_for(lambda: not sessions.STATE.rendering)
    for _ in range(5):
        yield
    assert (yield from timers_may_write())


def steps() -> Iterator[None]:
    """Does what the person does; every yield is a turn of the event loop."""
    scene = bpy.context.scene
    settings = scene.paradesc
    settings.radius_percent, settings.samples, settings.buffer_size, settings.backend = 10.0, 64, 256, "cpu"
    scene.render.use_lock_interface = False
    yield
    target().paradesc_live.mode = "LIVE"
    assert scene.render.use_lock_interface
    assert follows(2.0)(), radius_now()
    bpy.ops.ed.undo_push(message="live")
    yield from play_steps()
    yield from later_steps()
    settings.backend = "software"  # whose frames take long enough to be cancelled
    for _ in range(20):  # live values follow
        yield
    yield from bake_steps()
    scene.frame_set(1)
    prepare_render()
    found: dict[tuple[str, int], np.ndarray] = {}
    # Engines that draw use OpenGL beside the window, where Mesa 22's llvmpipe crashes in about one run of a hundred.
    long = bool(os.environ.get("PARADESC_LONG_TESTS"))
    engines = ("CYCLES", "BLENDER_EEVEE") if long else ("CYCLES",)
    for engine in engines:
        for frame in (1, 11):
            yield from render_steps(engine, frame, found)
        assert np.abs(found[engine, 1] - found[engine, 11]).max() > 0.1, found
        np.testing.assert_allclose(found["CYCLES", 1], found[engine, 1], atol=0.02)
        np.testing.assert_allclose(found["CYCLES", 11], found[engine, 11], atol=0.02)
    assert len(RENDERED_BY) >= 2 * len(engines), RENDERED_BY
    assert target().paradesc_live.mode == "LIVE", target().paradesc_live.sentence
    say(f"rendered each frame's values: {', '.join(engines)}")
    deforming.displace(target())
    engines = ("CYCLES", "BLENDER_WORKBENCH") if long else ("CYCLES",)
    for engine in engines:
        yield from animation_steps(engine)
    target().modifiers.clear()
    target().animation_data_clear()
    say(f"rendered each frame's pose: {', '.join(engines)}")
    yield from drawn_steps()
    scene.frame_set(1)
    target().data.shape_keys.animation_data_clear()
    yield from edit_steps()
    yield from mend_steps()
    target().paradesc_live.mode = "OFF"
    assert not bpy.context.scene.render.use_lock_interface
    say("all steps passed")


def main() -> None:
    """Prepares the scene and lets the event loop do the rest."""
    prepare()
    animated.empty_scene = lambda: None  # the window stays
    animated.swelling_sphere()
    begin(steps(), STEP)


main()
