"""The bake operator: bakes the selected meshes one after another without blocking the window, as one undo step."""

import bpy

from paradesc.bridge import ParadescError, abi
from paradesc.core import devices, legend

from ..scene import mesh_io, modes, targets, viewports
from ..settings import translation
from ..settings.looks import COLORS
from ..settings.properties import property_of
from .batch import Batch
from .fit import MaskOption, RadiusOption
from .modal import ModalJob

# The line of a bake lists so many names of skipped objects at most.
LISTED = 3
BRUSH_MODES = {"SCULPT", "VERTEX_PAINT", "WEIGHT_PAINT", "TEXTURE_PAINT"}
LEVELS = ("contrast", "brightness", "invert")


class PARADESC_OT_bake(MaskOption, RadiusOption, ModalJob, bpy.types.Operator):
    """Measure the selected meshes at every vertex, and show the mask as vertex colors"""

    bl_idname = "paradesc.bake"
    bl_label = "Bake Mask"
    bl_options = {"REGISTER", "UNDO"}
    as_before = "Cancelled; every mesh is as it was"
    obstacle = staticmethod(targets.obstacle)

    # The redo panel can change the levels, and those of the sidebar then follow.
    contrast: property_of(COLORS["contrast"], options={"SKIP_SAVE"})
    brightness: property_of(COLORS["brightness"], options={"SKIP_SAVE"})
    invert: property_of(COLORS["invert"], options={"SKIP_SAVE"})

    def begin(self, context: bpy.types.Context, beside: bool) -> Batch:
        """Takes settings and selection, with or without a window. The operator's own options replace the panel's."""
        group, looks = context.scene.paradesc, context.scene.paradesc_looks
        self.take_mask(group)
        self.take_radius(group)
        self.skipped = [item.name for item in targets.skipped(context)]
        for name in LEVELS:
            if self.properties.is_property_set(name) and getattr(self, name) != getattr(looks, name):
                setattr(looks, name, getattr(self, name))
        return Batch(context)

    def finish(self, context: bpy.types.Context) -> set[str]:
        """Writes all results and reports them."""
        batch = self.job
        keep_for_undo(context)
        batch.finish(context)
        self.show_radius(context.scene.paradesc)
        for name in LEVELS:
            setattr(self, name, getattr(context.scene.paradesc_looks, name))
        if not self.report_pieces(batch):
            return {"CANCELLED"}
        viewports.reveal(context)
        sentence = bake_sentence(batch)
        if self.skipped:
            names = ", ".join(f'"{name}"' for name in self.skipped[:LISTED])
            names += ", …" if len(self.skipped) > LISTED else ""
            clause = translation.said("; {count} skipped, not meshes: {names}")
            sentence += clause.format(count=len(self.skipped), names=names)
        self.report({"WARNING" if batch.failed else "INFO"}, sentence)
        return {"FINISHED"}


def keep_for_undo(context: bpy.types.Context) -> None:
    """Pushes an undo step in brush modes, because their own steps hold strokes and not a mesh's attributes."""
    active = context.active_object
    if active is not None and active.mode in BRUSH_MODES and not bpy.app.background:
        bpy.ops.ed.undo_push(message="Before Bake Mask")


def bake_sentence(batch: Batch) -> str:
    """One line that sums up a bake: descriptors, seconds, device, and which meshes failed."""
    written = batch.written
    seconds = sum(piece.results.field_report["seconds_total"] for piece in written)
    names = ", ".join(translation.label(legend.label(name)) for name in written[0].results.values)
    undefined = sum(piece.results.field_report["undefined_vertices"] for piece in written)
    done = {"names": names, "seconds": f"{seconds:.2f}", "device": written[0].results.device}
    line = translation.said("{names}: {seconds} s on {device}").format(**done)
    if undefined:
        line += translation.said(", {count} undefined vertices").format(count=f"{undefined:,}")
    if len(batch.pieces) == 1:
        return line
    if not batch.failed:
        return translation.said("{count} meshes, {line}").format(count=len(written), line=line)
    lost = ", ".join(f'"{piece.name}"' for piece in batch.failed)
    some = {"count": len(written), "whole": len(batch.pieces), "line": line, "lost": lost}
    return translation.said("{count} of {whole} meshes, {line}; without {lost}").format(**some)


