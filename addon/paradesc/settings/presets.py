"""Presets for common purposes, by one click each, and the user's own by Blender's preset system."""

from dataclasses import dataclass, field

import bpy
from bl_operators.presets import AddPresetBase

from .. import bridge
from . import properties

SUBFOLDER = "paradesc"
# These belong to the machine or to an object and not to a purpose, or say where results go.
NO_PRESET = {"backend", "device_index", "material_maps", "space", "shape_key"}


@dataclass(frozen=True)
class Preset:
    """Settings that differ from the defaults, and what they are for."""

    label: str
    purpose: str
    members: dict[str, object] = field(default_factory=dict)


# The first four are masks, which stand at the top of the panel.
PRESETS = {
    "cavity": Preset(
        "Cavity",
        "Grooves and dents, from 0 to 1: a mask for dirt, or to darken a color with",
        {"descriptors": {"cavity"}, "radius_percent": 2.0, "samples": 128},
    ),
    "edge_wear": Preset(
        "Edge Wear",
        "Edges and tips that stand out, from 0 to 1: a mask for worn paint or bare metal",
        {"descriptors": {"convexity"}, "radius_percent": 1.5, "samples": 128},
    ),
    "curvature": Preset(
        "Curvature",
        "Mean and Gaussian curvature, with sign: where and how strongly the surface bends",
        {"descriptors": {"mean_curvature", "gaussian_curvature"}, "radius_percent": 2.0},
    ),
    "openness": Preset(
        "Openness",
        "How open the space around each point is, 0.5 on a plane: a mask for dust, or for soft light and shade",
        {"descriptors": {"ambient_openness"}, "radius_percent": 5.0},
    ),
    "shape_classes": Preset(
        "Shape Classes",
        "Cup, rut, saddle, ridge or cap by the shape index, and how strongly so by the curvedness",
        {"descriptors": {"shape_index", "curvedness"}, "radius_percent": 3.0},
    ),
    "corners": Preset(
        "Corners",
        "Corner points: the Harris response, and 1 at each corner in harris_corner",
        {"descriptors": {"harris"}, "radius_percent": 3.0, "samples": 64},
    ),
}


MASKS = ("cavity", "edge_wear", "curvature", "openness")


def chosen_mask(group: bpy.types.PropertyGroup) -> str:
    """The mask whose descriptors are chosen, or ""."""
    return next((name for name in MASKS if PRESETS[name].members["descriptors"] == group.descriptors), "")


def members() -> list[str]:
    """Names of the settings that a preset sets."""
    groups = [group for group in properties.GROUPS if group != properties.output_members]
    return [name for group in groups for name in group() if name not in NO_PRESET]


def apply(group: bpy.types.PropertyGroup, name: str) -> Preset:
    """Applies one of our presets. Members of presets that it does not name get their default; other settings stay."""
    preset = PRESETS[name]
    for member in members():
        group.property_unset(member)
    for member, value in preset.members.items():
        setattr(group, member, value)
    return preset


class PARADESC_OT_preset(bpy.types.Operator):
    """Set descriptors, radius and quality for a purpose"""

    bl_idname = "paradesc.preset"
    bl_label = "Apply Preset"
    bl_options = {"REGISTER", "UNDO", "INTERNAL"}

    name: bpy.props.EnumProperty(
        name="Preset",
        description="What the settings are for",
        items=[(name, preset.label, preset.purpose) for name, preset in PRESETS.items()],
    )

    @classmethod
    def description(cls, _context: bpy.types.Context, asked: bpy.types.OperatorProperties) -> str:
        """What the preset is for."""
        return PRESETS[asked.name].purpose

    @classmethod
    def poll(cls, _context: bpy.types.Context) -> bool:
        """Needs the native library, whose descriptors a preset chooses."""
        return not bridge.missing_sentence()

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Applies the preset, and says what it is for."""
        preset = apply(context.scene.paradesc, self.name)
        PARADESC_MT_presets.bl_label = preset.label
        self.report({"INFO"}, f"{preset.label}: {preset.purpose}")
        return {"FINISHED"}


class PARADESC_MT_presets(bpy.types.Menu):
    """Settings for a purpose"""

    bl_idname = "PARADESC_MT_presets"
    bl_label = "Presets"
    preset_subdir = SUBFOLDER
    preset_operator = "script.execute_preset"

    def draw(self, context: bpy.types.Context) -> None:
        """Draws our presets, then the user's own."""
        for name, preset in PRESETS.items():
            self.layout.operator("paradesc.preset", text=preset.label).name = name
        if bpy.utils.preset_paths(SUBFOLDER):
            self.layout.separator()
            bpy.types.Menu.draw_preset(self, context)


class PARADESC_OT_add_preset(AddPresetBase, bpy.types.Operator):
    """Keep these settings as a preset of your own, or remove the one that was chosen last"""

    bl_idname = "paradesc.add_preset"
    bl_label = "Add Preset"
    preset_menu = "PARADESC_MT_presets"
    preset_subdir = SUBFOLDER
    preset_defines = ["paradesc = bpy.context.scene.paradesc"]

    @property
    def preset_values(self) -> list[str]:
        """The settings that a preset keeps."""
        return [f"paradesc.{name}" for name in members()]


classes = (PARADESC_OT_preset, PARADESC_MT_presets, PARADESC_OT_add_preset)


def unregister() -> None:
    """Forgets which preset was chosen last."""
    PARADESC_MT_presets.bl_label = "Presets"
