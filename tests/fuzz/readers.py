"""Fuzzes what the add-on reads from files: meshes, frame caches, their ranges, and what a bake left in a .blend.

Usage: readers.py [--inputs N] [--seed S] [--first I] [--reader NAME]. Valid content is damaged, mostly where its
structure is, with the checksum made right again so that more than the checksum is tested. Each input follows from seed
and number alone: a finding is repeated by the command that is printed with it. Without Blender's module the two readers
of a .blend are left out.
"""

import argparse
import copy
import functools
import hashlib
import json
import random
import resource
import struct
import sys
import tempfile
import time
import traceback
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import numpy as np

sys.path.append(str(Path(__file__).resolve().parents[1] / "addon"))

from mesh_kinds import SOUND
from paradesc.bridge import InputError, ParadescError
from paradesc.core import stored
from paradesc.files import cache, mesh_files, triangle_counts

try:
    import bpy

    from paradesc.scene import record, unwrap
    from paradesc.show import channels, recolor
    from paradesc.ui import panel, report_panel
except ImportError:
    bpy = None

# More than the interpreter, Blender and any input here need.
MOST_MEMORY = 2 << 30
# Where Linux has files that no disk waits for.
IN_MEMORY = "/dev/shm"

ODD = (
    None,
    True,
    False,
    0,
    -1,
    1,
    2**31,
    -(2**63),
    10**400,
    0.0,
    -0.0,
    1e308,
    5e-324,
    float("nan"),
    float("inf"),
    "",
    "radius",
)
ODD_TEXTS = (
    "",
    "__class__",
    "../../etc/passwd",
    "mean_curvature:quantiles",
    "x" * 200,
    "\u0000",
    "cos\nsystem",
    "é",
    "{0.__init__}",
)


class BrokenWordError(Exception):
    """A reader did what it must not do."""


def claim(holds: bool, what: str) -> None:
    """Raises if a reader broke its word."""
    if not holds:
        raise BrokenWordError(what)


def claim_one_sentence(error: ParadescError, path: Path) -> None:
    """Checks that a refusal of a file is one sentence with its name."""
    named = str(path) in error.sentence and "\n" not in error.sentence
    claim(named, "a refusal is not one sentence that names the file")


# ---- Damage


def odd(source: random.Random, depth: int = 0) -> object:
    """Any value that JSON or a custom property holds, the awkward ones first."""
    kind = source.randrange(8)
    if kind < 4 or depth > 3:
        return source.choice(ODD)
    if kind == 4:
        return source.choice(ODD_TEXTS)
    if kind == 5:
        return source.randint(-(2**33), 2**33)
    if kind == 6:
        return [odd(source, depth + 1) for _ in range(source.randrange(4))]
    return {source.choice(ODD_TEXTS) or "a": odd(source, depth + 1) for _ in range(source.randrange(4))}


def damaged(source: random.Random, value: object) -> object:
    """The value with one place in it changed, left out, doubled or given to another name."""
    if isinstance(value, dict) and value and source.random() < 0.9:
        name = source.choice(sorted(value))
        found = dict(value)
        action = source.randrange(8)
        if action == 0:
            del found[name]
        elif action == 1:
            found[source.choice(ODD_TEXTS)] = found.pop(name)
        elif action == 2:
            found[name] = found[source.choice(sorted(found))]
        else:
            found[name] = damaged(source, found[name])
        return found
    if isinstance(value, list) and value and source.random() < 0.9:
        at, found = source.randrange(len(value)), list(value)
        action = source.randrange(8)
        if action == 0:
            del found[at]
        elif action == 1:
            found.insert(at, found[source.randrange(len(found))])
        else:
            found[at] = damaged(source, found[at])
        return found
    if isinstance(value, int) and source.random() < 0.5:
        return value + source.choice((-1, 1, 2, 1 << 20, 1 << 31, 1 << 62))
    return odd(source)


def damaged_bytes(source: random.Random, content: bytes) -> bytes:
    """The bytes with some of them changed, left out or inserted, or with the end cut off."""
    found = bytearray(content)
    for _ in range(source.randrange(1, 4)):
        at = source.randrange(len(found) + 1)
        action = source.randrange(5)
        if action == 0:
            del found[at:]
        elif action == 1:
            del found[at : at + source.randrange(1, 9)]
        elif action == 2:
            found[at:at] = source.randbytes(source.randrange(1, 9))
        elif action == 3:
            found[at : at + 4] = struct.pack("<f", source.choice((np.nan, np.inf, -np.inf, 3e38, 1e-45, 0)))
        else:
            found[at : at + 1] = bytes([source.randrange(256)])
    return bytes(found)


