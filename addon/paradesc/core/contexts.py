"""Keeps native contexts, with their devices and compiled programs, for whoever asks next. Never imports bpy.

Calls on one context wait for each other, so a bake has one for itself while it lasts. Streams that are asked one after
the other, such as live objects, share one. One unused context of each kind is kept until close_idle(), a few in all.
"""

import os
import threading
from collections import deque
from contextlib import suppress
from dataclasses import dataclass, field
from types import TracebackType

from .. import bridge
from ..bridge import ParadescError, abi

# These errors say nothing against the device on which they happened.
HARMLESS = {abi.STATUS_CANCELLED, abi.STATUS_INVALID_ARGUMENT, abi.STATUS_INVALID_OPERATION}

# So many unused contexts are kept: the most recently used ones.
MOST_IDLE = 4

Key = tuple[str, int, int, int]  # the arguments of a context: backend, device, number of threads, memory limit


@dataclass
class Slot:
    """One context and who uses it."""

    key: Key
    context: bridge.Context
    shared: bool
    users: int = 1
    sound: bool = True


@dataclass
class Pool:
    """All contexts that are open; safe to ask from any thread."""

    used: list[Slot] = field(default_factory=list)
    idle: dict[Key, bridge.Context] = field(default_factory=dict)
    left: deque[Slot] = field(default_factory=deque)  # by users that are gone, not given back yet
    lock: threading.Lock = field(default_factory=threading.Lock)

    def take(self, key: Key, shared: bool) -> Slot:
        """A context of this device: if shared, the one that others share already; else an idle one, or a new one."""
        with suppress(IndexError):
            while True:
                self.give_back(self.left.popleft())
        with self.lock:
            found = next(
                (slot for slot in self.used if shared and slot.shared and slot.sound and slot.key == key), None
            )
            if found is not None:
                found.users += 1
                return found
            context = self.idle.pop(key, None)
        slot = Slot(key, context or bridge.Context(*key), shared)
        with self.lock:
            self.used.append(slot)
        return slot

    def give_back(self, slot: Slot) -> None:
        """Removes a user. The last one leaves the context to the next, unless it failed."""
        with self.lock:
            slot.users -= 1
            if slot.users > 0:
                return
            self.used.remove(slot)
            keeps = slot.sound and slot.key not in self.idle
            if keeps:
                self.idle[slot.key] = slot.context
            keys = list(self.idle)[:-MOST_IDLE]
            unused = [self.idle.pop(key) for key in keys] if keeps else [slot.context]
        for context in unused:
            context.close()

    def leave_to_other_process(self) -> None:
        """Makes the pool usable in a forked process, which lacks the threads that may hold the lock or compute."""
        self.lock = threading.Lock()
        for slot in self.used:
            slot.sound = False


POOL = Pool()
if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=POOL.leave_to_other_process)


class Lease:
    """A context that is lent out. Meshes made with it must be closed before it is given back."""

    def __init__(
        self, backend: str, device_index: int, shared: bool = False, memory_limit: int = 0, threads: int = 0
    ) -> None:
        self._slot: Slot | None = POOL.take((backend, device_index, threads, memory_limit), shared)
        self.context = self._slot.context

    def failed(self, error: BaseException) -> None:
        """Prevents the context from being used again if its device may be the reason of the error."""
        if self._slot is not None and not (isinstance(error, ParadescError) and error.status in HARMLESS):
            self._slot.sound = False

    def leave(self) -> None:
        """Lets the next lease give the context back. It takes no lock, since the garbage collector may call it."""
        slot, self._slot = self._slot, None
        if slot is not None:
            POOL.left.append(slot)

    def close(self) -> None:
        """Gives the context back."""
        slot, self._slot = self._slot, None
        if slot is not None:
            POOL.give_back(slot)

    def __enter__(self) -> bridge.Context:
        return self.context

    def __exit__(self, kind: type | None, error: BaseException | None, trace: TracebackType | None) -> None:
        if error is not None:
            self.failed(error)
        self.close()


def close_idle() -> None:
    """Frees the devices that are not in use."""
    with POOL.lock:
        contexts = list(POOL.idle.values())
        POOL.idle.clear()
    for context in contexts:
        context.close()
