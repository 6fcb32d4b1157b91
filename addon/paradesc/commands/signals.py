"""Turns Ctrl-C and SIGTERM into exceptions, or into a flag that the work checks. Never imports bpy."""

import ctypes
import signal
import threading
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from types import FrameType

NUMBERS = (signal.SIGINT, signal.SIGTERM)


class Terminated(BaseException):
    """The process was asked to end by SIGTERM."""


class Signals:
    """Handles both signals while open. They raise, or set stopped where an exception would have to pass through C."""

    def __init__(self, raises: bool = False) -> None:
        self.raises = raises
        self.stopped: type[BaseException] | None = None
        self.former: list[tuple[int, object, int | None]] = []

    def __enter__(self) -> "Signals":
        if threading.current_thread() is not threading.main_thread():
            return self  # only the main thread gets signals
        for number in NUMBERS:
            python, native = signal.getsignal(number), swap_native(number, signal.SIG_IGN)
            if python is None and native is None:
                continue  # C has set it, and Python cannot restore it
            self.former.append((number, python, native))
            signal.signal(number, self.stop)
        return self

    def __exit__(self, *_error: object) -> None:
        for number, python, native in self.former:
            signal.signal(number, signal.SIG_DFL if python is None else python)
            if native is not None:
                swap_native(number, native)
        self.former.clear()

    def stop(self, number: int, _frame: "FrameType | None") -> None:
        """Raises, or remembers the signal until the work checks for it."""
        self.stopped = Terminated if number == signal.SIGTERM else KeyboardInterrupt
        if self.raises:
            raise self.stopped


def swap_native(number: int, handler: int) -> int | None:
    """Sets the C handler of a signal and returns the former one, which Python does not know if Blender has set it."""
    try:
        swap = ctypes.CDLL(None).signal
    except (OSError, TypeError, AttributeError):
        return None  # C's signal() cannot be reached
    swap.argtypes, swap.restype = [ctypes.c_int, ctypes.c_void_p], ctypes.c_void_p
    return swap(number, int(handler)) or 0
