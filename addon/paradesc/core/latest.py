"""The newest of many requests to its results, on a thread of its own; older ones are dropped. Never imports bpy.

Everything but the work itself is called by one thread. Requests begin, and results are handed over, in step() only.
"""

import threading
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Generic, TypeVar

from ..bridge import ParadescError, abi
from . import threads
from .job import ProgressFunction

Request = TypeVar("Request")
Result = TypeVar("Result")


@dataclass
class Outcome(Generic[Request, Result]):
    """What came of a request: the result, or what went wrong."""

    request: Request
    result: Result | None = None
    error: Exception | None = None


class Latest(Generic[Request, Result]):
    """At most one request under way, and at most one that waits: the newest."""

    def __init__(self, work: Callable[[Request, ProgressFunction], Result]) -> None:
        self._work = work
        self._waiting: Request | None = None
        self._outcome: Outcome[Request, Result] | None = None  # of the thread
        self._thread: threading.Thread | None = None
        self._cancelled = threading.Event()

    @property
    def busy(self) -> bool:
        """True while step() may still have something to hand over."""
        return self._thread is not None or self._waiting is not None

    @property
    def newest(self) -> Request | None:
        """The newest request that nothing has come of yet."""
        if self._waiting is not None:
            return self._waiting
        return self._outcome.request if self._thread is not None and self._outcome is not None else None

    def ask(self, request: Request) -> None:
        """Takes the place of what waits."""
        self._waiting = request

    def step(self, wait: bool = False) -> Outcome[Request, Result] | None:
        """What came of the request under way if that has ended; begins the one that waits."""
        ended = None
        if self._thread is not None and (wait or not self._thread.is_alive()):
            self._thread.join()
            ended, self._thread, self._outcome = self._outcome, None, None
        if self._thread is None and self._waiting is not None:
            request, self._waiting = self._waiting, None
            self._outcome = Outcome(request)
            self._thread = threads.start("paradesc live", partial(self._run, self._outcome), self._cancelled.set)
        return ended

    def settle(self) -> None:
        """Forgets what waits, ends what is under way at its next tile, and waits for that: the work's own is free."""
        self._waiting = None
        if self._thread is not None:
            self._cancelled.set()
            self._thread.join()
            self._cancelled.clear()
            self._thread = self._outcome = None

    def _run(self, outcome: Outcome[Request, Result]) -> None:
        try:
            outcome.result = self._work(outcome.request, lambda _stage, _fraction: not self._cancelled.is_set())
        except Exception as error:  # noqa: BLE001 (handed over to the thread that asks)
            outcome.error = error


def is_cancelled(error: BaseException) -> bool:
    """Whether this says no more than that somebody cancelled."""
    return isinstance(error, ParadescError) and error.status == abi.STATUS_CANCELLED
