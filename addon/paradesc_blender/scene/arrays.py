"""Reads Blender's collections into arrays, and fills attributes, by foreach_get and foreach_set."""

import bpy
import numpy as np

# The member that holds each attribute type's values, and the count of numbers in it.
COLOR = ("color", 4)
MEMBERS = {"FLOAT": ("value", 1), "FLOAT_VECTOR": ("vector", 3), "FLOAT_COLOR": COLOR, "BYTE_COLOR": COLOR}


def read_array(collection: object, member: str, kind: type, width: int = 1) -> np.ndarray:
    """(n,) or (n, width) values of one member of a bpy collection."""
    array = np.empty(len(collection) * width, kind)
    collection.foreach_get(member, array)
    return array.reshape(-1, width) if width > 1 else array


def read_corner_vertices(mesh: bpy.types.Mesh) -> np.ndarray:
    """(corner_count,) int32"""
    attribute = mesh.attributes.get(".corner_vert")
    if attribute is not None:
        return read_array(attribute.data, "value", np.int32)
    return read_array(mesh.loops, "vertex_index", np.int32)


def kind_of(attribute: bpy.types.Attribute) -> tuple[str, str]:
    """The type and domain of an attribute."""
    return attribute.data_type, attribute.domain


def attribute_values(attribute: bpy.types.Attribute) -> np.ndarray:
    """(n,) or (n, width) float32 values of an attribute of floats or colors; not in edit mode, which hides them."""
    member, width = MEMBERS[attribute.data_type]
    return read_array(attribute.data, member, np.float32, width)


def set_values(attribute: bpy.types.Attribute, values: np.ndarray) -> None:
    """Fills an attribute of floats or colors with (n,) or (n, width) values."""
    attribute.data.foreach_set(MEMBERS[attribute.data_type][0], np.ascontiguousarray(values, np.float32).ravel())
