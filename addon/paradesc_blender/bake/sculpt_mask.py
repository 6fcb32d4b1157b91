"""The operator that masks cavities or edges in sculpt mode, at the panel's radius, and writes nothing else."""

from dataclasses import replace
from functools import partial

import bpy
import numpy as np

from paradesc.core import job
from paradesc.files.reading import ReadRequest

from ..scene import sculpt_masks, targets, viewports
from ..settings import presets, properties, translation
from .fit import RadiusOption
from .modal import ModalJob
from .pieces import Piece, Pieces, Work, computed, find, key_of

# The panel's masks whose values can be used as a sculpt mask as they are.
MASKS = ("cavity", "edge_wear", "openness")
# On a mesh of so many triangles the usual radius spans ten edges. Fitting normals would then take a sixth of the time
# without a visible effect.
FINE = 200_000


class MaskBatch(Pieces):
    """Computes one mask of the mesh in sculpt mode, as it is sculpted so far."""

    def __init__(self, context: bpy.types.Context, mask: str) -> None:
        """Takes the panel's settings, with the descriptor of the mask."""
        chosen = tuple(presets.PRESETS[mask].settings["descriptors"])
        settings = properties.job_settings(context.scene.paradesc)
        self.settings = replace(settings, descriptors=chosen, more_radii=())
        super().__init__([Piece(key_of(context.active_object))])

    def work_on(self, piece: Piece) -> Work:
        """Reads the mesh, with the shape key that is sculpted, and computes."""
        read = targets.read(find(piece.key), self.settings, ReadRequest())
        settings = quick(self.settings, len(read.measured.triangle_corners))
        piece.results = yield from computed(partial(job.run, read.measured, settings))
        piece.warnings = [*piece.results.warnings, *piece.results.facet_notes(), *read.warnings]

    def finish(self, invert: bool) -> None:
        """Writes the mask, over the range that a bake would show from black to white. No value leaves no mask."""
        for piece in self.written:
            with self.attempt(piece):
                ((name, values),) = piece.results.values.items()
                shown = piece.results.shown(name)
                weights = shown.shares(np.nan_to_num(values, nan=shown.minimum)).astype(np.float32)
                sculpt_masks.write_shown(find(piece.key), 1 - weights if invert else weights)


def quick(settings: job.Settings, triangles: int, fine: int | None = None) -> job.Settings:
    """The settings; for many triangles without fitted normals, which take time and change nothing visible."""
    if triangles < (fine or FINE) or settings.options.normals != "fitted":
        return settings
    return replace(settings, options=replace(settings.options, normals="max"))


class PARADESC_OT_mask_from_shape(RadiusOption, ModalJob, bpy.types.Operator):
    """Mask cavities, edges or exposed areas at the panel's radius; hidden parts keep their mask"""

    bl_idname = "paradesc.mask_from_shape"
    bl_label = "Mask from Shape"
    bl_options = {"REGISTER", "UNDO"}
    as_before = "Cancelled; the mask is as it was"

    mask: bpy.props.EnumProperty(
        name="Mask",
        description="Parts to mask",
        items=presets.items_of(MASKS),
        default=MASKS[0],
    )
    invert: bpy.props.BoolProperty(
        name="Invert", description="Mask everything else, to sculpt only there", default=False, options={"SKIP_SAVE"}
    )

    @classmethod
    def obstacle(cls, context: bpy.types.Context) -> str:
        """One sentence about why the mesh cannot be read or masked, or ""."""
        target = context.active_object
        if target is None or target.mode != "SCULPT":
            return "Enter sculpt mode first: masked parts are protected"
        return targets.reading_obstacle(context) or sculpt_masks.multires_obstacle(target)

    def begin(self, context: bpy.types.Context, beside: bool) -> MaskBatch:
        """Takes the panel's settings; the operator's own radius replaces the panel's."""
        self.take_radius(context.scene.paradesc)
        return MaskBatch(context, self.mask)

    def finish(self, context: bpy.types.Context) -> set[str]:
        """Writes the mask."""
        batch = self.job
        batch.finish(self.invert)
        if not self.report_pieces(batch):
            return {"CANCELLED"}
        viewports.yield_to_mask(context)
        results = batch.written[0].results
        done = {
            "mask": translation.label(presets.PRESETS[self.mask].name),
            "seconds": f"{results.field_report['seconds_total']:.2f}",
            "device": results.device,
        }
        self.report({"INFO"}, translation.said("Masked by {mask}: {seconds} s on {device}").format(**done))
        return {"FINISHED"}


classes = (PARADESC_OT_mask_from_shape,)
