"""Finds out which data on a mesh are the add-on's and unchanged; all other data are the user's and are never replaced.

An attribute or vertex group is the add-on's if a bake, or a button that copies values, has made it. A custom property
of the mesh keeps its fingerprint, which shows whether somebody has painted or edited it since: then it is the user's.
After a change of the faces, values cannot be compared, and the attribute stays the add-on's, unless a joined mesh has
brought values of its own or half of a pair is missing. Live values, which change at every frame, have no fingerprint
and stay the add-on's, too.
"""

import itertools
import zlib
from collections.abc import Callable, Iterable

import bpy
import numpy as np

from paradesc.files import file_names

from . import arrays, record

PROPERTY = "paradesc_left"
# The length of a checksum in letters. A fingerprint consists of one for the faces and one for the values.
LETTERS = 8
# A function from the name of one of our attributes to its type and domain.
KindOf = Callable[[str], tuple[str, str]]


# ---- Fingerprints


def fingerprints(mesh: bpy.types.Mesh) -> dict[str, str]:
    """The fingerprints that leave() stored, by name."""
    return {name: text for name, text in record.kept(mesh, PROPERTY).items() if isinstance(text, str)}


def leave(mesh: bpy.types.Mesh, names: Iterable[str]) -> None:
    """Keeps the fingerprints of attributes that have just been written. Not in edit mode."""
    faces, found = faces_of(mesh), [mesh.attributes[name] for name in names]
    known = [item for item in found if item.data_type in arrays.MEMBERS]
    made = {item.name: faces + short(arrays.attribute_values(item)) for item in known}
    keep(mesh, {**fingerprints(mesh), **made})


def leave_weights(mesh: bpy.types.Mesh, name: str, weights: np.ndarray) -> None:
    """Stores the fingerprint of a vertex group's (vertex_count,) weights. A colon keeps it apart from attributes."""
    keep(mesh, {**fingerprints(mesh), f":{name}": faces_of(mesh) + short(weights)})


def forget(mesh: bpy.types.Mesh, names: Iterable[str]) -> None:
    """Drops the fingerprints of attributes whose values keep changing."""
    known, gone = fingerprints(mesh), set(names)
    if gone & known.keys():
        keep(mesh, {name: text for name, text in known.items() if name not in gone})


def keep(mesh: bpy.types.Mesh, found: dict[str, str]) -> None:
    """Stores fingerprints, except those of attributes that are gone."""
    there = {name: text for name, text in found.items() if name.startswith(":") or name in mesh.attributes}
    if there:
        mesh[PROPERTY] = there
    elif PROPERTY in mesh:
        del mesh[PROPERTY]


def faces_of(mesh: bpy.types.Mesh) -> str:
    """The beginning of a fingerprint: how vertices and faces are connected."""
    return short(np.array([len(mesh.vertices)]), arrays.read_corner_vertices(mesh))


def short(*values: np.ndarray) -> str:
    """A fast checksum of arrays. It need not be secure, as nobody paints values on purpose to match it."""
    found = 0
    for array in values:
        found = zlib.crc32(np.ascontiguousarray(array).reshape(-1).view(np.uint8), found)
    return f"{found:0{LETTERS}x}"


def is_untouched(mesh: bpy.types.Mesh, key: str, values: np.ndarray, faces: str) -> bool:
    """Tells whether values match their fingerprint. Without one, or if the faces changed, they count as untouched."""
    text = fingerprints(mesh).get(key, "")
    return text[:LETTERS] != faces or text[LETTERS:] == short(values)


def is_as_left(mesh: bpy.types.Mesh, name: str, kind: tuple[str, str], faces: str) -> bool:
    """Returns whether one of our attributes still has the type, domain and values that we gave it."""
    attribute = mesh.attributes[name]
    if arrays.kind_of(attribute) != kind:
        return False
    values = arrays.attribute_values(attribute)
    return is_untouched(mesh, name, values, faces) if has_faces(mesh, name, faces) else is_filled(mesh, name, values)


def has_faces(mesh: bpy.types.Mesh, name: str, faces: str) -> bool:
    """Returns whether the mesh still has the faces that it had when we left an attribute."""
    return fingerprints(mesh).get(name, "")[:LETTERS] == faces


def is_filled(mesh: bpy.types.Mesh, name: str, values: np.ndarray) -> bool:
    """Returns whether (n,) or (n, width) values at new vertices are those with which Blender fills an attribute.

    If the mesh from which they come has no such attribute, they have the value 0, or one color.
    """
    rows = values[come_from_elsewhere(mesh, name)]
    return not rows.any() if rows.ndim == 1 else np.allclose(rows, rows[:1], atol=1e-5)  # tools round one color, too


def come_from_elsewhere(mesh: bpy.types.Mesh, name: str) -> np.ndarray:
    """(vertex_count,) bool: the vertices of another mesh, which lack another attribute of ours than this one.

    Blender's tools copy or interpolate all attributes together.
    """
    found = np.zeros(len(mesh.vertices), bool)
    for one in record.attributes_of(mesh):
        if name not in (one, f"{one}_color") and arrays.kind_of(mesh.attributes[one]) == ("FLOAT", "POINT"):
            found |= lack(mesh, one)
    return found


def lack(mesh: bpy.types.Mesh, name: str) -> np.ndarray:
    """(vertex_count,) bool: the vertices at which one of our attributes has what Blender fills in, and no bake leaves.

    That is a coverage of 0, or a value of 0 with transparent black (from Blender 5 on) or with white, unless the colors
    were made such that 0 may be white.
    """
    empty = arrays.attribute_values(mesh.attributes[name]) == 0
    if name == record.attribute_of(mesh, "coverage"):
        return empty
    known, color = record.read(mesh), mesh.attributes.get(f"{name}_color")
    low, high = known.get("ranges", {}).get(name, (0, 0))
    levels = map(known.get("drawn", {}).get(name, {}).get, ("contrast", "brightness", "invert"))
    if color is None or arrays.kind_of(color) != ("FLOAT_COLOR", "POINT"):
        return np.zeros(len(empty), bool)
    filled = (0,) if any(levels) or not low <= 0 < high else (0, 4)  # the sums of transparent black and of white
    return empty & np.isin(arrays.attribute_values(color).sum(axis=1), filled)


# ---- Names


def place(mesh: bpy.types.Mesh, name: str, ends: tuple[str, ...], kind_of: KindOf, faces: str) -> str:
    """A name under which attributes, one for each ending, are free, or ours and unchanged.

    It is the name itself, or has a number appended. A later bake finds the attributes of an earlier one again. If the
    faces have changed, a single attribute of several may be the user's, made after ours were deleted.
    """
    ours, known = set(record.attributes_of(mesh)), fingerprints(mesh)
    user = next((item for item in bpy.data.objects if item.data == mesh), None)  # any knows the names of vertex groups
    taken = {*mesh.attributes.keys(), *mesh.uv_layers.keys(), *(user.vertex_groups.keys() if user is not None else ())}
    candidates = list(itertools.islice(file_names.numbered(name), len(taken) + 2))

    def is_left(found: str) -> bool:
        there = [found + end for end in ends if found + end in taken]
        left = (one in ours and is_as_left(mesh, one, kind_of(one), faces) for one in there)
        whole = len(there) == len(ends) or all(has_faces(mesh, one, faces) for one in there if one in known)
        return bool(there) and all(left) and whole

    found = next(filter(is_left, candidates), None)
    return found or next(one for one in candidates if not any(one + end in taken for end in ends))
