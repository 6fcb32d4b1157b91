"""The Source and Animation panel: which mesh is measured, and frames baked into a cache while the window lives."""

import threading
from functools import partial
from pathlib import Path

import bpy

from . import bridge, cache, frames, operators, properties, surface_maps, threads
from .bridge import ParadescError, abi
from .mesh_io import refuse
from .panel import SidebarPanel

SOURCES = [
    ("original", "Original", "The object's own mesh, before shape keys and modifiers"),
    ("deformed", "Deformed", "The same mesh as armature, shape keys, lattice, cloth and their like move it"),
    ("evaluated", "Evaluated", "What all modifiers make; results go to the original vertices where these remain"),
]
DEFAULT_CACHE = "//paradesc_cache"
# In which the mesh is that of the object.
MODES = {"OBJECT", "VERTEX_PAINT", "WEIGHT_PAINT", "TEXTURE_PAINT"}


class PARADESC_PG_animation(bpy.types.PropertyGroup):
    """Which mesh, and which frames of it, in one scene."""

    source: bpy.props.EnumProperty(
        name="Source", description="Which mesh a single bake measures", items=SOURCES, default="original"
    )
    frame_source: bpy.props.EnumProperty(
        name="Frames of", description="Which mesh is measured at each frame", items=SOURCES[1:], default="deformed"
    )
    use_scene_range: bpy.props.BoolProperty(
        name="Scene range", description="Bake the frames from the scene's start to its end", default=True
    )
    frame_start: bpy.props.IntProperty(name="Start", description="First frame to bake", default=1)
    frame_end: bpy.props.IntProperty(name="End", description="Last frame to bake", default=250)
    frame_step: bpy.props.IntProperty(name="Step", description="Bake every so many frames", default=1, min=1)
    cache_folder: bpy.props.StringProperty(
        name="Cache",
        description="Where frames are kept, in a folder for each object; // is the folder of the .blend",
        subtype="DIR_PATH",
        default=DEFAULT_CACHE,
    )
    relative_to_rest: bpy.props.BoolProperty(
        name="Change against rest",
        description="Also the change against the original mesh, as values of their own (mean_curvature_change)",
        default=False,
    )
    overwrite: bpy.props.BoolProperty(
        name="Bake again", description="Compute frames again that are in the cache already", default=False
    )


def wanted_frames(scene: bpy.types.Scene) -> range:
    """The frames that the settings name."""
    group = scene.paradesc_animation
    first, last = scene.frame_start, scene.frame_end
    if not group.use_scene_range:
        first, last = group.frame_start, group.frame_end
    try:
        return cache.frame_range(first, last, group.frame_step)
    except ValueError as error:
        raise refuse(str(error)) from error


def cache_root(scene: bpy.types.Scene) -> Path:
    """The folder of all objects' frames."""
    folder = scene.paradesc_animation.cache_folder or DEFAULT_CACHE
    if folder.startswith("//") and not bpy.data.filepath:
        raise refuse("Save the .blend first, or choose a cache folder that does not begin with //.")
    return Path(bpy.path.abspath(folder))


def object_cache(scene: bpy.types.Scene, target: bpy.types.Object) -> Path:
    """The folder of one object's frames."""
    return cache.object_folder(cache_root(scene), target.name)


class FrameWorker:
    """Computes and writes one frame after another on threads of their own; ask it from the main thread."""

    def __init__(self, baker: frames.FrameBaker) -> None:
        self.baker = baker
        self.stage = "start"
        self.fraction = 0.0
        self._cancelled = threading.Event()
        self._error: Exception | None = None
        self._thread: threading.Thread | None = None

    def start(self, task: frames.Task) -> None:
        """Starts with a frame; the one before has to be done."""
        self._thread = threads.start("paradesc frames", partial(self._run, task), self.cancel)

    @property
    def idle(self) -> bool:
        """True where the next frame can be started."""
        return self._thread is None or not self._thread.is_alive()

    def cancel(self) -> None:
        """Asks the native call to stop at its next tile."""
        self._cancelled.set()

    @property
    def cancelled(self) -> bool:
        """Whether it was."""
        return self._cancelled.is_set()

    def wait(self) -> None:
        """Waits for the frame under way, and raises what went wrong with it."""
        if self._thread is not None:
            self._thread.join()
            self._thread = None
        if self._cancelled.is_set():
            raise ParadescError(abi.STATUS_CANCELLED, "Cancelled.")
        if self._error is not None:
            raise self._error

    def _run(self, task: frames.Task) -> None:
        try:
            self.baker.run(task, self._progress)
        except Exception as error:  # noqa: BLE001 (raised again on the main thread by wait())
            self._error = error

    def _progress(self, stage: str, fraction: float) -> bool:
        self.stage, self.fraction = stage, fraction
        return not self._cancelled.is_set()


