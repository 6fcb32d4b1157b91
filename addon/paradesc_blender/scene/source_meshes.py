"""Reads the measured mesh of an object: its own mesh, that mesh deformed by modifiers, or the result of all modifiers.

Deforming modifiers keep the object's own vertices. For other modifiers, a temporary attribute shows which own vertices
the evaluated mesh has: only vertices that were not interpolated keep its value. The add-on's own modifier, which
carries values to that mesh, changes no position and no face, so it does not count.
"""

from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import replace

import bpy
import numpy as np

from paradesc.bridge import InputError, MeshArrays
from paradesc.core import source_kinds, uv_faults
from paradesc.files.reading import Read

from . import carrying, mesh_io, unwrap
from .arrays import kind_of, read_array, read_corner_vertices

# Modifiers that create or remove vertices or faces. Geometry Nodes may do so as well, which is tested each time.
GENERATING = {
    "ARRAY", "BEVEL", "BOOLEAN", "BUILD", "DECIMATE", "EDGE_SPLIT", "EXPLODE", "FLUID", "MASK", "MESH_TO_VOLUME",
    "MIRROR", "MULTIRES", "OCEAN", "PARTICLE_INSTANCE", "REMESH", "SCREW", "SKIN", "SOLIDIFY", "SUBSURF", "TRIANGULATE",
    "VOLUME_TO_MESH", "WELD", "WIREFRAME",
}  # fmt: skip
MARK = "paradesc_origin"
# Integers up to this are exact as 32-bit floats.
EXACT = 1 << 24
BASE = source_kinds.in_words(source_kinds.ORIGINAL)


def read(
    target: bpy.types.Object,
    source: str,
    corner_normals: bool = False,
    needs_uvs: bool = True,
    base: MeshArrays | None = None,
    former: Read | None = None,
    placing: bool = True,
) -> Read:
    """The object's mesh from this source, in object space at the current frame. The scene stays as it is.

    base, the object's own mesh as it was read, and former, the reading of the former frame, need not be read again at
    each frame. Without placing, the places of results on the object are not looked for, and modifiers are evaluated
    less often.
    """

    def original() -> MeshArrays:
        return mesh_io.read_object(target, corner_normals, needs_uvs) if base is None else base

    if source == "original":
        return Read(original(), source)
    if is_edited(target):
        note = "In edit and sculpt mode the mesh is measured as it is edited, without its modifiers."
        return Read(mesh_io.read_object(target, corner_normals, needs_uvs), "original", notes=[note])
    if source == "deformed":
        return read_deformed(target, original())
    # Modifiers that are known to make vertices are evaluated only once: the marks are there by then.
    generating = any(modifier.type in GENERATING for modifier in shown_modifiers(target))
    marks = marks_of(target) if placing and generating and former is None else None
    with marked(target.data, marks), evaluated_mesh(target) as mesh:
        if same_vertices(mesh, target.data):
            arrays = moved(mesh, original())
            return Read(with_map(mesh, target.data, arrays) if base is None else arrays, source)
        arrays = read_made(target, mesh, corner_normals, needs_uvs)
        vertices = None if marks is None else carried(mesh, marks)
        earlier = carrying.carried_values(target, mesh) if placing and former is None else {}
    if former is not None and former.source == source:
        known = former.arrays
        is_same = len(known.positions) == len(arrays.positions)
        if is_same and np.array_equal(known.corner_vertices, arrays.corner_vertices):
            return replace(former, arrays=arrays)
    if not placing:
        return Read(arrays, source, own=False)
    vertices = origins(target) if vertices is None else vertices
    is_lost = not len(vertices) or bool((vertices < 0).any())
    notes = [f"Measured with its modifiers: {len(arrays.positions):,} vertices."]
    return Read(arrays, source, None if is_lost else vertices, not is_lost, earlier, notes=notes)


def read_made(target: bpy.types.Object, mesh: bpy.types.Mesh, corner_normals: bool, needs_uvs: bool) -> MeshArrays:
    """Reads a mesh that the object's modifiers have made."""
    if not mesh.polygons:
        raise InputError(
            f'The modifiers of "{target.name}" leave no faces; nodes that make instances have to realize them.'
        )
    return mesh_io.read_mesh(mesh, corner_normals, needs_uvs, target.data.name)


def moved(mesh: bpy.types.Mesh, base: MeshArrays) -> MeshArrays:
    """The faces of base at the mesh's positions, with the mesh's normals if base has any."""
    normals = None if base.corner_normals is None else mesh_io.read_corner_normals(mesh)
    return replace(base, positions=mesh_io.read_positions(mesh), corner_normals=normals)


