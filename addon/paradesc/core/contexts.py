"""Keeps native contexts, with their devices and compiled programs, for whoever asks next. Never imports bpy.

Calls on one context wait for each other, so a bake has one for itself while it lasts. Streams that are asked one after
the other, such as live objects, share one. One unused context of each device is kept until close_idle().
"""

import threading
from dataclasses import dataclass, field
from functools import lru_cache
from types import TracebackType

from .. import bridge
from ..bridge import ParadescError, abi

# These errors say nothing against the device on which they happened.
HARMLESS = {abi.STATUS_CANCELLED, abi.STATUS_INVALID_ARGUMENT, abi.STATUS_INVALID_OPERATION}

Key = tuple[str, int, int]  # backend and device, as asked for, and the memory limit


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
    lock: threading.Lock = field(default_factory=threading.Lock)
    threads: int = 0  # of the contexts that are opened from now on, for work on the processor; 0: all cores

    def take(self, key: Key, shared: bool) -> Slot:
        """A context of this device: if shared, the one that others share already; else an idle one, or a new one."""
        with self.lock:
            found = next(
                (slot for slot in self.used if shared and slot.shared and slot.sound and slot.key == key), None
            )
            if found is not None:
                found.users += 1
                return found
            context = self.idle.pop(key, None)
        backend, index, limit = key
        slot = Slot(key, context or bridge.Context(backend, index, self.threads, limit), shared)
        with self.lock:
            self.used.append(slot)
        return slot

    def give_back(self, slot: Slot) -> None:
        """Removes a user. The last one leaves the context to the next, unless it failed or replaced another device."""
        with self.lock:
            slot.users -= 1
            if slot.users > 0:
                return
            self.used.remove(slot)
            keeps = slot.sound and not slot.context.fallback and slot.key not in self.idle
            if keeps:
                self.idle[slot.key] = slot.context
        if not keeps:
            slot.context.close()


POOL = Pool()


class Lease:
    """A context for a while. Whoever makes meshes of it has to close them."""

    def __init__(self, backend: str, device_index: int, shared: bool = False, memory_limit: int = 0) -> None:
        self._slot: Slot | None = POOL.take((backend, device_index, memory_limit), shared)
        self.context = self._slot.context

    def failed(self, error: BaseException) -> None:
        """Prevents the context from being used again if its device may be the reason of the error."""
        if self._slot is not None and not (isinstance(error, ParadescError) and error.status in HARMLESS):
            self._slot.sound = False

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


@lru_cache(maxsize=1)
def automatic() -> str:
    """The backend that "auto" takes on this machine, "gpu" or "cpu"; looked for once."""
    with Lease("auto", -1) as context:
        return context.backend


def close_idle() -> None:
    """Frees the devices that nobody uses."""
    with POOL.lock:
        contexts = list(POOL.idle.values())
        POOL.idle.clear()
    for context in contexts:
        context.close()
