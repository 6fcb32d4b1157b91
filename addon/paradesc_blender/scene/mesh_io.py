"""Reads Blender's meshes into arrays and writes results to attributes, by foreach_get and foreach_set on numpy."""

from collections.abc import Iterable
from itertools import takewhile

import bpy
import numpy as np

from paradesc.bridge import InputError, MeshArrays, ParadescError, components
from paradesc.core import color_maps, uv_faults
from paradesc.core.advice import double_areas
from paradesc.core.job import UNDEFINED_MASK, Results, registry_name
from paradesc.files.file_names import numbered

from . import ownership, record, unwrap
from .arrays import read_array, read_corner_vertices, set_values

# The range of each descriptor's colors, and the parts of the record about their making, by name.
Drawing = tuple[dict[str, color_maps.ValueRange], dict[str, dict[str, object]]]


def read_object(target: bpy.types.Object, corner_normals: bool, needs_uvs: bool = True) -> MeshArrays:
    """The object's own mesh (before modifiers), in object space; in edit mode as edited so far.

    Without a usable UV map it gets a layout made for the computation, if it needs one.
    """
    mesh = target.data
    if mesh.is_editmode:
        target.update_from_editmode()
        copy = mesh.copy()  # Blender hides the attributes' values of an edited mesh, but not of its copy
        try:
            return read_mesh(copy, corner_normals, needs_uvs, mesh.name)
        finally:
            bpy.data.meshes.remove(copy)
    return read_mesh(mesh, corner_normals, needs_uvs, mesh.name)


def read_mesh(mesh: bpy.types.Mesh, corner_normals: bool, needs_uvs: bool, name: str) -> MeshArrays:
    """Reads a mesh's triangles as arrays; the mesh stays as it is."""
    if len(mesh.polygons) == 0:
        raise InputError(f'The mesh "{name}" has no faces; there is no surface to measure.')
    (triangles, faces), flat, sharp = read_triangles(mesh), read_sharp(mesh, "face"), read_sharp(mesh, "edge")
    arrays = MeshArrays(
        positions=read_positions(mesh),
        corner_vertices=read_corner_vertices(mesh),
        triangle_corners=triangles,
        corner_uvs=read_uvs(mesh),
        corner_normals=read_corner_normals(mesh) if corner_normals else None,
        triangle_smooth=None if flat is None else (~flat)[faces].astype(np.uint8),
        sharp_edges=None if sharp is None or not sharp.any() else read_edges(mesh)[sharp],
    )
    reason = uv_faults.fault(arrays.corner_uvs, arrays.triangle_corners)
    if reason:
        others = [layer for layer in mesh.uv_layers if layer != mesh.uv_layers.active]
        sound = [layer.name for layer in others if not uv_faults.fault(unwrap.read_uvs(layer), triangles)]
        arrays.uv_fault = uv_faults.with_others(reason, sound)
        arrays.layout = unwrap.layout(mesh, record.layout_of(mesh), arrays, reason) if needs_uvs else None
        arrays.corner_uvs = arrays.layout.uvs if arrays.layout else None
    return arrays


def read_positions(mesh: bpy.types.Mesh) -> np.ndarray:
    """(vertex_count, 3) float32; before Blender 3.5 positions are not an attribute."""
    attribute = mesh.attributes.get("position")
    if attribute is not None:
        return read_array(attribute.data, "vector", np.float32, 3)
    return read_array(mesh.vertices, "co", np.float32, 3)


def read_triangles(mesh: bpy.types.Mesh) -> tuple[np.ndarray, np.ndarray]:
    """(triangle_count, 3) int32 corners, as Blender divides faces, and (triangle_count,) int32 face of each triangle.

    That is slow to read. A mesh of triangles avoids it, unless its file is old and has their corners in another order.
    """
    count = len(mesh.polygons)
    whole = np.arange(3 * count, dtype=np.int32).reshape(-1, 3)
    if len(mesh.loops) == 3 * count and (
        ".corner_vert" in mesh.attributes
        or np.array_equal(read_array(mesh.polygons, "loop_start", np.int32), whole[:, 0])
    ):
        return whole, np.arange(count, dtype=np.int32)
    mesh.calc_loop_triangles()
    corners = read_array(mesh.loop_triangles, "loops", np.int32, 3)
    if hasattr(mesh, "loop_triangle_polygons"):
        return corners, read_array(mesh.loop_triangle_polygons, "value", np.int32)
    return corners, read_array(mesh.loop_triangles, "polygon_index", np.int32)  # before Blender 3.6


def read_uvs(mesh: bpy.types.Mesh) -> np.ndarray | None:
    """(corner_count, 2) float32 of the active UV map, or None without one."""
    layer = mesh.uv_layers.active
    return None if layer is None else unwrap.read_uvs(layer)