def with_map(mesh: bpy.types.Mesh, own: bpy.types.Mesh, arrays: MeshArrays) -> MeshArrays:
    """The arrays with the UV map as modifiers leave it, such as UV Warp and UV Project, if it can be used.

    mesh is the evaluated mesh. The active map of the object's own mesh counts, or one that nodes have made.
    """
    active = own.uv_layers.active
    layer = mesh.uv_layers.active if active is None else mesh.uv_layers.get(active.name)
    uvs = None if layer is None else unwrap.read_uvs(layer)
    if uv_faults.fault(uvs, arrays.triangle_corners):
        return arrays
    return replace(arrays, corner_uvs=uvs, layout=None, uv_fault="")


def read_deformed(target: bpy.types.Object, base: MeshArrays) -> Read:
    """Reads the object's own faces (base) at the positions to which deforming modifiers and shape keys move them."""
    with only_deforming(target) as hidden, evaluated_mesh(target) as mesh:
        if not same_vertices(mesh, target.data):
            names = quoted([modifier.name for modifier in shown_modifiers(target)])
            others = source_kinds.in_words(source_kinds.EVALUATED, source_kinds.ORIGINAL)
            raise InputError(
                f'The modifiers of "{target.name}" ({names}) change its faces and cannot be left out; choose the '
                f"source {others}."
            )
        notes = [f"Measured without the modifiers that change the vertices: {quoted(hidden)}."] if hidden else []
        return Read(moved(mesh, base), "deformed", notes=notes)


def quoted(names: list[str]) -> str:
    """The names in quotation marks, between commas."""
    return ", ".join(f'"{name}"' for name in names)


# ---- Evaluating


@contextmanager
def evaluated_mesh(target: bpy.types.Object) -> Iterator[bpy.types.Mesh]:
    """Yields the mesh after modifiers at the current frame; it exists only inside the with statement."""
    depsgraph = bpy.context.evaluated_depsgraph_get()
    evaluated = target.evaluated_get(depsgraph)
    if not evaluated.is_evaluated:
        raise InputError(
            f'The object "{target.name}" is disabled in viewports or not in the view layer, so Blender does not '
            f"evaluate its modifiers; enable it, or choose the source {BASE}."
        )
    try:
        mesh = evaluated.to_mesh(preserve_all_data_layers=True, depsgraph=depsgraph)
    except RuntimeError as error:
        raise InputError(f'Blender cannot evaluate "{target.name}": {error}') from error
    try:
        yield mesh
    finally:
        evaluated.to_mesh_clear()


@contextmanager
def only_deforming(target: bpy.types.Object) -> Iterator[list[str]]:
    """Temporarily hides modifiers that change vertices or faces, and always shows them again; yields their names."""
    hidden: list[str] = []
    with ExitStack() as ending:
        ending.callback(lambda: hidden and bpy.context.view_layer.update())
        hidden += hide([modifier for modifier in shown_modifiers(target) if modifier.type in GENERATING], ending)
        nodes = [modifier for modifier in shown_modifiers(target) if modifier.type == "NODES"]
        if nodes:
            with evaluated_mesh(target) as mesh:
                changed = not same_vertices(mesh, target.data)
            hidden += hide(nodes, ending) if changed else []
        yield hidden


def hide(modifiers: list[bpy.types.Modifier], ending: ExitStack) -> list[str]:
    """Hides the modifiers, mutes what would show them again, and returns their names; the end undoes all of it."""
    for modifier in modifiers:
        for curve in showing(modifier):
            curve.mute = True
            ending.callback(setattr, curve, "mute", False)
        modifier.show_viewport = False
        ending.callback(setattr, modifier, "show_viewport", True)
    if modifiers:
        bpy.context.view_layer.update()
    return [modifier.name for modifier in modifiers]


def showing(modifier: bpy.types.Modifier) -> list[bpy.types.FCurve]:
    """The drivers and F-curves that control a modifier's visibility and are not muted."""
    data = modifier.id_data.animation_data
    if data is None:
        return []
    path = f'modifiers["{bpy.utils.escape_identifier(modifier.name)}"].show_viewport'
    curves = (*data.drivers, *curves_of(data))
    return [curve for curve in curves if curve.data_path == path and not curve.mute]


