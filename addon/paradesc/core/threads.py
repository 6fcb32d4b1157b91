"""Runs threads that compute beside Blender, can be asked to stop, and are stopped before Python ends.

A native call that is still under way then would call back into an interpreter that is gone, and the process would
abort or hang.
"""

import atexit
import os
import threading
from collections.abc import Callable, Iterable
from typing import Generic, TypeVar

from ..bridge import ParadescError, ProgressFunction, abi

Item = TypeVar("Item")
Result = TypeVar("Result")

# At exit Python waits so many seconds for a cancelled thread, which usually takes a tenth of a second to stop.
PATIENCE = 30.0
# More threads than this only wait for memory access.
MOST_THREADS = 8

_running: dict[threading.Thread, Callable[[], None]] = {}


def start(name: str, work: Callable[[], None], cancel: Callable[[], None]) -> threading.Thread:
    """Runs work on a thread of that name; cancel() asks it to stop, from any thread."""

    def run() -> None:
        try:
            work()
        finally:
            _running.pop(thread, None)

    thread = threading.Thread(target=run, name=name, daemon=True)
    _running[thread] = cancel
    thread.start()
    return thread


def stop_all() -> None:
    """Stops every such thread, and waits for it."""
    for thread, cancel in list(_running.items()):
        cancel()
        thread.join(PATIENCE)


atexit.register(stop_all)


def go_on(progress: ProgressFunction | None, stage: str, fraction: float) -> None:
    """Reports progress; raises a cancellation if the function returns False."""
    if progress is not None and not progress(stage, fraction):
        raise ParadescError(abi.STATUS_CANCELLED, "Cancelled.")


def side_by_side(work: Callable[[Item], Result], items: Iterable[Item]) -> list[Result]:
    """The results of work for all items, in order. It runs on all cores, as far as work releases Python's lock."""
    given = list(items)
    results: list[Result] = [None] * len(given)
    errors: list[BaseException] = []
    waiting, stopped = iter(range(len(given))), threading.Event()

    def take() -> None:
        while not stopped.is_set() and (number := next(waiting, None)) is not None:
            try:
                results[number] = work(given[number])
            except BaseException as error:  # noqa: BLE001 (raised again below)
                errors.append(error)
                stopped.set()

    count = min(os.cpu_count() or 1, MOST_THREADS, len(given))
    helpers = [start("paradesc part", take, stopped.set) for _ in range(count - 1)]
    take()
    for helper in helpers:
        helper.join()
    if errors:
        raise errors[0]
    if stopped.is_set():
        raise ParadescError(abi.STATUS_CANCELLED, "Cancelled.")
    return results


class Worker(Generic[Result]):
    """Work on a thread of its own, so that a window stays responsive. Use it only from the thread that made it."""

    def __init__(self, work: Callable[[ProgressFunction], Result], name: str = "paradesc") -> None:
        """Starts the work, which is called with a progress function that gives False once it has to stop."""
        self.stage, self.fraction = "start", 0.0
        self._work = work
        self._cancelled = threading.Event()
        self._result: Result | None = None
        self._error: BaseException | None = None
        self._thread = start(name, self._run, self.cancel)

    @property
    def done(self) -> bool:
        """Returns whether result() returns without waiting."""
        return not self._thread.is_alive()

    def cancel(self) -> None:
        """Asks the native call to stop at its next tile."""
        self._cancelled.set()

    def join(self, patience: float | None = None) -> None:
        """Waits for the end, but no longer than these seconds."""
        self._thread.join(patience)

    def result(self) -> Result:
        """Waits for the end; returns the result or raises the error. After cancel() it raises in any case."""
        self.join()
        if self._cancelled.is_set():
            raise ParadescError(abi.STATUS_CANCELLED, "Cancelled.")
        if self._error is not None:
            raise self._error
        return self._result

    def _run(self) -> None:
        try:
            self._result = self._work(self._progress)
        except BaseException as error:  # noqa: BLE001 (raised again by result())
            self._error = error

    def _progress(self, stage: str, fraction: float) -> bool:
        self.stage, self.fraction = stage, fraction
        return not self._cancelled.is_set()
