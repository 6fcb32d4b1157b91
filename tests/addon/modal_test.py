"""Tests how work goes on in Blender's window: in turns, between which the window draws and takes events."""

import threading
from types import SimpleNamespace

import pytest

pytest.importorskip("bpy", reason="needs Blender")

from paradesc_blender.bake.modal import ModalJob  # noqa: E402
from paradesc_blender.bake.pieces import Piece, Pieces, computed  # noqa: E402


class Works(Pieces):
    """Pieces that call a function each."""

    def __init__(self, works):
        super().__init__([Piece((f"piece {number}", None)) for number in range(len(works))])
        self.works = dict(zip([piece.key for piece in self.pieces], works, strict=True))

    def work_on(self, piece):
        piece.results = yield from computed(lambda _progress: self.works[piece.key]())


class Job(ModalJob):
    """The operator without Blender's window."""

    def __init__(self, works, turn):
        self.job, self.turn, self.shown = Works(works), turn, 0

    def show_progress(self, _context):
        self.shown += 1

    def clean_up(self, _context):
        pass

    def end(self, _context):
        return {"FINISHED"}

    def take_turn(self):
        return self.modal(None, SimpleNamespace(type="TIMER", value="NOTHING"))


@pytest.fixture
def gate():
    """An event that is set at the end, so that no thread waits for it any longer."""
    found = threading.Event()
    yield found
    found.set()


def test_many_small_pieces_fit_into_one_turn():
    running = Job([lambda number=number: number for number in range(50)], turn=600.0)
    assert running.take_turn() == {"FINISHED"}
    assert [piece.results for piece in running.job.pieces] == list(range(50))


def test_a_turn_ends_though_its_work_does_not(gate):
    running = Job([lambda: 1, gate.wait, lambda: 3], turn=0.01)
    while running.job.current < 1 or running.job.worker is None:
        assert running.take_turn() == {"RUNNING_MODAL"}
    shown = running.shown
    assert running.take_turn() == {"RUNNING_MODAL"}  # the worker is asked for its state, and not waited for
    assert (running.job.current, running.shown) == (1, shown + 1)
    gate.set()
    while running.take_turn() != {"FINISHED"}:
        pass
    assert running.job.current == 3
