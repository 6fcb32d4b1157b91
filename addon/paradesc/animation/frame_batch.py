"""Frames of several objects into their caches, object after object, the computation on a thread beside the window."""

import threading
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path

import bpy

from ..bake.batch import key_of
from ..bridge import ParadescError, abi
from ..core import job, threads
from ..files import cache
from ..scene import surface_maps, targets
from ..scene.mesh_io import refuse
from ..settings import looks, properties
from . import frames, handlers, painting, pausing


class FrameWorker:
    """Computes and writes one frame after another on threads of their own; ask it from the main thread."""

    def __init__(self, baker: frames.FrameBaker) -> None:
        self.baker = baker
        self.stage = "start"
        self.fraction = 0.0
        self._cancelled = threading.Event()
        self._error: Exception | None = None
        self._thread: threading.Thread | None = None

    def start(self, task: frames.Task) -> None:
        """Starts with a frame; the one before has to be done."""
        self.fraction = 0.0
        self._thread = threads.start("paradesc frames", partial(self._run, task), self.cancel)

    @property
    def idle(self) -> bool:
        """True where the next frame can be started."""
        return self._thread is None or not self._thread.is_alive()

    def cancel(self) -> None:
        """Asks the native call to stop at its next tile."""
        self._cancelled.set()

    def wait(self) -> bool:
        """Waits for the frame under way, and raises what went wrong with it; False where there was none."""
        if self._thread is None:
            return False
        self._thread.join()
        self._thread = None
        if self._error is not None:
            raise self._error
        return True

    def _run(self, task: frames.Task) -> None:
        try:
            self.baker.run(task, self._progress)
        except Exception as error:  # noqa: BLE001 (raised again on the main thread by wait())
            self._error = error

    def _progress(self, stage: str, fraction: float) -> bool:
        self.stage, self.fraction = stage, fraction
        return not self._cancelled.is_set()


@dataclass
class Piece:
    """One object's frames: which object, and what came of it."""

    key: tuple[str, str | None]  # the object's name and library
    folder: Path
    cache_key: str = ""  # of its frames
    made: int = 0
    failure: str = ""  # one sentence
    notes: list[str] = field(default_factory=list)

    @property
    def name(self) -> str:
        """The object's name."""
        return self.key[0]