def read_corner_normals(mesh: bpy.types.Mesh) -> np.ndarray:
    """(corner_count, 3) float32 with custom and split normals; before Blender 4.1 they are computed on request."""
    if hasattr(mesh, "corner_normals"):
        return read_array(mesh.corner_normals, "vector", np.float32, 3)
    mesh.calc_normals_split()
    try:
        return read_array(mesh.loops, "normal", np.float32, 3)
    finally:
        mesh.free_normals_split()


def read_sharp(mesh: bpy.types.Mesh, kind: str) -> np.ndarray | None:
    """(n,) bool: which faces (kind: "face") are flat, or which edges ("edge") are sharp; None if none can be."""
    attribute = mesh.attributes.get(f"sharp_{kind}")
    if attribute is not None:
        return read_array(attribute.data, "value", bool)
    if "position" in mesh.attributes:
        return None
    if kind == "face":
        return ~read_array(mesh.polygons, "use_smooth", bool)
    return read_array(mesh.edges, "use_edge_sharp", bool)


def read_edges(mesh: bpy.types.Mesh) -> np.ndarray:
    """(edge_count, 2) int32 vertex pairs."""
    attribute = mesh.attributes.get(".edge_verts")
    if attribute is not None:
        return read_array(attribute.data, "value", np.int32, 2)
    return read_array(mesh.edges, "vertices", np.int32, 2)


# ---- Writing


def unwritable(target: bpy.types.Object) -> str:
    """The reason why the object's mesh would lose the results when the file is loaded again, or ""."""
    mesh = target.data
    if mesh.library is not None or target.library is not None:
        return f'The mesh "{mesh.name}" is linked from another file; make it local first.'
    if mesh.override_library is not None:
        return f'The mesh "{mesh.name}" is a library override, which cannot keep attributes; make it local first.'
    return ""


def check_writable(target: bpy.types.Object) -> None:
    """Raises if the object's mesh would lose the results."""
    if unwritable(target):
        raise InputError(unwritable(target))


def wanted_kind(name: str) -> tuple[str, str]:
    """The type and domain that one of our attributes has to have."""
    if name.endswith("_color"):
        return ("FLOAT_COLOR", "POINT")
    return ("FLOAT_VECTOR" if components(registry_name(name)) == 3 else "FLOAT", "POINT")


def places(mesh: bpy.types.Mesh, shown: Iterable[str], extras: Iterable[str]) -> dict[str, str]:
    """The attribute for each value, by name: one of the same name, with a number appended if the name is taken.

    A shown value also has a color attribute beside its own, so both names must be free or ours.
    """
    faces = ownership.faces_of(mesh)
    found = {name: ownership.place(mesh, name, ("", "_color"), wanted_kind, faces) for name in shown}
    return found | {name: ownership.place(mesh, name, ("",), wanted_kind, faces) for name in extras}


def attribute_names(shown: Iterable[str], extras: Iterable[str], at: dict[str, str]) -> list[str]:
    """The names of all attributes that hold these values."""
    return [name for one in shown for name in (at[one], f"{at[one]}_color")] + [at[name] for name in extras]


def refused(at: dict[str, str]) -> list[str]:
    """The names of attributes that values could not get; all of them are the user's from now on."""
    before = [one for name, place in at.items() for one in takewhile(place.__ne__, numbered(name))]
    return [one + end for one in before for end in ("", "_color")]


def moved_notes(at: dict[str, str]) -> list[str]:
    """Notes about attributes that could not get their usual names."""
    return [
        f'The attribute or vertex group "{name}" is not from a bake, or was changed, and is kept; the values are in '
        f'"{place}".'
        for name, place in at.items()
        if name != place
    ]


def drawing(results: Results, positions: np.ndarray, triangles: np.ndarray) -> Drawing:
    """The ranges of all values' colors and their parts of the record, from the surface that surface_of() gives."""
    ranges, told = {name: results.shown(name) for name in results.values}, {}
    for name, shown in ranges.items():
        told[name] = record.drawing_of(shown, results, name)
        if results.look.is_automatic(shown.diverging):  # recoloring goes back to this range
            told[name]["automatic"] = [shown.minimum, shown.maximum]
        told[name] |= extremes(positions, triangles, results.values[name], shown)
    return ranges, told


def check_count(mesh: bpy.types.Mesh, results: Results) -> None:
    """Raises if the mesh has changed its vertices since it was read."""
    if len(mesh.vertices) != len(results.coverage):
        raise InputError(f'The mesh "{mesh.name}" was changed while it was being computed; run it again.')


