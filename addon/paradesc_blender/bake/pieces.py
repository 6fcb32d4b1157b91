"""The base of bakes of meshes and of frames: a list of objects, processed one after another by workers."""

from collections.abc import Callable, Generator, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field

import bpy

from paradesc.bridge import ParadescError, ProgressFunction, abi
from paradesc.core.threads import Worker

from ..settings.translation import label, said

# People read these words for the stages that computations go through.
STAGE_WORDS = {
    "read": "Reading the mesh",
    "start": "Preparing",
    "mesh": "Preparing",
    "prepare": "Preparing",
    "rays": "Finding the detailed mesh",
    "image": "Drawing the image",
    "write": "Drawing the image",
}
ObjectKey = tuple[str, str | None]  # an object's name and library: objects themselves do not outlive an undo


@dataclass
class Piece:
    """One object of a bake, with its results, or its failure, and with notes and warnings."""

    key: ObjectKey
    results: object = field(default=None, kw_only=True)  # of the computation
    failure: str = field(default="", kw_only=True)  # one sentence
    notes: list[str] = field(default_factory=list, kw_only=True)
    warnings: list[str] = field(default_factory=list, kw_only=True)  # about what limits its results

    @property
    def name(self) -> str:
        """The object's name, for sentences."""
        return self.key[0]


Work = Iterator[Worker | None]  # on the main thread; each worker that it yields has ended before it goes on


def computed(work: Callable[[ProgressFunction], object], name: str = "paradesc") -> Generator[Worker, None, object]:
    """Computes beside the main thread, and returns the result."""
    worker = Worker(work, name)
    yield worker
    return worker.result()


# Not Generic: typing would keep every Pieces[…] and its class until Python ends, after bpy is gone. Blender's module
# then crashes if the process ends while a bake runs.
class Pieces:
    """Pieces processed one after another, in steps: work() goes on when the worker that it waits for ends.

    Subclasses define work_on(), which reads the mesh of a piece, computes, and keeps the results until those of all
    pieces are there.
    """

    def __init__(self, pieces: list[Piece]) -> None:
        """Starts before the first piece, with no worker under way."""
        self.pieces = pieces
        self.current = 0  # the number of pieces that are finished
        self.worker: Worker | None = None
        self.cancelled = False
        self.done = False  # whether no step is left, or the work is at rest after cancelling
        self._work = self.work()

    def work(self) -> Work:
        """Processes all pieces. A yielded None lets the window breathe."""
        for piece in self.pieces:
            with self.attempt(piece):
                yield from self.work_on(piece)
            self.current += 1
            if self.current < len(self.pieces):
                yield None

    @contextmanager
    def attempt(self, piece: Piece) -> Iterator[None]:
        """Makes an error the failure of this piece, so that the others go on."""
        try:
            yield
        except ParadescError as error:
            self.cancelled = self.cancelled or error.status == abi.STATUS_CANCELLED
            piece.failure = error.sentence

    def step(self, patience: float | None = 0.0) -> bool:
        """Goes on with the work if its worker has ended, or is closed if it was cancelled; returns whether it did.

        patience: the seconds to wait for the worker, or None to wait until it ends.
        """
        if self.worker is not None:
            self.worker.join(patience)  # if Ctrl-C interrupts the wait, the worker stays for close()
        if self.done or (self.worker is not None and not self.worker.done):
            return False
        self.worker = None
        if self.cancelled:
            self._work.close()
            self.done = True
            return True
        try:
            self.worker = next(self._work)
        except StopIteration:
            self.done = True
        return True

    def cancel(self) -> None:
        """Asks the worker to stop; the work ends once it has."""
        self.cancelled = True
        if self.worker is not None:
            self.worker.cancel()

    def close(self) -> None:
        """Cancels the remaining work, waits for it, and cleans up. Safe to call again."""
        if not self.done:
            self.cancel()
        while not self.done:
            self.step(None)

    @property
    def fraction(self) -> float:
        """The finished share of all the work."""
        own = self.worker.fraction if self.worker else 0.0
        return min((self.current + own) / len(self.pieces), 1.0)

    @property
    def stage(self) -> str:
        """Words for the step under way, shown as progress."""
        own = stage_words(self.worker)
        if len(self.pieces) == 1 or self.current == len(self.pieces):
            return own
        several = label("{stage}, mesh {number} of {count}")
        return several.format(stage=own, number=self.current + 1, count=len(self.pieces))

    @property
    def failed(self) -> list[Piece]:
        """The pieces that failed."""
        return [piece for piece in self.pieces if piece.failure]

    @property
    def written(self) -> list[Piece]:
        """The pieces whose results are there once the work is done; none if it was cancelled."""
        return [] if self.cancelled else [piece for piece in self.pieces if not piece.failure]


def stage_words(worker: Worker | None) -> str:
    """The stage of a worker in words; every stage of the computation itself reads as measuring."""
    return label(STAGE_WORDS.get(worker.stage if worker else "read", "Measuring"))


def report_all(report: Callable[[set[str], str], None], batch: Pieces) -> None:
    """Reports the notes and warnings of written pieces, with the objects' names if there are several."""
    several = len(batch.pieces) > 1
    for piece in batch.written:
        for kind, sentences in (("INFO", piece.notes), ("WARNING", piece.warnings)):
            for sentence in dict.fromkeys(sentences):
                report({kind}, f'"{piece.name}": {said(sentence)}' if several else said(sentence))


def failures(batch: Pieces) -> list[str]:
    """One sentence for each object that failed; if there are several, with its name unless the sentence contains it."""
    sentences = []
    for piece in batch.failed:
        is_clear = len(batch.pieces) == 1 or f'"{piece.name}"' in piece.failure
        sentences.append(said(piece.failure) if is_clear else f'"{piece.name}": {said(piece.failure)}')
    return sentences


def find(key: ObjectKey) -> bpy.types.Object:
    """The mesh object of this key; raises one sentence if it is gone."""
    found = bpy.data.objects.get(key)
    if found is None or found.type != "MESH":
        raise ParadescError(abi.STATUS_INVALID_OPERATION, f'The object "{key[0]}" is gone; nothing was written.')
    return found


def key_of(target: bpy.types.Object) -> ObjectKey:
    """The key by which bpy.data.objects finds an object."""
    return target.name, target.library.filepath if target.library is not None else None
