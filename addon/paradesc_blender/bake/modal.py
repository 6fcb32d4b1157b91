"""Runs work without blocking the window, with progress in the panel and Esc; scripts run the same steps in a row."""

import time
from collections.abc import Iterator

import bpy

from paradesc.bridge import ParadescError

from ..settings import translation
from ..settings.snapshot import Snapshot
from .pieces import Pieces, failures, report_all

# Events that move the view; everything else waits until the work has ended.
VIEW_EVENTS = {"MIDDLEMOUSE", "WHEELUPMOUSE", "WHEELDOWNMOUSE", "TRACKPADPAN", "TRACKPADZOOM", "MOUSEROTATE"}
# Events that can press a button in a sidebar, where Cancel is.
BUTTON_EVENTS = {"MOUSEMOVE", "INBETWEEN_MOUSEMOVE", "LEFTMOUSE"}


class ModalJob:
    """Base of modal operators that run Pieces.

    Subclasses define obstacle(context): one sentence about why the operator cannot run now, or ""; begin(context,
    beside), which makes the work and raises what is wrong with settings or selection (beside: a window waits for it);
    and finish(context), which writes and reports the results of self.job.
    """

    # The work under way in the window, for the panel. A modal operator takes all events, so there is at most one.
    running: Pieces | None = None
    # Seconds between two turns of the work, and for which a turn may hold up the window: as many small meshes or frames
    # as fit. A worker that takes longer is left alone until it has ended.
    turn = 0.05
    # The sentence after Esc.
    as_before = ""

    def report_pieces(self, batch: Pieces) -> bool:
        """Reports notes, warnings and failures of all pieces; False if all of them failed."""
        report_all(self.report, batch)
        lost = failures(batch)
        if not batch.written:
            self.report({"ERROR"}, "\n".join(lost))
            return False
        for sentence in lost:
            self.report({"WARNING"}, sentence)
        return True

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Returns whether the operator can run; the button's tooltip says why not."""
        running = "A bake is running; Esc cancels it" if ModalJob.running else ""
        return translation.can_run(cls, running or cls.obstacle(context))

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Runs all steps in a row, for scripts and background mode, where timers never fire."""
        if not self.has_begun(context, beside=False):
            return {"CANCELLED"}
        try:
            while not self.job.done:
                self.job.step(None)
            return self.end(context)
        except BaseException:  # such as Ctrl-C
            self.give_up()
            raise

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> set[str]:
        """Starts the work; modal() continues it."""
        if bpy.app.background:
            return self.execute(context)
        if not self.has_begun(context, beside=True):
            return {"CANCELLED"}
        ModalJob.running, self.shown = self.job, ""
        manager = context.window_manager
        self.timer = manager.event_timer_add(self.turn, window=context.window)
        manager.progress_begin(0.0, 1.0)
        manager.modal_handler_add(self)
        self.show_progress(context)
        return {"RUNNING_MODAL"}

    def has_begun(self, context: bpy.types.Context, beside: bool) -> bool:
        """Begins the work; False, with an error report, if it cannot begin."""
        self.before = Snapshot(context.scene)
        try:
            self.job = self.begin(context, beside)
        except ParadescError as error:
            self.before.restore()
            self.report({"ERROR"}, translation.said(error.sentence))
            return False
        return True

    def end(self, context: bpy.types.Context) -> set[str]:
        """Finishes the work, unless it was cancelled."""
        if self.job.cancelled:
            self.report({"INFO"}, translation.said(self.as_before))
            ended = {"CANCELLED"}
        else:
            try:
                ended = self.finish(context)
            except ParadescError as error:
                self.report({"ERROR"}, translation.said(error.sentence))
                ended = {"CANCELLED"}
        if ended == {"FINISHED"}:
            self.job.close()
        else:
            self.give_up()
        return ended

    def give_up(self) -> None:
        """Closes work that produced nothing; the settings become what they were before begin() changed them."""
        self.job.close()
        self.before.restore()

    def modal(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """Shows progress, cancels on Esc, and finishes when all is done."""
        if event.type == "ESC" and event.value == "PRESS":
            self.job.cancel()
            return {"RUNNING_MODAL"}
        if event.type != "TIMER":
            free = event.type in VIEW_EVENTS or (event.type in BUTTON_EVENTS and over_sidebar(context, event))
            return {"PASS_THROUGH"} if free else {"RUNNING_MODAL"}
        try:
            end = time.monotonic() + self.turn
            goes_on = self.job.step()
            while goes_on and (left := end - time.monotonic()) > 0.0:
                goes_on = self.job.step(left)
            if not self.job.done:
                self.show_progress(context)
                return {"RUNNING_MODAL"}
            self.clean_up(context)
            return self.end(context)
        except BaseException:
            self.cancel(context)
            raise

    def cancel(self, context: bpy.types.Context) -> None:
        """Cleans up when Blender ends the operator itself, for example because another file is loaded."""
        self.give_up()
        self.clean_up(context)

    def show_progress(self, context: bpy.types.Context) -> None:
        """Shows the progress at the cursor, in the status bar and in the panel."""
        text = progress_text(self.job)
        if text == self.shown:
            return
        self.shown = text
        context.window_manager.progress_update(self.job.fraction)
        if context.workspace is not None:
            context.workspace.status_text_set(f"Paradesc: {text} ({translation.label('Esc cancels')})")
        redraw_sidebars(context)

    def clean_up(self, context: bpy.types.Context) -> None:
        """Removes the timer and the progress."""
        if ModalJob.running is None:
            return
        ModalJob.running = None
        context.window_manager.event_timer_remove(self.timer)
        context.window_manager.progress_end()
        if context.workspace is not None:
            context.workspace.status_text_set(None)
        redraw_sidebars(context)


def progress_text(job: Pieces) -> str:
    """The progress in words: stage and percentage."""
    return translation.label("{stage}, {percent} %").format(stage=job.stage, percent=f"{100 * job.fraction:.0f}")


def sidebars(screen: bpy.types.Screen) -> Iterator[bpy.types.Region]:
    """The regions of a screen that have the panels."""
    for area in screen.areas:
        if area.type == "VIEW_3D":
            yield from (region for region in area.regions if region.type == "UI")


def redraw_sidebars(context: bpy.types.Context) -> None:
    """Redraws the sidebars, so that the panel shows the progress."""
    for window in context.window_manager.windows:
        for region in sidebars(window.screen):
            region.tag_redraw()


def over_sidebar(context: bpy.types.Context, event: bpy.types.Event) -> bool:
    """Returns whether the mouse is over a sidebar, where the panels' settings are grey during the work."""
    return any(
        0 <= event.mouse_x - region.x < region.width and 0 <= event.mouse_y - region.y < region.height
        for region in sidebars(context.screen)
    )


class PARADESC_OT_cancel(bpy.types.Operator):
    """Stop the running job, as Esc does; nothing is written"""

    bl_idname = "paradesc.cancel"
    bl_label = "Cancel"
    bl_options = {"INTERNAL"}

    @classmethod
    def poll(cls, _context: bpy.types.Context) -> bool:
        """Works only while a job runs."""
        return ModalJob.running is not None

    def execute(self, _context: bpy.types.Context) -> set[str]:
        """Asks the work to end; the operator that runs it notices at its next turn."""
        ModalJob.running.cancel()
        return {"FINISHED"}


classes = (PARADESC_OT_cancel,)


def register() -> None:
    """Adds the property that panels show the progress with."""
    bpy.types.WindowManager.paradesc_progress = bpy.props.FloatProperty(
        name="",
        subtype="PERCENTAGE",
        precision=0,
        min=0.0,
        max=100.0,
        get=lambda _manager: 100 * ModalJob.running.fraction if ModalJob.running else 0.0,
        options={"SKIP_SAVE"},
    )


def unregister() -> None:
    """Removes the property."""
    del bpy.types.WindowManager.paradesc_progress
