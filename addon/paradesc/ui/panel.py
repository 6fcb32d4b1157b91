"""The sidebar panel: presets, settings, the bake button, and the report of what the active mesh carries."""

import bpy
from mathutils import Vector

from .. import bridge
from ..bake.modal import ModalJob, Steps, progress_text
from ..core import devices, spaces
from ..scene import record, targets
from ..settings import presets, properties

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
# Operators that look at their map through Gaussian windows.
WINDOWED = {"difference_of_gaussians", "harris"}
# Widths in the sidebar, in pixels at Blender's own scale: a character, what lies beside the text, an icon.
CHARACTER, MARGIN, ICON = 5.5, 46, 28


class SidebarPanel:
    """The place of all panels: the Paradesc tab of the 3D viewport's sidebar."""

    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Paradesc"


class PARADESC_PT_bake(SidebarPanel, bpy.types.Panel):
    """Presets, and the button"""

    bl_label = "Paradesc"
    bl_idname = "PARADESC_PT_bake"

    def draw_header_preset(self, _context: bpy.types.Context) -> None:
        """Draws the button for the manual at the right end of the panel's header."""
        self.layout.operator("paradesc.manual", text="", icon="QUESTION", emboss=False)

    def draw(self, context: bpy.types.Context) -> None:
        """Draws preset, button, progress, and what stands in the way."""
        layout = self.layout
        missing = bridge.missing_sentence()
        if missing:
            sentence_lines(context, layout, missing, "ERROR")
            return
        row = layout.row(align=True)
        row.menu("PARADESC_MT_presets", text=presets.PARADESC_MT_presets.bl_label)
        row.operator("paradesc.add_preset", text="", icon="ADD")
        row.operator("paradesc.add_preset", text="", icon="REMOVE").remove_active = True
        running = ModalJob.running
        if running:
            draw_progress(context, layout, running)
            return
        chosen = targets.chosen(context)
        column = layout.column()
        column.scale_y = 1.3
        column.operator("paradesc.bake", text=button_text(len(targets.by_mesh(chosen))), icon="SHADING_TEXTURE")
        sentence = targets.obstacle(context)
        if sentence:
            sentence_lines(context, layout, sentence, "INFO")
        if any(targets.unwritable(target) for target in chosen):
            layout.operator("paradesc.make_local", icon="LINK_BLEND")


class SettingsPanel(SidebarPanel):
    """A sub-panel of settings."""

    bl_parent_id = "PARADESC_PT_bake"

    @classmethod
    def poll(cls, _context: bpy.types.Context) -> bool:
        """Needs the native library, which has the descriptors."""
        return not bridge.missing_sentence()

    def draw(self, context: bpy.types.Context) -> None:
        """Draws in Blender's two columns, without the dots for animation."""
        self.layout.use_property_split = True
        self.layout.use_property_decorate = False
        self.draw_settings(context, self.layout, context.scene.paradesc)


class PARADESC_PT_descriptor(SettingsPanel, bpy.types.Panel):
    """What to compute"""

    bl_label = "Descriptor"
    bl_idname = "PARADESC_PT_descriptor"
    bl_order = 0

    def draw_settings(self, context: bpy.types.Context, layout: bpy.types.UILayout, settings: object) -> None:
        """Draws the registry in three groups, and the options of the chosen operators."""
        layout.use_property_split = False
        for title, rows in descriptor_groups():
            layout.label(text=title)
            column = layout.column(align=True)
            if rows[0].map_degree:
                column.prop(settings, "map_descriptor", text="")
            for row in rows:
                column.prop_enum(settings, "descriptors", row.name)
        chosen = settings.descriptors
        column = layout.column()
        column.use_property_split = True
        if chosen & WINDOWED:
            column.prop(settings, "map_sigma")
        if "harris" in chosen:
            column.prop(settings, "harris_k")
            column.prop(settings, "corner_threshold")


