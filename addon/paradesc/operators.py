"""The bake operator: reads the active mesh, computes on a worker thread, writes attributes and colors back."""

import bpy

from . import bridge, job, mesh_io, properties, sources, surface_maps
from .bridge import ParadescError, abi

MODES = {"OBJECT", "EDIT", "VERTEX_PAINT", "WEIGHT_PAINT", "TEXTURE_PAINT"}
# Seconds between two looks at the worker.
TIMER_STEP = 0.1
# Events that move the view; everything else waits until the bake has ended.
VIEW_EVENTS = {"MIDDLEMOUSE", "WHEELUPMOUSE", "WHEELDOWNMOUSE", "TRACKPADPAN", "TRACKPADZOOM", "MOUSEROTATE"}


def obstacle(context: bpy.types.Context) -> str:
    """Why nothing can be baked right now, as one sentence, or ""."""
    missing = bridge.missing_sentence()
    if missing:
        return missing
    target = context.active_object
    if target is None or target.type != "MESH":
        return "Select a mesh object first"
    if target.mode not in MODES:
        return "Leave sculpt mode first"
    return ""


class PARADESC_OT_bake(bpy.types.Operator):
    """Compute the chosen descriptors at every vertex of the active mesh, as attributes and colors"""

    bl_idname = "paradesc.bake"
    bl_label = "Bake Descriptors"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Says why it cannot run where it cannot."""
        sentence = obstacle(context)
        if sentence:
            cls.poll_message_set(sentence)
        return not sentence

    def execute(self, context: bpy.types.Context) -> set[str]:
        """The same steps in a row: for scripts and background mode, where timers never fire."""
        try:
            settings, arrays = self.prepare(context)
            results = job.run(arrays, settings)
            self.finish(context.active_object, results)
        except ParadescError as error:
            self.report({"ERROR"}, error.sentence)
            return {"CANCELLED"}
        return {"FINISHED"}

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> set[str]:
        """Starts the worker; modal() waits for it."""
        if bpy.app.background:
            return self.execute(context)
        try:
            settings, arrays = self.prepare(context)
        except ParadescError as error:
            self.report({"ERROR"}, error.sentence)
            return {"CANCELLED"}
        self.target_name = context.active_object.name
        self.worker = job.Worker(arrays, settings)
        self.worker.start()
        manager = context.window_manager
        self.timer = manager.event_timer_add(TIMER_STEP, window=context.window)
        manager.progress_begin(0.0, 1.0)
        manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """Shows progress, cancels on Esc, and writes the results when they are there."""
        if event.type == "ESC" and event.value == "PRESS":
            self.worker.cancel()
            return {"RUNNING_MODAL"}
        if event.type != "TIMER":
            return {"PASS_THROUGH"} if event.type in VIEW_EVENTS else {"RUNNING_MODAL"}
        if not self.worker.done:
            context.window_manager.progress_update(self.worker.fraction)
            text = f"Paradesc: {self.worker.stage}, {self.worker.fraction:.0%} (Esc cancels)"
            context.workspace.status_text_set(text)
            return {"RUNNING_MODAL"}
        self.clean_up(context)
        return self.take_results()

    def cancel(self, context: bpy.types.Context) -> None:
        """Blender ends the operator itself, for one because another file is loaded."""
        self.worker.cancel()
        self.clean_up(context)

    def prepare(self, context: bpy.types.Context) -> tuple[job.Settings, bridge.MeshArrays]:
        """The settings, and the active mesh as arrays."""
        target = context.active_object
        mesh_io.check_writable(target)
        settings = properties.job_settings(context.scene.paradesc)
        needs_uvs = settings.backend != "reference"
        source = context.scene.paradesc_animation.source
        self.reading = sources.read(target, source, settings.options.normals == "mesh", needs_uvs)
        arrays = self.reading.arrays
        surface_maps.add_maps(target, arrays, surface_maps.Sources(material=context.scene.paradesc.material_maps))
        sources.check_maps(self.reading)
        return settings, arrays

    def take_results(self) -> set[str]:
        """Writes what the worker computed, or reports why there is nothing."""
        try:
            results = self.worker.results()
            target = bpy.data.objects.get(self.target_name)
            if target is None or target.type != "MESH":
                sentence = f'The object "{self.target_name}" is gone; nothing was written.'
                raise ParadescError(abi.STATUS_INVALID_OPERATION, sentence)
            self.finish(target, results)
        except ParadescError as error:
            cancelled = error.status == abi.STATUS_CANCELLED
            self.report({"INFO" if cancelled else "ERROR"}, "Cancelled" if cancelled else error.sentence)
            return {"CANCELLED"}
        return {"FINISHED"}

    def finish(self, target: bpy.types.Object, results: job.Results) -> None:
        """Writes the results to the mesh and says what was found."""
        sentences = [*self.reading.notes, *sources.deliver(target, results, self.reading)]
        for sentence in [*sentences, *results.warnings]:
            self.report({"WARNING"}, sentence)
        seconds = results.field_report["seconds_total"]
        self.report({"INFO"}, f"{', '.join(results.values)}: {seconds:.2f} s on {results.device}")

    def clean_up(self, context: bpy.types.Context) -> None:
        """Takes the timer and the progress away."""
        context.window_manager.event_timer_remove(self.timer)
        context.window_manager.progress_end()
        if context.workspace is not None:
            context.workspace.status_text_set(None)


classes = (PARADESC_OT_bake,)
