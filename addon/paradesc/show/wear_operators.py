"""The operators of wear: one bakes the masks that it needs and gives materials wear, one takes it out again."""

from dataclasses import replace

import bpy

from ..bake.batch import Batch
from ..bake.modal import ModalJob
from ..bake.operators import keep_for_undo
from ..bake.pieces import find, report_all
from ..bridge import ParadescError
from ..core.color_maps import AUTOMATIC
from ..core.threads import Worker
from ..scene import mesh_io, modes, targets, viewports
from ..settings import translation
from ..settings.snapshot import Snapshot
from . import wear


class MaskBatch(Batch):
    """A bake of one mask, grey whatever the panel's colors are."""

    def write(self, piece: object) -> None:
        """Writes it over its own range."""
        self.look = replace(self.look, color_map=AUTOMATIC, percentile=None, ranges={}, neutral=None)
        super().write(piece)


class MaskBatches:
    """The bakes of several masks one after another, each at its own radius."""

    def __init__(self, context: bpy.types.Context) -> None:
        """Takes settings and selection; what the panel has beside them is as it was afterwards."""
        group, before = context.scene.paradesc, Snapshot(context.scene)
        try:
            group.write_attributes, group.write_image, group.write_buffers, group.more_radii = True, False, False, ""
            self.batches = [self.batch(context, {name}) for name in wear.MASKS.values()]
        finally:
            before.restore()
        self.pieces = self.batches[0].pieces

    @staticmethod
    def batch(context: bpy.types.Context, descriptors: set[str]) -> MaskBatch:
        """The bake of one of them."""
        context.scene.paradesc.descriptors = descriptors
        return MaskBatch(context)

    @property
    def current(self) -> MaskBatch:
        """The bake that is under way, or the last one."""
        return next((one for one in self.batches if not one.done), self.batches[-1])

    @property
    def worker(self) -> Worker | None:
        """What computes just now."""
        return self.current.worker

    @property
    def cancelled(self) -> bool:
        """Whether any was cancelled."""
        return any(one.cancelled for one in self.batches)

    @property
    def done(self) -> bool:
        """Whether all have ended, or the one under way was cancelled."""
        return all(one.done for one in self.batches)

    @property
    def fraction(self) -> float:
        """The finished share of all."""
        return sum(one.fraction for one in self.batches) / len(self.batches)

    @property
    def stage(self) -> str:
        """What is being done."""
        return self.current.stage

    def step(self, wait: bool = False) -> None:
        """Goes on with the one under way."""
        self.current.step(wait)

    def cancel(self) -> None:
        """Ends all."""
        for one in self.batches:
            one.cancel()

    def close(self) -> None:
        """Lets go of all."""
        for one in self.batches:
            one.close()

    @property
    def failed(self) -> dict[str, str]:
        """What failed, by the name of the object."""
        return {piece.name: piece.failure for one in reversed(self.batches) for piece in one.failed}


class PARADESC_OT_add_wear(ModalJob, bpy.types.Operator):
    """Bake cavity and edge wear, and let the active material of the selected objects be dirty and worn by them"""

    bl_idname = "paradesc.add_wear"
    bl_label = "Add Wear to Material"
    bl_options = {"REGISTER", "UNDO"}

    look: bpy.props.EnumProperty(
        name="Look",
        description="Colors and levels of dirt and wear; what was tuned stays",
        items=[
            (wear.AS_IS, "Own Colors", "Dirt darkens and wear brightens the colors that the material has"),
            ("PAINTED_METAL", "Painted Metal", "Bare steel at the edges, grime in the hollows"),
            ("OLD_STONE", "Old Stone", "Pale edges, dark and mossy hollows"),
            ("DUSTY_PLASTIC", "Dusty Plastic", "Scuffed edges, pale dust in the hollows and on top"),
        ],
        default=wear.AS_IS,
        options={"SKIP_SAVE"},
    )

    @classmethod
    def obstacle(cls, context: bpy.types.Context) -> str:
        """What stands in the way of reading or writing the selected meshes."""
        sentence = targets.reading_obstacle(context)
        if sentence:
            return sentence
        refused = [targets.unwritable(target) for target in targets.chosen(context)]
        return refused[0] if all(refused) else ""

    def begin(self, context: bpy.types.Context, beside: bool) -> MaskBatches:
        """Takes the selection; refuses at once if no material of it can wear."""
        faults = [wear.fault(target) for target in targets.chosen(context)]
        if all(faults):
            raise mesh_io.refuse(faults[0])
        return MaskBatches(context)

    def finish(self, context: bpy.types.Context) -> set[str]:
        """Writes the masks and gives the materials wear; after Esc it does nothing."""
        job = self.job
        if job.cancelled:
            self.report({"INFO"}, "Cancelled; every mesh and material is as it was")
            return {"CANCELLED"}
        keep_for_undo(context)
        for batch in job.batches:
            batch.finish(context)
            report_all(self.report, batch, batch.written)
        lost, worn = job.failed, []
        for piece in [piece for piece in job.pieces if piece.name not in lost]:
            for key in piece.sharing:
                try:
                    worn += self.wear_of(find(key))
                except ParadescError as error:
                    lost[key[0]] = error.sentence
        for sentence in lost.values():
            self.report({"WARNING" if worn else "ERROR"}, translation.said(sentence))
        if not worn:
            return {"CANCELLED"}
        viewports.reveal_materials(context)
        self.report({"INFO"}, translation.said("Wear in {names}").format(names=", ".join(dict.fromkeys(worn))))
        return {"FINISHED"}

    def wear_of(self, target: bpy.types.Object) -> list[str]:
        """Gives one object wear; gives the name of its material."""
        look = self.look if self.properties.is_property_set("look") else ""
        with modes.object_mode(target):
            for sentence in wear.add(target, look):
                self.report({"INFO"}, translation.said(sentence))
        return [target.active_material.name]


class PARADESC_OT_remove_wear(bpy.types.Operator):
    """Take wear out of the materials of the selected objects; masks stay on the mesh"""

    bl_idname = "paradesc.remove_wear"
    bl_label = "Remove Wear"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Only where there is some."""
        there = any(wear.wears(target) for target in targets.chosen(context))
        if not there:
            cls.poll_message_set(translation.tooltip("No material of the selected objects has wear"))
        return there

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Gives every material back what it had."""
        notes = [note for target in targets.chosen(context) for note in wear.remove(target)]
        for sentence in dict.fromkeys(notes):
            self.report({"INFO"}, translation.said(sentence))
        return {"FINISHED"}


classes = (PARADESC_OT_add_wear, PARADESC_OT_remove_wear)
