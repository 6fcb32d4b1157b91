"""Bakes frames of several objects into their caches, one object after the other, without blocking the window."""

from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import bpy

from ..bake.pieces import Piece, Pieces, key_of, stage_words
from ..bridge import ParadescError, abi
from ..core import job
from ..core.threads import Worker
from ..files import cache
from ..scene import surface_maps, targets
from ..scene.mesh_io import refuse
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
        group = scene.paradesc_animation
        self.wanted, self.beside = wanted, beside
        self.settings = properties.job_settings(scene.paradesc)
        job.check_descriptors(self.settings.descriptors)
        self.options = (group.relative_to_rest, group.overwrite)
        self.material_maps = scene.paradesc.material_maps
        super().__init__(pieces_of(targets.chosen(context), root))
        self.next = 0  # index of the next one of the wanted frames
        self.baker: frames.FrameBaker | None = None
        self.scene_name, self.former = scene.name, (scene.frame_current, scene.frame_subframe)
        self._open = ExitStack()  # closed when the piece under way is left
        self._held = pausing.hold()

    @property
    def under_way(self) -> bool:
        """Whether an object is open, which it is from its first frame to its last, also between two workers."""
        return self.baker is not None

    @property
    def fraction(self) -> float:
        """The finished share of all the work."""
        if self.current == len(self.pieces):
            return 1.0
        under_way = self.worker is not None and not self.worker.done
        frames_done = self.next - 1 + self.worker.fraction if under_way else self.next
        return (self.current + frames_done / len(self.wanted)) / len(self.pieces)

    @property
    def stage(self) -> str:
        """Words for the step under way, shown as progress."""
        piece = self.pieces[min(self.current, len(self.pieces) - 1)]
        frame = self.wanted[max(0, self.next - 1)]
        stage = stage_words(self.worker.stage if self.worker else "read")
        text = label("{stage}, frame {frame} of {first} to {last}")
        text = text.format(stage=stage, frame=frame, first=self.wanted[0], last=self.wanted[-1])
        return text if len(self.pieces) == 1 else f'"{piece.name}": {text}'

    def step(self, wait: bool = False) -> None:
        """Opens the next object, or takes in the frame that has been computed and begins the next one."""
        if self.done:
            return
        piece = self.pieces[self.current]
        if self.baker is None:
            self.attempt(piece, self.open)
        elif wait or self.worker is None or self.worker.done:
            self.attempt(piece, self.advance)

    def attempt(self, piece: ObjectFrames, action: Callable[[ObjectFrames], None]) -> None:
        """Runs one step for an object. An error becomes the failure of this object, and the others go on."""
        try:
            action(piece)
        except ReferenceError:
            self.leave(piece, f'The object "{piece.name}" is gone; its frames so far are in the cache.')
        except ParadescError as error:
            self.cancelled = self.cancelled or error.status == abi.STATUS_CANCELLED
            self.leave(piece, "" if self.cancelled else error.sentence)

    def open(self, piece: ObjectFrames) -> None:
        """Reads an object and makes its native mesh."""
        target, scene = bpy.data.objects.get(piece.key), bpy.data.scenes.get(self.scene_name)
        if target is None or target.type != "MESH" or scene is None:
            raise refuse(f'The object "{piece.name}" is gone; it has no frames.')
        if piece.failure:
            raise refuse(piece.failure)
        maps = surface_maps.MapChoice(material=self.material_maps)
        source = frames.source_of(target, frame_source(scene.paradesc_animation))
        request = frames.FrameRequest(self.settings, piece.folder, source, *self.options, maps if maps.any else None)
        baker = frames.FrameBaker(scene, target, request)
        self.baker, self.next = baker, 0
        self._open.callback(baker.close)
        piece.cache_key = baker.key
        if not self.beside:
            self._open.enter_context(baker.evaluating())

    def advance(self, piece: ObjectFrames) -> None:
        """Takes in a frame and starts the next one; after the last one, closes the object."""
        if self.worker is not None:
            self.join().result()
            piece.made += 1
        if self.cancelled or self.next == len(self.wanted):
            self.leave(piece, "")
            return
        task = self.baker.prepare(self.wanted[self.next])
        self.next += 1
        if task is not None:
            self.worker = Worker(partial(self.baker.run, task), "paradesc frames")
            self.worker.start()

    def leave(self, piece: ObjectFrames, failure: str) -> None:
        """Closes an object and continues with the next one."""
        piece.failure = failure
        if self.baker is not None:
            piece.notes = list(self.baker.notes)
        self.baker = self.worker = None
        self.current, self.next = self.current + 1, 0
        opened, self._open = self._open, ExitStack()
        opened.close()

    def close(self) -> None:
        """Cancels the rest, returns to the former frame, and ends the wait of live values. Safe to call again."""
        self.settle()
        if self._held is None:
            return
        pausing.release(self._held)
        self._held, scene = None, bpy.data.scenes.get(self.scene_name)
        if scene is not None:
            frame, part = self.former
            scene.frame_set(frame, subframe=part)

    def hold_ranges(self) -> None:
        """Stores color ranges that span all baked frames of all objects, for live and played objects of the scene."""
        scene = bpy.data.scenes.get(self.scene_name)
        places = [(piece.folder, piece.cache_key) for piece in self.pieces if piece.cache_key and not piece.failure]
        if scene is None or not places:
            return
        look = looks.scene_look(scene)
        if not look.ranges:
            with sessions.our_turn(wait=True):
                painting.hold_ranges(scene.paradesc_live, look, cache.ranges_over(places, look))
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
            piece.failure = f'Another object is called "{item.name}" as well, and has its frames there; rename one.'
        pieces.append(piece)
    return pieces
