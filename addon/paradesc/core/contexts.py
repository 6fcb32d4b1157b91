"""Native contexts, each with its device and its compiled programs, kept for the next one who asks. Never imports bpy.

Calls on one context wait for each other, so that a bake has one for itself while it lasts; streams that are asked one
after the other, as live objects are, share one. What nobody uses is kept, one a device, until close_idle().
"""

import threading
from dataclasses import dataclass, field
from types import TracebackType

from .. import bridge
from ..bridge import ParadescError, abi

# What says nothing against the device that it happened on.
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

    def take(self, key: Key, shared: bool) -> Slot:
        """A context of this device: where shared, the one that others share already, else one that is idle, or new."""
        with self.lock:
            found = next(
                (slot for slot in self.used if shared and slot.shared and slot.sound and slot.key == key), None
            )
            if found is not None:
                found.users += 1
                return found
            context = self.idle.pop(key, None)
        backend, index, limit = key
        slot = Slot(key, context or bridge.Context(backend, index, memory_limit=limit), shared)
        with self.lock:
            self.used.append(slot)
        return slot

    def give_back(self, slot: Slot) -> None:
        """One user less; the last one leaves the context to the next, unless it went wrong or stood in for another."""
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
    """A context for a while; meshes made of it are closed by whoever made them."""

    def __init__(self, backend: str, device_index: int, shared: bool = False, memory_limit: int = 0) -> None:
        self._slot: Slot | None = POOL.take((backend, device_index, memory_limit), shared)
        self.context = self._slot.context

    def failed(self, error: BaseException) -> None:
        """Has the context not used again where its device may be the reason."""
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


def close_idle() -> None:
    """Frees the devices that nobody uses."""
    with POOL.lock:
        contexts = list(POOL.idle.values())
        POOL.idle.clear()
    for context in contexts:
        context.close()
