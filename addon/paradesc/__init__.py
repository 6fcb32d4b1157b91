"""Paradesc: geometric descriptors of UV-mapped meshes as attributes and colors, computed in texture space.

Importing the package imports no part of Blender; register() does.
"""

# Read by Blender before 4.2 without running this file: literals only. The manifest tells later ones.
bl_info = {
    "name": "Paradesc",
    "author": "The Paradesc authors",
    "version": (0, 1, 0),
    "blender": (3, 4, 0),
    "location": "3D Viewport > Sidebar > Paradesc",
    "description": "Curvature and other geometric descriptors of UV-mapped meshes at a radius you choose",
    "category": "Mesh",
}

__version__ = "0.1.0"

_registered: list[type] = []


def register() -> None:
    """Registers properties, operators and panels, in the order in which they refer to each other."""
    import bpy

    from . import operators, panel, properties

    _registered[:] = [properties.make_settings(), *operators.classes, *panel.classes]
    for cls in _registered:
        bpy.utils.register_class(cls)
    bpy.types.Scene.paradesc = bpy.props.PointerProperty(type=_registered[0])


def unregister() -> None:
    """Takes back what register() did, in reverse order."""
    import bpy

    del bpy.types.Scene.paradesc
    for cls in reversed(_registered):
        bpy.utils.unregister_class(cls)
    _registered.clear()
