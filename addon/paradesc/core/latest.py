"""Works on the newest of many requests, on a thread of its own, and drops older ones. Never imports bpy.

One thread calls everything except the work itself. Only step() begins requests and hands over results.
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
    """The outcome of a request: the result, or the error."""

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
    def computing(self) -> bool:
        """True while the thread works."""
        return self._worker is not None and not self._worker.done

    @property
    def newest(self) -> Request | None:
        """The newest request without an outcome yet."""
        return self._under_way if self._waiting is None else self._waiting

    def ask(self, request: Request) -> None:
        """Makes this the waiting request, in place of an earlier one."""
        self._waiting = request

    def step(self, wait: bool = False) -> Outcome[Request, Result] | None:
        """Returns the outcome of the request under way if it has ended, else None, and starts the one that waits."""
        ended = None
        if self._worker is not None and (wait or self._worker.done):
            try:
                ended = Outcome(self._under_way, self._worker.result())
            except Exception as error:  # noqa: BLE001 (handed over to the thread that asks)
                ended = Outcome(self._under_way, error=error)
            self._worker = self._under_way = None
        if self._worker is None and self._waiting is not None:
            self._under_way, self._waiting = self._waiting, None
            self._worker = Worker(partial(self._work, self._under_way), "paradesc live")
        return ended

    def settle(self) -> None:
        """Drops the waiting request, cancels the one under way, and waits for its end."""
        self._waiting = None
        if self._worker is not None:
            self._worker.cancel()
            self._worker.join()
            self._worker = self._under_way = None


def is_cancelled(error: BaseException) -> bool:
    """Returns whether the outcome is a cancellation."""
    return isinstance(error, ParadescError) and error.status == abi.STATUS_CANCELLED