def curves_of(animation: bpy.types.AnimData) -> Iterator[bpy.types.FCurve]:
    """The F-curves with keyframes, from the action or its strips; actions have layers since Blender 4.4."""
    strips = (strip.action for track in animation.nla_tracks for strip in track.strips)
    for action in filter(None, (animation.action, *strips)):
        if getattr(action, "layers", None):
            bags = (bag for layer in action.layers for strip in layer.strips for bag in strip.channelbags)
        else:
            bags = (action,)
        for bag in bags:
            yield from bag.fcurves


def shown_modifiers(target: bpy.types.Object, rendering: bool = False) -> list[bpy.types.Modifier]:
    """The modifiers that are enabled in the viewport, or in renders, without the one that carries values."""
    shown = "show_render" if rendering else "show_viewport"
    return [item for item in target.modifiers if getattr(item, shown) and not carrying.is_ours(item)]


def is_edited(target: bpy.types.Object) -> bool:
    """Returns whether the mode shows the object's own mesh as it is edited, with the active shape key alone."""
    return target.data.is_editmode or target.mode == "SCULPT"


def shape_key(target: bpy.types.Object, active: bool) -> bpy.types.ShapeKey | None:
    """The active shape key, or the basis; None without shape keys."""
    keys = target.data.shape_keys
    return keys and ((active and target.active_shape_key) or keys.reference_key)


def same_vertices(mesh: bpy.types.Mesh, other: bpy.types.Mesh) -> bool:
    """Returns whether both meshes have the same number of vertices and the same faces."""
    return (
        len(mesh.vertices) == len(other.vertices)
        and len(mesh.loops) == len(other.loops)
        and len(mesh.polygons) == len(other.polygons)
        and np.array_equal(read_corner_vertices(mesh), read_corner_vertices(other))
    )


# ---- Finding vertices again


def origins(target: bpy.types.Object) -> np.ndarray:
    """(original_count,) int64 first vertex of the evaluated mesh that came from each original vertex, or -1."""
    marks = marks_of(target)
    if marks is None:
        return np.full(len(target.data.vertices), -1, np.int64)
    with marked(target.data, marks), evaluated_mesh(target) as mesh:
        return carried(mesh, marks)


def marks_of(target: bpy.types.Object) -> np.ndarray | None:
    """(original_count, 3) float32 marks by which vertices are recognized; None if they cannot be marked.

    They cannot if floats cannot number them, or on linked meshes, whose evaluated copies get no attributes.
    """
    count, mesh = len(target.data.vertices), target.data
    if count >= EXACT or mesh.library is not None or mesh.override_library is not None:
        return None
    marks = np.empty((count, 3), np.float32)
    marks[:, 0] = np.arange(count)
    marks[:, 1:] = np.random.default_rng(0).integers(1, EXACT, (count, 2))  # a mixed vertex has neither
    return marks


def carried(mesh: bpy.types.Mesh, marks: np.ndarray) -> np.ndarray:
    """(original_count,) int64 first vertex of an evaluated mesh that has each mark, or -1."""
    attribute = mesh.attributes.get(MARK)
    if attribute is None or kind_of(attribute) != ("FLOAT_VECTOR", "POINT"):
        return np.full(len(marks), -1, np.int64)
    return matched(read_array(attribute.data, "vector", np.float32, 3), marks)


def matched(carried: np.ndarray, marks: np.ndarray) -> np.ndarray:
    """(count,) int64 first row of carried (n, 3) that equals each row of marks (count, 3), which column 0 numbers."""
    count = len(marks)
    first = carried[:, 0]
    plausible = np.isfinite(first) & (first >= 0) & (first < count)
    index = np.where(plausible, first, 0).astype(np.int64)
    places = np.flatnonzero(plausible & (carried == marks[index]).all(axis=1)) if count else np.empty(0, np.int64)
    found = np.full(count, -1, np.int64)
    found[index[places[::-1]]] = places[::-1]
    return found


@contextmanager
def marked(mesh: bpy.types.Mesh, marks: np.ndarray | None) -> Iterator[None]:
    """Temporarily stores the marks (vertex_count, 3) on the mesh's vertices, if there are any."""
    if marks is None:
        yield
        return
    if MARK in mesh.attributes:
        raise InputError(f'The mesh "{mesh.name}" has an attribute "{MARK}"; rename it, because this name is needed.')
    active = mesh.attributes.active_index
    made = mesh.attributes.new(MARK, "FLOAT_VECTOR", "POINT")
    try:
        made.data.foreach_set("vector", marks.ravel())
        mesh.update()
        bpy.context.view_layer.update()
        yield
    finally:
        mesh.attributes.remove(mesh.attributes[MARK])
        mesh.attributes.active_index = active
        mesh.update()
        bpy.context.view_layer.update()
