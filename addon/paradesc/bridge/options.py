"""Defines how to compute: the names of all choices in Python, and the options as a C struct."""

from dataclasses import make_dataclass

from . import abi
from .library import new_struct, unusable
from .option_table import TABLE

# C's numbers of backends and of choices are their places, from 0.
BACKENDS = {name: number for number, name in enumerate(("auto", "gpu", "software", "reference", "cpu"))}
# How each backend measures: values of one method agree from machine to machine, those of two methods do only nearly.
METHODS = {
    "gpu": "texture space",
    "software": "texture space",
    "reference": "reference",
    "cpu": "surface samples",
}


# The numbers of the choices of each option that is a name, and what a sentence calls the option.
CHOICES = {
    row.name: ({name: number for number, (name, _, _) in enumerate(row.choices)}, row.what)
    for row in TABLE
    if row.choices
}


def uses_texture_space(backend: str) -> bool:
    """Returns whether a backend, other than auto, bakes buffers over a UV map, and so needs one."""
    return METHODS[backend] == "texture space"


# The settings of a computation; the defaults are those of pdesc_options_init.
Options = make_dataclass(
    "Options",
    [
        (name, type(default), default)
        for name, default in (("radius", 0.02), *((row.name, row.default) for row in TABLE))
    ],
    namespace={"__module__": __name__, "__doc__": "The settings of a computation."},
)


def native_options(options: Options, buffers: bool = False) -> abi.ComputeOptions:
    """The options as a C struct; buffers: whether the baked buffers will be read."""
    native = new_struct(abi.ComputeOptions)
    native.radius = options.radius
    for row in TABLE:
        value = getattr(options, row.name)
        if row.choices:
            value = choice(CHOICES[row.name][0], value, row.what)
        elif isinstance(row.default, str):
            value = value.encode()
        elif row.unsigned and not 0 <= value < 2**32:
            raise unusable(f"The {row.what} {value} is not between 0 and {2**32 - 1}.")
        elif isinstance(row.default, int) and not row.unsigned:
            value = int32(value, row.what)
        setattr(native, row.name, value)
    native.buffers = int(buffers)
    return native


def choice(names: dict[str, int], name: str, what: str) -> int:
    """The number of a named choice; a ParadescError lists the names that exist."""
    if name not in names:
        raise unusable(f'There is no {what} "{name}"; choose one of {", ".join(names)}.')
    return names[name]


def int32(value: int, what: str) -> int:
    """The value itself if it fits the C type; ctypes would cut it silently."""
    if not -(2**31) <= value < 2**31:
        raise unusable(f"The {what} {value} is out of range.")
    return value
