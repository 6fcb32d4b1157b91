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

from damage import claim, claim_one_sentence, damaged, damaged_bytes, odd
from mesh_readers import read_mesh_file
from paradesc.bridge import ParadescError
from paradesc.core import stored
from paradesc.files import cache

try:
    import bpy

    from paradesc_blender.scene import record, unwrap
    from paradesc_blender.show import channels, recolor
    from paradesc_blender.ui import report_panel, result
except ImportError:
    bpy = None

# More than the interpreter, Blender and any input here need.
MOST_MEMORY = 2 << 30
# The folder in which Linux keeps files in memory.
IN_MEMORY = "/dev/shm"


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
    cache.locked_ranges({folder: ""})
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
        lines = [*report_panel.report_lines(found), result.result_sentence(found)] if bpy else []
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
