"""The base of bakes of meshes and of frames: a list of objects, processed one after another by workers."""

from collections.abc import Callable
from dataclasses import dataclass, field

import bpy

from ..bridge import ParadescError, abi
from ..core.threads import Worker
from ..files import file_names
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
    "write images": "Writing images",
    "write buffers": "Writing buffers",
}
ObjectKey = tuple[str, str | None]  # an object's name and library: objects themselves do not outlive an undo


@dataclass
class Piece:
    """One object of a bake, with its failure, notes and warnings."""

    key: ObjectKey
    failure: str = field(default="", kw_only=True)  # one sentence
    notes: list[str] = field(default_factory=list, kw_only=True)
    warnings: list[str] = field(default_factory=list, kw_only=True)  # about what limits its results

    @property
    def name(self) -> str:
        """The object's name, for sentences."""
        return self.key[0]

    def target(self) -> bpy.types.Object:
        """The mesh object; raises one sentence if it is gone."""
        return find(self.key)

    def drop(self) -> None:
        """Drops what was computed, because something went wrong."""


# Not Generic: typing would keep every Pieces[…] and its class until Python ends, after bpy is gone. Blender's module
# then crashes if the process ends while a bake runs.
class Pieces:
    """Pieces processed one after another. Subclasses define step(), which continues the current one, and fraction."""

    def __init__(self, pieces: list[Piece]) -> None:
        """Starts with no piece under way."""
        self.pieces = pieces
        self.current = 0  # the number of pieces that are finished
        self.worker: Worker | None = None
        self.cancelled = False

    @property
    def under_way(self) -> bool:
        """Whether the current piece has been begun."""
        return self.worker is not None

    @property
    def done(self) -> bool:
        """Whether every piece has been computed or has failed, or the bake is cancelled and at rest."""
        return not self.under_way and (self.cancelled or self.current == len(self.pieces))

    @property
    def failed(self) -> list[Piece]:
        """The pieces that failed."""
        return [piece for piece in self.pieces if piece.failure]

    def step(self, wait: bool = False) -> None:
        """Continues with the current piece. wait: waits for its worker, instead of checking whether it has ended."""
        raise NotImplementedError

    def join(self) -> Worker:
        """Waits for the worker and detaches it. If Ctrl-C interrupts the wait, the worker stays for settle()."""
        self.worker.join()
        worker, self.worker = self.worker, None
        return worker

    def cancel(self) -> None:
        """Asks the worker to stop; the bake ends once it has."""
        self.cancelled = True
        if self.worker is not None:
            self.worker.cancel()

    def settle(self) -> None:
        """Cancels the remaining work and waits until nothing is under way. Safe to call again."""
        if not self.done:
            self.cancel()
        while not self.done:
            self.step(wait=True)


class OneByOne(Pieces):
    """Meshes, each processed by one worker. Subclasses define start() and take()."""

    def start(self, piece: Piece) -> None:
        """Reads a mesh and starts its worker."""
        raise NotImplementedError

    def take(self, piece: Piece, worker: Worker) -> None:
        """Keeps a worker's results until all are there."""
        raise NotImplementedError

    @property
    def fraction(self) -> float:
        """The finished share of all the work."""
        own = self.worker.fraction if self.worker else 0.0
        return min((self.current + own) / len(self.pieces), 1.0)

    @property
    def stage(self) -> str:
        """Words for the step under way, shown as progress."""
        own = stage_words(self.worker.stage if self.worker else "read")
        if len(self.pieces) == 1 or self.current == len(self.pieces):
            return own
        several = label("{stage}, mesh {number} of {count}")
        return several.format(stage=own, number=self.current + 1, count=len(self.pieces))

    def step(self, wait: bool = False) -> None:
        """Starts the worker of the next mesh, or takes in the results of a worker that has ended."""
        if self.done:
            return
        piece = self.pieces[self.current]
        if self.worker is None:
            self.attempt(piece, self.start)
            if piece.failure:
                self.current += 1
        elif wait or self.worker.done:
            worker = self.join()
            self.current += 1
            self.attempt(piece, lambda piece: self.take(piece, worker))

    def attempt(self, piece: Piece, action: Callable[[Piece], None]) -> None:
        """Runs one step for a mesh. An error becomes the failure of this mesh, and the others go on."""
        try:
            action(piece)
        except ParadescError as error:
            if error.status == abi.STATUS_CANCELLED:
                self.cancelled = True
            piece.failure = error.sentence
            piece.drop()


def stage_words(stage: str) -> str:
    """A stage in words; every stage of the computation itself reads as measuring."""
    return label(STAGE_WORDS.get(stage, "Measuring"))


def report_all(report: Callable[[set[str], str], None], batch: Pieces, written: list[Piece]) -> None:
    """Reports the notes and warnings of written pieces, with the objects' names if there are several."""
    several = len(batch.pieces) > 1
    for piece in written:
        for kind, sentences in (("INFO", piece.notes), ("WARNING", piece.warnings)):
            for sentence in dict.fromkeys(sentences):
                report({kind}, f'"{piece.name}": {said(sentence)}' if several else said(sentence))


def failures(batch: Pieces) -> list[str]:
    """One sentence for each object that failed; with its name if there are several."""
    if len(batch.pieces) == 1:
        return [said(piece.failure) for piece in batch.failed]
    return [with_name(piece.name, piece.failure) for piece in batch.failed]


def file_word(name: str) -> str:
    """An object's name as part of a file name. Two objects may get the same."""
    return file_names.cut(bpy.path.clean_name(name))


def file_words(keys: list[ObjectKey]) -> list[str]:
    """Distinct file words of objects. Numbers count all objects in the .blend, so that every bake gives the same."""
    there = {*keys, *(key_of(item) for item in bpy.data.objects if item.type == "MESH")}
    every = sorted(there, key=lambda key: (key[0], key[1] or ""))
    words = dict(zip(every, file_names.distinct([file_word(name) for name, _ in every]), strict=True))
    return [words[key] for key in keys]


def with_name(name: str, failure: str) -> str:
    """The sentence with the object's name in front, unless the sentence contains the name."""
    return said(failure) if f'"{name}"' in failure else f'"{name}": {said(failure)}'


def find(key: ObjectKey) -> bpy.types.Object:
    """The mesh object of this key; raises one sentence if it is gone."""
    found = bpy.data.objects.get(key)
    if found is None or found.type != "MESH":
        raise ParadescError(abi.STATUS_INVALID_OPERATION, f'The object "{key[0]}" is gone; nothing was written.')
    return found


def key_of(target: bpy.types.Object) -> ObjectKey:
    """The key by which bpy.data.objects finds an object."""
    return target.name, target.library.filepath if target.library is not None else None
