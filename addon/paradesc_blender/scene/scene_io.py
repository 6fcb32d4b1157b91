"""Opens the input of the command line as a Blender scene, and saves it."""

import re
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import bmesh
import bpy
import numpy as np

from paradesc.bridge import InputError, ParadescError
from paradesc.core import source_kinds, welding
from paradesc.core.standard_streams import quiet
from paradesc.files import mesh_files
from paradesc.files.paths import is_file
from paradesc.files.text_rows import MARK

from . import carrying
from .arrays import read_corner_vertices
from .mesh_io import read_positions

# The operators that import files of a suffix, with default options. The first one that this Blender has is used.
IMPORTERS = {
    ".obj": ("wm.obj_import", "import_scene.obj"),
    ".ply": ("wm.ply_import", "import_mesh.ply"),
    ".stl": ("import_mesh.stl", "wm.stl_import"),  # before 4.1 the second one is there, but unfinished
    ".glb": ("import_scene.gltf",),
    ".gltf": ("import_scene.gltf",),
    ".fbx": ("wm.fbx_import", "import_scene.fbx"),
    ".usd": ("wm.usd_import",),
    ".usda": ("wm.usd_import",),
    ".usdc": ("wm.usd_import",),
    ".usdz": ("wm.usd_import",),
}
SUFFIXES = (".blend", *IMPORTERS)


def open_scene(path: Path, verbose: bool = False) -> list[str]:
    """Opens a .blend, or imports any other file into an empty scene; returns notes about the import."""
    with reading(path, verbose) as (whole, faces):
        if path.suffix.lower() == ".blend":
            bpy.ops.wm.open_mainfile(filepath=str(whole), load_ui=False)
            return []
        bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
        return imported(whole, faces)


def add_objects(path: Path, verbose: bool = False) -> list[bpy.types.Object]:
    """Adds the mesh objects of another file to the open scene. Blender numbers names that are taken."""
    before = set(bpy.data.objects)
    with reading(path, verbose) as (whole, faces):
        if path.suffix.lower() == ".blend":
            with bpy.data.libraries.load(str(whole)) as (there, here):
                here.objects = list(there.objects)
            for item in set(bpy.data.objects) - before:
                if not carrying.is_carrier(item):
                    bpy.context.scene.collection.objects.link(item)
        else:
            imported(whole, faces)
    bpy.context.view_layer.update()
    added = sorted(set(bpy.data.objects) - before, key=lambda item: item.name)
    found = [item for item in added if item.type == "MESH" and not carrying.is_carrier(item)]
    if not found:
        raise InputError(f'There is no mesh object in "{path}".')
    return found


@contextmanager
def reading(path: Path, verbose: bool) -> Iterator[tuple[Path, int]]:
    """Yields a sound file's absolute path and its least number of faces; raises one sentence on any error.

    Importers make 0 of NaN, and a mesh of half a file. So our own reader checks a file first, if it knows the format.
    """
    suffix = path.suffix.lower()
    if suffix in mesh_files.BLENDER_LACKS:
        raise InputError(f'Blender does not open "{path}"; save it as .ply, or give --reader files.')
    if suffix not in SUFFIXES:
        raise InputError(f'"{path}" is none of {", ".join([*SUFFIXES, *mesh_files.BLENDER_LACKS])}.')
    if not is_file(path):
        raise InputError(f'There is no file "{path}".')
    faces = mesh_files.check(path)
    try:
        with quiet(verbose):
            yield path.absolute(), faces  # Blender would resolve it by $PWD, which may not be the working directory
    except ParadescError:
        raise
    except (RuntimeError, ValueError, KeyError, IndexError, TypeError, AttributeError, OSError) as error:
        remedy = "; --reader files reads it" if faces else ""
        raise InputError(f'Blender cannot read "{path}": {reason(error)}{remedy}.') from error


def imported(path: Path, faces: int) -> list[str]:
    """Imports a file with at least so many faces into the open scene; returns notes about changes to its meshes."""
    suffix, objects, meshes = path.suffix.lower(), set(bpy.data.objects), list(bpy.data.meshes)
    importer = find_importer(suffix)
    with numpy_bool():
        importer(filepath=str(path))
    found = sum(len(item.data.polygons) for item in set(bpy.data.objects) - objects if item.type == "MESH")
    if found < faces or (suffix == ".obj" and begins_with_mark(path)):
        lost = f"only {found:,} of its {faces:,} faces" if found < faces else "it without its first line"
        raise InputError(f'Blender reads "{path}" wrongly, {lost}; --reader files reads all of it.')
    return weld_meshes(meshes) if suffix == ".stl" else []


def begins_with_mark(path: Path) -> bool:
    """Returns whether a text begins with a byte order mark: Blender's .obj importer misreads a line after one."""
    with path.open("rb") as file:
        return file.read(len(MARK)) == MARK


