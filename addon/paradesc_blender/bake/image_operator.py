"""The operators that bake textures, of the selected meshes or of one onto another, as one step to undo."""

import time

import bpy

from ..scene import image_preview, pairs, targets
from ..settings.translation import said
from .fit import MaskOption, RadiusOption
from .image_batch import ImageBatch
from .modal import ModalJob
from .pieces import find


class ImageJob(MaskOption, RadiusOption, ModalJob):
    """Base of the operators that bake textures. Their own mask and radius replace those of the panel."""

    onto = False  # the pairs among the selected meshes
    as_before = "Cancelled; no image was written"

    def begin(self, context: bpy.types.Context, beside: bool) -> ImageBatch:
        """Applies the operator's mask and radius, and makes the batch; beside: there is a window."""
        self.take_mask(context.scene.paradesc)
        self.take_radius(context.scene.paradesc)
        return ImageBatch(context, self.onto)

    def finish(self, context: bpy.types.Context) -> set[str]:
        """Keeps all textures and says where."""
        batch = self.job
        batch.finish()
        self.show_radius(context.scene.paradesc)
        if not self.report_pieces(batch):
            return {"CANCELLED"}
        for piece in batch.written:
            made, shown = piece.kept, piece.textures.most_telling()
            image_preview.reveal(find(piece.key), bpy.data.images[made.names[shown]], made.uv_map, made.cage)
        self.report({"WARNING" if batch.failed else "INFO"}, image_sentence(batch))
        return {"FINISHED"}


class PARADESC_OT_bake_image(ImageJob, bpy.types.Operator):
    """Measure the surface for every texel of the UV map, and load the result as 16-bit textures beside the .blend"""

    bl_idname = "paradesc.bake_image"
    bl_label = "Bake to Image"
    bl_options = {"REGISTER", "UNDO"}
    obstacle = staticmethod(targets.reading_obstacle)


class PARADESC_OT_bake_onto(ImageJob, bpy.types.Operator):
    """Measure detailed meshes, and load the result as textures over the UV map of a low-poly one"""

    bl_description = (
        "Measure detailed meshes, and load the result as textures over the UV map of a low-poly one: the other "
        "selected meshes onto the active one, or those named _high onto those named _low"
    )
    bl_idname = "paradesc.bake_onto"
    bl_label = "Bake Selected to Active"
    bl_options = {"REGISTER", "UNDO"}
    onto = True

    cage: bpy.props.FloatProperty(
        name="Cage Distance",
        description="Distance from the low-poly mesh within which the detailed ones are searched; 0 uses the panel's "
        "value",
        default=0.0,
        min=0.0,
        precision=4,
        subtype="DISTANCE",
        options={"SKIP_SAVE"},
    )

    @classmethod
    def obstacle(cls, context: bpy.types.Context) -> str:
        """One sentence about why the meshes cannot be read or paired, or ""."""
        sentence = targets.reading_obstacle(context)
        if sentence or pairs.chosen(context):
            return sentence
        return "Select the detailed meshes and then the low-poly one, or end their names in _high and _low"

    def begin(self, context: bpy.types.Context, beside: bool) -> ImageBatch:
        """Takes settings and selection. A cage distance given to the operator replaces the panel's."""
        if self.cage > 0:
            context.scene.paradesc.cage = self.cage
        return super().begin(context, beside)

    def finish(self, context: bpy.types.Context) -> set[str]:
        """Finishes as Bake to Image does, and shows the cage distance that was used as the operator's own."""
        ended = super().finish(context)
        if ended == {"FINISHED"}:
            self.cage = self.job.written[0].textures.results.transfer.cage
        return ended


def image_sentence(batch: ImageBatch) -> str:
    """One line that says which images were written, where, and how long that took."""
    made = [name for piece in batch.written for name in piece.made]
    several = {"count": len(made), "first": made[0], "last": made[-1]}
    what = said("{count} images, {first} to {last}").format(**several) if len(made) > 1 else made[0]
    here = said("in this .blend, which is not saved yet")
    where = here if batch.folder is None else said("in {folder}").format(folder=batch.folder)
    found = [piece.textures.results for piece in batch.written]
    computed = sum(results.field_report["seconds_total"] for results in found)
    added = dict.fromkeys(name for piece in batch.written for name in piece.materials)
    materials = ", ".join(f'"{name}"' for name in added)
    parts = {
        "what": what,
        "size": batch.choice.size,
        "where": where,
        "seconds": f"{time.monotonic() - batch.started:.2f}",
        "computed": f"{computed:.2f}",
        "device": found[0].device,
    }
    line = said("{what}, {size} × {size}, {where}: {seconds} s, of which {computed} s on {device}").format(**parts)
    return line + (said("; in the material {names}").format(names=materials) if materials else "")


classes = (PARADESC_OT_bake_image, PARADESC_OT_bake_onto)