class PARADESC_PT_neighborhood(SettingsPanel, bpy.types.Panel):
    """How far a vertex looks around"""

    bl_label = "Neighborhood"
    bl_idname = "PARADESC_PT_neighborhood"
    bl_order = 10

    def draw_settings(self, context: bpy.types.Context, layout: bpy.types.UILayout, settings: object) -> None:
        """Draws radius and unit, what that is as a length, further radii, and the space."""
        column = layout.column(align=True)
        column.prop(settings, properties.radius_member(settings))
        column.prop(settings, "radius_unit")
        target = next(iter(targets.chosen(context)), None)
        words = radius_words(context.scene, settings, target) if target is not None else ""
        if words:
            split = layout.split(factor=0.4)
            split.label(text="")
            split.label(text=words)
        layout.prop(settings, "more_radii")
        layout.prop(settings, "space")
        if target is not None and target.data.shape_keys is not None:
            layout.prop(settings, "shape_key")
        if target is not None and settings.space == "object" and not spaces.is_even(target.matrix_world):
            sentence = "The object is scaled unevenly: measure in World, or apply the scale"
            sentence_lines(context, layout, sentence, "INFO")


class PARADESC_PT_quality(SettingsPanel, bpy.types.Panel):
    """How exactly to compute, and on what"""

    bl_label = "Quality and Device"
    bl_idname = "PARADESC_PT_quality"
    bl_order = 20

    def draw_settings(self, context: bpy.types.Context, layout: bpy.types.UILayout, settings: object) -> None:
        """Draws samples, buffers, normals, creases and device."""
        for name in ("samples", "adaptive", "buffer_size", "precision", "normals", "creases", "material_maps"):
            layout.prop(settings, name)
        split = layout.split(factor=0.4)
        column = split.column()
        column.alignment = "RIGHT"
        column.label(text="Device")
        split.menu("PARADESC_MT_devices", text=devices.label_of(settings.backend, settings.device_index))


class PARADESC_MT_devices(bpy.types.Menu):
    """What can compute here"""

    bl_idname = "PARADESC_MT_devices"
    bl_label = "Device"

    def draw(self, context: bpy.types.Context) -> None:
        """Draws every device; a backend without one is grey, and its tooltip says why."""
        settings = context.scene.paradesc
        current = (settings.backend, settings.device_index)
        for backend, index, label, there in [
            ("auto", -1, "Automatic", True),
            *((row.backend, row.index, row.label, not row.missing) for row in devices.found()),
        ]:
            row = self.layout.row()
            row.enabled = there
            icon = "CHECKMARK" if current == (backend, index) else "BLANK1"
            choice = row.operator("paradesc.choose_device", text=label, icon=icon)
            choice.backend, choice.index = backend, index


class PARADESC_PT_method(SettingsPanel, bpy.types.Panel):
    """Choices that researchers want; the defaults are the most exact"""

    bl_label = "Method"
    bl_idname = "PARADESC_PT_method"
    bl_order = 30
    bl_options = {"DEFAULT_CLOSED"}

    def draw_settings(self, context: bpy.types.Context, layout: bpy.types.UILayout, settings: object) -> None:
        """Draws estimators, distance and evaluation; what belongs to one choice is grey with the others."""
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
            ("seed", True),
        ):
            row = layout.row()
            row.active = active
            row.prop(settings, name)


class PARADESC_PT_output(SettingsPanel, bpy.types.Panel):
    """Where results go"""

    bl_label = "Output"
    bl_idname = "PARADESC_PT_output"
    bl_order = 35
    bl_options = {"DEFAULT_CLOSED"}

    def draw_settings(self, context: bpy.types.Context, layout: bpy.types.UILayout, settings: object) -> None:
        """Draws attributes, images and buffers, each with its options."""
        layout.use_property_split = False
        layout.prop(settings, "write_attributes")
        for name, members in (
            ("write_image", ("image_format", "texels", "image_path")),
            ("write_buffers", ("buffers_path",)),
        ):
            layout.prop(settings, name)
            if getattr(settings, name):
                column = layout.column(align=True)
                for member in members:
                    column.prop(settings, member, text="" if member.endswith("path") else None)


