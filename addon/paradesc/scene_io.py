"""Opens what the command line is given as a Blender scene, and saves it: .blend, .obj, .ply, .glb."""

import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import bpy
import numpy as np

from .mesh_io import refuse
from .streams import quiet

SUFFIXES = (".blend", ".obj", ".ply", ".glb", ".gltf")


def open_scene(path: Path, verbose: bool = False) -> None:
    """Makes the file the open scene; anything but a .blend is imported into an empty one."""
    suffix = path.suffix.lower()
    if suffix not in SUFFIXES:
        raise refuse(f'"{path}" is none of {", ".join(SUFFIXES)}.')
    if not path.is_file():
        raise refuse(f'There is no file "{path}".')
    try:
        with quiet(verbose):
            whole = path.absolute()  # of the rest Blender would ask $PWD, which need not be the working directory
            if suffix == ".blend":
                bpy.ops.wm.open_mainfile(filepath=str(whole), load_ui=False)
            else:
                bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
                import_file(whole, suffix)
    except (RuntimeError, ValueError, KeyError, IndexError, TypeError, AttributeError, OSError) as error:
        raise refuse(f'Blender cannot read "{path}": {reason(error)}.') from error


def reason(error: Exception) -> str:
    """What Blender says is wrong, in one sentence without its final dot; of a traceback the exception alone."""
    lines = [line.strip() for line in str(error).splitlines() if line.strip()]
    raised = [line for line in lines if re.match(r"[A-Za-z_.]*(Error|Exception): ", line) and "Traceback" not in line]
    line = (raised or lines or [type(error).__name__])[-1]
    return line.removeprefix("Error: ").rstrip(".")[:300]


def import_file(path: Path, suffix: str) -> None:
    """Calls the importer that this Blender has for the suffix, with its own defaults."""
    if suffix == ".obj":
        bpy.ops.wm.obj_import(filepath=str(path))
    elif suffix == ".ply" and bpy.app.version >= (4, 0, 0):
        bpy.ops.wm.ply_import(filepath=str(path))
    elif suffix == ".ply":
        bpy.ops.import_mesh.ply(filepath=str(path))
    else:
        with numpy_bool():
            bpy.ops.import_scene.gltf(filepath=str(path))


@contextmanager
def numpy_bool() -> Iterator[None]:
    """Gives numpy 1.24 to 1.26 their former np.bool for a while: the glTF importer of Blender 3.4 asks for it."""
    if "bool" in np.__dict__:
        yield
        return
    np.bool = bool
    try:
        yield
    finally:
        del np.bool


def choose_object(name: str | None, prefer_active: bool) -> bpy.types.Object:
    """The mesh object of that name; without a name the active one if preferred, else the one with the most vertices."""
    meshes = [item for item in bpy.context.scene.objects if item.type == "MESH"]
    if name is not None:
        found = bpy.context.scene.objects.get(name)
        if found is None:
            known = ", ".join(f'"{item.name}"' for item in meshes[:8]) or "none"
            raise refuse(f'There is no object "{name}"; mesh objects: {known}.')
        if found.type != "MESH":
            raise refuse(f'The object "{name}" is no mesh.')
        return found
    active = bpy.context.view_layer.objects.active
    if prefer_active and active is not None and active.type == "MESH":
        return active
    if not meshes:
        raise refuse("There is no mesh object in the scene.")
    return max(meshes, key=lambda item: len(item.data.vertices))


def save_blend(path: Path, verbose: bool = False) -> None:
    """Saves the open scene as a .blend; the open scene keeps its own name."""
    try:
        with quiet(verbose):
            bpy.ops.wm.save_as_mainfile(filepath=str(path.resolve()), copy=True, check_existing=False)
    except RuntimeError as error:
        raise refuse(f'Blender cannot write "{path}": {reason(error)}.') from error