# ---- Frame files


@functools.cache
def sound_frame(count: int) -> bytes:
    """The file of a frame of so many vertices; it is kept, as making it takes as long as reading it."""
    values = {
        "mean_curvature": np.linspace(-1, 1, count, dtype=np.float32),
        "principal_direction_max": np.ones((count, 3), np.float32),
        "coverage": np.ones(count, np.float32),
    }
    info = {"object": "Suzanne", "radius": {"mean_curvature": 0.1}}
    return cache.encode(cache.Frame(7, "key", "input", values, info))


def damaged_frame(source: random.Random) -> bytes:
    """A frame file with damage in its header, its arrays or anywhere, mostly with the right checksum."""
    content = sound_frame(source.randrange(1, 12))
    start = len(cache.MAGIC) + 8
    (length,) = struct.unpack_from("<Q", content, len(cache.MAGIC))
    text, body = content[start : start + length], content[start + length : -cache.DIGEST_BYTES]
    if source.random() < 0.7:
        header = json.loads(text)
        for _ in range(source.randrange(1, 4)):
            header = damaged(source, header)
        text = json.dumps(header).encode()
    if source.random() < 0.1:
        text = damaged_bytes(source, text)
    if source.random() < 0.3:
        body = damaged_bytes(source, body)
    said = len(text) if source.random() < 0.9 else source.choice((0, 1, 2**32, 2**63, len(text) + 1))
    whole = cache.MAGIC + struct.pack("<Q", said) + text + body
    if source.random() < 0.05:
        return damaged_bytes(source, whole + hashlib.sha256(whole).digest())
    return whole + hashlib.sha256(whole).digest()


def read_frame(source: random.Random, folder: Path) -> bool:
    """Reads one damaged frame file; True if it was taken as sound."""
    path, content = folder / "frame_00007.pdframe", damaged_frame(source)
    path.write_bytes(content)
    try:
        frame = cache.read_frame(path)
    except ParadescError as error:
        claim_one_sentence(error, path)
        return False
    arrays = [*frame.values.values(), *frame.quantiles.values()]
    claim(sum(array.nbytes for array in arrays) <= len(content), "more is held than the file has")
    claim(all(len(array) == frame.vertex_count for array in frame.values.values()), "arrays have several lengths")
    claim(all(array.dtype == np.float32 for array in arrays), "an array is of another type")
    for shown in cache.ranges([frame]).values():
        claim(shown.minimum < shown.maximum and np.isfinite([shown.minimum, shown.maximum]).all(), "a range is none")
    cache.locked_ranges([folder])
    return True


def read_range(source: random.Random, folder: Path) -> bool:
    """Reads one damaged file of ranges."""
    path = folder / cache.RANGE_FILE
    content: object = {"mean_curvature": [-1.5, 1.5], "": [0, 1]}
    for _ in range(source.randrange(1, 4)):
        content = damaged(source, content)
    text = json.dumps(content).encode()
    path.write_bytes(damaged_bytes(source, text) if source.random() < 0.3 else text)
    try:
        found = cache.read_fixed(folder)
    except ParadescError as error:
        claim_one_sentence(error, path)
        return False
    for name, (low, high) in found.items():
        claim(isinstance(name, str) and low < high and np.isfinite([low, high]).all(), "a range is none")
    return True


# ---- Mesh files

# Numbers, words and lines of text are changed into these.
ODD_WORDS = (
    *(
        b"0",
        b"-1",
        b"1",
        b"4294967295",
        b"99999999999999999999",
        b"1e400",
        b"nan",
        b"-inf",
        b"1.#IND",
        b"1,5",
        b"x",
        b"",
    ),
    *(b"//", b"1/", b"#", b"\\\n", b"\r", b"\0", b"\xef\xbb\xbf", b"\xff", b"end_header", b"f", b"v", b"o", b"solid"),
    *(b"element face 1000000000000", b"property list double double vertex_indices", b"OFF"),
)


def damaged_mesh(source: random.Random, suffix: str, content: bytes) -> bytes:
    """A mesh file with damage in its header, its words, its lines or anywhere."""
    if suffix in (".glb", ".gltf") and source.random() < 0.8:
        return damaged_gltf(source, content)
    if source.random() < 0.3:
        return damaged_bytes(source, content)
    between = source.choice((b" ", b"\n"))
    parts = content.split(between)
    for _ in range(source.randrange(1, 4)):
        # the header of a .ply and the first lines are where the structure is
        at = source.randrange(min(len(parts), source.choice((8, 20, len(parts)))))
        action = source.randrange(4)
        if action == 0:
            del parts[at : at + source.choice((1, 1, 3, len(parts)))]
        elif action == 1:
            parts[at:at] = parts[at : at + source.randrange(4)]
        else:
            parts[at] = source.choice(ODD_WORDS)
        parts = parts or [b""]
    return between.join(parts)


