"""Paradesc: curvature and other geometric descriptors of meshes at a radius that you choose.

Its functions are imported with the first of their names. Nothing here imports Blender's modules.
"""

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .api import (
        Descriptor,
        InputError,
        Mask,
        Mesh,
        ParadescError,
        ParadescWarning,
        Result,
        compute,
        descriptors,
        profile,
    )
    from .core.balance import Profile

__all__ = [
    "Descriptor", "InputError", "Mask", "Mesh", "ParadescError", "ParadescWarning", "Profile", "Result",
    "compute", "descriptors", "profile",
]  # fmt: skip

__version__ = "0.1.0"


def __getattr__(name: str) -> object:
    """Imports the public names of api.py on first use."""
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(".core.balance" if name == "Profile" else ".api", __name__), name)


def __dir__() -> list[str]:
    return sorted({*__all__, *(name for name in globals() if name.startswith("__"))})
