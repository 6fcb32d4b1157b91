"""Blender's scene as the commands see it, the twin of FileSource in paradesc/commands/sources.py.

It also adds the command line of an enabled add-on, `blender -c paradesc …`, which exists since Blender 4.2.
"""

import argparse
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import bpy

from paradesc.bridge import InputError, ParadescError, abi
from paradesc.commands.common import BLENDER, UsageError
from paradesc.commands.main import main
from paradesc.commands.sources import Opened, Source, Subject, find
from paradesc.core import job
from paradesc.core.color_maps import Look
from paradesc.core.standard_streams import quiet
from paradesc.files import cache
from paradesc.files.frame_baking import FrameRequest
from paradesc.files.reading import Read
from paradesc.files.results import Baked

from .animation import frames
from .scene import delivery, mesh_io, modes, record, scene_io, targets
from .settings import animation, hooks, looks, preset_folders, properties
from .settings.looks import scene_look


class SceneSource(Source):
    """The open scene, or the input opened as one."""

    unwraps = True

    def __init__(self, arguments: argparse.Namespace, is_open: bool) -> None:
        super().__init__(arguments)
        self.is_open = is_open

    def open(self) -> list[str]:
        """Opens the input, or takes the open scene; returns notes about what Blender imported."""
        if self.arguments.input is not None:
            return scene_io.open_scene(self.arguments.input, self.arguments.verbose)
        if not self.is_open:
            raise UsageError(f"INPUT is missing; give a file: {', '.join(scene_io.SUFFIXES)}.")
        bpy.context.view_layer.update()  # a script may have moved objects
        return []

    # ---- Objects

    @property
    def meshes(self) -> list[bpy.types.Object]:
        """The scene's mesh objects."""
        return scene_io.mesh_objects()

    def all(self) -> Opened:
        """The objects that --all asks for."""
        return Opened(*scene_io.all_objects(getattr(self.arguments, "source", None) or self.arguments.usual_source))

    def described(self) -> list[bpy.types.Object]:
        """The objects that --object names, or all but shapes of bones."""
        return self.asked() or [item for item in self.meshes if item not in scene_io.bone_shapes()]

    def one(self, name: str | None = None) -> bpy.types.Object:
        """The object of this name, the active one of a .blend, or the largest."""
        if name is None:
            given = self.arguments.input
            return scene_io.choose_object(prefer_active=given is None or given.suffix.lower() == ".blend")
        found = bpy.context.scene.objects.get(name)
        if found is not None and found.type != "MESH":
            raise InputError(f'The object "{name}" is not a mesh.')
        return found or find(self.meshes, name)

    @contextmanager
    def detailed(self) -> Iterator[list[bpy.types.Object]]:
        """The scene's objects, or those of --from-file, which are in the scene until the end."""
        other, before = self.arguments.from_file, set(bpy.data.objects)
        try:
            yield self.meshes if other is None else scene_io.add_objects(other, self.arguments.verbose)
        finally:  # data that only they use is then not saved
            for item in set(bpy.data.objects) - before:
                bpy.data.objects.remove(item)

    def named(self, there: list[bpy.types.Object], names: list[str]) -> list[bpy.types.Object]:
        """The objects of these names, of another file also by the numbers that Blender adds; without names all."""
        added = self.arguments.from_file is not None
        found = [find(there, name, numbered=added) for name in dict.fromkeys(names)]
        return found or [item for item in there if item.data.polygons]

    def mesh_name(self, target: bpy.types.Object) -> str:
        """The name of the object's mesh."""
        return target.data.name_full

    def subject(self, target: bpy.types.Object) -> Subject:
        """The object as something to describe."""
        mesh = target.data
        facts: dict[str, object] = {
            "object": target.name,
            "mesh": mesh.name,
            "renders": not target.hide_render,
            "linked": mesh.library is not None or mesh.override_library is not None,
            "scale": [round(float(size), 6) for size in target.matrix_world.to_scale()],
            "modifiers": [modifier.type for modifier in target.modifiers],
            "shape_keys": len(mesh.shape_keys.key_blocks) if mesh.shape_keys else 0,
            "uv_maps": [layer.name for layer in mesh.uv_layers],
            "baked": record.attributes_of(mesh),
            "obstacle": "",
        }
        uvs, active = mesh_io.read_uvs(mesh), mesh.uv_layers.active
        return Subject(
            facts, len(mesh.vertices), len(mesh.polygons), active.name if active else None, uvs,
            lambda: mesh_io.read_object(target, corner_normals=False, needs_uvs=False),
        )  # fmt: skip

    # ---- Meshes

    def read(self, target: bpy.types.Object, settings: job.Settings) -> Read:
        """Reads the object's mesh, by --source before or after modifiers."""
        with quiet(self.arguments.verbose):
            return targets.read(target, settings, self.request())

    read_high = read  # a detailed object

    def check_writable(self, chosen: list[bpy.types.Object]) -> None:
        """Refuses objects whose meshes cannot take results."""
        for target in chosen:
            mesh_io.check_writable(target)

    def write(self, chosen: list[bpy.types.Object], baked: list[Baked]) -> None:
        """Writes the results to the scene; objects that share a mesh get the results of the first one."""
        for sharing in targets.by_mesh(chosen):
            one = baked[chosen.index(sharing[0])]
            one.notes += delivery.deliver(sharing[0], one.results, one.reading)
            one.notes += targets.shared_note(sharing, one.results.settings.space, one.reading.source)

    def save(self, path: Path) -> None:
        """Saves the open scene as a .blend, first to a temporary file; the open scene keeps its own path."""
        try:
            with quiet(self.arguments.verbose):
                bpy.ops.wm.save_as_mainfile(filepath=str(path.resolve()), copy=True, check_existing=False)
        except RuntimeError as error:
            sentence = f'Blender cannot write "{path}": {scene_io.reason(error)}.'
            raise ParadescError(abi.STATUS_UNKNOWN, sentence) from error

    # ---- Frames

    def frame_range(self) -> range:
        """The frames of the open scene."""
        scene = bpy.context.scene
        return range(scene.frame_start, scene.frame_end + 1, max(1, scene.frame_step))

    def cache_folder(self) -> Path:
        """The folder that --cache names, or one beside the .blend."""
        if self.arguments.cache is not None:
            return self.arguments.cache
        if not bpy.data.filepath:
            raise UsageError("There is no .blend to keep the frames beside; give --cache FOLDER.")
        return Path(bpy.data.filepath).parent / cache.DEFAULT_FOLDER

    @contextmanager
    def frame_baker(self, target: bpy.types.Object, request: FrameRequest) -> Iterator[frames.FrameBaker]:
        """Yields what bakes the object's frames; the scene is at its own frame again at the end.

        A file may have been saved in edit mode, which does not show the animation.
        """
        scene = bpy.context.scene
        with modes.object_mode(target):
            source = frames.source_of(target, request.source)
            request = replace(request, source=source, maps=self.request().maps)
            with quiet(self.arguments.verbose):
                baker = frames.FrameBaker(scene, target, request)
            with baker, frames.frame_kept(scene), baker.evaluating():
                yield baker

    # ---- Settings

    def settings(self, usual: str) -> job.Settings:
        """The panel's settings, for --scene-settings; those that are no part of a computation go to the options.

        usual: the command's own source, which tells whether it bakes frames.
        """
        arguments = self.arguments
        with scene_settings() as scene:
            group, animated = scene.paradesc, scene.paradesc_animation
            if not arguments.source:
                arguments.source = animated.source if usual == "original" else animation.frame_source(animated)
            arguments.relative_to_rest = arguments.relative_to_rest or animated.relative_to_rest
            arguments.shape_key = arguments.shape_key or group.shape_key
            if arguments.cage is None:
                arguments.cage = group.cage
            if not (arguments.displacement or arguments.normal_map):
                arguments.material_maps = arguments.material_maps or group.material_maps
            return properties.job_settings(group)

    def look(self) -> Look:
        """The scene's look, for --scene-settings."""
        with scene_settings() as scene:
            return scene_look(scene)

    # The presets of Blender's folders.
    presets = staticmethod(preset_folders.every_row)


@contextmanager
def scene_settings() -> Iterator[bpy.types.Scene]:
    """The open scene with the panels' settings, which are in the .blend whether or not the add-on is enabled."""
    if hasattr(bpy.types.Scene, "paradesc"):
        yield bpy.context.scene
        return
    modules = (properties, looks, animation)
    hooks.clear_at_end([*looks.classes, *animation.classes])
    for module in modules:
        hooks.add(module)
    try:
        yield bpy.context.scene
    finally:
        for module in modules:
            hooks.remove(module)


classes = ()
# The handle that Blender returned for the command, which is needed to remove the command.
handles: list[object] = []


def register() -> None:
    """Lets commands read the scene by this add-on, and adds the command, if this Blender has commands."""
    BLENDER.append(SceneSource)
    if hasattr(bpy.utils, "register_cli_command"):
        handles.append(bpy.utils.register_cli_command("paradesc", main))


def unregister() -> None:
    """Removes both."""
    while SceneSource in BLENDER:
        BLENDER.remove(SceneSource)
    while handles:
        bpy.utils.unregister_cli_command(handles.pop())