def write_at(mesh: bpy.types.Mesh, results: Results, at: dict[str, str], drawn: Drawing) -> None:
    """Writes the results to the attributes that places() chose, in the colors of drawing(). Not in edit mode."""
    extras = {name: values for name, values in results.extras.items() if name in at}
    names = attribute_names(results.values, extras, at)
    make_attributes(mesh, names)
    layout = None if results.unwrapped is None else unwrap.keep(mesh, results.unwrapped)
    for name, values in (results.values | extras).items():  # all exist: creating one moves the others in memory
        set_values(mesh.attributes[at[name]], values)
    ranges, told = drawn
    for name, shown in ranges.items():
        write_colors(mesh, at[name], results.values[name], shown)
    show(mesh, at[most_telling(told)])
    placed = ({at[name]: row for name, row in rows.items()} for rows in drawn)
    record.disown(mesh, refused(at))
    record.write(mesh, record.facts_of(results), *placed, names, layout)
    ownership.leave(mesh, names)
    mesh.update()


def make_attributes(mesh: bpy.types.Mesh, names: list[str]) -> None:
    """Creates the missing attributes, or none if that fails."""
    made: list[str] = []
    try:
        for name in names:
            if mesh.attributes.get(name) is None:
                made.append(make_attribute(mesh, name))
            if made and made[-1] not in names:
                raise InputError(f'The name "{name}" is taken on the mesh "{mesh.name}"; rename what has this name.')
    except (RuntimeError, ParadescError):
        for name in made:
            mesh.attributes.remove(mesh.attributes[name])
        raise


def make_attribute(mesh: bpy.types.Mesh, name: str) -> str:
    """Creates one of our attributes; returns the name that Blender gave it."""
    attribute = mesh.attributes.new(name, *wanted_kind(name))
    if attribute is None:
        raise InputError(
            f'Blender could not make the attribute "{name}" on the mesh "{mesh.name}"; rename what has this name.'
        )
    return attribute.name


def extras_on(mesh: bpy.types.Mesh, results: Results) -> dict[str, np.ndarray]:
    """The extras to write. The mask of undefined vertices is left out if none is undefined, unless the mesh has one."""
    kept = {**results.extras}
    if not kept[UNDEFINED_MASK].any() and record.attribute_of(mesh, UNDEFINED_MASK) not in mesh.attributes:
        del kept[UNDEFINED_MASK]
    return kept


def show(mesh: bpy.types.Mesh, name: str) -> None:
    """Makes the colors of a descriptor's values the active ones, in the viewport and for rendering."""
    colors = mesh.color_attributes
    colors.active_color = colors[f"{name}_color"]
    colors.render_color_index = colors.find(f"{name}_color")


def most_telling(seen: dict[str, dict[str, float]]) -> str:
    """The first of the values, unless it is a mask that is black nearly everywhere and another mask is less so."""
    first = next(iter(seen))
    dark = {name: row["dark"] for name, row in seen.items() if "dark" in row}
    return [*dark][color_maps.most_telling([*dark.values()])] if first in dark else first


# So many faces suffice to estimate how much of a mask is black or white.
ENOUGH_FACES = 100_000


def surface_of(mesh: bpy.types.Mesh) -> tuple[np.ndarray, np.ndarray]:
    """(vertex_count, 3) float32 positions, and (n, 3) int32 first three vertices of enough faces."""
    corners, starts = read_corner_vertices(mesh), read_array(mesh.polygons, "loop_start", np.int32)
    starts = starts[np.diff(starts, append=len(corners)) >= 3]  # files may have faces of two corners
    return read_positions(mesh), corners[starts[:: 1 + len(starts) // ENOUGH_FACES, None] + np.arange(3)]


def areas_of_vertices(mesh: bpy.types.Mesh) -> np.ndarray:
    """(vertex_count,) float64: a third of the areas of the triangles at each vertex."""
    mesh.calc_loop_triangles()
    triangles, positions = read_array(mesh.loop_triangles, "vertices", np.int32, 3), read_positions(mesh)
    areas = np.repeat(double_areas(positions[triangles]) / 6, 3)
    return np.bincount(triangles.reshape(-1), weights=areas, minlength=len(positions))


def extremes(
    positions: np.ndarray, triangles: np.ndarray, values: np.ndarray, shown: color_maps.ValueRange
) -> dict[str, float]:
    """The approximate shares of the area that a mask shows nearly black and nearly white; {} if it is not a mask."""
    if values.ndim == 2 or shown.color_map.diverging:
        return {}
    corners = triangles[np.isfinite(values[triangles]).all(axis=1)]
    areas = double_areas(positions[corners])
    if not areas.sum() > 0:
        return {}
    places = shown.shares(values[corners])
    return {
        "dark": float(np.average((places < color_maps.DARK).mean(axis=1), weights=areas)),
        "bright": float(np.average((places > color_maps.BRIGHT).mean(axis=1), weights=areas)),
    }


def write_colors(mesh: bpy.types.Mesh, name: str, values: np.ndarray, shown: color_maps.ValueRange) -> None:
    """Fills the color attribute beside the attribute of a descriptor's (n,) or (n, 3) values."""
    rgba = color_maps.linear_rgba(color_maps.colors(values, shown))
    set_values(mesh.attributes[f"{name}_color"], rgba)