def damaged_gltf(source: random.Random, content: bytes) -> bytes:
    """A glTF file whose header has a few places changed."""
    binary = b""
    if content[:4] == b"glTF":
        (length,) = struct.unpack_from("<I", content, 12)
        content, binary = content[20 : 20 + length], content[20 + length :]
    header = json.loads(content.removeprefix(b"\xef\xbb\xbf"))
    for _ in range(source.randrange(1, 4)):
        header = damaged(source, header)
    text = json.dumps(header).encode()
    if not binary:
        return text
    return struct.pack("<4sIII4s", b"glTF", 2, 20 + len(text) + len(binary), len(text), b"JSON") + text + binary


def read_mesh_file(source: random.Random, folder: Path) -> bool:
    """Reads one damaged mesh file; True if there was a surface, which then holds together."""
    suffix, name = source.choice(sorted(SOUND))
    path = folder / f"a{suffix}"
    path.write_bytes(damaged_mesh(source, suffix, SOUND[suffix, name]))
    claim(triangle_counts.triangles(path) >= 0, "a number of triangles is negative")
    try:
        meshes = mesh_files.read(path)
    except InputError as error:
        claim_one_sentence(error, path)
        claim(error.sentence.endswith(".") and "Error" not in error.sentence.split("(")[0], "a refusal is no sentence")
        return False
    claim(mesh_files.check(path) >= 0, "what is read is refused by the check")
    for mesh in meshes:
        arrays, count = mesh.arrays, len(mesh.arrays.positions)
        claim(bool(np.isfinite(arrays.positions).all()), "a position is not finite")
        claim(len(arrays.triangle_corners) > 0 and bool((arrays.triangle_vertices < count).all()), "a face is none")
        claim(bool((arrays.corner_vertices >= 0).all()), "a corner has no vertex")
        for rows in (arrays.corner_uvs, mesh.corner_normals):
            claim(rows is None or len(rows) == len(arrays.corner_vertices), "corners have other rows than there are")
        claim(mesh.matrix_world.shape == (4, 4) and all("\n" not in note for note in mesh.notes), "a mesh is none")
    return True


# ---- What a bake left in a .blend


def sound_summary() -> dict[str, object]:
    """A custom property as record.write() makes it."""
    return {
        "settings": {"radius": 0.02, "space": "world", "names": ["mean_curvature"]},
        "mesh_report": dict.fromkeys((*stored.MESH_REPORT, "parts", "diagonal"), 3),
        "field_report": {
            **dict.fromkeys(stored.FIELD_REPORT, 0.5),
            "private_layout": 1,
            "cut_charts": 2,
            "seconds_bake": 0.1,
        },
        "backend": "reference",
        "device": "CPU",
        "warnings": "One.\nTwo.",
        "ranges": {"mean_curvature": [-1.0, 1.0], "shape_index": [-1.0, 1.0]},
        "drawn": {"mean_curvature": {"map": "heat", "diverging": True, "neutral": 0.0, "radius": 0.1, "unit": "1/m"}},
        "attributes": ["mean_curvature", "mean_curvature_color", "shape_index", "shape_index_color", "coverage"],
        "layout": {"topology": "a", "content": "b"},
    }


def damaged_summary(source: random.Random) -> object:
    """A custom property with a few places of it changed."""
    content: object = sound_summary()
    for _ in range(source.randrange(1, 5)):
        content = damaged(source, content)
    return content


def check_summary(found: dict[str, object]) -> None:
    """Checks everything that panels, legends and operators take from it without another check."""
    if "mesh_report" in found:
        lines = [*report_panel.report_lines(found), panel.result_sentence(found)] if bpy else []
        claim(all(isinstance(line, str) for line in lines), "a line of the report is no text")
    if found:
        found["warnings"].splitlines()
    for name in found.get("attributes", []):
        low, high = found["ranges"].get(name, (0.0, 1.0))
        claim(low < high, "a range is none")
        row = found["drawn"].get(name, {})
        claim(
            isinstance(row.get("unit", ""), str) and float(row.get("radius", 0.0)) == row.get("radius", 0.0),
            "a drawing is none",
        )