class PARADESC_OT_make_local(bpy.types.Operator):
    """Make the meshes of the selected objects local to this file, so that they keep what is baked into them"""

    bl_idname = "paradesc.make_local"
    bl_label = "Make Meshes Local"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Needs a chosen mesh that is linked or an override."""
        found = any(mesh_io.unwritable(target) for target in targets.chosen(context))
        return translation.can_run(cls, "" if found else "Every selected mesh is already local")

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Makes objects and meshes local if they are linked or overrides; whatever else they use stays linked."""
        names = []
        copies: dict[bpy.types.Mesh, bpy.types.Mesh] = {}
        try:
            for target in [item for item in targets.chosen(context) if mesh_io.unwritable(item)]:
                names.append(make_local(target, copies).name)
        except ParadescError as error:
            self.report({"ERROR"}, translation.said(error.sentence))
            return {"FINISHED" if names else "CANCELLED"}
        self.report({"INFO"}, translation.said("Local now: {names}").format(names=", ".join(names)))
        return {"FINISHED"}


def make_local(target: bpy.types.Object, copies: dict[bpy.types.Mesh, bpy.types.Mesh]) -> bpy.types.Object:
    """Returns the object, made local, with a local mesh. copies: the local meshes that have been made so far."""
    if target.library is not None:
        if any(item.override_library and item.override_library.reference == target for item in bpy.data.objects):
            sentence = f'Overrides follow the linked object "{target.name}"; make those local, or remove them first.'
            raise ParadescError(abi.STATUS_INVALID_ARGUMENT, sentence)
        target = target.make_local()
    if target.data.override_library is not None:
        target.data.override_library.destroy()  # a copy would be an override again; this keeps its contents
    mesh = target.data
    if mesh.library is not None:
        copies[mesh] = copies.get(mesh) or mesh.copy()
        target.data = copies[mesh]
    mesh_io.check_writable(target)
    return target


class PARADESC_OT_convert_to_mesh(bpy.types.Operator):
    """Convert the selected texts, curves, surfaces and metaballs to meshes, so that they can be baked"""

    bl_idname = "paradesc.convert_to_mesh"
    bl_label = "Convert to Mesh"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Needs a selected object that can be converted to a mesh."""
        missing = "Select text, curves, surfaces or metaballs in object mode first"
        return translation.can_run(cls, "" if targets.skipped(context) else missing)

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Converts the objects in place, as Blender does. Selection and active object stay."""
        found = targets.skipped(context)
        reasons = {item: targets.unconvertible(item) for item in found}
        for sentence in filter(None, reasons.values()):
            self.report({"WARNING"}, sentence)
        chosen = [item for item in found if not reasons[item]]
        if not chosen:
            return {"CANCELLED"}
        names = ", ".join(f'"{item.name}"' for item in chosen)
        convert(context, chosen)
        self.report({"INFO"}, translation.said("Converted to meshes: {names}").format(names=names))
        return {"FINISHED"}


def convert(context: bpy.types.Context, chosen: list[bpy.types.Object]) -> None:
    """Converts the objects to meshes. One object of a family of metaballs remains, with the whole surface."""
    for item in chosen:  # objects that share its data stay as they are; Blender 4.2 would empty shared texts besides
        if item.type != "META" and item.data.users > 1:
            item.data = item.data.copy()
    objects = context.view_layer.objects
    active, names = objects.active, [item.name for item in chosen]
    others = [item for item in context.selected_objects if item not in chosen]
    modes.select_only(objects, chosen)
    is_other = active is not None and active not in chosen
    objects.active = chosen[0] if is_other or active is None else active
    bpy.ops.object.convert(target="MESH")
    made = list(objects.selected)
    for item in made:  # a new object stands for metaballs, with a number behind the name that is free by now
        stem = item.name.rpartition(".")[0]
        if item.name not in names and stem in names and stem not in bpy.data.objects:
            item.name = stem
    modes.select_only(objects, [*made, *others])
    if is_other:
        objects.active = active


class PARADESC_OT_choose_device(bpy.types.Operator):
    """Compute on this device"""

    bl_idname = "paradesc.choose_device"
    bl_label = "Choose Device"
    bl_options = {"INTERNAL", "UNDO"}

    backend: bpy.props.StringProperty(
        name="Backend", description="One of auto, gpu, cpu, software and reference", default="auto"
    )
    index: bpy.props.IntProperty(name="Device", description="Number among the backend's devices, or -1", default=-1)

    @classmethod
    def description(cls, _context: bpy.types.Context, asked: bpy.types.OperatorProperties) -> str:
        """The tooltip: what the device is, or why it is missing."""
        return translation.tooltip(devices.about(asked.backend))

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Sets the backend and the index of the device."""
        group = context.scene.paradesc
        group.backend, group.device_index = self.backend, self.index
        return {"FINISHED"}


classes = (PARADESC_OT_bake, PARADESC_OT_make_local, PARADESC_OT_convert_to_mesh, PARADESC_OT_choose_device)
