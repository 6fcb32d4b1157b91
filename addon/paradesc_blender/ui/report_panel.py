"""The panel with the facts about the last bake of the chosen mesh."""

import bpy

from ..scene import record, targets
from ..settings.translation import label
from ..show import recolor
from .drawing import SettingsPanel, descriptor_words, sentence_lines

# Mesh defects, each of which has a line if there are any: the member of the mesh report, and words for people.
DEFECTS = (
    ("loose_vertices", "{loose_vertices:,} vertices without a face"),
    ("degenerate_triangles", "{degenerate_triangles:,} triangles without area"),
    ("copied_triangles", "{copied_triangles:,} triangles at the places of others"),
    ("zero_uv_area_triangles", "{zero_uv_area_triangles:,} triangles without UV area"),
    ("flipped_triangles", "{flipped_triangles:,} flipped triangles"),
    ("nonmanifold_edges", "{nonmanifold_edges:,} non-manifold edges"),
    ("nonmanifold_vertices", "{nonmanifold_vertices:,} non-manifold vertices"),
)
# The costs of a bake: the member of the field report, and words for people.
STAGES = (
    ("seconds_prepare", "– preparing: {seconds_prepare:.2f} s"),
    ("seconds_bake", "– drawing buffers: {seconds_bake:.2f} s"),
    ("seconds_evaluate", "– measuring: {seconds_evaluate:.2f} s"),
    ("memory_megabytes", "Memory: about {memory_megabytes:,.0f} MB"),
)


class PARADESC_PT_report(SettingsPanel, bpy.types.Panel):
    """The findings of the last bake of this mesh"""

    bl_label = "Last Bake"
    bl_idname = "PARADESC_PT_report"
    bl_order = 60

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Works only if the mesh was baked."""
        return bool(stored_report(targets.first(context)))

    def draw_settings(self, context: bpy.types.Context, layout: bpy.types.UILayout, _settings: object) -> None:
        """Draws one line for each fact, then the notes. Warnings are under the bake button."""
        column = layout.column(align=True)
        target = targets.first(context)
        stored = stored_report(target)
        for fact in [*report_lines(stored), *range_lines(target.data, stored)]:
            sentence_lines(context, column, fact)
        for sentence in stored["notes"].splitlines():
            sentence_lines(context, column, sentence, "INFO")


def stored_report(target: bpy.types.Object | None) -> dict[str, dict]:
    """The record of the last bake of an object's mesh; empty if there was none, or if its values are gone."""
    stored = record.read(target.data) if target is not None else {}
    if "mesh_report" not in stored:
        return {}  # the frames of a cache have no report
    left = stored["attributes"]  # the list outlives an undo in edit mode, the attributes do not
    return stored if any(name in target.data.attributes for name in left) else {}


def report_lines(stored: dict[str, dict]) -> list[str]:
    """The facts about one bake, as lines."""
    mesh, field = stored["mesh_report"], stored["field_report"]
    in_texels = field["radius_in_texels"] > 0  # otherwise the bake used none
    texels = label(" ({radius_in_texels:.1f} texels)").format(**field) if in_texels else ""
    lines = [
        label("{vertices:,} vertices, {triangles:,} triangles").format(
            vertices=mesh["vertex_count"], triangles=mesh["triangle_count"]
        ),
        label("UV islands: {charts}, seam edges: {seam_edges}").format(**mesh),
        label("Radius: {radius:.4g}").format(**field) + texels,
        label("Coverage: {percent:.2f} %").format(percent=100 * field["coverage_mean"]),
        label("Undefined vertices: {undefined_vertices:,}").format(**field),
        label("Time: {seconds_total:.2f} s ({backend})").format(**{**field, "backend": stored["backend"]}),
        *[label(line).format(**field) for name, line in STAGES if field.get(name, 0) > 0],
        stored["device"],
    ]
    if stored["settings"].get("space") == "world":
        lines.append(label("Measured in the world"))
    if field.get("crease_edges"):
        lines.append(label("Crease edges: {crease_edges:,}").format(**field))
    if field.get("private_layout"):
        cut = (
            "UV islands laid out afresh, {cut_charts:,} cut"
            if field.get("cut_charts")
            else "UV islands laid out afresh"
        )
        lines.append(label(cut).format(**field))
    lines += [label(line).format(**mesh) for name, line in DEFECTS if mesh.get(name)]
    return lines


def range_lines(mesh: bpy.types.Mesh, stored: dict[str, dict]) -> list[str]:
    """Lines about the values at both ends of the colors of each descriptor: a mask's legend reads from 0 to 1."""
    line, ranges = label("{what}: colors from {low} to {high}"), stored["ranges"]
    names = [name for name in recolor.baked_names(mesh) if name in ranges and not recolor.is_direction(name)]
    ends = ((descriptor_words(name), *(f"{end:.3g}" for end in ranges[name])) for name in names)
    return [line.format(what=what, low=low, high=high) for what, low, high in ends]


classes = (PARADESC_PT_report,)
