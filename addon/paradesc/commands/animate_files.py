"""Bakes an animation given as a sequence of mesh files, without Blender. The first file is the rest pose."""

import argparse
import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from ..bridge import InputError, MeshArrays, ParadescError, SurfaceMaps
from ..core import job
from ..core.digests import digest
from ..core.polygons import PolygonMesh
from ..core.stream import TOPOLOGY, same_topology
from ..files import cache, mesh_files, sequences
from ..files.frame_baking import Baker, FrameRequest, Task, at_frame
from ..files.map_images import MapChoice
from ..files.paths import is_folder
from ..files.reading import Read, ReadRequest, read_mesh
from .common import UsageError
from .sources import Opened, Source, check_options, chosen, reads_files, scene_source

SOURCE = "files"


@dataclass
class MeshSequence:
    """A mesh whose frames are the files of a sequence."""

    name: str
    files: dict[int, Path]  # by frame
    selector: str | None  # the mesh's name in each file; None: the largest

    @cached_property
    def first(self) -> PolygonMesh:
        """The mesh of the first file."""
        return self.mesh_at(next(iter(self.files)))

    def mesh_at(self, frame: int) -> PolygonMesh:
        """The mesh of a frame."""
        return chosen(mesh_files.read(self.files[frame]), self.selector)


class SequenceSource(Source):
    """A sequence of files, with the methods of SceneSource that commands about frames call."""

    files: dict[int, Path]

    def open(self) -> list[str]:
        """Finds the files of all frames, among them those that --frames asks for."""
        check_options(self.arguments)
        self.files = sequences.frames_of(self.arguments.input)
        lacking = [frame for frame in parse_frames(self.arguments.frames) or () if frame not in self.files]
        if lacking:
            more = f" and {len(lacking) - 1:,} more" if len(lacking) > 1 else ""
            there = f"there are frames {min(self.files)} to {max(self.files)}"
            raise InputError(f"There is no file for frame {lacking[0]}{more}; {there}.")
        return []

    def picked(self) -> Opened:
        """The meshes that the options choose, by their names in the first file."""
        arguments, first = self.arguments, next(iter(self.files.values()))
        there = mesh_files.read(first) if arguments.all or arguments.object else []
        if len(there) > 1 or arguments.object:
            picked = [chosen(there, name) for name in dict.fromkeys(arguments.object)] or there
            return Opened([MeshSequence(mesh.name, self.files, mesh.name) for mesh in picked])
        return Opened([MeshSequence(sequences.name_of(arguments.input, first), self.files, None)])

    def frame_range(self) -> Sequence[int]:
        """The frames of all files."""
        return list(self.files)

    def cache_folder(self) -> Path:
        """The folder that --cache names, or one beside the files."""
        given = self.arguments.input
        beside = (given if is_folder(given) else given.parent) / cache.DEFAULT_FOLDER
        return beside if self.arguments.cache is None else self.arguments.cache

    def frame_baker(self, mesh: MeshSequence, request: FrameRequest) -> "FileBaker":
        """Bakes the mesh's frames."""
        return FileBaker(mesh, request, self.request())


def source_of_frames(arguments: argparse.Namespace) -> Any:
    """The source of frames, which is not open yet. A single file that is read without Blender is refused."""
    given = arguments.input
    if given is None or not sequences.is_sequence(given):
        if reads_files(arguments):
            how = "a folder, frames/mesh_####.ply or 'frames/*.ply'"
            raise UsageError(f'"{given}" is one mesh and no animation; give a sequence of files: {how}.')
        return scene_source(arguments)
    if arguments.reader == "blender":
        raise UsageError("A sequence of files is read without Blender; leave --reader blender out.")
    return SequenceSource(arguments)


def parse_frames(text: str | None) -> range | None:
    """The frames that --frames asks for; None stands for those of the source."""
    try:
        return None if text is None else cache.parse_frames(text)
    except ValueError as error:
        raise UsageError(str(error)) from error


class FileBaker(Baker):
    """Bakes the frames of one mesh, each from a file."""

    def __init__(self, mesh: MeshSequence, request: FrameRequest, reading: ReadRequest) -> None:
        self.mesh, self.reading, self.settings = mesh, reading, request.settings
        self.maps: SurfaceMaps | None = None
        super().__init__(mesh.name, mesh.first.name, request)

    def open(self, settings: job.Settings) -> None:
        """Opens the device, and keeps the settings, by which the meshes of all frames are read."""
        self.settings = settings
        super().open(settings)

    def read_base(self, _needs_uvs: bool) -> MeshArrays:
        """The mesh of the first file."""
        if self.reading.maps.normal_map is not None:
            raise InputError("Normal maps are followed in single bakes only; leave them out to bake frames.")
        read = read_mesh(self.mesh.first, self.settings, self.reading)
        self.reading = replace(self.reading, maps=MapChoice())  # images are read only once
        self.maps = read.measured.maps = self.maps or read.measured.maps
        self.tell(read.sentences)
        return read.measured

    def prepare(self, frame: int) -> Task | None:
        """Reads a frame's file; None if its result is there already."""
        start = time.perf_counter()
        try:
            read = read_mesh(self.mesh.mesh_at(frame), self.settings, self.reading)
        except ParadescError as error:
            raise at_frame(frame, error) from error
        arrays = read.measured
        content = digest(arrays.positions, arrays.corner_normals)
        if same_topology(arrays, self.base):
            arrays = replace(self.base, positions=arrays.positions, corner_normals=arrays.corner_normals)
        elif self.request.relative:
            sentence = f"Frame {frame} has other faces than the first file, which is the rest pose"
            raise InputError(f"{sentence}; leave --relative-to-rest out.")
        else:
            arrays.maps = self.maps
            shape = [getattr(arrays, name) for name in TOPOLOGY]
            content = digest(np.frombuffer(content.encode(), np.uint8), *shape)
        self.tell(read.sentences)
        if self.is_kept(frame, content):
            return None
        return Task(frame, Read(arrays), content, {"depsgraph": 0.0, "read": time.perf_counter() - start})
