"""Paradesc in Blender: masks and curvature as vertex colors, attributes and textures; live values; the sidebar's panels.

The package paradesc computes, reads and writes files, and has the command line. An extension brings it as a wheel. In a
checkout, and with Blender before 4.2, it lies beside this folder.
"""

import atexit
from importlib import import_module
from types import ModuleType

import bpy

# Blender before 4.2 reads this without running the file, so it holds literals only. Later versions read the manifest.
bl_info = {
    "name": "Paradesc",
    "author": "The Paradesc authors",
    "version": (0, 1, 0),
    "blender": (3, 4, 0),
    "location": "3D Viewport > Sidebar > Paradesc",
    "description": "Masks for dirt, worn edges and open places, and curvature: as vertex colors and textures",
    "category": "Mesh",
}

__version__ = ".".join(map(str, bl_info["version"]))

# The modules are listed in the order in which they depend on each other. settings/hooks.py says what each may have.
MODULES = (
    "settings.translation",
    "settings.asset_library",
    "settings.preferences",
    "settings.research",
    "settings.properties",
    "settings.animation",
    "settings.presets",
    "bake.modal",
    "scene.viewports",
    "scene.writing",
    "scene.strays",
    "bake.operators",
    "bake.fit",
    "scene.image_preview",
    "bake.image_operator",
    "bake.image_viewing",
    "bake.sculpt_mask",
    "ui.manual",
    "ui.panel",
    "ui.settings_panel",
    "ui.report_panel",
    "settings.looks",
    "show.recolor",
    "show.materials",
    "show.geometry_nodes",
    "show.wear_operators",
    "show.channels",
    "ui.looks_panel",
    "ui.menus",
    "show.overlay",
    "animation.pausing",
    "animation.live_settings",
    "animation.operators",
    "ui.animation_panel",
    "ui.live_panel",
    "animation.handlers",
    "source",
)


def check_version() -> None:
    """Raises unless the package paradesc is of this version. One that was loaded before an update stays until the end."""
    import paradesc

    from .ui import failure

    if paradesc.__version__ != __version__:
        found = f"Paradesc {__version__} finds the package paradesc {paradesc.__version__} ({paradesc.__path__[0]})"
        remedy = "restart Blender if you have just updated the add-on, else remove that package"
        raise failure.OtherVersionError(f"{found}; {remedy}.")


def modules() -> list[ModuleType]:
    """The modules that Blender has to know, which import bpy."""
    return [import_module(f".{name}", __name__) for name in MODULES]


def register() -> None:
    """Registers every module's classes, then its further additions; if an import fails, a stand-in that says why."""
    try:
        check_version()
        from .settings import hooks

        found = modules()
    except ImportError as error:
        from .ui import failure  # which needs nothing of the package

        failure.register(error)
        return
    for module in found:
        hooks.add(module)
    if not bpy.app.binary_path:
        atexit.unregister(end)
        atexit.register(end, [cls for module in found for cls in module.classes])


def unregister() -> None:
    """Undoes register(), in reverse order; does nothing if it was undone already."""
    from .ui import failure

    if failure.unregister() or not hasattr(bpy.types.Scene, "paradesc"):
        return
    from .settings import hooks

    for module in reversed(modules()):
        hooks.remove(module)


def end(classes: list[type]) -> None:
    """Unregisters everything: bpy would crash at exit if classes or properties with callbacks remained registered."""
    from .settings import hooks

    unregister()
    hooks.clear(classes)
