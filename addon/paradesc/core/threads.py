"""Threads that compute beside Blender; when Python ends they are stopped first.

A native call that is still under way then would call back into an interpreter that is gone, which aborts or hangs the
process.
"""

import atexit
import threading
from collections.abc import Callable

# Seconds that the end of Python waits for a thread that was told to stop; it takes a tenth of one.
PATIENCE = 30.0

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
    """Has every such thread stop, and waits for it."""
    for thread, cancel in list(_running.items()):
        cancel()
        thread.join(PATIENCE)


atexit.register(stop_all)
