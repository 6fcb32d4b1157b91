"""The panels of settings: descriptors, neighborhood, textures, quality and device; and for research, method."""

import bpy
from mathutils import Vector

from paradesc import bridge
from paradesc.core import devices, members, spaces

from ..scene import targets
from ..settings import preferences
from ..settings.translation import label
from .drawing import SettingsPanel, choice, setting

# Backends with baked buffers, whose size is a setting.
WITH_BUFFERS = {"gpu", "software"}
# Settings without effect unless samples are carried over seams.
CARRIED = {"max_jumps", "pattern", "ellipse"}
# Operators that have Gaussian windows over their map.
WINDOWED = {"difference_of_gaussians", "harris"}


class PARADESC_PT_descriptor(SettingsPanel, bpy.types.Panel):
    """The descriptors to compute"""

    bl_label = "Analysis"
    bl_idname = "PARADESC_PT_descriptor"
    bl_order = 0

    def draw_settings(self, _context: bpy.types.Context, layout: bpy.types.UILayout, settings: object) -> None:
        """Draws the registry in three groups, and the options of the chosen operators."""
        layout.use_property_split = False
        for title, rows in descriptor_groups():
            layout.label(text=label(title), translate=False)
            column = layout.column(align=True)
            if rows[0].map_degree:
                column.prop(settings, "map_descriptor", text="")
            for row in rows:
                choice(column, settings, "descriptors", row.name)
        chosen = settings.descriptors
        column = layout.column()
        column.use_property_split = True
        if chosen & WINDOWED:
            setting(column, settings, "map_sigma")
        if "harris" in chosen:
            setting(column, settings, "harris_k")
            setting(column, settings, "corner_threshold")


class PARADESC_PT_neighborhood(SettingsPanel, bpy.types.Panel):
    """The size and the space of the neighborhood"""

    bl_label = "Neighborhood"
    bl_idname = "PARADESC_PT_neighborhood"
    bl_order = 10

    def draw_settings(self, context: bpy.types.Context, layout: bpy.types.UILayout, settings: object) -> None:
        """Draws the radius's unit, its length, further radii, and the space."""
        column = layout.column(align=True)
        setting(column, settings, "radius_unit")
        target = targets.first(context)
        words = radius_words(context.scene, settings, target) if target is not None else ""
        if words:
            split = layout.split(factor=0.4)
            split.label(text="")
            split.label(text=words, translate=False)
        setting(layout, settings, "more_radii")
        setting(layout, settings, "space")
        if target is not None and target.data.shape_keys is not None:
            setting(layout, settings, "shape_key")


class PARADESC_PT_image(SettingsPanel, bpy.types.Panel):
    """Textures over the UV map"""

    bl_label = "Image"
    bl_idname = "PARADESC_PT_image"
    bl_order = 25

    def draw_settings(self, _context: bpy.types.Context, layout: bpy.types.UILayout, settings: object) -> None:
        """Draws size, outside, packing, use in materials, and the cage distance."""
        for name in ("texels", "image_outside", "image_packed", "image_to_material", "cage"):
            setting(layout, settings, name)


class PARADESC_PT_quality(SettingsPanel, bpy.types.Panel):
    """The accuracy and the device of the computation"""

    bl_label = "Quality and Device"
    bl_idname = "PARADESC_PT_quality"
    bl_order = 50

    def draw_settings(self, _context: bpy.types.Context, layout: bpy.types.UILayout, settings: object) -> None:
        """Draws samples, creases and device, and the settings that only graphics devices or research use."""
        for name in (*members.options("quality"), "material_maps"):
            if name != "buffer_size":
                setting(layout, settings, name)
        column = layout.column(align=True)
        column.label(text=label("Device"), translate=False)
        text = device_words(devices.label_of(settings.backend, settings.device_index))
        column.menu("PARADESC_MT_devices", text=text, translate=False)
        if settings.backend in WITH_BUFFERS or preferences.shows_research():
            setting(layout, settings, "buffer_size")


class PARADESC_MT_devices(bpy.types.Menu):
    """Devices that can compute here"""

    bl_idname = "PARADESC_MT_devices"
    bl_label = "Device"

    def draw(self, context: bpy.types.Context) -> None:
        """Draws every device; a backend without one is grey, and its tooltip says why."""
        settings = context.scene.paradesc
        current = (settings.backend, settings.device_index)
        for backend, index, name, there in [
            ("auto", -1, "Automatic", True),
            *((row.backend, row.index, row.label, not row.missing) for row in devices.found()),
        ]:
            row = self.layout.row()
            row.enabled = there
            icon = "CHECKMARK" if current == (backend, index) else "BLANK1"
            choice = row.operator("paradesc.choose_device", text=device_words(name), icon=icon, translate=False)
            choice.backend, choice.index = backend, index


class PARADESC_PT_method(SettingsPanel, bpy.types.Panel):
    """Choices that researchers want; the defaults are the most exact"""

    bl_label = "Method"
    bl_idname = "PARADESC_PT_method"
    bl_order = 51

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Works only if research settings are shown."""
        return super().poll(context) and preferences.shows_research()

    def draw_settings(self, _context: bpy.types.Context, layout: bpy.types.UILayout, settings: object) -> None:
        """Draws estimators, distance and evaluation; settings without effect under the present choices are grey."""
        by_choice = settings.relocation != "connected"
        carried = by_choice or settings.backend in WITH_BUFFERS
        for name in members.options("method"):
            row = layout.row()
            row.active = carried if name in CARRIED else by_choice or name != "geodesic"
            setting(row, settings, name)


def device_words(name: str) -> str:
    """The name of a device with its kind translated."""
    kind, colon, rest = name.partition(": ")
    return label(kind) + colon + rest


def descriptor_groups() -> list[tuple[str, list[bridge.Descriptor]]]:
    """The registry in groups, each with a title."""
    rows = bridge.descriptors()
    groups = [
        ("On the Surface", [row for row in rows if row.components == 1 and not row.map_degree]),
        ("Directions", [row for row in rows if row.components > 1]),
        ("Filters Of", [row for row in rows if row.components == 1 and row.map_degree]),
    ]
    return [(title, found) for title, found in groups if found]


def radius_words(scene: bpy.types.Scene, settings: bpy.types.PropertyGroup, target: bpy.types.Object) -> str:
    """The radius as a length in the scene; "" if the number says it already, or if the scale is uneven."""
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
    """A length with the scene's unit, as text."""
    units = scene.unit_settings
    if units.system == "NONE":
        return f"{length:.4g}"
    return bpy.utils.units.to_string(units.system, "LENGTH", length * units.scale_length, precision=3)


classes = (
    PARADESC_MT_devices,
    PARADESC_PT_descriptor,
    PARADESC_PT_neighborhood,
    PARADESC_PT_image,
    PARADESC_PT_quality,
    PARADESC_PT_method,
)