def read_summary(source: random.Random, _: Path) -> bool:
    """Reads one damaged custom property, from memory and every tenth time from a Blender mesh."""
    content = damaged_summary(source)
    found = stored.checked(copy.deepcopy(content))
    check_summary(found)
    if bpy is not None and source.random() < 0.1:
        read_mesh(source, content)
    return bool(found)


def read_mesh(source: random.Random, content: object) -> None:
    """Runs the readers of a mesh with this property."""
    mesh = bpy.data.meshes.new("fuzz")
    try:
        for name in (record.PROPERTY, channels.OWN):
            with suppress(TypeError, OverflowError, ValueError, KeyError):  # Blender does not hold it either
                mesh[name] = content if source.random() < 0.9 else odd(source)
        check_summary(record.read(mesh))
        claim(all(isinstance(text, str) for text in record.layout_of(mesh).values()), "a layout's name is no text")
        claim(all(isinstance(name, str) for name in channels.own_names(mesh, "attributes")), "a name is no text")
        for name in recolor.baked_names(mesh):
            try:
                recolor.stored_range(mesh, name).color_map  # noqa: B018
            except ParadescError:
                continue
    finally:
        bpy.data.meshes.remove(mesh)


def read_layout(source: random.Random, _: Path) -> bool:
    """Reads a kept layout whose attribute, names or mesh have changed since it was made."""
    mesh = bpy.data.meshes.new("fuzz")
    try:
        count = source.randrange(0, 4)
        mesh.from_pydata([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [], [(0, 1, 2)] * min(count, 1))
        kind = source.choice(("FLOAT_VECTOR", "FLOAT", "INT", "FLOAT_COLOR", "BOOLEAN", "FLOAT2", "STRING"))
        attribute = mesh.attributes.new(unwrap.ATTRIBUTE, kind, source.choice(("CORNER", "POINT", "FACE", "EDGE")))
        if kind == "FLOAT_VECTOR":
            numbers = [source.choice((0.5, 0.25, np.nan, np.inf, 3e38)) for _ in range(3 * len(attribute.data))]
            attribute.data.foreach_set("vector", numbers)
        uvs = np.array([0.5] * 2 * len(mesh.loops), np.float32).reshape(-1, 2)
        made = {"topology": "a", "content": source.choice((unwrap.digest(uvs), "b"))}
        made = {name: text for name, text in made.items() if source.random() < 0.9}
        found = unwrap.kept_uvs(mesh, made, source.choice(("a", "a", "b")))
        claim(
            found is None or (found.shape == (len(mesh.loops), 2) and np.isfinite(found).all()), "a layout does not fit"
        )
        return found is not None
    finally:
        bpy.data.meshes.remove(mesh)


# ---- All

Reader = Callable[[random.Random, Path], bool]
# The function of each name, and its share of the inputs.
READERS: dict[str, tuple[Reader, float]] = {
    "frame": (read_frame, 0.4),
    "range": (read_range, 0.15),
    "mesh": (read_mesh_file, 0.2),
    "summary": (read_summary, 0.23),
    "layout": (read_layout, 0.02),
}


def fuzz(name: str, seed: int, first: int, count: int) -> tuple[int, str]:
    """Runs a reader over so many inputs; gives how many were taken as sound, and the errors."""
    reader, _ = READERS[name]
    taken = 0
    with tempfile.TemporaryDirectory(dir=IN_MEMORY if Path(IN_MEMORY).is_dir() else None) as folder:
        for number in range(first, first + count):
            try:
                taken += reader(random.Random(f"{name} {seed} {number}"), Path(folder))
            except Exception:  # noqa: BLE001 (whatever it is, it is a finding)
                again = f"tests/fuzz/readers.py --reader {name} --seed {seed} --first {number} --inputs 1"
                return taken, f"{traceback.format_exc()}Again: {again}"
            for path in Path(folder).iterdir():
                path.unlink()
    return taken, ""


def main(words: list[str]) -> int:
    """Runs the readers; the exit code is 1 if one broke its word."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--inputs", type=int, default=100_000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--reader", choices=READERS)
    given = parser.parse_args(words)
    resource.setrlimit(resource.RLIMIT_DATA, (MOST_MEMORY, MOST_MEMORY))
    failed = False
    for name, (reader, share) in READERS.items():
        if given.reader not in (None, name) or (reader is read_layout and bpy is None):
            continue
        count = given.inputs if given.reader else round(given.inputs * share)
        start = time.monotonic()
        taken, trouble = fuzz(name, given.seed, given.first, count)
        sys.stdout.write(
            f"{name}: {count} inputs, {taken} taken as sound, {time.monotonic() - start:.1f} s\n{trouble}\n"
        )
        failed |= bool(trouble)
    return int(failed)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
