"""The radius of the panel as an option of operators, and fitted to the active mesh, whose triangles it has to span."""

import bpy
import numpy as np

from ..bridge import MeshArrays, ParadescError
from ..core import advice
from ..scene import targets
from ..scene.mesh_io import refuse
from ..settings import properties, translation


class RadiusOption:
    """An operator with a radius of its own, which Blender's redo panel changes and which then is the sidebar's too."""

    radius: bpy.props.FloatProperty(
        name="Radius",
        description="How far a vertex looks around, in percent of the diagonal of the mesh's bounding box; 0: as the "
        "panel or the mask has it",
        default=0.0,
        min=0.0,
        soft_max=20.0,
        max=100.0,
        precision=2,
        subtype="PERCENTAGE",
        options={"SKIP_SAVE"},
    )

    def take_radius(self, group: bpy.types.PropertyGroup) -> None:
        """Sets the panel's radius if one was given, else shows the panel's."""
        if self.radius > 0:
            group.radius_unit, group.radius_percent = "diagonal", self.radius
        elif group.radius_unit == "diagonal":
            self.radius = group.radius_percent


def lengths_of(arrays: MeshArrays) -> tuple[float, float]:
    """The mean edge length and the diagonal of the bounding box, of what has faces."""
    if not len(arrays.triangle_vertices) or not np.isfinite(arrays.positions[arrays.triangle_vertices]).all():
        raise refuse("The mesh has no faces to fit the radius to, or a position that is no number.")
    edge, diagonal = advice.mean_edge_and_diagonal(arrays)
    if not diagonal > 0:
        raise refuse("The mesh is a single point, so there is no radius that fits it.")
    return edge, diagonal


class PARADESC_OT_fit_radius(bpy.types.Operator):
    """Set the radius to what suits the active mesh: at least two edges, to see the surface and not its faces"""

    bl_idname = "paradesc.fit_radius"
    bl_label = "Fit to Mesh"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Needs a mesh."""
        there = bool(targets.chosen(context))
        if not there:
            cls.poll_message_set(translation.tooltip("Select a mesh object first"))
        return there

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Reads the mesh by its source, and sets the radius in percent of the diagonal."""
        group, target = context.scene.paradesc, targets.chosen(context)[0]
        request = targets.ReadRequest(group.shape_key, source=context.scene.paradesc_animation.source, placing=False)
        try:
            edge, diagonal = lengths_of(targets.read(target, properties.job_settings(group), request).measured)
        except ParadescError as error:
            self.report({"ERROR"}, error.sentence)
            return {"CANCELLED"}
        group.radius_unit, group.radius_percent = "diagonal", 100 * advice.fitting_radius(edge, diagonal)
        shares = {"radius": f"{group.radius_percent:.3g}", "edge": f"{100 * edge / diagonal:.2g}"}
        self.report({"INFO"}, translation.said("Radius {radius} %: the mean edge is {edge} %").format(**shares))
        return {"FINISHED"}


classes = (PARADESC_OT_fit_radius,)