class PARADESC_PT_report(SidebarPanel, bpy.types.Panel):
    """What the last bake of this mesh found"""

    bl_label = "Last Run"
    bl_idname = "PARADESC_PT_report"
    bl_order = 60
    bl_parent_id = "PARADESC_PT_bake"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Shows only if there was a bake."""
        target = context.active_object
        if target is None or target.type != "MESH" or "mesh_report" not in record.read(target.data):
            return False  # frames of a cache have no report
        left = record.attributes_of(target.data)  # the list outlives an undo in edit mode, the attributes do not
        return any(name in target.data.attributes for name in left)

    def draw(self, context: bpy.types.Context) -> None:
        """Draws one line for each fact, and warnings below."""
        column = self.layout.column(align=True)
        stored = record.read(context.active_object.data)
        for fact in report_lines(stored):
            for line in wrapped(fact, line_length(context)):
                column.label(text=line)
        shading = context.space_data.shading
        if shading.type == "SOLID" and shading.color_type != "VERTEX":
            sentence_lines(context, column, "Colors show with the viewport's Color set to Attribute:", "INFO")
            column.prop(shading, "color_type", text="")
        for sentence in stored["warnings"].splitlines():
            sentence_lines(context, column, sentence, "ERROR")


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
        lines.append("Charts laid out afresh" + cut)
    lines += [f"{mesh[name]:,} {words}" for name, words in DEFECTS if mesh[name]]
    return lines


def descriptor_groups() -> list[tuple[str, list[bridge.Descriptor]]]:
    """The registry in groups with a title each, which follow from what the registry says."""
    rows = bridge.descriptors()
    groups = [
        ("Of the Surface, Any Number", [row for row in rows if row.components == 1 and not row.map_degree]),
        ("Directions", [row for row in rows if row.components > 1]),
        ("Operators on the Map Of", [row for row in rows if row.components == 1 and row.map_degree]),
    ]
    return [(title, found) for title, found in groups if found]


def button_text(count: int) -> str:
    """The text of the button for so many meshes."""
    return f"Bake {count} Meshes" if count > 1 else "Bake Descriptors"


def draw_progress(context: bpy.types.Context, layout: bpy.types.UILayout, running: Steps) -> None:
    """Draws how far the work is; Blender has a bar for it since 4.0."""
    if hasattr(layout, "progress"):
        layout.progress(factor=running.fraction, text=f"{running.fraction:.0%}", type="BAR")
    sentence_lines(context, layout, f"{progress_text(running)} (Esc cancels)", "SORTTIME")


def radius_words(scene: bpy.types.Scene, settings: bpy.types.PropertyGroup, target: bpy.types.Object) -> str:
    """The radius as a length in the scene, unless the number says it or the scale is uneven; then ""."""
    in_world = settings.space == "world"
    if not spaces.is_even(target.matrix_world) or settings.radius_unit == "mean-edge":
        return ""
    scale = float(spaces.scales(target.matrix_world).mean())
    if settings.radius_unit == "absolute":
        if in_world or abs(scale - 1) < spaces.EVEN:
            return ""
        return "= " + length_words(scene, settings.radius_absolute * scale)
    low, high = Vector(target.bound_box[0]), Vector(target.bound_box[6])
    return "≈ " + length_words(scene, settings.radius_percent / 100 * (high - low).length * scale)


def length_words(scene: bpy.types.Scene, length: float) -> str:
    """A length in words, in the units of the scene."""
    units = scene.unit_settings
    if units.system == "NONE":
        return f"{length:.4g}"
    return bpy.utils.units.to_string(units.system, "LENGTH", length * units.scale_length, precision=3)


def sentence_lines(context: bpy.types.Context, layout: bpy.types.UILayout, sentence: str, icon: str) -> None:
    """Draws a sentence in lines, the first with an icon."""
    column = layout.column(align=True)
    for index, line in enumerate(wrapped(sentence, line_length(context, ICON))):
        column.label(text=line, icon="BLANK1" if index else icon)


def line_length(context: bpy.types.Context, taken: int = 0) -> int:
    """How many characters fit beside each other at the present width of the sidebar."""
    width = context.region.width / context.preferences.system.ui_scale
    return max(int((width - MARGIN - taken) / CHARACTER), 16)


def texels(field: dict[str, float]) -> str:
    """The radius in texels, if a device used any."""
    return f" ({field['radius_in_texels']:.1f} texels)" if field["radius_in_texels"] > 0 else ""


def wrapped(sentence: str, width: int) -> list[str]:
    """The sentence in lines of at most width characters: Blender's labels do not wrap."""
    lines = [""]
    for word in sentence.split():
        if lines[-1] and len(lines[-1]) + len(word) >= width:
            lines.append("")
        lines[-1] = f"{lines[-1]} {word}".strip()
    return lines


classes = (
    PARADESC_MT_devices,
    PARADESC_PT_bake,
    PARADESC_PT_descriptor,
    PARADESC_PT_neighborhood,
    PARADESC_PT_quality,
    PARADESC_PT_method,
    PARADESC_PT_output,
    PARADESC_PT_report,
)
