"""The mask and the radius of the panel as options of operators, and the radius fitted to the active mesh."""

import math

import bpy

from paradesc.bridge import ParadescError
from paradesc.core import advice, fitting, members
from paradesc.files.reading import ReadRequest

from ..scene import targets
from ..settings import presets, properties, translation

PANEL = ("panel", "As Set", "The descriptors of the panel")


class MaskOption:
    """Adds a mask option to an operator, so that menus can run it for one mask. The panel's mask then follows."""

    mask: bpy.props.EnumProperty(
        name="Mask",
        description="Mask to bake, or the descriptors of the panel",
        items=[PANEL, *presets.items_of(presets.MASKS)],
        default=PANEL[0],
        options={"SKIP_SAVE"},
    )

    def take_mask(self, group: bpy.types.PropertyGroup) -> None:
        """Sets the panel's mask to the operator's."""
        if self.mask != PANEL[0]:
            presets.choose_mask(group, self.mask)


class RadiusOption:
    """Adds a radius option to an operator. The redo panel can change it, and the sidebar's radius then follows."""

    fit: bpy.props.EnumProperty(
        name="Radius from Mesh",
        description="Fit the radius to the mesh and the mask, or use the one below",
        items=[PANEL, *members.FITS],
        default=PANEL[0],
        options={"SKIP_SAVE"},
    )
    radius: bpy.props.FloatProperty(
        name="Radius",
        description="Radius of the neighborhood that is measured, in percent of the diagonal of the mesh's bounding "
        "box; 0 uses the value of the panel or the mask",
        default=0.0,
        min=0.0,
        soft_max=20.0,
        max=100.0,
        precision=2,
        subtype="PERCENTAGE",
        options={"SKIP_SAVE"},
    )
    shown_radius: bpy.props.FloatProperty(options={"HIDDEN", "SKIP_SAVE"})

    def take_radius(self, group: bpy.types.PropertyGroup) -> None:
        """Sets the panel's radius to the operator's: a number if one was given, otherwise a size that fits the mesh."""
        given = self.fit == "typed" or not math.isclose(self.radius, self.shown_radius, rel_tol=1e-6)
        if self.radius > 0 and given:
            group.radius_unit, group.radius_percent = "diagonal", self.radius
        elif self.fit != PANEL[0]:
            group.radius_fit = self.fit

    def show_radius(self, group: bpy.types.PropertyGroup) -> None:
        """Copies the panel's radius, which the bake may have fitted, to the operator."""
        self.fit = group.radius_fit
        if group.radius_unit == "diagonal":
            self.radius = self.shown_radius = group.radius_percent


class PARADESC_OT_fit_radius(bpy.types.Operator):
    """Fit the radius to the mesh and the mask again, in place of the typed one"""

    bl_idname = "paradesc.fit_radius"
    bl_label = "Fit to Mesh"
    bl_options = {"REGISTER", "UNDO"}

    size: bpy.props.EnumProperty(
        name="Size", description="The size of the measured shapes", items=members.FITS[:3], default="medium"
    )

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Needs a mesh object."""
        return translation.can_run(cls, "" if targets.first(context) else "Select a mesh object first")

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Reads the mesh by its source, and shows the radius that the next bake will have."""
        group, target = context.scene.paradesc, targets.first(context)
        request = ReadRequest(group.shape_key, source=context.scene.paradesc_animation.source, placing=False)
        try:
            settings = properties.job_settings(group)
            arrays = targets.read(target, settings, request).measured
            radius, edge, diagonal = advice.fitted_radius(arrays, settings.descriptors, self.size)
        except ParadescError as error:
            self.report({"ERROR"}, translation.said(error.sentence))
            return {"CANCELLED"}
        group.radius_fit = self.size
        properties.show_radius(group, fitting.fitted(properties.job_settings(group), arrays))
        shares = {"radius": f"{100 * radius / diagonal:.3g}", "edge": f"{100 * edge / diagonal:.2g}"}
        self.report({"INFO"}, translation.said("Radius {radius} %: the mean edge is {edge} %").format(**shares))
        return {"FINISHED"}


classes = (PARADESC_OT_fit_radius,)
