"""The operators of wear: one bakes the needed masks and adds wear to materials, one removes it."""

from dataclasses import replace

import bpy

from paradesc.bridge import InputError
from paradesc.core.color_maps import Look

from ..bake.batch import Batch, MeshBake
from ..bake.image_batch import ImageBatch
from ..bake.modal import ModalJob
from ..bake.operators import keep_for_undo
from ..bake.pieces import ObjectKey, Pieces, Work, failures, find, report_all
from ..scene import modes, targets, viewports
from ..settings import translation
from ..settings.snapshot import Snapshot
from . import wear


def mask_look(look: Look) -> Look:
    """The look of masks for shaders: white is high. The range is each mask's own, or one that several meshes share."""
    shared = {name: span for name, span in look.ranges.items() if name}
    return replace(Look(), ranges=shared, levels=look.levels)


class VertexMasks(Batch):
    """A bake of the masks as vertex colors."""

    def write(self, piece: MeshBake) -> None:
        """Writes one mesh's masks."""
        self.look = mask_look(self.look)
        super().write(piece)


class WearJob(Pieces):
    """Bakes the masks of all chosen objects: one batch as vertex colors, one as images of those with few vertices."""

    def __init__(self, context: bpy.types.Context) -> None:
        """Takes settings and selection. The panel's settings are changed for it only temporarily."""
        super().__init__([])
        group, before = context.scene.paradesc, Snapshot(context.scene)
        chosen, source = targets.chosen(context), context.scene.paradesc_animation.source
        coarse = [target for target in chosen if wear.needs_image(target, source)]
        fine = [target for target in chosen if target not in coarse]
        try:
            group.descriptors, group.more_radii = set(wear.MASKS.values()), ""
            group.image_packed, group.image_to_material = False, True
            self.batches = []
            for kind, found in ((VertexMasks, fine), (ImageBatch, coarse)):
                if found:
                    with context.temp_override(active_object=found[0], object=found[0], selected_objects=found):
                        self.batches.append(kind(bpy.context))
            if coarse:
                choice = self.batches[-1].choice
                self.batches[-1].choice = replace(choice, look=mask_look(choice.look))
        finally:
            before.restore()
        self.batch = self.batches[0]  # the one under way

    def work(self) -> Work:
        """Bakes one batch after the other."""
        for batch in self.batches:
            while not batch.done:
                self.batch = batch
                batch.step()
                yield batch.worker

    @property
    def fraction(self) -> float:
        """The finished share of all the work."""
        return sum(one.fraction for one in self.batches) / len(self.batches)

    @property
    def stage(self) -> str:
        """Words for the step under way, shown as progress."""
        return self.batch.stage

    def close(self) -> None:
        """Cancels what is left, and closes all batches."""
        super().close()
        for one in self.batches:
            one.close()


class PARADESC_OT_add_wear(ModalJob, bpy.types.Operator):
    """Bake cavity and edge wear, and add dirt and worn edges to the active materials of the selected objects"""

    bl_idname = "paradesc.add_wear"
    bl_label = "Add Wear to Material"
    bl_options = {"REGISTER", "UNDO"}
    as_before = "Cancelled; every mesh and material is as it was"

    look: bpy.props.EnumProperty(
        name="Look",
        description="Colors and levels of dirt and wear; values that you tuned are kept",
        items=[
            (wear.AS_IS, "Own Colors", "Dirt darkens and wear brightens the colors that the material has"),
            ("PAINTED_METAL", "Painted Metal", "Bare steel at the edges, grime in the hollows"),
            ("OLD_STONE", "Old Stone", "Pale edges, dark and mossy hollows"),
            ("DUSTY_PLASTIC", "Dusty Plastic", "Scuffed edges, pale dust in the hollows and on top"),
        ],
        default=wear.AS_IS,
        options={"SKIP_SAVE"},
    )

    obstacle = staticmethod(targets.obstacle)

    def begin(self, context: bpy.types.Context, beside: bool) -> WearJob:
        """Makes the job; raises at once if no material of the selection can get wear."""
        faults = [wear.fault(target) for target in targets.chosen(context)]
        if all(faults):
            raise InputError(faults[0])
        return WearJob(context)

    def finish(self, context: bpy.types.Context) -> set[str]:
        """Writes the masks and adds wear to the materials."""
        keep_for_undo(context)
        lost, worn = [], []
        for batch in self.job.batches:
            self.finish_batch(context, batch, worn)
            report_all(self.report, batch)
            lost += failures(batch)
        for sentence in lost:
            self.report({"WARNING" if worn else "ERROR"}, sentence)
        if not worn:
            return {"CANCELLED"}
        viewports.reveal_materials(context)
        self.report({"INFO"}, translation.said("Wear in {names}").format(names=", ".join(dict.fromkeys(worn))))
        return {"FINISHED"}

    def finish_batch(self, context: bpy.types.Context, batch: Pieces, worn: list[str]) -> None:
        """Writes a batch's masks, adds wear, and adds the materials' names to worn. Images use existing wear."""
        at_vertices = isinstance(batch, VertexMasks)
        if at_vertices:
            batch.finish(context)
        for piece in batch.written:
            for key in piece.sharing:
                with batch.attempt(piece):
                    self.wear_of(key, not at_vertices, worn)
        if not at_vertices:
            with wear.as_left(find(key) for piece in batch.written for key in piece.sharing):
                batch.finish()

    def wear_of(self, key: ObjectKey, of_images: bool, worn: list[str]) -> None:
        """Adds wear to one object, and the name of its material to worn."""
        target, look = find(key), self.look if self.properties.is_property_set("look") else ""
        with modes.object_mode(target):
            for sentence in wear.add(target, look, of_images):
                self.report({"INFO"}, translation.said(sentence))
        worn.append(target.active_material.name)


class PARADESC_OT_remove_wear(bpy.types.Operator):
    """Remove wear from the materials of the selected objects; masks stay on the mesh"""

    bl_idname = "paradesc.remove_wear"
    bl_label = "Remove Wear"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Needs a material with wear."""
        there = any(wear.has_wear(slot.material) for one in targets.chosen(context) for slot in one.material_slots)
        return translation.can_run(cls, "" if there else "No material of the selected objects has wear")

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Removes wear from the materials of all chosen objects."""
        notes = [note for target in targets.chosen(context) for note in wear.remove(target)]
        for sentence in dict.fromkeys(notes):
            self.report({"INFO"}, translation.said(sentence))
        return {"FINISHED"}


classes = (PARADESC_OT_add_wear, PARADESC_OT_remove_wear)
