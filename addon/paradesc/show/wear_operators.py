"""The operators of wear: one bakes the masks that it needs and gives materials wear, one takes it out again."""

from dataclasses import replace

import bpy

from ..bake.batch import Batch, MeshBake
from ..bake.modal import ModalJob
from ..bake.operators import keep_for_undo
from ..bake.pieces import failures, find, report_all, with_name
from ..bridge import ParadescError
from ..core.color_maps import Look
from ..scene import mesh_io, modes, targets, viewports
from ..settings import translation
from ..settings.snapshot import Snapshot
from . import wear


class MaskBatch(Batch):
    """A bake of the masks that wear needs, grey whatever the panel's colors are."""

    def __init__(self, context: bpy.types.Context) -> None:
        """Takes settings and selection; the panel has afterwards what it had."""
        group, before = context.scene.paradesc, Snapshot(context.scene)
        try:
            group.descriptors, group.more_radii = set(wear.MASKS.values()), ""
            group.write_attributes, group.write_image, group.write_buffers = True, False, False
            super().__init__(context)
        finally:
            before.restore()

    def write(self, piece: MeshBake) -> None:
        """Writes one mesh's masks: white is high, over a range of their own or the one that several meshes share."""
        shared = {name: span for name, span in self.look.ranges.items() if name}
        levels = replace(self.look.levels, invert=False)
        self.look = replace(Look(), ranges=shared, levels=levels)
        super().write(piece)


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

    def begin(self, context: bpy.types.Context, beside: bool) -> MaskBatch:
        """Takes the selection; refuses at once if no material of it can wear."""
        faults = [wear.fault(target) for target in targets.chosen(context)]
        if all(faults):
            raise mesh_io.refuse(faults[0])
        return MaskBatch(context)

    def finish(self, context: bpy.types.Context) -> set[str]:
        """Writes the masks and gives the materials wear; after Esc it does nothing."""
        batch = self.job
        if batch.cancelled:
            self.report({"INFO"}, "Cancelled; every mesh and material is as it was")
            return {"CANCELLED"}
        keep_for_undo(context)
        batch.finish(context)
        report_all(self.report, batch, batch.written)
        lost, worn = failures(batch), []
        for key in [key for piece in batch.written for key in piece.sharing]:
            try:
                worn.append(self.wear_of(find(key)))
            except ParadescError as error:
                lost.append(with_name(key[0], error.sentence))
        for sentence in lost:
            self.report({"WARNING" if worn else "ERROR"}, sentence)
        if not worn:
            return {"CANCELLED"}
        viewports.reveal_materials(context)
        self.report({"INFO"}, translation.said("Wear in {names}").format(names=", ".join(dict.fromkeys(worn))))
        return {"FINISHED"}

    def wear_of(self, target: bpy.types.Object) -> str:
        """Gives one object wear; gives the name of its material."""
        look = self.look if self.properties.is_property_set("look") else ""
        with modes.object_mode(target):
            for sentence in wear.add(target, look):
                self.report({"INFO"}, translation.said(sentence))
        return target.active_material.name


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
