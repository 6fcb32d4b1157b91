"""Fuzzes paradesc.compute() and paradesc.Mesh by what users may give them: shapes, types, numbers, options of any kind.

Usage: python_inputs.py [--inputs N] [--seed S] [--first I]. Each input is a small mesh and options of which some are
damaged. It has to give a result, a ParadescError whose text is one sentence, or a TypeError for an option that there is
not; never another exception, and what was given has to stay as it was. Each input follows from seed and number alone: a
finding is repeated by the command that is printed with it.
"""

import argparse
import random
import sys
import time
import traceback
from fractions import Fraction
from types import SimpleNamespace

import numpy as np

import paradesc
from paradesc import ParadescError
from paradesc.bridge import CHOICES

ODD = (None, True, False, 0, -1, 1, 3, 2**31, -(2**63), 2**64, 10**400, 0.0, -0.0, 0.5, 1e308, 5e-324, float("nan"),
       float("inf"), "", "cpu", "é\n\ud800", b"abc", 1j, (), [], {}, {1, 2}, object(), Fraction(1, 3), np.float32(0.3),
       np.int8(-3), np.bool_(True), np.datetime64("2026-01-01"), np.array(0.2), np.zeros((0, 3)), np.zeros((2, 2, 2)),
       np.array(["a"]), np.array([None]), range(3), type, len, ..., NotImplemented, memoryview(b"abc"), [[]], [[[0]]],
       np.ma.masked, np.float64("nan"), np.longdouble(2), slice(1))  # fmt: skip
NUMBERS = (np.nan, np.inf, -np.inf, 1e300, -1e39, 3.4e38, 1e-45, 5e-324, 1e20, 0.0, -0.0, 1e7, 1e-30)
INDICES = (-1, -(2**31), 2**31 - 1, 2**31, 2**63 - 1, 10**6, 0, 1, 4)
TYPES = (">f8", "<f4", ">f4", "f2", "longdouble", ">i4", "i8", "u1", "u8", "i2", "bool", "complex64", "object", "U5",
         "S4")  # fmt: skip
WHOLE = ("samples", "threads", "device_index", "memory_limit", "buffer_size", "max_jumps", "seed", "texels")
REAL = ("map_sigma", "harris_k", "adaptive", "corner_threshold")


class BrokenWordError(Exception):
    """It did what it must not do."""


