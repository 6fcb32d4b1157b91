"""The operator that bakes textures of the selected meshes and loads them, as one step to undo."""

import bpy

from ..scene import targets
from .image_batch import ImageBatch
from .modal import ModalJob
from .pieces import failures, report_all


class PARADESC_OT_bake_image(ModalJob, bpy.types.Operator):
    """Measure the surface for every texel of the UV map, and load the result as 16-bit textures beside the .blend"""

    bl_idname = "paradesc.bake_image"
    bl_label = "Bake to Image"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def obstacle(cls, context: bpy.types.Context) -> str:
        """What stands in the way of reading the selected meshes."""
        return targets.reading_obstacle(context)

    def begin(self, context: bpy.types.Context, beside: bool) -> ImageBatch:
        """Takes settings and selection, with or without a window."""
        return ImageBatch(context)

    def finish(self, context: bpy.types.Context) -> set[str]:
        """Keeps all textures and says where; after Esc it keeps none."""
        batch = self.job
        if batch.cancelled:
            self.report({"INFO"}, "Cancelled; no image was written")
            return {"CANCELLED"}
        batch.finish()
        report_all(self.report, batch, batch.written)
        failed = failures(batch)
        if not batch.written:
            self.report({"ERROR"}, "\n".join(failed))
            return {"CANCELLED"}
        for sentence in failed:
            self.report({"WARNING"}, sentence)
        self.report({"WARNING" if failed else "INFO"}, image_sentence(batch))
        return {"FINISHED"}


def image_sentence(batch: ImageBatch) -> str:
    """What was written, where, and how long it took, in one line."""
    made = [texture.name for piece in batch.written for texture in piece.textures.made]
    what = f"{made[0]}.png" if len(made) == 1 else f"{len(made)} images, {made[0]}.png to {made[-1]}.png"
    where = "in this .blend, which is not saved yet" if batch.folder is None else f"in {batch.folder}"
    found = [piece.textures.results for piece in batch.written]
    computed = sum(results.field_report["seconds_total"] for results in found)
    materials = ", ".join(f'"{name}"' for name in dict.fromkeys(piece.material for piece in batch.written) if name)
    size = batch.choice.size
    line = f"{what}, {size} × {size}, {where}: {batch.seconds:.2f} s, of which {computed:.2f} s on {found[0].device}"
    return line + (f"; in the material {materials}" if materials else "")


classes = (PARADESC_OT_bake_image,)
