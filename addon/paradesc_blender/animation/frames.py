"""Bakes frames of an animated object into files of a frame cache, for the animate command and the Bake Frames operator.

prepare() needs Blender's main thread, run() runs on any thread.
"""

import time
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from pathlib import Path

import bpy
import numpy as np

from paradesc.bridge import InputError, MeshArrays, ParadescError
from paradesc.core import source_kinds
from paradesc.core.digests import digest
from paradesc.files.frame_baking import Baker, FrameRequest, Task, at_frame
from paradesc.files.reading import Read

from ..scene import mesh_io, source_meshes, surface_maps
from . import pausing

OWN_VERTICES = (
    "The modifiers do not keep the original vertices, so the frames hold the values of the evaluated mesh: they can "
    "be read, but not played on the object."
)


def source_of(target: bpy.types.Object, source: str) -> str:
    """The source of the object's frames, as the scene or an option names it.

    The automatic source is the evaluated mesh if it keeps the object's own vertices, so that its frames can be played
    on the object, and the deformed mesh otherwise.
    """
    if source != source_kinds.AUTOMATIC:
        return source
    evaluated = source_meshes.read(target, source_kinds.EVALUATED, needs_uvs=False)
    return source_kinds.EVALUATED if evaluated.own else source_kinds.DEFORMED


class FrameBaker(Baker):
    """Bakes frames of one object. Its own mesh is the rest pose, from which all frames take radii and rest values."""

    def __init__(self, scene: bpy.types.Scene, target: bpy.types.Object, request: FrameRequest) -> None:
        self.scene, self.target = scene, target
        self.former: Read | None = None
        self.scene_file = Path(bpy.data.filepath).name
        super().__init__(target.name, target.data.name, request)

    def read_base(self, needs_uvs: bool) -> MeshArrays:
        """The object's own mesh."""
        base = mesh_io.read_object(self.target, self.normals, needs_uvs)
        self.add_maps(base)
        return base

    def add_maps(self, arrays: MeshArrays) -> None:
        """Puts the displacement into the arrays; normal maps would need the tangents of every frame."""
        notes = surface_maps.add_maps(self.target, arrays, self.request.maps)
        if arrays.maps is not None and arrays.maps.normals is not None:
            raise InputError("Normal maps are followed in single bakes only; leave them out to bake frames.")
        self.tell(notes)

    def prepare(self, frame: int) -> Task | None:
        """Goes to the frame and reads the object there; None if its file exists already. Main thread only."""
        start = time.perf_counter()
        with self.evaluating():
            self.scene.frame_set(frame)
            bpy.context.view_layer.update()
            moved = time.perf_counter()
            args = (self.request.source, self.normals, self.needs_uvs, self.base, self.former)
            try:
                read = source_meshes.read(self.target, *args)
            except ParadescError as error:
                raise at_frame(frame, error) from error
        self.former, arrays = read, read.arrays  # the next frame is read faster with it
        content = digest(arrays.positions, arrays.corner_normals, read.vertices)
        if arrays.corner_vertices is not self.base.corner_vertices:
            if self.request.relative:
                raise InputError(
                    f'The modifiers of "{self.target.name}" change its vertices, so there is no rest pose to compare '
                    f"with; choose the source {source_kinds.in_words('deformed')}."
                )
            self.add_maps(arrays)
            content = digest(np.frombuffer(content.encode(), np.uint8), arrays.corner_vertices, arrays.corner_uvs)
        self.tell(read.notes if read.own else [OWN_VERTICES])
        seconds = {"depsgraph": moved - start, "read": time.perf_counter() - moved}
        return None if self.is_kept(frame, content) else Task(frame, read, content, seconds)

    @contextmanager
    def evaluating(self) -> Iterator[None]:
        """Hides modifiers that are not measured during evaluation; without a window, hold it over all frames."""
        deformed = self.request.source == "deformed"
        with pausing.held(), source_meshes.only_deforming(self.target) if deformed else nullcontext([]) as hidden:
            if hidden:
                names = source_meshes.quoted(hidden)
                sentence = f"Measured without the modifiers that change the vertices: {names}."
                self.tell([sentence])
            yield


@contextmanager
def frame_kept(scene: bpy.types.Scene) -> Iterator[None]:
    """Comes back to the frame that was current, whatever happens."""
    frame, part = scene.frame_current, scene.frame_subframe
    try:
        yield
    finally:
        scene.frame_set(frame, subframe=part)