class FrameBatch:
    """What Bake Frames does step by step, all on the main thread but the computation itself. Live values wait."""

    def __init__(self, context: bpy.types.Context, wanted: range, root: Path, beside: bool) -> None:
        """Takes the settings and the chosen objects; beside: a window lives, and computing goes on beside it."""
        scene = context.scene
        group = scene.paradesc_animation
        self.wanted, self.beside = wanted, beside
        self.settings = properties.job_settings(scene.paradesc)
        job.check_descriptors(self.settings.descriptors)
        self.options = (group.frame_source, group.relative_to_rest, group.overwrite)
        self.material_maps = scene.paradesc.material_maps
        self.pieces = pieces_of(targets.chosen(context), root)
        self.current = self.next = 0  # which piece, and which of the wanted frames
        self.baker: frames.FrameBaker | None = None
        self.worker: FrameWorker | None = None
        self.cancelled = False
        self.scene_name, self.former = scene.name, (scene.frame_current, scene.frame_subframe)
        self._open = ExitStack()  # of the piece under way
        self._held = pausing.hold()

    @property
    def done(self) -> bool:
        """Whether every object has its frames or has failed, or all is at rest after cancelling."""
        return self.baker is None and (self.cancelled or self.current == len(self.pieces))

    @property
    def fraction(self) -> float:
        """The finished share of all the work."""
        if self.current == len(self.pieces):
            return 1.0
        under_way = self.worker is not None and not self.worker.idle
        frames_done = self.next - 1 + self.worker.fraction if under_way else self.next
        return (self.current + frames_done / len(self.wanted)) / len(self.pieces)

    @property
    def stage(self) -> str:
        """What is being done, for people."""
        piece = self.pieces[min(self.current, len(self.pieces) - 1)]
        frame = self.wanted[max(0, self.next - 1)]
        text = f"frame {frame} of {self.wanted[0]} to {self.wanted[-1]}, {self.worker.stage if self.worker else 'read'}"
        if len(self.pieces) == 1:
            return text
        return f'object {self.current + 1} of {len(self.pieces)}, "{piece.name}", {text}'

    def step(self) -> None:
        """Opens the next object, or takes in the frame that has been computed and begins the next one."""
        if self.done:
            return
        piece = self.pieces[self.current]
        if self.baker is None:
            self.attempt(piece, self.open)
        elif not self.beside or self.worker.idle or self.cancelled:
            self.attempt(piece, self.advance)

    def attempt(self, piece: Piece, action: Callable[[Piece], None]) -> None:
        """Does something about one object; what goes wrong is its failure, and the others go on."""
        try:
            action(piece)
        except ReferenceError:
            self.leave(piece, f'The object "{piece.name}" is gone; its frames so far are in the cache.')
        except ParadescError as error:
            self.cancelled = self.cancelled or error.status == abi.STATUS_CANCELLED
            self.leave(piece, "" if self.cancelled else error.sentence)

    def open(self, piece: Piece) -> None:
        """Reads an object and makes its native mesh."""
        target, scene = bpy.data.objects.get(piece.key), bpy.data.scenes.get(self.scene_name)
        if target is None or target.type != "MESH" or scene is None:
            raise refuse(f'The object "{piece.name}" is gone; it has no frames.')
        if piece.failure:
            raise refuse(piece.failure)
        maps = surface_maps.Sources(material=self.material_maps)
        request = frames.Request(self.settings, piece.folder, *self.options, maps if maps.any else None)
        baker = frames.FrameBaker(scene, target, request)
        self.baker, self.worker, self.next = baker, FrameWorker(baker), 0
        self._open.callback(baker.close)
        piece.cache_key = baker.key
        if not self.beside:
            self._open.enter_context(baker.evaluating())

    def advance(self, piece: Piece) -> None:
        """Takes in a frame and begins the next one; after the last one leaves the object."""
        piece.made += self.worker.wait()
        if self.cancelled or self.next == len(self.wanted):
            self.leave(piece, "")
            return
        task = self.baker.prepare(self.wanted[self.next])
        self.next += 1
        if task is not None and self.beside:
            self.worker.start(task)
        elif task is not None:
            self.baker.run(task)
            piece.made += 1

    def leave(self, piece: Piece, failure: str) -> None:
        """Closes an object; the next one is next."""
        piece.failure = failure
        if self.baker is not None:
            piece.notes = list(self.baker.notes)
        self.baker = self.worker = None
        self.current, self.next = self.current + 1, 0
        opened, self._open = self._open, ExitStack()
        opened.close()

    def cancel(self) -> None:
        """Ends the bake as soon as the worker has heard of it; the frames so far stay."""
        self.cancelled = True
        if self.worker is not None:
            self.worker.cancel()

    def end(self) -> None:
        """Cancels what is left, goes back to the frame before, and lets live values go on. Safe to call again."""
        if not self.done:
            self.cancel()
        while not self.done:
            self.step()
        if self._held is None:
            return
        pausing.release(self._held)
        self._held, scene = None, bpy.data.scenes.get(self.scene_name)
        if scene is not None:
            frame, part = self.former
            scene.frame_set(frame, subframe=part)

    def hold_ranges(self) -> None:
        """Has the scene's colors of live and played objects span all these frames of all objects."""
        scene = bpy.data.scenes.get(self.scene_name)
        places = [(piece.folder, piece.cache_key) for piece in self.pieces if piece.cache_key and not piece.failure]
        if scene is None or not places:
            return
        look = looks.scene_look(scene)
        if not look.ranges:
            with handlers.our_turn(wait=True):
                painting.hold_ranges(scene.paradesc_live, look, cache.ranges_over(places, look))
        handlers.forget_ranges()

    @property
    def made(self) -> int:
        """Frames that had to be computed."""
        return sum(piece.made for piece in self.pieces)

    @property
    def failed(self) -> list[Piece]:
        """The objects that something is wrong with."""
        return [piece for piece in self.pieces if piece.failure]


def pieces_of(objects: list[bpy.types.Object], root: Path) -> list[Piece]:
    """A piece an object, each with a folder of its own."""
    pieces: list[Piece] = []
    for item in objects:
        piece = Piece(key_of(item), cache.object_folder(root, item.name))
        if any(other.folder == piece.folder for other in pieces):
            piece.failure = f'Another object is called "{item.name}" as well, and has its frames there; rename one.'
        pieces.append(piece)
    return pieces
