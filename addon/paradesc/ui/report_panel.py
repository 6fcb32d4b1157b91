"""The panel about what the last bake of the active mesh found."""

import bpy

from ..scene import record
from .drawing import SidebarPanel, sentence_lines

# Mesh defects that get a line each if there are any: the member of the mesh report, and words for people.
DEFECTS = (
    ("loose_vertices", "vertices without a face"),
    ("degenerate_triangles", "triangles without area"),
    ("zero_uv_area_triangles", "triangles without UV area"),
    ("flipped_triangles", "flipped triangles"),
    ("nonmanifold_edges", "non-manifold edges"),
    ("nonmanifold_vertices", "non-manifold vertices"),
)
# Stages of a bake that are timed: the member of the field report, and words for people.
STAGES = (("seconds_prepare", "mesh"), ("seconds_bake", "bake"), ("seconds_evaluate", "evaluate"))


class PARADESC_PT_report(SidebarPanel, bpy.types.Panel):
    """What the last bake of this mesh found"""

    bl_label = "Last Bake"
    bl_idname = "PARADESC_PT_report"
    bl_order = 60
    bl_parent_id = "PARADESC_PT_bake"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Shows only if there was a bake."""
        return bool(stored_report(context.active_object))

    def draw(self, context: bpy.types.Context) -> None:
        """Draws one line for each fact, and notes below; what limits the values stands under the button."""
        column = self.layout.column(align=True)
        stored = stored_report(context.active_object)
        for fact in report_lines(stored):
            sentence_lines(context, column, fact)
        for sentence in stored["notes"].splitlines():
            sentence_lines(context, column, sentence, "INFO")


def stored_report(target: bpy.types.Object | None) -> dict[str, dict]:
    """What the last bake left on the mesh of an object; empty if there was none, or if its values are gone."""
    stored = record.read(target.data) if target is not None and target.type == "MESH" else {}
    if "mesh_report" not in stored:
        return {}  # frames of a cache have no report
    left = stored["attributes"]  # the list outlives an undo in edit mode, the attributes do not
    return stored if any(name in target.data.attributes for name in left) else {}


def report_lines(stored: dict[str, dict]) -> list[str]:
    """The facts of one bake, as lines."""
    mesh, field = stored["mesh_report"], stored["field_report"]
    lines = [
        f"{mesh['vertex_count']:,} vertices, {mesh['triangle_count']:,} triangles",
        f"UV islands: {mesh['charts']}, seam edges: {mesh['seam_edges']}",
        f"Radius: {field['radius']:.4g}" + texels(field),
        f"Coverage: {100 * field['coverage_mean']:.2f} %",
        f"Undefined vertices: {field['undefined_vertices']:,}",
        f"Time: {field['seconds_total']:.2f} s ({stored['backend']})",
        *[f"– {words}: {field[name]:.2f} s" for name, words in STAGES if field.get(name, 0) > 0],
        *[f"Memory: about {field[name]:,.0f} MB" for name in ("memory_megabytes",) if field.get(name, 0) > 0],
        stored["device"],
    ]
    if stored["settings"].get("space") == "world":
        lines.append("Measured in the world")
    if field.get("crease_edges"):
        lines.append(f"Crease edges: {field['crease_edges']:,}")
    if field.get("private_layout"):
        cut = f", {field['cut_charts']:,} cut" if field.get("cut_charts") else ""
        lines.append("UV islands laid out afresh" + cut)
    lines += [f"{mesh[name]:,} {words}" for name, words in DEFECTS if mesh[name]]
    return lines


def texels(field: dict[str, float]) -> str:
    """The radius in texels, if a device used any."""
    return f" ({field['radius_in_texels']:.1f} texels)" if field["radius_in_texels"] > 0 else ""


classes = (PARADESC_PT_report,)
