"""Keeps values of one object, one file for each frame: written whole or not at all, checked before use.

A file is MAGIC, the length of the header (8 bytes), the header, the arrays one after the other, and the SHA-256 of all
before it. Numbers are little-endian. The header is JSON: version, key (of settings and mesh: frames of one key belong
together), frame, input (of the positions that were measured), vertex_count, arrays (name, columns, rows of 32-bit
floats each) and info, which is for readers. There is no index: ranges and lists of frames come from the files that are
there, so caches are merged by copying files. Never imports bpy.
"""

import hashlib
import json
import re
import struct
import time
from collections.abc import Iterable
from contextlib import suppress
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from ..bridge import METHODS, MeshArrays, ParadescError, abi
from ..core import color_maps, job, stored
from ..core.digests import digest
from . import file_names, results

MAGIC = b"PDFRAME\n"
VERSION = 1
SUFFIX = ".pdframe"
DIGEST_BYTES = 32
LARGEST_HEADER = 1 << 22
LARGEST_COUNT = 1 << 31
LAST_FRAME = 1 << 20  # Blender's own limit is 1,048,574
NAME = re.compile(r"[A-Za-z][A-Za-z0-9_.+-]{0,62}")
FILE_NAME = re.compile(r"frame_(-?\d{1,7})" + re.escape(SUFFIX))
# Each frame keeps its distribution at so many evenly spaced ranks; the range over all frames follows from these.
QUANTILES = 257
ENDING = ":quantiles"  # of the names of their arrays
FRAMES = re.compile(r"(-?\d+)(?:[:-](-?\d+))?(?::(\d+))?")
MOST_FRAMES = 1_000_000
RANGE_FILE = "range.json"
# The number of times, and the seconds after which, a file is read again that another machine may still be writing.
METHOD_TRIES, METHOD_WAIT = 20, 0.1
# The folder beside the .blend, if no other is given.
DEFAULT_FOLDER = "paradesc_cache"


@dataclass
class Frame:
    """The content of one file."""

    frame: int
    key: str
    input: str
    values: dict[str, np.ndarray]  # each (vertex_count,) or (vertex_count, 3) float32, NaN where undefined
    info: dict[str, object] = field(default_factory=dict)
    quantiles: dict[str, np.ndarray] = field(default_factory=dict)  # each (QUANTILES,) float32, or (0,) with no value
    counts: dict[str, int] = field(default_factory=dict)  # defined values

    @property
    def vertex_count(self) -> int:
        """The number of vertices of the mesh that the values belong to."""
        return len(next(iter(self.values.values()), ()))

    def other_scene(self, file: str) -> str:
        """The name of the .blend that baked this frame, if it is another than this one."""
        scene = self.info.get("scene", file)
        return scene if isinstance(scene, str) and scene != file else ""


# ---- Names


def frame_path(folder: Path, frame: int) -> Path:
    """The path of a frame's file."""
    return folder / f"frame_{frame:05d}{SUFFIX}"


def object_folder(folder: Path, name: str, others: Iterable[Path] = ()) -> Path:
    """The folder of an object's frames, different from those of other objects in this folder or among the others."""
    there = {path.name for path in others}
    with suppress(OSError):  # it may not be there yet
        there.update(path.name for path in folder.iterdir())
    return folder / file_names.folder_name(name, there)


def frames_in(folder: Path) -> dict[int, Path]:
    """The frame files in a folder, by frame and in order. Their contents are not read."""
    try:
        names = sorted(path.name for path in folder.iterdir())
    except FileNotFoundError:
        return {}
    except OSError as error:
        raise refused(f'The folder "{folder}" cannot be read: {error.strerror or error}.') from error
    matches = [match for match in map(FILE_NAME.fullmatch, names) if match]
    return {frame: folder / name for frame, name in sorted((int(match[1]), match[0]) for match in matches)}