class PARADESC_OT_bake_frames(bpy.types.Operator):
    """Compute the chosen descriptors at every frame into the cache; frames that are there already are kept"""

    bl_idname = "paradesc.bake_frames"
    bl_label = "Bake Frames"
    bl_options = {"REGISTER"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Says why it cannot run where it cannot."""
        sentence = bridge.missing_sentence()
        target = context.active_object
        if not sentence and (target is None or target.type != "MESH"):
            sentence = "Make a mesh the active object first"
        if not sentence and target.mode not in MODES:
            sentence = f"Leave {target.mode.replace('_', ' ').lower()} mode first"
        if sentence:
            cls.poll_message_set(sentence)
        return not sentence

    def execute(self, context: bpy.types.Context) -> set[str]:
        """All frames in a row: for scripts and background mode, where timers never fire."""
        try:
            self.begin(context)
        except ParadescError as error:
            return self.fail(error)
        try:
            with frames.frame_kept(context.scene), self.baker.evaluating():
                for frame in self.wanted:
                    self.bake(frame)
        except ParadescError as error:
            return self.fail(error)
        finally:
            self.baker.close()
        return self.succeed()

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> set[str]:
        """Starts with the first frame; modal() goes on."""
        if bpy.app.background:
            return self.execute(context)
        try:
            self.begin(context)
        except ParadescError as error:
            return self.fail(error)
        scene = context.scene
        self.scene_name, self.former = scene.name, (scene.frame_current, scene.frame_subframe)
        self.worker = FrameWorker(self.baker)
        manager = context.window_manager
        self.timer = manager.event_timer_add(0.02, window=context.window)
        manager.progress_begin(0.0, 1.0)
        manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """Cancels on Esc; when a frame is written, reads the next one."""
        if event.type == "ESC" and event.value == "PRESS":
            self.worker.cancel()
            return {"RUNNING_MODAL"}
        if event.type != "TIMER":
            return {"PASS_THROUGH"} if event.type in operators.VIEW_EVENTS else {"RUNNING_MODAL"}
        self.show_progress(context)
        if not self.worker.idle:
            return {"RUNNING_MODAL"}
        try:
            self.worker.wait()
            if self.next < len(self.wanted):
                self.go_on()
                return {"RUNNING_MODAL"}
        except (ParadescError, ReferenceError) as error:
            self.clean_up(context)
            gone = isinstance(error, ReferenceError)
            return self.fail(refuse("The object is gone; the frames so far are in the cache.") if gone else error)
        except BaseException:
            self.clean_up(context)
            raise
        self.clean_up(context)
        return self.succeed()

    def cancel(self, context: bpy.types.Context) -> None:
        """Blender ends the operator itself, for one because another file is loaded."""
        self.worker.cancel()
        self.clean_up(context)

    def begin(self, context: bpy.types.Context) -> None:
        """Reads the settings and the object."""
        scene, target = context.scene, context.active_object
        group = scene.paradesc_animation
        self.wanted = wanted_frames(scene)
        self.next = self.made = 0
        maps = surface_maps.Sources(material=scene.paradesc.material_maps)
        settings = properties.job_settings(scene.paradesc)
        folder = object_cache(scene, target)
        request = frames.Request(
            settings, folder, group.frame_source, group.relative_to_rest, group.overwrite, maps if maps.any else None
        )
        self.baker = frames.FrameBaker(scene, target, request)

    def bake(self, frame: int) -> None:
        """One frame, on this thread."""
        task = self.baker.prepare(frame)
        if task is not None:
            self.baker.run(task)
            self.made += 1

    def go_on(self) -> None:
        """Reads the next frame and gives it to the worker, unless it is there already."""
        task = self.baker.prepare(self.wanted[self.next])
        self.next += 1
        if task is not None:
            self.worker.start(task)
            self.made += 1

    def show_progress(self, context: bpy.types.Context) -> None:
        """In the cursor and in the status bar."""
        done = max(0, self.next - 1) + (0.0 if self.worker.idle else self.worker.fraction)
        context.window_manager.progress_update(done / len(self.wanted))
        frame = self.wanted[max(0, self.next - 1)]
        text = f"Paradesc: frame {frame} of {self.wanted[0]} to {self.wanted[-1]}, {self.worker.stage} (Esc cancels)"
        context.workspace.status_text_set(text)

    def clean_up(self, context: bpy.types.Context) -> None:
        """Takes timer and progress away, and goes back to the frame before."""
        context.window_manager.event_timer_remove(self.timer)
        context.window_manager.progress_end()
        if context.workspace is not None:
            context.workspace.status_text_set(None)
        self.worker.cancel()
        try:
            self.worker.wait()
        except ParadescError:
            self.baker.close()
        scene = bpy.data.scenes.get(self.scene_name)
        if scene is not None:
            frame, part = self.former
            scene.frame_set(frame, subframe=part)

    def succeed(self) -> set[str]:
        """Says what there is now."""
        self.baker.close()
        for sentence in self.baker.notes:
            self.report({"INFO"}, sentence)
        there = len(self.wanted) - self.made
        self.report({"INFO"}, f"{self.made} frames baked, {there} were there already: {self.baker.request.folder}")
        return {"FINISHED"}

    def fail(self, error: ParadescError) -> set[str]:
        """Says why there is no more."""
        cancelled = error.status == abi.STATUS_CANCELLED
        text = "Cancelled; the frames so far are in the cache" if cancelled else error.sentence
        self.report({"INFO" if cancelled else "ERROR"}, text)
        return {"CANCELLED"}


class PARADESC_PT_animation(SidebarPanel, bpy.types.Panel):
    """Which mesh is measured, and frames of an animation"""

    bl_label = "Source and Animation"
    bl_idname = "PARADESC_PT_animation"
    bl_order = 50
    bl_parent_id = "PARADESC_PT_bake"

    def draw(self, context: bpy.types.Context) -> None:
        """Source, frames, cache, button."""
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        scene, group = context.scene, context.scene.paradesc_animation
        layout.prop(group, "source")
        layout.separator()
        layout.prop(group, "frame_source")
        layout.prop(group, "use_scene_range")
        column = layout.column(align=True)
        if not group.use_scene_range:
            column.prop(group, "frame_start")
            column.prop(group, "frame_end")
        column.prop(group, "frame_step")
        layout.prop(group, "relative_to_rest")
        layout.prop(group, "cache_folder")
        layout.prop(group, "overwrite")
        layout.operator("paradesc.bake_frames", icon="RENDER_ANIMATION")
        for line in cache_lines(scene, context.active_object):
            layout.label(text=line)


def cache_lines(scene: bpy.types.Scene, target: bpy.types.Object | None) -> list[str]:
    """How many frames the cache has of an object; by their names alone, as panels are drawn often."""
    if target is None or target.type != "MESH":
        return []
    try:
        found = cache.frames_in(object_cache(scene, target))
    except ParadescError:
        return []
    return (
        [f"{len(found):,} frames in the cache: {min(found)} to {max(found)}"] if found else ["No frames in the cache"]
    )


def register() -> None:
    """Gives every scene its source and frames."""
    bpy.types.Scene.paradesc_animation = bpy.props.PointerProperty(type=PARADESC_PG_animation)


def unregister() -> None:
    """Takes them away."""
    del bpy.types.Scene.paradesc_animation


classes = (PARADESC_PG_animation, PARADESC_OT_bake_frames, PARADESC_PT_animation)
