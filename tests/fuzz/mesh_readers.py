"""Fuzzes the readers of mesh files of every kind, for readers.py."""

import json
import random
import struct
import sys
from pathlib import Path

import numpy as np

sys.path.append(str(Path(__file__).resolve().parents[1] / "addon"))

from damage import claim, claim_one_sentence, damaged, damaged_bytes
from mesh_kinds import SOUND
from paradesc.bridge import InputError
from paradesc.files import mesh_files

# Numbers, words and lines of text are changed into these.
ODD_WORDS = (
    b"0", b"-1", b"1", b"4294967295", b"99999999999999999999", b"1e400", b"nan", b"-inf", b"1.#IND", b"1,5", b"x", b"",
    b"//", b"1/", b"#", b"\\\n", b"\r", b"\0", b"\xef\xbb\xbf", b"\xff", b"end_header", b"f", b"v", b"o", b"solid",
    b"element face 1000000000000", b"property list double double vertex_indices", b"OFF",
)  # fmt: skip


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
