"""The settings kept in a scene: Blender's properties, made of the members that core/members.py defines."""

import bpy

from ..core import choices, members
from ..core.job import Settings
from ..core.members import Member
from . import leaving, preferences, translation

# The defaults that a scene's settings were made with: files before version 1 have none stored, and those before version 2
# know no radius that follows from the mesh.
VERSION = 2
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
    """The option that // stands for the .blend's folder, which Blender needs since 4.5."""
    known = "is_path_supports_blend_relative" in bpy.types.Property.bl_rna.properties
    return {"PATH_SUPPORTS_BLEND_RELATIVE"} if known else set()


def property_of(member: Member, **more: object) -> object:
    """Blender's property of a setting; more: words that are Blender's alone, such as update."""
    words = {**member.words, **more}
    if member.kind == "choices":
        words["options"] = {"ENUM_FLAG"}
    elif words.get("subtype") in PATHS:
        words["options"] = path_options()
    return PROPERTIES[member.kind](**words)


def make_settings() -> type:
    """Makes the class of the settings, with the registry as it is now."""
    every = [(name, member) for group in members.GROUPS for name, member in group().items()]
    annotations = {name: property_of(member, update=typed if name in RADII else stamp) for name, member in every}
    annotations["version"] = bpy.props.IntProperty(
        name="Version", description="The defaults that files were saved with", default=0, options={"HIDDEN"}
    )
    body = {"__annotations__": annotations, "__doc__": "Paradesc's settings of one scene.", "__module__": __name__}
    return type("PARADESC_PG_settings", (bpy.types.PropertyGroup,), body)


def stamp(group: bpy.types.PropertyGroup, _context: bpy.types.Context) -> None:
    """Notes beside the first setting that is stored which defaults the others have.

    No save handler does so: Blender saves for recovery, and appends scenes, without calling any.
    """
    if group.version < VERSION:
        group.version = VERSION


# The scene's radius is being set to what was fitted, which nobody has typed.
showing: list[bool] = []


def typed(group: bpy.types.PropertyGroup, context: bpy.types.Context) -> None:
    """Keeps a radius that somebody has typed, from one mesh to the next."""
    stamp(group, context)
    if not showing and group.radius_fit != "typed":
        group.radius_fit = "typed"


def show_radius(group: bpy.types.PropertyGroup, settings: Settings) -> None:
    """Shows the radius that a bake has fitted; the next one still fits its own."""
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
    """A scene's settings as the computation takes them, within the memory that the preferences allow."""
    return choices.settings_of(group, preferences.memory_limit())


# register() makes the class of the settings, once the native library is in place.
classes = ()


def register() -> None:
    """Gives every scene its settings."""
    settings = translation.in_our_context(make_settings())
    bpy.utils.register_class(settings)
    bpy.types.Scene.paradesc = bpy.props.PointerProperty(type=settings)


def unregister() -> None:
    """Removes them."""
    del bpy.types.Scene.paradesc
    settings = bpy.types.PropertyGroup.bl_rna_get_subclass_py("PARADESC_PG_settings")
    bpy.utils.unregister_class(settings)
    leaving.clear([settings])
