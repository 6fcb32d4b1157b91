"""The bake operator: the selected meshes, one after another beside a living window, in one step to undo."""

import bpy

from ..bridge import ParadescError, abi
from ..core import devices
from ..scene import mesh_io, targets
from ..scene.targets import obstacle
from .batch import Batch, with_name

# Seconds between two looks at the worker.
TIMER_STEP = 0.1
BRUSH_MODES = {"SCULPT", "VERTEX_PAINT", "WEIGHT_PAINT", "TEXTURE_PAINT"}
# Events that move the view; everything else waits until the bake has ended.
VIEW_EVENTS = {"MIDDLEMOUSE", "WHEELUPMOUSE", "WHEELDOWNMOUSE", "TRACKPADPAN", "TRACKPADZOOM", "MOUSEROTATE"}


class PARADESC_OT_bake(bpy.types.Operator):
    """Compute the chosen descriptors at every vertex of the selected meshes, as attributes and colors"""

    bl_idname = "paradesc.bake"
    bl_label = "Bake Descriptors"
    bl_options = {"REGISTER", "UNDO"}

    # What is under way in the window, for the panel; a bake is modal, so there is one at most.
    running: Batch | None = None

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Says why it cannot run where it cannot."""
        sentence = "A bake is running; Esc cancels it" if PARADESC_OT_bake.running else obstacle(context)
        if sentence:
            cls.poll_message_set(sentence)
        return not sentence

    def execute(self, context: bpy.types.Context) -> set[str]:
        """The same steps in a row: for scripts and background mode, where timers never fire."""
        if not self.begin(context):
            return {"CANCELLED"}
        try:
            while not self.batch.done:
                self.batch.step(wait=True)
            return self.end(context)
        except BaseException:  # Ctrl-C, for one
            self.batch.abandon()
            raise

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> set[str]:
        """Starts; modal() goes on."""
        if bpy.app.background:
            return self.execute(context)
        if not self.begin(context):
            return {"CANCELLED"}
        PARADESC_OT_bake.running = self.batch
        manager = context.window_manager
        self.timer = manager.event_timer_add(TIMER_STEP, window=context.window)
        manager.progress_begin(0.0, 1.0)
        manager.modal_handler_add(self)
        self.show_progress(context)
        return {"RUNNING_MODAL"}

    def begin(self, context: bpy.types.Context) -> bool:
        """Takes the settings and the selection; reports what is wrong with them."""
        try:
            self.batch = Batch(context)
        except ParadescError as error:
            self.report({"ERROR"}, error.sentence)
            return False
        return True

    def modal(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """Shows progress, cancels on Esc, and writes the results when all are there."""
        if event.type == "ESC" and event.value == "PRESS":
            self.batch.cancel()
            return {"RUNNING_MODAL"}
        if event.type != "TIMER":
            return {"PASS_THROUGH"} if event.type in VIEW_EVENTS else {"RUNNING_MODAL"}
        try:
            self.batch.step()
            if self.batch.worker is None:  # the next mesh need not wait for the next turn
                self.batch.step()
            if not self.batch.done:
                self.show_progress(context)
                return {"RUNNING_MODAL"}
            self.clean_up(context)
            return self.end(context)
        except BaseException:
            self.cancel(context)
            raise

    def cancel(self, context: bpy.types.Context) -> None:
        """Blender ends the operator itself, for one because another file is loaded."""
        self.batch.abandon()
        self.clean_up(context)

    def show_progress(self, context: bpy.types.Context) -> None:
        """In the cursor, the status bar and the panel."""
        context.window_manager.progress_update(self.batch.fraction)
        if context.workspace is not None:
            context.workspace.status_text_set(f"Paradesc: {progress_text(self.batch)} (Esc cancels)")
        redraw_sidebars(context)

    def end(self, context: bpy.types.Context) -> set[str]:
        """Writes all results and says what was found; after Esc nothing, of no mesh."""
        batch = self.batch
        if batch.cancelled:
            batch.abandon()
            self.report({"INFO"}, "Cancelled; every mesh is as it was")
            return {"CANCELLED"}
        keep_for_undo(context)
        batch.finish(context)
        several = len(batch.pieces) > 1
        for piece in batch.written:
            for sentence in dict.fromkeys([*piece.results.warnings, *piece.notes]):
                self.report({"WARNING"}, f'"{piece.name}": {sentence}' if several else sentence)
        if not batch.written:
            self.report({"ERROR"}, "\n".join(failures(batch)) if several else batch.failed[0].failure)
            return {"CANCELLED"}
        for sentence in failures(batch):
            self.report({"WARNING"}, sentence)
        for path in [path for piece in batch.written for path in piece.placed]:
            self.report({"INFO"}, f"Wrote {path}")
        self.report({"WARNING" if batch.failed else "INFO"}, summary(batch))
        return {"FINISHED"}

    def clean_up(self, context: bpy.types.Context) -> None:
        """Takes the timer and the progress away."""
        if PARADESC_OT_bake.running is None:
            return
        PARADESC_OT_bake.running = None
        context.window_manager.event_timer_remove(self.timer)
        context.window_manager.progress_end()
        if context.workspace is not None:
            context.workspace.status_text_set(None)
        redraw_sidebars(context)


def keep_for_undo(context: bpy.types.Context) -> None:
    """In brush modes, a step of undo to come back to: their own steps hold strokes, not the attributes of a mesh."""
    active = context.active_object
    if active is not None and active.mode in BRUSH_MODES and not bpy.app.background:
        bpy.ops.ed.undo_push(message="Before Bake Descriptors")


def progress_text(batch: Batch) -> str:
    """How far a bake is, for people."""
    return f"{batch.stage}, {batch.fraction:.0%}"


def redraw_sidebars(context: bpy.types.Context) -> None:
    """Lets the panel show how far the bake is."""
    for window in context.window_manager.windows:
        for area in window.screen.areas:
            if area.type == "VIEW_3D":
                for region in area.regions:
                    if region.type == "UI":
                        region.tag_redraw()


def failures(batch: Batch) -> list[str]:
    """One sentence for each mesh that failed."""
    return [with_name(piece.name, piece.failure) for piece in batch.failed]


def summary(batch: Batch) -> str:
    """What a bake did, in one line."""
    written = batch.written
    seconds = sum(piece.results.field_report["seconds_total"] for piece in written)
    names = ", ".join(written[0].results.values)
    undefined = sum(piece.results.field_report["undefined_vertices"] for piece in written)
    end = f", {undefined:,} undefined vertices" if undefined else ""
    line = f"{names}: {seconds:.2f} s on {written[0].results.device}{end}"
    if len(batch.pieces) == 1:
        return line
    count = f"{len(written)} meshes" if not batch.failed else f"{len(written)} of {len(batch.pieces)} meshes"
    lost = ", ".join(f'"{piece.name}"' for piece in batch.failed)
    return f"{count}, {line}" + (f"; without {lost}" if lost else "")


class PARADESC_OT_make_local(bpy.types.Operator):
    """Make the meshes of the selected objects local to this file, so that they keep what is baked into them"""

    bl_idname = "paradesc.make_local"
    bl_label = "Make Meshes Local"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Only where one is not."""
        found = any(targets.unwritable(target) for target in targets.chosen(context))
        if not found:
            cls.poll_message_set("Every chosen mesh is local already")
        return found

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Object and mesh, where they are linked or overrides; whatever else they use stays linked."""
        names = []
        copies: dict[bpy.types.Mesh, bpy.types.Mesh] = {}
        try:
            for target in [item for item in targets.chosen(context) if targets.unwritable(item)]:
                names.append(make_local(target, copies).name)
        except ParadescError as error:
            self.report({"ERROR"}, error.sentence)
            return {"FINISHED" if names else "CANCELLED"}
        self.report({"INFO"}, f"Local now: {', '.join(names)}")
        return {"FINISHED"}


def make_local(target: bpy.types.Object, copies: dict[bpy.types.Mesh, bpy.types.Mesh]) -> bpy.types.Object:
    """The object, local, with a local mesh; copies holds the meshes that have been made so far."""
    if target.library is not None:
        if any(item.override_library and item.override_library.reference == target for item in bpy.data.objects):
            sentence = f'Overrides follow the linked object "{target.name}"; make those local, or remove them first.'
            raise ParadescError(abi.STATUS_INVALID_ARGUMENT, sentence)
        target = target.make_local()
    if target.data.override_library is not None:
        target.data.override_library.destroy()  # a copy would be an override again; this leaves what it was of
    mesh = target.data
    if mesh.library is not None:
        copies[mesh] = copies.get(mesh) or mesh.copy()
        target.data = copies[mesh]
    mesh_io.check_writable(target)
    return target


class PARADESC_OT_choose_device(bpy.types.Operator):
    """Compute on this device"""

    bl_idname = "paradesc.choose_device"
    bl_label = "Choose Device"
    bl_options = {"INTERNAL", "UNDO"}

    backend: bpy.props.StringProperty(
        name="Backend", description="One of auto, gpu, software and reference", default="auto"
    )
    index: bpy.props.IntProperty(name="Device", description="Number among the backend's devices, or -1", default=-1)

    @classmethod
    def description(cls, _context: bpy.types.Context, asked: bpy.types.OperatorProperties) -> str:
        """What the device is, or why it is not there."""
        return devices.about(asked.backend)

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Sets both members."""
        group = context.scene.paradesc
        group.backend, group.device_index = self.backend, self.index
        return {"FINISHED"}


classes = (PARADESC_OT_bake, PARADESC_OT_make_local, PARADESC_OT_choose_device)