def parse_frames(text: str) -> range:
    """The frames of A:B, A:B:STEP or A, B included; a minus sign may stand for the first colon, as farms write it."""
    found = FRAMES.fullmatch(text.strip())
    need(found, f'"{text}" is not a range of frames; give A:B or A:B:STEP, for example 1:250.')
    return frame_range(int(found[1]), int(found[2] or found[1]), int(found[3] or 1))


def frame_range(first: int, last: int, step: int) -> range:
    """All frames from first to last; raises ValueError if there are none, or far too many."""
    need(step >= 1, "The step between frames must be at least 1.")
    need(last >= first, f"The last frame, {last}, comes before the first, {first}.")
    are_few = max(abs(first), abs(last)) < LAST_FRAME and (last - first) // step < MOST_FRAMES
    need(are_few, f"Frames {first} to {last} are more than Blender has.")
    return range(first, last + 1, step)


# ---- Keys


def key_of(arrays: MeshArrays, settings: job.Settings, method: str, **more: object) -> str:
    """A key of the facts that all frames of one cache share: the mesh without its positions, and the measurement.

    The device is left out, so that machines can share the work; its method, one of METHODS, is included.
    """
    content = settings.as_dict()
    del content["backend"], content["device_index"]
    # Frames that are stored already have this option in their keys, as it always was for them.
    content.update(more, method=method, version=VERSION, seam_error=False)
    text = json.dumps(content, sort_keys=True).encode()
    return digest(
        np.frombuffer(text, np.uint8),
        arrays.corner_vertices,
        arrays.triangle_corners,
        arrays.corner_uvs,
        arrays.triangle_smooth,
        arrays.sharp_edges,
    )


# ---- Writing


def encode(content: Frame) -> bytes:
    """The bytes of a file: the same for the same content."""
    arrays, counts = dict(content.values), {}
    for name, values in content.values.items():
        if values.ndim == 1:
            finite = np.sort(values[np.isfinite(values)])
            ranks = np.round(np.linspace(0, finite.size - 1, QUANTILES if finite.size else 0)).astype(np.int64)
            arrays[name + ENDING], counts[name] = finite[ranks], int(finite.size)
    header = {
        "version": VERSION,
        "key": content.key,
        "frame": content.frame,
        "input": content.input,
        "vertex_count": content.vertex_count,
        "arrays": [[name, 1 if array.ndim == 1 else array.shape[1], len(array)] for name, array in arrays.items()],
        "counts": counts,
        "info": content.info,
    }
    text = json.dumps(header, sort_keys=True, allow_nan=False).encode()
    body = [np.ascontiguousarray(array, "<f4").tobytes() for array in arrays.values()]
    whole = b"".join([MAGIC, struct.pack("<Q", len(text)), text, *body])
    return whole + hashlib.sha256(whole).digest()


def write_frame(folder: Path, content: Frame) -> Path:
    """Writes one file: a reader, or a run that was killed, finds the old one, none, or the whole new one."""
    path = frame_path(folder, content.frame)
    results.make_folder(folder)
    results.write_whole(path, encode(content), Path.write_bytes)
    return path


def sweep(folder: Path) -> None:
    """Removes temporary files of killed runs that are at least a day old."""
    for path in folder.glob(f".frame_*{SUFFIX}.*.part"):
        with suppress(OSError):  # another machine has removed it already
            if path.stat().st_mtime < time.time() - 86400:
                path.unlink()


# ---- Reading


def read_frame(path: Path) -> Frame:
    """Reads and checks the content of a file; raises one sentence if anything is wrong."""
    try:
        return decode(path.read_bytes(), path)
    except FileNotFoundError as error:
        raise refused(f'There is no frame file "{path}".') from error
    except (OSError, MemoryError) as error:
        raise refused(f'The frame file "{path}" cannot be read: {error}.') from error
    except (ValueError, TypeError, KeyError, AttributeError, RecursionError) as error:
        raise refused(f'The frame file "{path}" is damaged ({reason(error)}); bake this frame again.') from error


