"""The sidebar panel: settings, the bake button, and the report of what the active mesh carries."""

import bpy

from . import bridge, mesh_io, properties

# Mesh defects worth a line each when there are any: member of the mesh report, words for people.
DEFECTS = (
    ("loose_vertices", "vertices without a face"),
    ("degenerate_triangles", "triangles without area"),
    ("zero_uv_area_triangles", "triangles without UV area"),
    ("flipped_triangles", "flipped triangles"),
    ("nonmanifold_edges", "non-manifold edges"),
    ("nonmanifold_vertices", "non-manifold vertices"),
)


class SidebarPanel:
    """Where all panels are: the Paradesc tab of the 3D viewport's sidebar."""

    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Paradesc"


class PARADESC_PT_bake(SidebarPanel, bpy.types.Panel):
    """What to compute, and the button"""

    bl_label = "Paradesc"
    bl_idname = "PARADESC_PT_bake"

    def draw(self, context: bpy.types.Context) -> None:
        """Descriptors, radius, button."""
        layout = self.layout
        missing = bridge.missing_sentence()
        if missing:
            for line in wrapped(missing, 36):
                layout.label(text=line, icon="ERROR" if missing.startswith(line) else "BLANK1")
            return
        settings = context.scene.paradesc
        layout.label(text="Descriptors (Shift: several)")
        layout.column(align=True).prop(settings, "descriptors")
        column = layout.column(align=True)
        column.prop(settings, properties.radius_member(settings))
        column.prop(settings, "radius_unit", text="")
        layout.operator("paradesc.bake", icon="SHADING_TEXTURE")


class PARADESC_PT_quality(SidebarPanel, bpy.types.Panel):
    """How to compute"""

    bl_label = "Quality and Device"
    bl_idname = "PARADESC_PT_quality"
    bl_order = 20
    bl_parent_id = "PARADESC_PT_bake"

    def draw(self, context: bpy.types.Context) -> None:
        """Samples, buffers, normals, device."""
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        settings = context.scene.paradesc
        for name in (
            "samples",
            "adaptive",
            "buffer_size",
            "precision",
            "normals",
            "material_maps",
            "backend",
            "device_index",
        ):
            layout.prop(settings, name)
        note = bridge.without_devices()
        for line in wrapped(note, 36) if note else []:
            layout.label(text=line, icon="INFO" if note.startswith(line) else "BLANK1")


class PARADESC_PT_method(SidebarPanel, bpy.types.Panel):
    """Choices that researchers want; the defaults are the most exact"""

    bl_label = "Method"
    bl_idname = "PARADESC_PT_method"
    bl_order = 30
    bl_parent_id = "PARADESC_PT_bake"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        """Estimators, distance, evaluation; what belongs to one choice only is grey with the others."""
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        settings = context.scene.paradesc
        carried = settings.relocation != "connected"
        for name, active in (
            ("estimator", True),
            ("variance_reduction", True),
            ("distance", True),
            ("evaluate", True),
            ("texels", settings.evaluate == "texel"),
            ("relocation", True),
            ("max_jumps", carried),
            ("pattern", carried),
            ("ellipse", carried),
            ("geodesic", carried),
        ):
            row = layout.row()
            row.active = active
            row.prop(settings, name)


class PARADESC_PT_report(SidebarPanel, bpy.types.Panel):
    """What the last bake of this mesh found"""

    bl_label = "Last Run"
    bl_idname = "PARADESC_PT_report"
    bl_order = 60
    bl_parent_id = "PARADESC_PT_bake"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Only where there was one."""
        target = context.active_object
        return target is not None and target.type == "MESH" and bool(mesh_io.stored_summary(target.data))

    def draw(self, context: bpy.types.Context) -> None:
        """One line a fact, warnings below."""
        column = self.layout.column(align=True)
        stored = mesh_io.stored_summary(context.active_object.data)
        for line in report_lines(stored):
            column.label(text=line)
        shading = context.space_data.shading
        if shading.type == "SOLID" and shading.color_type != "VERTEX":
            column.label(text="Colors show with the viewport's", icon="INFO")
            column.label(text="Color set to Attribute:", icon="BLANK1")
            column.prop(shading, "color_type", text="")
        for sentence in stored["warnings"].splitlines():
            for index, line in enumerate(wrapped(sentence, 36)):
                column.label(text=line, icon="BLANK1" if index else "ERROR")


def report_lines(stored: dict[str, dict]) -> list[str]:
    """The facts of one bake, as lines."""
    mesh, field = stored["mesh_report"], stored["field_report"]
    lines = [
        f"{mesh['vertex_count']:,} vertices, {mesh['triangle_count']:,} triangles",
        f"Charts: {mesh['charts']}, seam edges: {mesh['seam_edges']}",
        f"Radius: {field['radius']:.4g}" + texels(field),
        f"Coverage: {100 * field['coverage_mean']:.2f} %",
        f"Undefined vertices: {field['undefined_vertices']:,}",
        f"Time: {field['seconds_total']:.2f} s ({stored['backend']})",
        *wrapped(stored["device"], 36),
    ]
    if field.get("private_layout"):
        cut = f", {field['cut_charts']:,} cut" if field.get("cut_charts") else ""
        lines.append("Charts laid out afresh" + cut)
    lines += [f"{mesh[name]:,} {words}" for name, words in DEFECTS if mesh[name]]
    return lines


def texels(field: dict[str, float]) -> str:
    """The radius in texels, where a device had any."""
    return f" ({field['radius_in_texels']:.1f} texels)" if field["radius_in_texels"] > 0 else ""


def wrapped(sentence: str, width: int) -> list[str]:
    """The sentence in lines of at most width characters: Blender's labels do not wrap."""
    lines = [""]
    for word in sentence.split():
        if lines[-1] and len(lines[-1]) + len(word) >= width:
            lines.append("")
        lines[-1] = f"{lines[-1]} {word}".strip()
    return lines


classes = (PARADESC_PT_bake, PARADESC_PT_quality, PARADESC_PT_method, PARADESC_PT_report)
