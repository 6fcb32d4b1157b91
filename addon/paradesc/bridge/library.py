"""Finds, loads and checks libparadesc in the package's own lib folder, and reads its descriptor registry."""

import ctypes
import platform
import sys
from ctypes import byref, sizeof
from dataclasses import dataclass, fields
from functools import lru_cache
from pathlib import Path
from typing import TypeVar

from .. import __version__
from . import abi

# The library of each sys.platform; one zip serves both kinds of Mac.
LIBRARY_NAMES = {
    "linux": "libparadesc.so",
    "win32": "paradesc.dll",
    "darwin": f"libparadesc-{platform.machine()}.dylib",
}
# Platforms that releases contain libraries for: platform.machine() by sys.platform. Linux on ARM64 has only a wheel.
MACHINES = {"linux": ("x86_64", "aarch64"), "win32": ("AMD64", "ARM64"), "darwin": ("x86_64", "arm64")}
# libparadesc needs these libraries; they are loaded first if they are in the same folder.
COMPANION_NAMES = ("libOpenMeshCore.so.9.0",)
# Bytes kept free behind every struct: a newer library of the same ABI version may know more members than abi.py.
GROWTH_ROOM = 256
# The labels of masks, which replace those of the descriptors that they are.
MASK_LABELS = {"convexity": "Edge Wear", "ambient_openness": "Openness"}
# A loaded library cannot be unloaded, so an add-on or package that was updated meanwhile still finds the old one.
REMEDY = "restart Blender or Python if you have just updated it, else install both from one release"

Struct = TypeVar("Struct", bound=ctypes.Structure)


class ParadescError(Exception):
    """A failure with its status code and one sentence for people.

    Attributes
    ----------
    status : int
        One of the numbers PDESC_ERROR_* of paradesc.h.
    sentence : str
        The sentence that str() shows.

    Examples
    --------
    >>> import numpy as np
    >>> import paradesc
    >>> u, v = np.meshgrid(np.linspace(-1, 1, 21), np.linspace(-1, 1, 21))
    >>> vertices = np.stack([u, v, -0.2 * u * u], axis=2).reshape(-1, 3)
    >>> faces = np.arange(420).reshape(20, 21)[:, :20].reshape(-1, 1) + [0, 1, 22, 21]
    >>> try:
    ...     paradesc.compute(vertices, faces, radius=0.2, progress=lambda stage, fraction: False)
    ... except paradesc.ParadescError as error:
    ...     print(error)  # doctest: +ELLIPSIS
    Cancelled in stage ...
    """

    def __init__(self, status: int, sentence: str) -> None:
        super().__init__(sentence)
        self.status = status
        self.sentence = sentence

    def __reduce__(self) -> tuple[object, ...]:
        """The same error in another process, whatever arguments a class of errors takes."""
        return type(self).__new__, (type(self), self.sentence), self.__dict__


class InputError(ParadescError, ValueError):
    """An error in the given mesh, file or options. It is also a ValueError, which Python users expect.

    Examples
    --------
    >>> import paradesc
    >>> try:
    ...     paradesc.compute([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 9]])
    ... except paradesc.InputError as error:
    ...     print(error)
    Face 0 names vertex 9, but there are 3 vertices, counted from 0.
    """

    def __init__(self, sentence: str) -> None:
        super().__init__(abi.STATUS_INVALID_ARGUMENT, sentence)


def unusable(sentence: str) -> ParadescError:
    """The error for an argument that cannot be used, where the input may be sound."""
    return ParadescError(abi.STATUS_INVALID_ARGUMENT, sentence)


@dataclass(frozen=True)
class Descriptor:
    """A descriptor that can be computed, as descriptors() lists it.

    Attributes
    ----------
    name, label, description : str
        The name that compute() takes; the name for people; a formula or a sentence.
    length_power : int
        The power of the length that is the unit; unit has it as text.
    is_signed : bool
        True if values lie on both sides of the neutral value.
    neutral_value : float
        The value of a plane; NaN if a plane has none.
    display_minimum, display_maximum : float
        A fixed range for colors; NaN if the range follows from the values.
    components : int
        1 for numbers, 3 for vectors in the space of the vertices.
    map_degree : int
        The power of the map's unit in the result of an operator on a map; 0 for all other descriptors.

    Examples
    --------
    >>> import paradesc
    >>> row = paradesc.descriptors()[0]
    >>> row.name, row.unit
    ('mean_curvature', '1/length')
    """

    name: str
    label: str
    description: str
    length_power: int
    is_signed: bool
    neutral_value: float
    display_minimum: float
    display_maximum: float
    components: int = 1
    map_degree: int = 0

    @property
    def unit(self) -> str:
        """The unit as text: "1/length", "length^3", or "" for none."""
        return unit_name(self.length_power)

    def unit_on(self, map_name: str) -> str:
        """The unit of an operator on the map of another descriptor; a descriptor of the surface has its own unit.

        Parameters
        ----------
        map_name : str
            The other descriptor.

        Returns
        -------
        str
            As unit has it.
        """
        powers = [row.length_power for row in descriptors() if row.name == map_name]
        return unit_name(self.length_power + self.map_degree * sum(powers))