def decode(content: bytes, path: Path) -> Frame:
    """Turns bytes of encode() into a frame; raises ValueError, TypeError, KeyError or AttributeError for any others."""
    start, end = len(MAGIC) + 8, len(content) - DIGEST_BYTES
    need(start <= end and content.startswith(MAGIC), "it does not begin as one")
    need(hashlib.sha256(content[:end]).digest() == content[end:], "its checksum is wrong")
    (length,) = struct.unpack_from("<Q", content, len(MAGIC))
    need(length <= min(LARGEST_HEADER, end - start), "its header is too long")
    header = json.loads(content[start : start + length])
    check_header(header, path)
    arrays, at = {}, start + length
    for name, columns, rows in header["arrays"]:
        need(4 * columns * rows <= end - at, "it ends too early")
        array = np.frombuffer(content, "<f4", columns * rows, at).astype(np.float32)
        arrays[name] = array if columns == 1 else array.reshape(rows, columns)
        at += 4 * columns * rows
    need(at == end, "it ends too late")
    quantiles = {name.removesuffix(ENDING): arrays.pop(name) for name in list(arrays) if name.endswith(ENDING)}
    return Frame(header["frame"], header["key"], header["input"], arrays, header["info"], quantiles, header["counts"])


def check_header(header: dict[str, Any], path: Path) -> None:
    """Raises if a header is not one of ours, or of another frame than the file's name says."""
    version, frame, count = (header[name] for name in ("version", "frame", "vertex_count"))
    need(type(version) is int and version == VERSION, f"it has version {version}, and this Paradesc reads {VERSION}")
    named = FILE_NAME.fullmatch(path.name)
    need(not named or int(named[1]) == frame, f"it holds frame {frame}")
    is_sound = is_whole(frame, -LAST_FRAME, LAST_FRAME) and is_whole(count, 0, LARGEST_COUNT)
    is_sound &= all(isinstance(header[name], str) and len(header[name]) <= 128 for name in ("key", "input"))
    is_sound &= isinstance(header["info"], dict) and all(is_whole(one, 0, count) for one in header["counts"].values())
    names = [name for name, _, _ in header["arrays"]]
    is_sound &= len(set(names)) == len(names)
    for name, columns, rows in header["arrays"]:
        stem = name.removesuffix(ENDING)
        widest, fewest, most = (4, count, count) if stem == name else (1, 0, QUANTILES)
        is_sound &= NAME.fullmatch(stem) is not None and is_whole(columns, 1, widest) and is_whole(rows, fewest, most)
    need(is_sound, "its header is wrong")


def need(fits: object, fault: str) -> None:
    """Raises the fault unless the content fits."""
    if not fits:
        raise ValueError(fault)


def is_whole(number: object, lowest: int, highest: int) -> bool:
    """Returns whether it is a whole number in this range."""
    return type(number) is int and lowest <= number <= highest


def sound_frame(folder: Path, frame: int) -> Frame | None:
    """The frame, if it exists and is sound."""
    try:
        return read_frame(frame_path(folder, frame))
    except ParadescError:
        return None


# ---- One method for all frames


def settled_method(folder: Path, animation: str, own: str) -> str:
    """The method of an animation's frames, which the first machine that bakes there writes into the folder.

    animation: a key of the frames that does not depend on the method. own: the method of this machine, for the case
    that it is the first.
    """
    path = folder / f"method_{animation[:16]}.json"
    results.make_folder(folder)
    try:
        with path.open("x", encoding="utf-8") as file:  # only one of several machines succeeds
            json.dump({"method": own}, file)
        return own
    except FileExistsError:
        pass
    except OSError as error:
        raise refused(f'The file "{path}" cannot be written: {error.strerror or error}.') from error
    for _ in range(METHOD_TRIES):
        with suppress(OSError, ValueError, TypeError, KeyError):
            method = json.loads(path.read_text(encoding="utf-8"))["method"]
            if method in METHODS.values():
                return method
        time.sleep(METHOD_WAIT)
    raise refused(f'The file "{path}" is damaged; remove it, and bake all frames again.')


