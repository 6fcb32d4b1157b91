"""The Source and Animation panel: which mesh is measured, and frames baked into a cache while the window lives."""

import bpy

from .. import bridge
from ..animation import frame_batch, handlers
from ..animation.cache_places import DEFAULT_CACHE, cache_root, object_cache, wanted_frames
from ..bake import operators
from ..bake.batch import with_name
from ..bridge import ParadescError
from ..core.source_kinds import SOURCES
from ..files import cache
from ..scene import targets
from ..settings.properties import path_options
from .panel import SidebarPanel

# In which the mesh is that of the object.
MODES = {"OBJECT", "VERTEX_PAINT", "WEIGHT_PAINT", "TEXTURE_PAINT"}


class PARADESC_PG_animation(bpy.types.PropertyGroup):
    """Which mesh, and which frames of it, in one scene."""

    source: bpy.props.EnumProperty(
        name="Source", description="Which mesh a single bake measures", items=list(SOURCES), default="original"
    )
    frame_source: bpy.props.EnumProperty(
        name="Frame Source",
        description="Which mesh is measured at each frame",
        items=list(SOURCES[1:]),
        default="deformed",
    )
    use_scene_range: bpy.props.BoolProperty(
        name="Scene Range", description="Bake the frames from the scene's start to its end", default=True
    )
    frame_start: bpy.props.IntProperty(name="Start", description="First frame to bake", default=1)
    frame_end: bpy.props.IntProperty(name="End", description="Last frame to bake", default=250)
    frame_step: bpy.props.IntProperty(name="Step", description="Bake every so many frames", default=1, min=1)
    cache_folder: bpy.props.StringProperty(
        name="Cache",
        description="Where frames are kept, in a folder for each object; // is the folder of the .blend",
        subtype="DIR_PATH",
        default=DEFAULT_CACHE,
        options=path_options(),
    )
    relative_to_rest: bpy.props.BoolProperty(
        name="Change Against Rest",
        description="Also the change against the original mesh, as values of their own (mean_curvature_change)",
        default=False,
    )
    overwrite: bpy.props.BoolProperty(
        name="Bake Again", description="Compute frames again that are in the cache already", default=False
    )


class PARADESC_OT_bake_frames(bpy.types.Operator):
    """Compute the chosen descriptors of the selected meshes at every frame into the cache; what is there is kept"""

    bl_idname = "paradesc.bake_frames"
    bl_label = "Bake Frames"
    bl_options = {"REGISTER"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Says why it cannot run where it cannot."""
        sentence = bridge.missing_sentence()
        objects = targets.chosen(context)
        if not sentence and not objects:
            sentence = "Select a mesh object first"
        modes = {item.mode for item in objects} - MODES
        if not sentence and modes:
            sentence = f"Leave {min(modes).replace('_', ' ').lower()} mode first"
        if sentence:
            cls.poll_message_set(sentence)
        return not sentence

    def execute(self, context: bpy.types.Context) -> set[str]:
        """All frames in a row: for scripts and background mode, where timers never fire."""
        if not self.begin(context, beside=False):
            return {"CANCELLED"}
        try:
            while not self.batch.done:
                self.batch.step()
        finally:
            self.batch.end()
        return self.finish()

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> set[str]:
        """Starts; modal() goes on."""
        if bpy.app.background:
            return self.execute(context)
        if not self.begin(context, beside=True):
            return {"CANCELLED"}
        manager = context.window_manager
        self.timer = manager.event_timer_add(0.02, window=context.window)
        manager.progress_begin(0.0, 1.0)
        manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def begin(self, context: bpy.types.Context, beside: bool) -> bool:
        """Takes the settings and the selection; reports what is wrong with them."""
        try:
            wanted, root = wanted_frames(context.scene), cache_root(context.scene)
            self.batch = frame_batch.FrameBatch(context, wanted, root, beside)
        except ParadescError as error:
            self.report({"ERROR"}, error.sentence)
            return False
        return True

    def modal(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """Cancels on Esc; when a frame is written, reads the next one."""
        if event.type == "ESC" and event.value == "PRESS":
            self.batch.cancel()
            return {"RUNNING_MODAL"}
        if event.type != "TIMER":
            return {"PASS_THROUGH"} if event.type in operators.VIEW_EVENTS else {"RUNNING_MODAL"}
        try:
            self.batch.step()
            if not self.batch.done:
                self.show_progress(context)
                return {"RUNNING_MODAL"}
        except BaseException:
            self.cancel(context)
            raise
        self.clean_up(context)
        return self.finish()

    def cancel(self, context: bpy.types.Context) -> None:
        """Blender ends the operator itself, for one because another file is loaded."""
        self.clean_up(context)

    def show_progress(self, context: bpy.types.Context) -> None:
        """In the cursor and in the status bar."""
        context.window_manager.progress_update(self.batch.fraction)
        context.workspace.status_text_set(f"Paradesc: {self.batch.stage} (Esc cancels)")

    def clean_up(self, context: bpy.types.Context) -> None:
        """Takes timer and progress away, and goes back to the frame before."""
        context.window_manager.event_timer_remove(self.timer)
        context.window_manager.progress_end()
        if context.workspace is not None:
            context.workspace.status_text_set(None)
        self.batch.end()

    def finish(self) -> set[str]:
        """Says what there is now."""
        batch = self.batch
        several = len(batch.pieces) > 1
        for piece in batch.pieces:
            for sentence in piece.notes:
                self.report({"INFO"}, f'"{piece.name}": {sentence}' if several else sentence)
        if batch.cancelled:
            self.report({"INFO"}, "Cancelled; the frames so far are in the cache")
            return {"CANCELLED"}
        sentences = [with_name(piece.name, piece.failure) if several else piece.failure for piece in batch.failed]
        if len(batch.failed) == len(batch.pieces):
            self.report({"ERROR"}, "\n".join(sentences))
            return {"CANCELLED"}
        for sentence in sentences:
            self.report({"WARNING"}, sentence)
        batch.hold_ranges()
        handlers.refresh_window(handlers.live_objects())
        self.report({"INFO"}, summary(batch))
        return {"FINISHED"}


def summary(batch: frame_batch.FrameBatch) -> str:
    """One line about all frames."""
    sound = [piece for piece in batch.pieces if not piece.failure]
    there = len(batch.wanted) * len(sound) - sum(piece.made for piece in sound)
    folder = sound[0].folder if len(batch.pieces) == 1 else sound[0].folder.parent
    objects = f" of {len(sound)} objects" if len(batch.pieces) > 1 else ""
    return f"{batch.made} frames{objects} baked, {there} were there already: {folder}"


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
        layout.row(heading="Change").prop(group, "relative_to_rest", text="Against Rest")
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
