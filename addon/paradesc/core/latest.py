"""The newest of many requests to its results, on a thread of its own; older ones are dropped. Never imports bpy.

Everything but the work itself is called by one thread. Requests begin, and results are handed over, in step() only.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Generic, TypeVar

from ..bridge import ParadescError, ProgressFunction, abi
from .threads import Worker

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
        self._under_way: Request | None = None
        self._worker: Worker[Result] | None = None

    @property
    def busy(self) -> bool:
        """True while step() may still have something to hand over."""
        return self._worker is not None or self._waiting is not None

    @property
    def newest(self) -> Request | None:
        """The newest request that nothing has come of yet."""
        return self._under_way if self._waiting is None else self._waiting

    def ask(self, request: Request) -> None:
        """Takes the place of what waits."""
        self._waiting = request

    def step(self, wait: bool = False) -> Outcome[Request, Result] | None:
        """What came of the request under way if that has ended; begins the one that waits."""
        ended = None
        if self._worker is not None and (wait or self._worker.done):
            ended = outcome_of(self._under_way, self._worker)
            self._worker = self._under_way = None
        if self._worker is None and self._waiting is not None:
            self._under_way, self._waiting = self._waiting, None
            self._worker = Worker(partial(self._work, self._under_way), "paradesc live")
            self._worker.start()
        return ended

    def settle(self) -> None:
        """Forgets what waits, ends what is under way at its next tile, and waits for that: the work's own is free."""
        self._waiting = None
        if self._worker is not None:
            self._worker.cancel()
            self._worker.join()
            self._worker = self._under_way = None


def outcome_of(request: Request, worker: Worker[Result]) -> Outcome[Request, Result]:
    """What a worker has made of a request."""
    try:
        return Outcome(request, worker.result())
    except Exception as error:  # noqa: BLE001 (handed over to the thread that asks)
        return Outcome(request, error=error)


def is_cancelled(error: BaseException) -> bool:
    """Whether this says no more than that somebody cancelled."""
    return isinstance(error, ParadescError) and error.status == abi.STATUS_CANCELLED
