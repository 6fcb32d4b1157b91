"""Turns the options of compute() into settings, or says in one sentence which one is wrong. Never imports bpy."""

import difflib
import inspect
import math
from collections.abc import Callable, Iterable, Mapping
from numbers import Integral, Real

import numpy as np

from .. import bridge
from ..bridge import BACKENDS, CHOICES, InputError
from ..core import balance
from ..core.corners import check_threshold
from ..core.face_centers import DOMAINS
from ..core.job import Settings, check_descriptors

DEFAULTS = {row.name: row.default for row in bridge.TABLE}
KNOWN = ("corner_threshold", *DEFAULTS)
# The settings that belong to the machine, with their largest values.
WHOLE = {"device_index": 2**31 - 1, "threads": 4096, "memory_limit": 2**63 - 1}


def check_names(function: Callable, more: Iterable[str], known: Iterable[str] = KNOWN) -> None:
    """Refuses a keyword argument that a function has not, as Python does, and names the nearest that it has."""
    for name in more:
        if name not in known:
            every = [*inspect.signature(function).parameters, *known]
            (nearest,) = difflib.get_close_matches(name, every, 1, 0)
            sentence = f"{function.__qualname__}() got an unexpected keyword argument {shown(name)}"
            raise TypeError(f"{sentence}; the nearest is {nearest!r}.")


def settings_of(descriptors: object, radius: object, given: Mapping[str, object]) -> Settings:
    """The settings of a computation; given are options and machine settings by name."""
    radii = radii_of(radius)
    options = {name: option_of(name, value) for name, value in given.items() if name in DEFAULTS}
    machine = {name: whole_number(name, given[name]) for name in WHOLE if name in given}
    for name, value in machine.items():
        least = -1 if name == "device_index" else 0
        if not least <= value <= WHOLE[name]:
            raise InputError(f"{name} is {shown(value)}; it has to be between {least} and {WHOLE[name]}.")
    if "corner_threshold" in given:
        machine["corner_threshold"] = real_number("corner_threshold", given["corner_threshold"])
        check_threshold(machine["corner_threshold"])
    return Settings(
        descriptors_of(descriptors),
        bridge.Options(**options, radius=radii[0]),
        choice_of("backend", given.get("backend", "auto"), BACKENDS),
        more_radii=radii[1:],
        domain=choice_of("domain", given.get("domain", "vertices"), DOMAINS),
        radius_fit=balance.AUTO if isinstance(radius, str) else "typed",
        **machine,
    )


def descriptors_of(given: object) -> tuple[str, ...]:
    """The names of descriptors, of which one may be given by itself."""
    if isinstance(given, str):
        given = (given,)
    try:
        names = tuple(given)
    except TypeError as error:
        raise InputError(f"descriptors is {shown(given)}; give a name or several.") from error
    known = [row.name for row in bridge.descriptors()]
    for name in names:
        if not isinstance(name, str) or name not in known:
            raise InputError(f"There is no descriptor {shown(name)}; choose from {', '.join(known)}.")
    names = tuple(map(str, names))
    check_descriptors(names)
    return names


def radii_of(given: object) -> tuple[float, ...]:
    """One radius or several; the usual one stands for "auto", which settings_of() notes."""
    if isinstance(given, str) and given == balance.AUTO:
        return (bridge.Options.radius,)
    if isinstance(given, np.ndarray) and given.ndim == 1:
        given = given.tolist()
    several = tuple(given) if isinstance(given, (list, tuple)) else (given,)
    if not several:
        raise InputError("radius is empty; give one or several.")
    radii = tuple(real_number("radius", value) for value in several)
    for value in radii:
        if value <= 0:
            raise InputError(f"radius is {value:g}; it has to be above 0.")
    return radii


def rising(given: object) -> list[float]:
    """The two or more radii of a profile in ascending order."""
    radii = radii_of(given)
    if len(set(radii)) < 2 or len(set(radii)) < len(radii):
        raise InputError(f"radii is {shown(given)}; give two or more, each once.")
    return sorted(radii)


def option_of(name: str, value: object) -> object:
    """The value of an option, if it is of the right type and one of its choices."""
    if name in CHOICES:
        return choice_of(name, value, CHOICES[name][0])
    if name == "map_descriptor":
        return choice_of(name, value, [row.name for row in bridge.descriptors()])
    return whole_number(name, value) if isinstance(DEFAULTS[name], int) else real_number(name, value)


def choice_of(name: str, value: object, choices: Iterable[str]) -> str:
    """The value, if it is one of the choices."""
    if not isinstance(value, str) or value not in choices:
        raise InputError(f"{name} is {shown(value)}; choose one of {', '.join(choices)}.")
    return str(value)


def real_number(name: str, value: object) -> float:
    """A finite number."""
    value = value.item() if isinstance(value, np.ndarray) and value.ndim == 0 else value
    is_number = isinstance(value, Real) and not isinstance(value, bool)
    try:
        number = float(value) if is_number else math.nan
    except (OverflowError, ValueError):
        number = math.inf
    if not math.isfinite(number):
        raise InputError(f"{name} is {shown(value)}; a finite number is needed.")
    return number


def whole_number(name: str, value: object) -> int:
    """A whole number."""
    if not isinstance(value, Integral) or isinstance(value, bool):
        raise InputError(f"{name} is {shown(value)}; a whole number is needed.")
    return int(value)


def shown(value: object) -> str:
    """A value as a sentence shows it: short, and on one line."""
    try:
        text = ascii(value) if isinstance(value, str) else repr(value)
    except Exception:  # noqa: BLE001 (whatever a foreign object does, the sentence is about its type)
        text = f"a {type(value).__name__}"
    text = " ".join(text.split())
    return text if len(text) <= 60 else f"{text[:57]}…"
