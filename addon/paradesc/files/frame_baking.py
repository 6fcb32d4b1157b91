"""Bakes frames of one mesh into files of a frame cache. Subclasses decide where each frame's mesh comes from.

Radii are those of the base mesh in all frames, so that values of one frame can be compared with those of another. Never
imports bpy.
"""

import time
from dataclasses import dataclass, field, replace
from operator import attrgetter
from pathlib import Path

from .. import __version__
from ..bridge import METHODS, Closing, InputError, MeshArrays, ParadescError, ProgressFunction, abi, unusable
from ..core import color_maps, fitting, job
from ..core.digests import digest
from ..core.stream import Stream, is_too_small
from . import cache
from .map_images import MapChoice
from .reading import Read, on_original

CPU_METHOD = METHODS["cpu"]


@dataclass
class FrameRequest:
    """The options for baking one object's frames."""

    settings: job.Settings
    folder: Path  # of the frames of this object
    source: str = "deformed"
    relative: bool = False  # whether to bake the change against the base mesh as well
    force: bool = False  # whether to compute existing frames again
    maps: MapChoice = field(default_factory=MapChoice)


@dataclass
class Task:
    """One frame, read, to be computed and written."""

    frame: int
    read: Read
    input: str
    seconds: dict[str, float]


@dataclass
class Done:
    """One frame that was written."""

    frame: int
    seconds: dict[str, float]
    device: str
    warnings: list[str]


class Baker(Closing):
    """Bakes the frames of one mesh, on one native mesh as long as the faces stay. Existing frames are kept."""

    scene_file = ""  # the name of the .blend, if frames come from one

    def __init__(self, object_name: str, mesh_name: str, request: FrameRequest) -> None:
        self.object_name, self.mesh_name, self.request = object_name, mesh_name, request
        settings = request.settings
        if settings.space != "object":
            raise InputError("Frames are measured in object space; choose that, and apply the scale where it matters.")
        self.normals = settings.options.normals == "mesh"
        self.notes: list[str] = []
        self.limits: list[str] = []  # of the radius, by the first frame that has any: their numbers differ a little
        self.undefined_frames: list[int] = []
        self._rest: job.Results | None = None
        self.stream: Stream | None = None
        try:
            self.open(settings)
            cache.sweep(request.folder)
            settled = self.settled()
            if settled != settings.backend:
                self.stream.close()
                self.open(replace(settings, backend=settled))
            self.key = self.make_key(self.method, self.base)
            self.notes += job.unused_notes(self.stream.backend, settings.options)
        except BaseException:
            self.close()
            raise

    def read_base(self, needs_uvs: bool) -> MeshArrays:
        """The base mesh, whose size decides the radii. Changes, if asked for, are measured against its values."""
        raise NotImplementedError

    def prepare(self, frame: int) -> Task | None:
        """Reads the mesh of a frame; None if its file exists already."""
        raise NotImplementedError

    def tell(self, notes: list[str]) -> None:
        """Adds the notes that are not among those of this mesh yet."""
        self.notes += [note for note in notes if note not in self.notes]

    def tell_undefined(self, frame: int) -> None:
        """Names the frame in the note about those in which the mesh is smaller than the radius."""
        former, self.undefined_frames = undefined_note(self.undefined_frames), [*self.undefined_frames, frame]
        self.notes = [*(note for note in self.notes if note != former), undefined_note(self.undefined_frames)]

    def open(self, settings: job.Settings) -> None:
        """Reads the base mesh as these settings need it, and opens their device."""
        self.needs_uvs = job.needs_uvs(settings)
        self.base = self.read_base(self.needs_uvs)
        self.stream = Stream(self.base, settings)
        self.stream.settings = with_fixed_radii(self.stream, self.base, settings)
        self.method = METHODS[self.stream.backend]

    def settled(self) -> str:
        """The backend for these frames. Under auto it is one with the method of the frames that exist already."""
        own = self.request.settings.backend
        if own != "auto":
            return own
        # Without a layout made for the computation, as some methods need one and others do not.
        plain = self.base if self.base.layout is None else replace(self.base, corner_uvs=None, layout=None)
        animation = self.make_key("", plain)
        method = cache.settled_method(self.request.folder, animation, self.method)
        if method == self.method:
            return own
        return "cpu" if method == CPU_METHOD else "software"

    def make_key(self, method: str, base: MeshArrays) -> str:
        """A key of the facts that all frames share."""
        maps = base.maps
        rest = digest(base.positions) if self.request.relative else ""
        images = digest(maps.heights) + f"{maps.midlevel!r} {maps.scale!r}" if maps is not None else ""
        more = {"source": self.request.source, "rest": rest, "maps": images, "paradesc": __version__}
        return cache.key_of(base, self.stream.settings, method, names=self.request.settings.value_names(), **more)

    def is_kept(self, frame: int, content: str) -> bool:
        """Returns whether the frame exists already with the same key and input."""
        there = cache.sound_frame(self.request.folder, frame)
        if there is None:
            return False
        if not self.request.force and (there.key, there.input) == (self.key, content):
            return True
        if other := there.other_scene(self.scene_file):
            sentence = f'Frames that "{other}" had in "{self.request.folder}" were replaced'
            self.tell([f"{sentence}; to keep the frames of both files, give each its own cache folder."])
        return False

    def run(self, task: Task, progress: ProgressFunction | None = None) -> Done:
        """Computes a frame and writes its file."""
        try:
            rest = self.rest(progress) if self.request.relative else None
            start = time.perf_counter()
            arrays = task.read.arrays
            if not self.stream.matches(arrays):
                self.stream.replace(arrays)
            results = self.stream.compute(arrays.positions, progress, arrays.corner_normals)
            computed = time.perf_counter()
            cache.write_frame(self.request.folder, self.content(task, results, rest))
            if is_too_small(results):
                self.tell_undefined(task.frame)
        except ParadescError as error:
            raise at_frame(task.frame, error) from error
        report = list(results.field_reports.values())
        native = {name: sum(part[f"seconds_{name}"] for part in report) for name in ("prepare", "bake", "evaluate")}
        total = sum(part["seconds_total"] for part in report)
        write = {"write": time.perf_counter() - computed}
        seconds = {**task.seconds, "upload": computed - start - total, **native, **write}
        self.limits = self.limits or results.facet_notes()
        warnings = [*results.warnings, *self.limits]
        return Done(task.frame, seconds, f"{results.backend}: {results.device}", warnings)

    def rest(self, progress: ProgressFunction | None) -> job.Results:
        """The results of the base mesh, computed on first use."""
        if self._rest is None:
            self._rest = self.stream.compute(self.base.positions, progress, self.base.corner_normals)
        return self._rest

    def content(self, task: Task, results: job.Results, rest: job.Results | None) -> cache.Frame:
        """The content of a frame's file."""
        found = on_original(results, task.read.vertices)  # where those are still there
        values, radius = {}, {}
        for asked, name in zip(self.request.settings.value_names(), found.settings.value_names(), strict=True):
            values[asked] = found.values[name]
            radius[asked] = results.radius_of(name)
            if rest is not None and found.values[name].ndim == 1:
                values[asked + job.CHANGE] = found.values[name] - rest.values[name]
                radius[asked + job.CHANGE] = radius[asked]
        settings = self.request.settings.as_dict()
        for own in ("backend", "device_index"):
            del settings[own]
        info = {
            "object": self.object_name,
            "mesh": self.mesh_name,
            "source": self.request.source,
            "vertices": "original" if task.read.own else "evaluated",
            "settings": settings,
            "radius": radius,
            "warnings": results.warnings,
        }
        if self.scene_file:
            info["scene"] = self.scene_file
        return cache.Frame(task.frame, self.key, task.input, {**values, **found.extras}, info)

    def close(self) -> None:
        """Frees the device."""
        if self.stream is not None:
            self.stream.close()


