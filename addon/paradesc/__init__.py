"""Paradesc: curvature and other geometric descriptors of meshes at a radius, as attributes, colors and textures.

Importing the package imports no part of Blender; register() does. compute() and what else `__all__` names are the
Python package (api.py), which is imported with the first of these names.
"""

import atexit
import sys
from importlib import import_module
from types import ModuleType
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .api import (
        Descriptor,
        InputError,
        Mask,
        Mesh,
        ParadescError,
        ParadescWarning,
        Profile,
        Result,
        compute,
        descriptors,
        profile,
    )

__all__ = [
    "Descriptor", "InputError", "Mask", "Mesh", "ParadescError", "ParadescWarning", "Profile", "Result",
    "compute", "descriptors", "profile",
]  # fmt: skip

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

# After an update within a session Blender before 4.2 reads this file again, but not the modules behind it.
for _name in [name for name in sys.modules if name.startswith(__name__ + ".")]:
    del sys.modules[_name]

# The modules are listed in the order in which they depend on each other. Each has a tuple of classes, and register()
# and unregister() if it needs more.
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
    "ui.image_panel",
    "settings.looks",
    "show.recolor",
    "show.materials",
    "show.geometry_nodes",
    "show.wear_operators",
    "show.channels",
    "show.copies",
    "ui.wear_panel",
    "ui.looks_panel",
    "ui.menus",
    "show.overlay",
    "animation.pausing",
    "animation.live_settings",
    "animation.operators",
    "ui.animation_panel",
    "ui.live_panel",
    "animation.handlers",
    "commands.cli_command",
)


def __getattr__(name: str) -> object:
    """Imports the public names of api.py on first use. They are not cached here, as Blender may run this file again."""
    if name in __all__:
        return getattr(import_module(".api", __name__), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted({*__all__, *(name for name in globals() if name.startswith("__"))})


def modules() -> list[ModuleType]:
    """The modules that Blender has to know, which import bpy."""
    return [import_module(f".{name}", __name__) for name in MODULES]


def register() -> None:
    """Registers every module's classes, then its further additions; if an import fails, a stand-in that says why."""
    import bpy

    try:
        found = modules()
    except ImportError as error:
        from .ui import failure

        failure.register(error)
        return
    in_our_context = import_module(".settings.translation", __name__).in_our_context
    for module in found:
        for cls in module.classes:
            bpy.utils.register_class(in_our_context(cls))
        if hasattr(module, "register"):
            module.register()
    if not bpy.app.binary_path:
        atexit.unregister(end)
        atexit.register(end, [cls for module in found for cls in module.classes])


def unregister() -> None:
    """Undoes register(), in reverse order; does nothing if it was undone already."""
    import bpy

    from .ui import failure

    if failure.unregister() or not hasattr(bpy.types.Scene, "paradesc"):
        return
    for module in reversed(modules()):
        if hasattr(module, "unregister"):
            module.unregister()
        for cls in reversed(module.classes):
            bpy.utils.unregister_class(cls)


def end(classes: list[type]) -> None:
    """Unregisters everything: bpy would crash at exit if classes or properties with callbacks remained registered."""
    from .settings.leaving import clear

    unregister()
    clear(classes)
