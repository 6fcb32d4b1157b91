"""Bakes frames of several objects into their caches, one object after the other, without blocking the window."""

from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import bpy

from paradesc.bridge import InputError
from paradesc.core import job
from paradesc.files import cache

from ..bake.pieces import Piece, Pieces, Work, computed, key_of, stage_words
from ..scene import surface_maps, targets
from ..settings import looks, properties
from ..settings.animation import frame_source
from ..settings.translation import label
from . import frames, painting, pausing, sessions


@dataclass
class ObjectFrames(Piece):
    """The frames of one object: which object it is, and the results."""

    folder: Path
    cache_key: str = ""  # of its frames
    made: int = 0


class FrameBatch(Pieces):
    """Runs Bake Frames step by step. Only the computation leaves the main thread. Live values wait meanwhile."""

    def __init__(self, context: bpy.types.Context, wanted: range, root: Path, beside: bool) -> None:
        """Takes the settings and the chosen objects. beside: whether a window has to stay responsive meanwhile."""
        scene = context.scene
        group, maps = scene.paradesc_animation, surface_maps.MapChoice(material=scene.paradesc.material_maps)
        settings, options = properties.job_settings(scene.paradesc), (group.relative_to_rest, group.overwrite)
        job.check_descriptors(settings.descriptors)
        self.request = frames.FrameRequest(settings, root, frame_source(group), *options, maps)
        self.wanted, self.beside = wanted, beside
        super().__init__(pieces_of(targets.chosen(context), root))
        self.next = 0  # how many of the wanted frames of the current object have been begun
        self.baker: frames.FrameBaker | None = None
        self.scene_name, self.former = scene.name, (scene.frame_current, scene.frame_subframe)

    def work(self) -> Work:
        """Bakes all objects while live values wait, and comes back to the former frame, cancelled or not."""
        try:
            with pausing.held():
                yield from super().work()
        finally:
            scene, (frame, part) = bpy.data.scenes.get(self.scene_name), self.former
            if scene is not None:
                scene.frame_set(frame, subframe=part)

    @property
    def fraction(self) -> float:
        """The finished share of all the work."""
        under_way = self.worker is not None and not self.worker.done
        frames_done = self.next - 1 + self.worker.fraction if under_way else self.next
        return min((self.current + frames_done / len(self.wanted)) / len(self.pieces), 1.0)

    @property
    def stage(self) -> str:
        """Words for the step under way, shown as progress."""
        piece = self.pieces[min(self.current, len(self.pieces) - 1)]
        frame = self.wanted[max(0, self.next - 1)]
        text = label("{stage}, frame {frame} of {first} to {last}")
        text = text.format(stage=stage_words(self.worker), frame=frame, first=self.wanted[0], last=self.wanted[-1])
        return text if len(self.pieces) == 1 else f'"{piece.name}": {text}'

    @contextmanager
    def attempt(self, piece: ObjectFrames) -> Iterator[None]:
        """Makes an error the failure of this object, so that the others go on; closes the object."""
        try:
            with super().attempt(piece):
                yield
        except ReferenceError:
            piece.failure = f'The object "{piece.name}" is gone; its frames so far are in the cache.'
        finally:
            piece.notes = [] if self.baker is None else list(self.baker.notes)
            self.baker, self.next = None, 0

    def work_on(self, piece: ObjectFrames) -> Work:
        """Opens an object and bakes its frames."""
        target, scene = bpy.data.objects.get(piece.key), bpy.data.scenes.get(self.scene_name)
        if target is None or target.type != "MESH" or scene is None:
            raise InputError(f'The object "{piece.name}" is gone; it has no frames.')
        if piece.failure:
            raise InputError(piece.failure)
        source = frames.source_of(target, self.request.source)
        request = replace(self.request, folder=piece.folder, source=source)
        self.baker = baker = frames.FrameBaker(scene, target, request)
        piece.cache_key = baker.key
        with baker, nullcontext() if self.beside else baker.evaluating():
            yield None
            for frame in self.wanted:
                task = baker.prepare(frame)
                self.next += 1
                if task is None:
                    yield None
                else:
                    yield from computed(partial(baker.run, task), "paradesc frames")
                    piece.made += 1

    def hold_ranges(self) -> None:
        """Stores color ranges that span all baked frames of all objects, for live and played objects of the scene."""
        scene = bpy.data.scenes.get(self.scene_name)
        places = {piece.folder: piece.cache_key for piece in self.written if piece.cache_key}
        if scene is None or not places:
            return
        look = looks.scene_look(scene)
        if not look.ranges:
            with sessions.our_turn(wait=True):
                painting.hold_ranges(scene.paradesc_live, look, cache.locked_ranges(places, look))
        sessions.forget_ranges()

    @property
    def made(self) -> int:
        """The number of frames that had to be computed."""
        return sum(piece.made for piece in self.pieces)


def pieces_of(objects: list[bpy.types.Object], root: Path) -> list[ObjectFrames]:
    """Makes a piece for each object, each with a folder of its own."""
    pieces: list[ObjectFrames] = []
    for item in objects:
        folder = cache.object_folder(root, item.name, [other.folder for other in pieces])
        piece = ObjectFrames(key_of(item), folder)
        if any(other.folder == piece.folder for other in pieces):
            piece.failure = (
                f'Another object is also called "{item.name}" and keeps its frames in the same folder; rename one.'
            )
        pieces.append(piece)
    return pieces