def find_importer(suffix: str) -> object:
    """The operator that imports files of this suffix in this Blender."""
    found = next(filter(None, map(operator_of, IMPORTERS[suffix])), None)
    if found is None:
        version = bpy.app.version_string
        raise InputError(f"Blender {version} here was built without, or has switched off, its importer of {suffix}.")
    return found


def operator_of(name: str) -> object | None:
    """The operator of this name; None if this Blender lacks it, which bpy.ops itself cannot tell."""
    category, _, member = name.partition(".")
    with suppress(KeyError, AttributeError):
        found = getattr(getattr(bpy.ops, category), member)
        found.get_rna_type()
        return found
    return None


def weld_meshes(before: list[bpy.types.Mesh]) -> list[str]:
    """Welds the separate triangles of an STL file into a surface; returns notes. Earlier meshes stay as they are."""
    sentences = []
    for mesh in [item for item in bpy.data.meshes if item not in before]:
        triangles = len(mesh.polygons)
        points = read_positions(mesh)
        if len(points) == 0 or not np.isfinite(points).all():
            continue
        corners = read_corner_vertices(mesh)
        reach = welding.reach(points, corners.reshape(-1, 3)) if len(corners) == 3 * triangles else 0.0
        welded = bmesh.new()
        welded.from_mesh(mesh)
        bmesh.ops.remove_doubles(welded, verts=welded.verts, dist=reach)
        welded.to_mesh(mesh)
        welded.free()
        sentences.append(
            f"An STL file holds loose triangles: the {3 * triangles:,} corners of {triangles:,} were welded into "
            f"{len(mesh.vertices):,} vertices, where they differ by rounding alone."
        )
    return sentences


def reason(error: Exception) -> str:
    """Blender's error message as one sentence without its final dot; of a traceback only the exception."""
    lines = [line.strip() for line in str(error).splitlines() if line.strip()]
    lines = [line for line in lines if not line.startswith("Location: ")]
    raised = [
        line for line in lines if re.match(r"[A-Za-z_.]*([Ee]rror|Exception): ", line) and "Traceback" not in line
    ]
    line = (raised or lines or [type(error).__name__])[-1]
    return line.removeprefix("Error: ").rstrip(".")[:300]


@contextmanager
def numpy_bool() -> Iterator[None]:
    """Temporarily gives numpy 1.24 to 1.26 the removed np.bool, which the glTF importer of Blender 3.4 needs."""
    if "bool" in np.__dict__:
        yield
        return
    np.bool = bool
    try:
        yield
    finally:
        del np.bool


def mesh_objects() -> list[bpy.types.Object]:
    """The scene's mesh objects."""
    return [item for item in bpy.context.scene.objects if item.type == "MESH"]


def choose_object(prefer_active: bool) -> bpy.types.Object:
    """The active mesh object if it is preferred, else that with the most vertices."""
    meshes = mesh_objects()
    active = bpy.context.view_layer.objects.active
    if prefer_active and active is not None and active.type == "MESH":
        return active
    if not meshes:
        raise InputError("There is no mesh object in the scene.")
    shapes = bone_shapes()
    return max([item for item in meshes if item not in shapes] or meshes, key=lambda item: len(item.data.vertices))


def all_objects(source: str = source_kinds.ORIGINAL) -> tuple[list[bpy.types.Object], list[str]]:
    """Every mesh object of the view layer that renders and has faces with this source; notes about the others."""
    shapes, depsgraph = bone_shapes(), bpy.context.evaluated_depsgraph_get()
    chosen, sentences = [], []
    for item in (item for item in bpy.context.view_layer.objects if item.type == "MESH"):
        # Modifiers may create all faces.
        shown = item.evaluated_get(depsgraph) if source == source_kinds.EVALUATED else item
        measured = shown if shown.is_evaluated else item
        if item in shapes:
            reason = "is the shape of a bone"
        elif item.hide_render or all(collection.hide_render for collection in item.users_collection):
            reason = "is disabled in renders"
        elif measured.type != "MESH" or not measured.data.polygons:
            reason = "has no faces"
        else:
            chosen.append(item)
            continue
        sentences.append(f'The object "{item.name}" {reason} and was left out.')
    if not chosen:
        raise InputError(" ".join(["There is no mesh object with faces in the scene that renders.", *sentences]))
    return sorted(chosen, key=lambda item: item.name), sentences


def bone_shapes() -> set[bpy.types.Object]:
    """The objects that serve as custom shapes of bones; the importer of glTF creates one."""
    rigs = [item for item in bpy.context.scene.objects if item.type == "ARMATURE" and item.pose]
    return {bone.custom_shape for rig in rigs for bone in rig.pose.bones if bone.custom_shape}
