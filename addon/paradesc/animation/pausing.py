"""While frames are evaluated for a bake, live values wait: nobody sees them, and they would be computed twice."""

from collections.abc import Iterator
from contextlib import contextmanager

_holds: list[object] = []


def hold() -> object:
    """Has live values wait until release() is given what this gives."""
    held = object()
    _holds.append(held)
    return held


def release(held: object) -> None:
    """Lets them go on, unless somebody else holds them."""
    if held in _holds:
        _holds.remove(held)


def is_held() -> bool:
    """Whether they wait."""
    return bool(_holds)


@contextmanager
def held() -> Iterator[None]:
    """Has them wait for a while."""
    mine = hold()
    try:
        yield
    finally:
        release(mine)