def sound(source):
    """Positions (n, 3) and faces of a tetrahedron, a cube, a fan with a concave outline, or a strip."""
    kind = source.randrange(4)
    if kind == 0:
        return np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], float), [
            [0, 2, 1],
            [0, 1, 3],
            [1, 2, 3],
            [0, 3, 2],
        ]
    if kind == 1:
        cube = np.stack(np.meshgrid(*[[0.0, 1.0]] * 3, indexing="ij"), axis=3).reshape(-1, 3)
        return cube, [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    count = source.randrange(5, 12)
    random_points = np.random.default_rng(source.randrange(2**32)).normal(size=(count, 3))
    if kind == 2:
        return random_points, [list(range(count)), [0, 1, 2], [*range(count - 1, -1, -1)][: source.randrange(3, count)]]
    return random_points, [[k, k + 1, k + 2] for k in range(count - 2)]


def laid_out(source, array):
    """The same numbers, or nearly, in another type, order of bytes, layout in memory or container."""
    action = source.randrange(9)
    if action == 0:
        with np.errstate(all="ignore"):
            return array.astype(source.choice(TYPES))
    if action == 1:
        return np.asfortranarray(array)
    if action == 2:
        return np.repeat(array, 2, axis=0)[::2]
    if action == 3:
        return array[::-1]
    if action == 4:
        return array.tolist()
    if action == 5:
        return tuple(map(tuple, array.tolist())) if array.ndim == 2 else array
    if action == 6:
        return np.ma.masked_array(array, np.random.default_rng(source.randrange(99)).random(array.shape) < 0.1)
    if action == 7:
        return memoryview(np.ascontiguousarray(array))
    return array


def shaped(source, array):
    """The numbers in another shape."""
    action = source.randrange(7)
    if action == 0:
        return array[: source.randrange(len(array) + 1)]
    if action == 1:
        return array[..., : source.randrange(4)]
    if action == 2:
        return array.reshape(-1)
    if action == 3:
        return array[None]
    if action == 4:
        return array.T
    if action == 5:
        return np.concatenate([array, array], axis=source.randrange(array.ndim))
    return array.ravel()[0] if array.size else array


def damaged(source, array, values):
    """An array with a few other numbers, another shape or layout, or something else altogether."""
    if source.random() < 0.1:
        return source.choice(ODD)
    found = np.array(array)
    if found.size and source.random() < 0.6:
        if source.random() < 0.3 and found.dtype.kind == "i":
            found = found.astype(float) + (0.5 if source.random() < 0.3 else 0)
        for _ in range(source.randrange(1, 3)):
            at = source.randrange(found.size)
            value = source.choice(values)
            if found.dtype.kind == "f" or abs(value) < 2**63:
                found.reshape(-1)[at] = value
    if source.random() < 0.25:
        found = shaped(source, found)
    if isinstance(found, np.ndarray) and source.random() < 0.6:
        found = laid_out(source, found)
    if isinstance(found, np.ndarray) and source.random() < 0.3:
        found.flags.writeable = False
    return found


def ragged(source, faces):
    """Lists of lists with a few places changed."""
    found = [list(row) for row in faces]
    for _ in range(source.randrange(3)):
        row = source.randrange(len(found))
        action = source.randrange(6)
        if action == 0:
            found[row] = source.choice(ODD)
        elif action == 1 and isinstance(found[row], list):
            found[row].append(source.choice((*ODD, *INDICES)))
        elif action == 2 and isinstance(found[row], list):
            found[row] = found[row][: source.randrange(4)]
        elif action == 3 and isinstance(found[row], list):
            found[row] = np.array(found[row], object) if source.random() < 0.1 else np.array(faces[0])
        elif action == 4:
            found.append([source.choice(INDICES) for _ in range(source.randrange(6))])
        elif action == 5 and len(found) > 1:
            del found[row]
    return tuple(found) if source.random() < 0.1 else found


def chosen_options(source, count, faces):
    """Options, sound and odd ones, by name."""
    names = [row.name for row in paradesc.descriptors()]
    found = {
        "descriptors": source.choice(names) if source.random() < 0.7 else source.sample(names, source.randrange(4))
    }
    found["radius"] = source.choice((0.02, 0.3, 0.9, (0.1, 0.4), [0.2], np.array([0.2, 0.3])))
    for name, (choices, _) in CHOICES.items():
        if source.random() < 0.08 and name not in ("evaluate", "precision", "relocation"):
            found[name] = source.choice([*choices])
    if source.random() < 0.15:
        found["uvs"] = damaged(source, np.random.default_rng(source.randrange(99)).random((count, 2)), NUMBERS)
    if source.random() < 0.1:
        found["corner_normals"] = damaged(source, np.ones((count, 3)), NUMBERS)
    if source.random() < 0.15:
        found["sharp_edges"] = damaged(source, np.array(faces[0][:2])[None], INDICES)
    for name in source.choices((*WHOLE, *REAL), k=int(source.random() < 0.15)):
        found[name] = source.choice((0, 1, 2, 16, 64, 0.04, 1e9, 10**6))
    if source.random() < 0.15:
        name = source.choice(
            (*WHOLE, *REAL, *CHOICES, "descriptors", "radius", "backend", "map_descriptor", "progress")
        )
        found[name] = source.choice(ODD) if name != "progress" else source.choice((None, 3, "x", lambda *_: None))
    if source.random() < 0.02:
        found[source.choice(("sampels", "seed_", "buffers", "é"))] = 1
    found.setdefault("backend", "cpu")  # others open devices, which takes long
    return found


def copied(value):
    """A copy of a value, to be compared afterwards; None for values that need no comparison."""
    return value.tobytes() if type(value) is np.ndarray and value.dtype.kind != "O" else None


def other_mesh(source, vertices, faces):
    """The arrays as another package's mesh has them."""
    return source.choice(
        (
            SimpleNamespace(vertices=vertices, faces=faces),
            SimpleNamespace(vertices=vertices, triangles=faces),
            SimpleNamespace(points=vertices, faces=faces),
            SimpleNamespace(points=vertices, cells=faces, celltypes=source.choice(([5], [5, 7], [12], ["a"], None))),
            SimpleNamespace(vertex={"positions": vertices}, triangle={"indices": faces}),
        )
    )


def compute(source):
    """Computes on one input; True if there was a result."""
    points, faces = sound(source)
    vertices = damaged(source, points, NUMBERS) if source.random() < 0.35 else points * source.choice((1, 1e-3, 1e6))
    if len({len(row) for row in faces}) > 1 or source.random() < 0.3:
        polygons = ragged(source, faces)
    else:
        polygons = damaged(source, np.array(faces), INDICES) if source.random() < 0.5 else np.array(faces)
    given = chosen_options(source, len(points), faces)
    arrays = [vertices, polygons, *given.values()]
    before = [copied(value) for value in arrays]
    try:
        result = called(source, vertices, polygons, given)
    except TypeError as error:
        if "unexpected keyword argument" not in str(error):
            raise
        return False
    except ParadescError as error:
        if "\n" in str(error) or not str(error).rstrip().endswith("."):
            raise BrokenWordError(f"a refusal is not one sentence: {error!s}") from error
        return False
    finally:
        if [copied(value) for value in arrays] != before:
            raise BrokenWordError("what was given was changed")
    check(result, vertices)
    return True


def called(source, vertices, polygons, given):
    """The result by one of the ways that there are."""
    way = source.random()
    if way < 0.1:
        return paradesc.compute(other_mesh(source, vertices, polygons), **given)
    if way > 0.2:
        return paradesc.compute(vertices, polygons, **given)
    machine = {
        name: given.pop(name) for name in ("backend", "threads", "device_index", "memory_limit") if name in given
    }
    edges = {name: given.pop(name) for name in ("uvs", "sharp_edges") if name in given}
    with paradesc.Mesh(vertices, polygons, **machine, **edges) as mesh:
        mesh.compute(**given)
        mesh.positions = damaged(source, mesh.positions, NUMBERS) if source.random() < 0.5 else 2 * mesh.positions
        assert mesh.report["triangle_count"] > 0
        return mesh.compute(**given)


def check(result, vertices):
    """Checks everything that a result promises."""
    count = len(result.coverage)
    for name, values in result.items():
        if values.dtype != np.float32 or values.shape not in ((count,), (count, 3)):
            raise BrokenWordError(f"{name} is {values.dtype} {values.shape}")
        if np.isinf(values).any():
            raise BrokenWordError(f"{name} is infinite")
    if isinstance(vertices, np.ndarray) and len(vertices) != count:
        raise BrokenWordError("values do not belong to the vertices")
    if not repr(result) or not 0 <= result.radius < np.inf:  # 0: all vertices in one place
        raise BrokenWordError("a result does not say what it is")


def main(words=None):
    """Runs inputs; the exit code is 1 if one broke its word."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--inputs", type=int, default=100_000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--first", type=int, default=0)
    given = parser.parse_args(words)
    start, results = time.monotonic(), 0
    for number in range(given.first, given.first + given.inputs):
        try:
            results += compute(random.Random(f"{given.seed} {number}"))
        except Exception:  # noqa: BLE001 (whatever it is, it is a finding)
            again = f"tests/fuzz/python_inputs.py --seed {given.seed} --first {number} --inputs 1"
            sys.stdout.write(f"{traceback.format_exc()}Again: {again}\n")
            return 1
    seconds = time.monotonic() - start
    sys.stdout.write(f"{given.inputs:,} inputs: {results:,} results, the others one sentence each; {seconds:.0f} s\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
