"""Lists what can compute here: every device of every backend, looked for once. Never imports bpy."""

from dataclasses import dataclass
from functools import lru_cache
from itertools import takewhile

from .. import bridge
from ..bridge import ParadescError

# More graphics cards than this are not listed.
MOST = 16
TITLES = {
    "auto": "Automatic",
    "gpu": "Graphics Card",
    "software": "Software",
    "reference": "Reference",
    "cpu": "Processor",
}
ABOUT = {
    "auto": "The processor, and the software rasterizer for settings that need OpenGL",
    "gpu": "A graphics card with OpenGL 4.5",
    "software": "The method of graphics cards on the processor, by a software rasterizer",
    "reference": "Exact integration over the triangles, for comparison; slow, needs no UV map",
    "cpu": "Samples of the surface on all cores of the processor; needs no UV map",
}


@dataclass(frozen=True)
class Device:
    """One device, or the sentence that says why a backend has none."""

    backend: str
    index: int  # -1: the backend's only or first one
    name: str
    missing: str = ""

    @property
    def label(self) -> str:
        """The label of the device in menus."""
        return f"{TITLES[self.backend]}: {self.name.split(' (')[0] if self.name else 'none'}"


@lru_cache(maxsize=1)
def found() -> tuple[Device, ...]:
    """Every graphics card, the software rasterizer, the reference, and the processor."""
    cards = [*takewhile(lambda card: card.name, (device_of("gpu", index) for index in range(MOST)))]
    return (*(cards or [device_of("gpu")]), device_of("software"), device_of("reference"), device_of("cpu"))


def device_of(backend: str, index: int = -1) -> Device:
    """A device of a backend, by default that which the backend chooses by itself."""
    try:
        with bridge.Context(backend, index) as context:
            return Device(backend, index, context.device)
    except ParadescError as error:
        return Device(backend, index, "", error.sentence)


def about(backend: str) -> str:
    """The description of a backend, and why it is missing if it is."""
    rows = [row.missing for row in found() if row.backend == backend and row.missing] if backend != "auto" else []
    return " – ".join([ABOUT.get(backend, ""), *rows]).rstrip(".")


def label_of(backend: str, index: int) -> str:
    """The panel's label of a choice. Devices are not queried for it, so it uses those that are known already."""
    if backend == "auto":
        return TITLES[backend]
    if found.cache_info().currsize:
        rows = [row for row in found() if row.backend == backend]
        row = next((row for row in rows if row.index == index), rows[0] if index < 0 else None)
        if row is not None:
            return row.label
    return TITLES[backend] if index < 0 else f"{TITLES[backend]} {index}"
