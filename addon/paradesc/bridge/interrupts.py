"""Holds Ctrl-C back during a native call, so that it stops the call instead of being lost.

Python runs the handler of a signal where the next Python function begins. During a native call that is the progress
callback, before its first line: an exception from there ends in C, where nobody sees it.
"""

import signal
import threading
from collections.abc import Callable
from types import FrameType, TracebackType

NUMBERS = (signal.SIGINT, signal.SIGTERM)


class Interrupts:
    """Collects what handlers of Ctrl-C and SIGTERM raise; does nothing on other threads than the main one.

    Handlers still run at once, and one that raises nothing stops nothing. Handlers in C are left alone.
    """

    def __init__(self, caught: list[BaseException]) -> None:
        """Takes the list to which errors are added; the caller of the native function then raises the first."""
        self._caught = caught
        self._former: dict[int, Callable[[int, FrameType | None], object]] = {}

    def __enter__(self) -> None:
        if threading.current_thread() is not threading.main_thread():
            return
        for number in NUMBERS:
            former = signal.getsignal(number)
            if callable(former):
                self._former[number] = former
                signal.signal(number, self._keep)

    def __exit__(self, kind: type | None, error: BaseException | None, trace: TracebackType | None) -> None:
        for number, former in self._former.items():
            signal.signal(number, former)

    def _keep(self, number: int, frame: FrameType | None) -> None:
        try:
            self._former[number](number, frame)
        except BaseException as error:  # noqa: BLE001 (raised again once the call has ended)
            self._caught.append(error)
