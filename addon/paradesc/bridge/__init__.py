"""The way from Python to libparadesc: plain Python, ctypes and numpy, never Blender."""

from .library import Descriptor, ParadescError, descriptors, load_library, missing_sentence
from .session import (
    BACKENDS,
    NORMALS,
    RADIUS_UNITS,
    RELOCATIONS,
    Context,
    Field,
    Layout,
    Mesh,
    MeshArrays,
    Options,
    devices,
)

__all__ = [
    "BACKENDS",
    "NORMALS",
    "RADIUS_UNITS",
    "RELOCATIONS",
    "Context",
    "Descriptor",
    "Field",
    "Layout",
    "Mesh",
    "MeshArrays",
    "Options",
    "ParadescError",
    "descriptors",
    "devices",
    "load_library",
    "missing_sentence",
]
