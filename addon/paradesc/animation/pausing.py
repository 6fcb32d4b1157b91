"""Makes live values wait while frames are evaluated for a bake: nobody sees them, and they would be computed twice."""

from collections.abc import Iterator
from contextlib import contextmanager

_holds: list[object] = []


def hold() -> object:
    """Makes live values wait until release() gets what this returns."""
    held = object()
    _holds.append(held)
    return held


def release(held: object) -> None:
    """Lets live values go on, unless somebody else holds them."""
    if held in _holds:
        _holds.remove(held)


def is_held() -> bool:
    """Whether live values wait."""
    return bool(_holds)


@contextmanager
def held() -> Iterator[None]:
    """Makes live values wait inside the with statement."""
    mine = hold()
    try:
        yield
    finally:
        release(mine)
