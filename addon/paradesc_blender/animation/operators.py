"""The operators that bake frames of all selected meshes into the cache, and that recompute color ranges."""

import bpy

from paradesc import bridge

from ..bake.modal import ModalJob
from ..scene import targets
from ..settings import translation
from ..settings.animation import cache_root, wanted_frames
from . import sessions
from .frame_batch import FrameBatch

# In these modes the mesh is that of the object.
MODES = {"OBJECT", "VERTEX_PAINT", "WEIGHT_PAINT", "TEXTURE_PAINT"}


class PARADESC_OT_bake_frames(ModalJob, bpy.types.Operator):
    """Compute the chosen descriptors of the selected meshes for every frame into the cache; existing frames are kept"""

    bl_idname = "paradesc.bake_frames"
    bl_label = "Bake Frames"
    bl_options = {"REGISTER", "UNDO"}
    as_before = "Cancelled; the frames so far are in the cache"

    @classmethod
    def obstacle(cls, context: bpy.types.Context) -> str:
        """Refuses modes in which the mesh is not that of the object."""
        objects = targets.chosen(context)
        modes = {"EDIT" if item.data.is_editmode else item.mode for item in objects} - MODES
        if bridge.missing_sentence() or not objects:
            return bridge.missing_sentence() or "Select a mesh object first"
        return targets.leave(min(modes)) if modes else ""

    def begin(self, context: bpy.types.Context, beside: bool) -> FrameBatch:
        """Makes the batch for the scene's wanted frames and cache folder."""
        return FrameBatch(context, wanted_frames(context.scene), cache_root(context.scene), beside)

    def finish(self, _context: bpy.types.Context) -> set[str]:
        """Makes colors span all frames, and reports which frames exist now."""
        batch = self.job
        if not self.report_pieces(batch):
            return {"CANCELLED"}
        batch.hold_ranges()
        sessions.refresh_window(sessions.live_objects())
        self.report({"INFO"}, frames_sentence(batch))
        return {"FINISHED"}


def frames_sentence(batch: FrameBatch) -> str:
    """One line about all frames."""
    sound = batch.written
    there = len(batch.wanted) * len(sound) - sum(piece.made for piece in sound)
    folder = sound[0].folder if len(batch.pieces) == 1 else sound[0].folder.parent
    found = {"made": batch.made, "objects": len(sound), "there": there, "folder": folder}
    if len(batch.pieces) == 1:
        return translation.said("{made} frames baked, {there} existed already: {folder}").format(**found)
    sentence = "{made} frames of {objects} objects baked, {there} existed already: {folder}"
    return translation.said(sentence).format(**found)


class PARADESC_OT_live_range(bpy.types.Operator):
    """Fit the colors of live objects to the values of this frame, and those of played objects to all frames"""

    bl_idname = "paradesc.live_range"
    bl_label = "Range of This Frame"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, _context: bpy.types.Context) -> bool:
        """Returns whether the operator can run; the button's tooltip says why not."""
        return translation.can_run(cls, "" if sessions.live_objects() else "Switch an object to Live first")

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Replaces the stored ranges by those of the present values."""
        sessions.take_ranges(context.scene)
        return {"FINISHED"}


classes = (PARADESC_OT_bake_frames, PARADESC_OT_live_range)