def undefined_note(frames: list[int]) -> str:
    """The note about frames in which nothing can be measured."""
    names = ", ".join(map(str, frames))
    return f"The mesh is smaller than the radius in these frames, whose values are undefined: {names}."


def at_fixed_radii(settings: job.Settings, report: dict[str, float | int]) -> job.Settings:
    """The settings with radii in units of the positions, so that they do not depend on the size of a frame's mesh."""
    unit = {"diagonal": report["diagonal"], "mean-edge": report["mean_edge"]}.get(settings.options.radius_unit, 1.0)
    options = replace(settings.options, radius=settings.options.radius * unit, radius_unit="absolute")
    return replace(settings, options=options, more_radii=tuple(radius * unit for radius in settings.more_radii))


def with_fixed_radii(stream: Stream, arrays: MeshArrays, settings: job.Settings) -> job.Settings:
    """The settings with the radii that a bake of these arrays would have, fitted to the mesh if they ask for that."""
    report = stream.mesh_at(arrays).report()
    found = at_fixed_radii(job.fitted(settings, arrays), report)
    largest, diagonal = max((found.options.radius, *found.more_radii)), report["diagonal"]
    if largest > diagonal:
        sentence = f"The radius is {largest:.6g}, but the mesh's diagonal is only {diagonal:.6g}"
        raise unusable(f"{sentence}; choose a smaller radius.")
    if settings.radius_fit not in fitting.NARROWED or not color_maps.EDGES & set(settings.descriptors):
        return found

    def compute(chosen: job.Settings) -> job.Results:
        stream.settings = chosen
        return stream.compute(arrays.positions, corner_normals=arrays.corner_normals)

    return fitting.narrowed(found, compute, attrgetter("values")).settings


def at_frame(frame: int, error: ParadescError) -> ParadescError:
    """The error, with the frame named in its sentence."""
    if error.status == abi.STATUS_CANCELLED or error.sentence.startswith("Frame "):
        return error
    sentence = f"Frame {frame}: {error.sentence}"
    return InputError(sentence) if isinstance(error, InputError) else ParadescError(error.status, sentence)
