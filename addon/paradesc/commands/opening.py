"""Opens the input, in Blender or without, and picks the objects to work on."""

import argparse
import sys
from dataclasses import dataclass, field

from ..core.standard_streams import quiet
from . import file_reading
from .common import UsageError, print_notes
from .reading import Target


@dataclass
class Opened:
    """The objects to work on, and notes about how they were found."""

    objects: list[Target]
    notes: list[str] = field(default_factory=list)
    beside: list[Target] = field(default_factory=list)  # all meshes of a file that was read without Blender


def open_input(arguments: argparse.Namespace) -> tuple[bool, list[str]]:
    """Opens the input, or takes the open scene. Returns whether a file was imported, and notes about the import."""
    scene_is_open = "bpy" in sys.modules  # in Blender, and in scripts that made a scene
    try:
        with quiet(arguments.verbose):
            import bpy  # before bmesh, which scene_io imports

            from ..scene import scene_io
    except ImportError as error:
        raise file_reading.missing(arguments) from error
    if arguments.input is not None:
        notes = scene_io.open_scene(arguments.input, arguments.verbose)
        return arguments.input.suffix.lower() != ".blend", notes
    if not scene_is_open:
        raise UsageError(f"INPUT is missing; give a file: {', '.join(scene_io.SUFFIXES)}.")
    bpy.context.view_layer.update()  # a script may have moved objects
    return False, []


def open_object(arguments: argparse.Namespace) -> Target:
    """Opens the input and picks --object or the one that stands out; prints how it was found."""
    if file_reading.reads_files(arguments):
        names = [arguments.object] if arguments.object is not None else []
        return file_reading.chosen(file_reading.open_files(arguments), names)[0]
    imported, notes = open_input(arguments)
    from ..scene import scene_io

    print_notes(notes)
    return scene_io.choose_object(arguments.object, prefer_active=not imported)


def open_objects(arguments: argparse.Namespace) -> Opened:
    """Opens the input and picks the objects: --all of them, those that --object names, or the one that stands out."""
    if file_reading.reads_files(arguments):
        meshes = file_reading.open_files(arguments)
        return Opened(meshes if arguments.all else file_reading.chosen(meshes, arguments.object), beside=meshes)
    imported, notes = open_input(arguments)
    from ..scene import scene_io

    if arguments.all:
        chosen, left_out = scene_io.all_objects(getattr(arguments, "source", None) or arguments.usual_source)
        return Opened(chosen, notes + left_out)
    if arguments.object:
        return Opened([scene_io.find_object(name) for name in dict.fromkeys(arguments.object)], notes)
    return Opened([scene_io.choose_object(None, prefer_active=not imported)], notes)