# ---- One range over all


def ranges(frames: Iterable[Frame], look: color_maps.Look | None = None) -> dict[str, color_maps.ValueRange]:
    """The range of values to show for each name over all of these frames, of one object or of several."""
    parts: dict[str, list[tuple[np.ndarray, int]]] = {}
    radii: dict[str, float] = {}
    for frame in frames:
        for name, quantiles in frame.quantiles.items():
            parts.setdefault(name, []).append((quantiles, frame.counts.get(name, 0)))
            given = frame.info.get("radius")
            radius = given.get(name) if isinstance(given, dict) else None
            radii[name] = float(radius) if stored.is_number(radius) and 1e-30 < radius < 1e30 else 0.0
    found = {}
    for name in parts:
        with suppress(StopIteration):  # coverage, or values that only a newer version knows
            found[name] = color_maps.value_range(pool(parts[name]), job.registry_row(name), radii[name], look)
    return found


def pool(parts: list[tuple[np.ndarray, int]]) -> np.ndarray:
    """(m,) values distributed as those of all frames, in which frames with more values have more weight."""
    most = max(count for _, count in parts)
    chosen = [np.empty(0, np.float32)]
    for quantiles, count in parts:
        if len(quantiles) and count:
            points = max(1, round(QUANTILES * count / most))
            middle = (np.arange(points) + 0.5) / points * (len(quantiles) - 1)
            chosen.append(quantiles[np.round(middle).astype(np.int64)])
    return np.sort(np.concatenate(chosen))


def read_fixed(folder: Path) -> dict[str, tuple[float, float]]:
    """The ranges that the user fixed for this folder, by name; "" stands for all others."""
    path = folder / RANGE_FILE
    try:
        content = json.loads(path.read_text()) if path.is_file() else {}
        found = {str(name): (float(low), float(high)) for name, (low, high) in content.items()}
        need(all(np.isfinite(pair).all() and pair[0] < pair[1] for pair in found.values()), "a range is empty")
    except (OSError, ValueError, TypeError, AttributeError, OverflowError, RecursionError, MemoryError) as error:
        raise refused(f'The file "{path}" is damaged ({reason(error)}); remove it, or give the range again.') from error
    return found


def write_fixed(folder: Path, fixed: dict[str, tuple[float, float]]) -> None:
    """Fixes ranges for this folder, which replace those that follow from its frames."""
    results.write_whole(folder / RANGE_FILE, (json.dumps(fixed, sort_keys=True) + "\n").encode(), Path.write_bytes)


def locked_ranges(keys: dict[Path, str], look: color_maps.Look | None = None) -> dict[str, color_maps.ValueRange]:
    """One range for each name over all sound frames in folders, each with its own key; "" takes any key."""
    frames = []
    for folder, key in keys.items():
        for path in frames_in(folder).values():
            with suppress(ParadescError):  # a frame that is damaged is baked again by the next run
                frame = read_frame(path)
                if key in ("", frame.key):
                    frames.append(replace(frame, values={}))
    found = ranges(frames, look)
    for folder in keys:
        fixed = read_fixed(folder)
        for name, shown in found.items():
            if name in fixed or "" in fixed:
                low, high = fixed.get(name) or fixed[""]
                found[name] = replace(shown, minimum=low, maximum=high)
    return found


def reason(error: Exception) -> str:
    """The text of an error on one line, as it may quote the file."""
    return " ".join(str(error).split())[:200]


def refused(sentence: str) -> ParadescError:
    """The error for a file or folder that cannot be used."""
    return ParadescError(abi.STATUS_UNKNOWN, sentence)