def unit_name(power: int) -> str:
    """length^power as text."""
    if power == 0:
        return ""
    name = "length" if abs(power) == 1 else f"length^{abs(power)}"
    return name if power > 0 else f"1/{name}"


def library_path() -> Path:
    """The absolute path where the native library has to be."""
    name = LIBRARY_NAMES.get(sys.platform, "libparadesc.so")
    return Path(__file__).resolve().parent.parent / "lib" / name


def missing_sentence() -> str:
    """Why the native library cannot be used, as one sentence; "" when it can."""
    try:
        load_library()
    except ParadescError as error:
        return error.sentence
    return ""


@lru_cache(maxsize=1)
def load_library() -> ctypes.CDLL:
    """Loads libparadesc once, compares its ABI version and declares its functions."""
    return open_library(library_path())


def open_library(path: Path) -> ctypes.CDLL:
    """Loads the library at an absolute path; ParadescError says in one sentence what is wrong with it."""
    if not path.is_file():
        raise ParadescError(abi.STATUS_UNSUPPORTED, absent_sentence(path))
    try:
        for name in COMPANION_NAMES:
            if (path.parent / name).is_file():
                ctypes.CDLL(str(path.parent / name), mode=ctypes.RTLD_LOCAL)
        library = ctypes.CDLL(str(path), mode=ctypes.RTLD_LOCAL)
    except OSError as error:
        sentence = f"native library cannot be loaded – {str(error).strip().rstrip('.')}; {offer()}."
        raise ParadescError(abi.STATUS_UNSUPPORTED, sentence) from error
    check_version(library, path)
    return library


def absent_sentence(path: Path) -> str:
    """A sentence that says what to do if there is no library."""
    if platform.machine() not in MACHINES.get(sys.platform, ()):
        return f"native library missing – {offer()}; elsewhere build it with cmake, so that {path} exists."
    return (
        f"native library missing – {path.name} is not in {path.parent}; install a release package of the add-on for "
        "this system, or by pip a wheel, instead of a source archive, or build it with cmake."
    )


def offer() -> str:
    """A sentence with the packages and wheels that releases contain, and the system this is."""
    return (
        "releases are for Linux, Windows and macOS on x86-64 and ARM64 (for Linux on ARM64 a wheel alone), and "
        f"this is {platform.system()} on {platform.machine()}"
    )


def check_version(library: ctypes.CDLL, path: Path) -> None:
    """Declares the functions, and compares the versions with those that the package is for, before any other call."""
    try:
        for name, (result, arguments) in abi.FUNCTIONS.items():
            function = getattr(library, name)
            function.restype, function.argtypes = result, arguments
    except AttributeError as error:
        sentence = f"native library does not fit – {path.name} lacks a function ({error}); {REMEDY}."
        raise ParadescError(abi.STATUS_UNSUPPORTED, sentence) from error
    found = library.pdesc_abi_version()
    if found != abi.ABI_VERSION:
        raise ParadescError(
            abi.STATUS_UNSUPPORTED,
            f"native library does not fit – {path.name} has ABI version {found} and the package needs "
            f"{abi.ABI_VERSION}; {REMEDY}.",
        )
    version = text(library.pdesc_version())
    if version != __version__:
        raise ParadescError(
            abi.STATUS_UNSUPPORTED,
            f"native library does not fit – {path.name} is version {version} and the package {__version__}; {REMEDY}.",
        )


def check(status: int) -> None:
    """Turns a pdesc_status into an exception that carries the library's sentence."""
    if status != abi.STATUS_OK:
        sentence = text(load_library().pdesc_last_error()) or f"The native library failed with status {status}."
        raise ParadescError(status, sentence)


def text(raw: bytes | None) -> str:
    """A C string as str."""
    return raw.decode("utf-8", "replace") if raw else ""


def new_struct(kind: type[Struct]) -> Struct:
    """A struct with the library's defaults, and with spare room for members that only a newer library knows."""
    room = (ctypes.c_ubyte * (sizeof(kind) + GROWTH_ROOM))()
    struct = kind.from_buffer(room)
    getattr(load_library(), abi.STRUCTS[kind] + "_init")(byref(struct))
    return struct


@lru_cache(maxsize=1)
def descriptors() -> tuple[Descriptor, ...]:
    """The descriptors that compute() takes, in the order of the native registry.

    Returns
    -------
    tuple of Descriptor
        A row for each.

    Raises
    ------
    ParadescError
        The native library is missing, or does not fit this system.

    Examples
    --------
    >>> import paradesc
    >>> [row.name for row in paradesc.descriptors() if row.components == 3]
    ['principal_direction_max', 'principal_direction_min']
    """
    library = load_library()
    rows = []
    for index in range(library.pdesc_descriptor_count()):
        info = new_struct(abi.DescriptorInfo)
        check(library.pdesc_descriptor_get(index, byref(info)))
        found = {row.name: getattr(info, row.name) for row in fields(Descriptor)}
        found.update(name=text(info.name), label=text(info.label), description=text(info.description))
        found.update(label=MASK_LABELS.get(found["name"], found["label"]), is_signed=bool(info.is_signed))
        rows.append(Descriptor(**found))
    return tuple(rows)


def components(name: str) -> int:
    """The number of values of a descriptor at a vertex, 1 or 3."""
    return next((row.components for row in descriptors() if row.name == name), 1)
