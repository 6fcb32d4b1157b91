"""The newest request on another thread counts, and nothing is handed over after settling."""

import threading

import pytest

from paradesc.bridge import ParadescError, abi
from paradesc.core.latest import Latest, is_cancelled


class Gate:
    """Work that waits until it is let through, or cancelled."""

    def __init__(self):
        self.begun, self.open, self.asked = [], threading.Event(), threading.Event()

    def __call__(self, request, progress):
        self.begun.append(request)
        while not self.open.wait(0.002):
            goes_on = progress("work", 0.0)
            self.asked.set()
            if not goes_on:
                raise ParadescError(abi.STATUS_CANCELLED, "Cancelled.")
        if request == "bad":
            raise ValueError(request)
        return request.upper()


@pytest.fixture
def gate():
    """Work behind a gate, which is opened in the end."""
    made = Gate()
    yield made
    made.open.set()


def ask(latest, *requests):
    """Makes one request after the other."""
    for request in requests:
        latest.ask(request)
        assert latest.step() is None


def test_only_the_newest_of_those_that_wait_is_worked_on(gate):
    latest = Latest(gate)
    ask(latest, "one", "two", "three")
    assert latest.newest == "three"
    gate.open.set()
    assert latest.step(wait=True).result == "ONE"
    assert latest.step(wait=True).result == "THREE"
    assert gate.begun == ["one", "three"]
    assert not latest.busy
    assert latest.newest is None


def test_what_goes_wrong_is_handed_over_and_the_next_request_is_taken(gate):
    gate.open.set()
    latest = Latest(gate)
    ask(latest, "bad")
    outcome = latest.step(wait=True)
    assert (outcome.request, outcome.result, str(outcome.error)) == ("bad", None, "bad")
    latest.ask("good")
    latest.step()
    assert latest.step(wait=True).result == "GOOD"


def test_settling_ends_the_work_and_drops_everything(gate):
    latest = Latest(gate)
    ask(latest, "one", "two")
    latest.settle()
    assert not latest.busy
    assert latest.step(wait=True) is None
    assert latest.newest is None
    assert gate.begun == ["one"]


def test_what_is_asked_for_after_settling_goes_on_when_it_asks(gate):
    latest = Latest(gate)
    ask(latest, "one", "two")
    latest.settle()
    gate.asked.clear()
    ask(latest, "three")
    assert gate.asked.wait(60)  # the gate is shut: the work has asked whether to go on before it is let through
    gate.open.set()
    outcome = latest.step(wait=True)
    assert (outcome.request, outcome.result, outcome.error) == ("three", "THREE", None)
    assert gate.begun == ["one", "three"]


def test_cancelled_is_told_from_failed():
    assert is_cancelled(ParadescError(abi.STATUS_CANCELLED, "Cancelled."))
    assert not is_cancelled(ParadescError(abi.STATUS_OUT_OF_MEMORY, "Out of memory."))
    assert not is_cancelled(ValueError())
