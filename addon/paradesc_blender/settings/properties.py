"""The settings kept in a scene: Blender's properties, made of the members that core/members.py defines."""

import bpy

from paradesc.core import choices, members
from paradesc.core.job import Settings
from paradesc.core.members import Member

from . import hooks, preferences, translation

RADII = ("radius_percent", "radius_absolute", "radius_edges")
PROPERTIES = {
    "bool": bpy.props.BoolProperty,
    "int": bpy.props.IntProperty,
    "float": bpy.props.FloatProperty,
    "text": bpy.props.StringProperty,
    "choice": bpy.props.EnumProperty,
    "choices": bpy.props.EnumProperty,
}
PATHS = ("FILE_PATH", "DIR_PATH")


def path_options() -> set[str]:
    """The option for paths in which // stands for the .blend's folder, which Blender requires since 4.5."""
    known = "is_path_supports_blend_relative" in bpy.types.Property.bl_rna.properties
    return {"PATH_SUPPORTS_BLEND_RELATIVE"} if known else set()


def property_of(member: Member, **more: object) -> object:
    """Blender's property for a setting; more: further options of the property, such as update."""
    words = {**member.words, **more}
    if member.kind == "choices":
        words["options"] = {"ENUM_FLAG"}
    elif words.get("subtype") in PATHS:
        words["options"] = words.get("options", set()) | path_options()
    return PROPERTIES[member.kind](**words)


# Not empty while a fitted radius is being set, which therefore does not count as typed.
showing: list[bool] = []


def typed(group: bpy.types.PropertyGroup, _context: bpy.types.Context) -> None:
    """Marks the radius as typed when somebody changes it, so that it stays for other meshes."""
    if not showing and group.radius_fit != "typed":
        group.radius_fit = "typed"


def show_radius(group: bpy.types.PropertyGroup, settings: Settings) -> None:
    """Shows the radius that a bake has fitted; the next bake still fits its own."""
    options = settings.options
    if group.radius_fit == "typed" or options.radius_unit != group.radius_unit:
        return
    showing.append(True)
    try:
        radius = 100 * options.radius if options.radius_unit == "diagonal" else options.radius
        setattr(group, choices.radius_member(group), radius)
    finally:
        showing.clear()


def job_settings(group: bpy.types.PropertyGroup) -> Settings:
    """A scene's settings for the computation, with the memory limit of the preferences."""
    return choices.settings_of(group, preferences.memory_limit())


# register() creates the class of the settings, as that needs the native library.
classes = ()


def register() -> None:
    """Adds the settings to every scene."""
    every = [(name, member) for group in members.GROUPS for name, member in group().items()]
    annotations = {name: property_of(member, **({"update": typed} if name in RADII else {})) for name, member in every}
    body = {"__annotations__": annotations, "__doc__": "Paradesc's settings of one scene.", "__module__": __name__}
    settings = translation.in_our_context(type("PARADESC_PG_settings", (bpy.types.PropertyGroup,), body))
    bpy.utils.register_class(settings)
    bpy.types.Scene.paradesc = bpy.props.PointerProperty(type=settings)


def unregister() -> None:
    """Removes the settings."""
    del bpy.types.Scene.paradesc
    settings = bpy.types.PropertyGroup.bl_rna_get_subclass_py("PARADESC_PG_settings")
    bpy.utils.unregister_class(settings)
    hooks.clear([settings])
