"""A mesh file that cannot be read is one sentence that says why; every refusal of the readers is provoked here."""

import base64
import copy
import json
import zlib

import numpy as np
import pytest

from mesh_kinds import (
    FIELD,
    SOUND,
    ball,
    embedded,
    freesurfer,
    gii,
    glb,
    obj,
    off,
    ply,
    sparse,
    stl,
    stl_binary,
    vtk,
    vtp,
)
from paradesc.bridge import InputError, origin
from paradesc.core import polygons
from paradesc.files import (
    gltf_file,
    mesh_files,
    neuro_files,
    obj_file,
    off_file,
    ply_file,
    stl_file,
    text_rows,
    vtk_legacy_file,
    vtp_file,
    wrong_kinds,
)
from refusals import check_all_provoked, failing, refusal

SQUARE = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"
HEAD = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
FACE = "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
POINTS = "0 0 0\n1 0 0\n0 1 0\n"
BIG = HEAD.replace("ascii", "binary_big_endian").encode()


def changed(made, *where, value=None):
    """A .glb whose header has another value at a place, or lacks it."""
    header, content = copy.deepcopy(made[0]), made[1]
    part = header
    for key in where[:-1]:
        part = part[key]
    if value is None:
        del part[where[-1]]
    else:
        part[where[-1]] = value
    return glb(header, content)


def meshopt():
    header, content = ball()
    header["bufferViews"][0]["extensions"] = {"EXT_meshopt_compression": {}}
    return glb(header, content)


def draco():
    header, content = ball()
    header["meshes"][0]["primitives"][0]["extensions"] = {"KHR_draco_mesh_compression": {}}
    del header["accessors"][0]["bufferView"]
    return glb(header, content)


def with_uri(uri):
    header, _ = ball()
    header["buffers"][0]["uri"] = uri
    return json.dumps(header).encode()


def changed_text(content, before, after):
    assert before in content
    return content.replace(before, after, 1)


def packed_vtp(size, last, block):
    """Points that lie in one block of so many bytes as the header says; None: what no one packed."""
    packed = b"\0\0\0" if block is None else zlib.compress(block)
    head = np.array([1, size, last, len(packed)], "<u4").tobytes()
    text = "".join(base64.b64encode(part).decode() for part in (head, packed))
    made = PIECE.format(ARRAY.format("binary", "", text), "")
    return made.replace('type="PolyData"', 'type="PolyData" compressor="vtkZLibDataCompressor"')


OBJ = [
    ("v 0 0\nf 1 1 1\n", 'line 1, "v 0 0", has fewer than 3 numbers'),
    ("# x\nv 0,5 0 1\nf 1 1 1\n", 'line 2, "v 0,5 0 1", is not a row of numbers; decimals take a point'),
    ("v 0 0 1\nv 0 0 x\nf 1 1 1\n", 'line 2, "v 0 0 x", is not a row of numbers.'),
    (SQUARE + "f 1 2 9\n", 'line 5, "f 1 2 9", names vertex 9, and there are 4, counted from 1'),
    (SQUARE + "f 1 2 3\nf 0 1 \\\n 2\n", 'line 6, "f 0 1 2", names vertex 0, and there are 4'),
    (SQUARE + "\\\nf 1 2 3\nf 1 2 -9\n", 'line 7, "f 1 2 -9", names vertex -9, and there are 4'),
    (SQUARE + "f one two three\n", 'line 5, "f one two three", is not a face'),
    (SQUARE + "f 1/1/1/1 2 3\n", "is not a face"),
    (SQUARE + "f 1 2 3-4\n", "is not a face"),
    (SQUARE, "has no faces"),
    (SQUARE + "v nan 0 0\nf 1 2 3\n", "Vertex 4 is at (nan, 0, 0); positions have to be finite numbers"),
    (SQUARE + "v -1.#IND 0 0\nf 1 2 5\n", "Vertex 4 is at (nan, 0, 0)"),
    (SQUARE + "v 1.#INF 1e39 0\nf 1 2 5\n", "Vertex 4 is at (inf, inf, 0)"),
]
PLY = [
    ("nothing", "does not begin as one"),
    ("plywood\n", "does not begin as one"),
    ("ply\nformat ascii 1.0\n", "header does not end"),
    ("ply\nformat ascii 1.0\nelement vertex x\nend_header\n", 'has the line "element vertex x"'),
    ("ply\nformat ascii 1.0\nelement vertex 1\nproperty half x\nend_header\n", 'has the line "property half x"'),
    ("ply\nformat ascii 1.0\nelement vertex -1\nend_header\n", "negative number of rows"),
    (HEAD.replace("format ascii 1.0\n", "") + FACE + POINTS + "3 0 1 2\n", "does not say its format"),
    (HEAD + FACE + POINTS + "3 0 1 9\n", "a face has vertex 9, counted from 0, and there are 3"),
    (HEAD + FACE + POINTS + "3 0 1 -1\n", "a face has vertex -1, counted from 0, and there are 3"),
    (HEAD + FACE + POINTS + "3 0 1 0.5\n", "a face has a vertex that is not a whole number"),
    (HEAD + FACE + POINTS + "3 0 1\n", 'the row "3 0 1" has too few numbers'),
    (HEAD + FACE + POINTS + "-3 0 1 2\n", 'the row "-3 0 1 2" has too few numbers'),
    (HEAD + FACE + "0 0 0\n1 0 0\n0 1 x\n3 0 1 2\n", '"0 1 x" is not a row of numbers'),
    (HEAD + FACE + "0,5 0 0\n1 0 0\n0 1 0\n3 0 1 2\n", '"0,5 0 0" is not a row of numbers; decimals take a point'),
    (HEAD + FACE + "0 0 0\n1 0 0\n", "ends too early"),
    (HEAD + FACE.replace("vertex_indices", "points") + POINTS + "3 0 1 2\n", "have no list of vertices"),
    (HEAD.replace("float x", "float X") + FACE + POINTS + "3 0 1 2\n", "its vertices have no property x"),
    (HEAD.replace("float z", "list uchar float z") + FACE + "0 0 1 0\n" * 3 + "3 0 1 2\n", "have no property z"),
    (HEAD + FACE + "0 0 nan\n1 0 0\n0 1 0\n3 0 1 2\n", "Vertex 0 is at (0, 0, nan)"),
    (BIG + FACE.encode() + bytes(20), "ends too early"),
    (BIG + FACE.encode() + bytes(36), "ends too early"),
    (BIG + FACE.encode() + bytes(36) + b"\3" + bytes(8), "ends too early"),
    (BIG + FACE.encode().replace(b"face 1", b"face 2") + bytes(36) + b"\3" + bytes(12) + b"\4", "ends too early"),
    (BIG + FACE.encode().replace(b"uchar", b"int") + bytes(36) + b"\xff" * 4, "a list in it is longer than the file"),
    (BIG + FACE.encode().replace(b"end_h", b"property list uchar int more\nend_h") + bytes(36) + b"\3" + bytes(9),
     "ends too early"),
    (ply("binary_little_endian")[:-9], "ends too early"),
    (HEAD + FACE.replace("face 1", "face 0") + POINTS, "has no faces"),
]  # fmt: skip
OFF = [
    ("OFF\n", "does not begin with the numbers"),
    ("OFF\n3.5 1 0\n", "does not begin with the numbers"),
    ("OFF\n-3 1 0\n", "does not begin with the numbers"),
    ("OFF\nx y z\n", '"x y z" is not a row of numbers'),
    ("4OFF\n1 1 0\n", "4OFF has vertices in another space than three dimensions"),
    ("nOFF\n4\n1 1 0\n", "nOFF has vertices in another space"),
    ("OFF BINARY\n\1", "binary OFF, which this reader does not know; save it as text"),
    ("OFF\n3 1 0\n0 0 0\n", "promises 3 vertices and 1 faces, and holds too few numbers"),
    ("COFF\n3 1 0\n0 0\n0 1\n0 0\n 0 1 0\n 3 0 1 2", "it ends before its 3 vertices"),
    ("OFF\n3 3 0\n" + POINTS + "3 0 1 2\n3 0 2 1\n", "it promises 3 faces, and ends after 2"),
    ("OFF\n3 1 0\n" + POINTS + "3 0 1 2\n3 0 2 1\n", "more follows the 1 faces that it promises"),
    ("OFF\n3 1 0\n" + POINTS + "3 0 1 3\n", "a face has vertex 3, counted from 0, and there are 3"),
    ("OFF\n3 1 0\n" + POINTS + "3 -1 1 2\n", "a face has vertex -1, counted from 0, and there are 3"),
    ("OFF\n3 1 0\n" + POINTS + "3 0 1 1.5\n", "a face has a vertex that is not a whole number"),
    ("OFF\n3 0 0\n" + POINTS, "has no faces"),
]
STL = [
    (b"x" * 80, "neither text nor long enough to be binary"),
    (stl_binary(count=433), "promises 433 triangles and holds 432; it was cut off, or damaged"),
    (stl_binary(count=100), "promises 100 triangles and holds 432; it was cut off, or damaged"),
    (stl_binary()[:-20], "promises 432 triangles and holds 431; it was cut off"),
    ("solid x\nfacet", "its 1 facets have 0 corners, and not three each; it was cut off, or damaged"),
    (stl().replace(b"vertex", b"vertex x", 1), "corners, and not three each|not a row of numbers"),
    (stl().replace(b"vertex ", b"vertex a", 1), 'the corner "a'),
    (stl()[:-60], "corners, and not three each|not a row of numbers"),
    ("solid x\nendsolid x\n", "has no faces"),
]
GLTF = [
    (".glb", "glTF" + "\0" * 40, "it is glTF 0, and this reader knows 2.0; convert it"),
    (".glb", "glTF", "does not begin as one, or was cut off"),
    (".glb", "nonsense", "does not begin as one"),
    (".glb", SOUND[".glb", "plain"][:200], "was cut off"),
    (".glb", SOUND[".glb", "plain"][:-2000], "bytes; it was cut off"),
    (".glb", changed(ball(), "asset", "version", value="1.0"), "it is glTF 1.0, and this reader knows 2.0"),
    (".glb", glb(*ball(extensionsRequired=["KHR_draco_mesh_compression"])), "KHR_draco_mesh_compression; export it "),
    (".glb", glb(*ball(extensionsRequired=["X_y"])), "needs the extensions X_y; export it without them, or"),
    (".glb", meshopt(), "compressed (EXT_meshopt_compression); export it without compression"),
    (".glb", draco(), "compressed (KHR_draco_mesh_compression); export it without compression"),
    (".glb", changed(ball(), "meshes", 0, "primitives", 0, "attributes", value={}), "of mesh 0 has no positions"),
    (".glb", changed(ball(), "bufferViews", 0, "byteLength", value=9), "reaches beyond its buffer view 0"),
    (".glb", changed(ball(), "accessors", 0, "count", value=-1), "reaches beyond its buffer view 0"),
    (".glb", changed(ball(), "accessors", 0, "type", value="VEC2"), "positions have not three coordinates"),
    (".glb", changed(ball(), "accessors", 0, "count", value=7), "a face has vertex 217, counted from 0, and"),
    (".glb", glb(*ball("i1")), "a face has vertex -128, counted from 0, and there are 218"),
    (".glb", changed(ball(), "accessors", 0, "count"), "its header is damaged (KeyError: 'count')"),
    (".glb", changed(ball(), "nodes", value=[{"children": [0], "mesh": 0}]), "node 0 is below itself"),
    (".glb", changed(sparse(), "accessors", 0, "count", value=2), "replaces rows that are not there"),
    (".glb", changed(sparse(), "accessors", 0, value={
        "componentType": 5126, "type": "VEC3", "count": 1 << 40, "sparse": {},
    }), "has 1,099,511,627,776 rows"),
    (".glb", changed(ball(), "meshes", 0, "primitives", 0, "mode", value=1), "has no faces"),
    (".gltf", "{", "its header is not JSON"),
    (".gltf", "[1]", "its header is not a JSON object"),
    (".gltf", "{}", "has no faces"),
    (".gltf", with_uri("gone.bin"), 'its buffer "gone.bin" is not beside it; keep both in one folder'),
    (".gltf", with_uri("a\0b"), "is not beside it"),
    (".gltf", with_uri("https://example.org/a.bin"), 'its buffer "https://example.org/a.bin" is not beside it'),
    (".gltf", with_uri("file:///mesh/a.bin"), 'its buffer "file:///mesh/a.bin" is not beside it; keep both'),
    (".gltf", with_uri("data:a;base64,A"), "a buffer in it is damaged"),
    (".gltf", embedded(*ball()).replace(b"data:application/octet-stream;base64,", b"data:,"), "a face has vertex"),
]  # fmt: skip
VTK = [
    (b"# vtk", "does not begin as a file of VTK's legacy format"),
    (changed_text(vtk(), b"218 float", b"218 quad"), 'numbers of the type "quad"'),
    (changed_text(vtk(), b"218 float", b"219 float"), "it promises 657 numbers where it has others"),
    (changed_text(vtk(), b"218 float", b"x float"), 'it has "x" where a number of points or polygons should be'),
    (changed_text(vtk(), b" 218 float", b""), 'its line "POINTS" is not complete'),
    (changed_text(vtk(), b"POINTS", b"PLACES"), 'it has "PLACES 218 float" where points or polygons should begin'),
    (changed_text(vtk(), b"POLYDATA", b"UNSTRUCTURED_GRID"), "it holds a UNSTRUCTURED_GRID, and no surface (POLYDATA)"),
    (changed_text(vtk(), b"432 1728", b"431 1728"), "it promises 431 polygons and has another number"),
    (changed_text(vtk(), b"432 1728", b"-1 1728"), 'it has "-1" where a number'),
    (vtk("BINARY")[:1000], "it promises 654 numbers and ends before them; it was cut off"),
    (changed_text(vtk(before=FIELD), b"FieldData 2", b"FieldData 9"), "is not complete"),
    (b"# vtk DataFile Version 3.0\nx\nASCII\nDATASET POLYDATA\nFIELD a 1\n", "it ends within a field"),
    (changed_text(vtk(version="5.1"), b"CONNECTIVITY", b"NORMALS"), "its polygons have no CONNECTIVITY"),
    (changed_text(vtk(version="5.1"), b"1293", b"1233"), "its polygons do not follow each other"),
    (vtk().split(b"POLYGONS")[0], "has no faces"),
]
PIECE = '<?xml version="1.0"?><VTKFile type="PolyData"><PolyData><Piece>{}</Piece></PolyData>{}</VTKFile>'
ARRAY = '<Points><DataArray type="Float32" format="{}" {}>{}</DataArray></Points>'
VTP = [
    ("<VTKFile>", "its XML is damaged or cut off"),
    ('<VTKFile type="UnstructuredGrid"/>', "it holds UnstructuredGrid, and no surface (PolyData)"),
    ("<html/>", "it is a web page"),
    ("<a/>", "it holds a, and no surface"),
    (PIECE.format("", ""), "has no faces"),
    (PIECE.format(ARRAY.format("ascii", "", "0 0 0"), ""), "has no faces"),
    (PIECE.format(ARRAY.format("ascii", "", "0 0"), ""), "its points are no rows of three numbers"),
    (PIECE.format(ARRAY.format("ascii", "", "0 0 a"), ""), "holds other things than numbers"),
    (PIECE.format(ARRAY.format("tape", "", ""), ""), 'it has an array of the format "tape"'),
    (PIECE.format(ARRAY.format("binary", "", ""), ""), "it ends within an array; it was cut off"),
    (PIECE.format(ARRAY.format("binary", "", "!!!!!!!!"), ""), "an array of it is not base64"),
    (PIECE.format(ARRAY.format("appended", "", ""), ""), 'it has "None" where a number of bytes should be'),
    (PIECE.format(ARRAY.format("appended", 'offset="0"', ""), ""), "an array of it lies behind its end"),
    (PIECE.format("", '<AppendedData encoding="raw">'), "its appended arrays do not begin"),
    (changed_text(vtp(), b"Float32", b"String"), 'it has an array of the type "String"'),
    (changed_text(vtp(), b"ZLib", b"LZ4"), "its arrays are packed by vtkLZ4DataCompressor"),
    (vtp("appended", raw=True)[:3000], "an array of it lies behind its end"),
    (packed_vtp(1000, 0, b"x" * 500), "what is packed in it is not as long as it promises"),
    (packed_vtp(1 << 30, 0, b"x"), "it promises more than what is packed in it can be"),
    (packed_vtp(9, 0, None), "it is damaged"),
]
NEURO = [
    (".gii", "<GIFTI", "nibabel finds it damaged"),
    (".gii", changed_text(gii(), b"FLOAT32", b"FLOAT99"), "nibabel finds it damaged"),
    (".gii", gii(codes=("NIFTI_INTENT_SHAPE", "NIFTI_INTENT_TRIANGLE")), "it holds no triangles of points, but values"),
    (".white", freesurfer()[:3000], "nibabel finds it damaged"),
    (".white", b"\xff\xff\xff" + bytes(12 + 4 * 100), "it holds no triangles of points, but values"),
    (".white", b"x", "nibabel finds it damaged"),
]
OTHERS = [
    (".obj", "", "it is empty"),
    (".ply", "version https://git-lfs.github.com/spec/v1\noid sha256:aa\n", "it is a pointer of Git LFS"),
    (".glb", "\n <!DOCTYPE html><html>", "it is a web page, and not the file itself"),
    (".obj", b"\x1f\x8b\x08\0", "it is compressed by gzip; unpack it first"),
    (".stl", b"PK\x03\x04", "it is a .zip; unpack it first"),
    (".obj", SQUARE.encode("utf-16"), "it is text in UTF-16; save it as UTF-8"),
    (".off", "OFF\n".encode("utf-16-be"), "it is text in UTF-16; save it as UTF-8"),
    (".obj", "P 0.3 0.3 0.4 10 1 4\n", "it is a surface of the MNI tools"),
    (".obj", ply(), "it begins as a .ply; rename it"),
    (".ply", off(), "it begins as a .off; rename it"),
    (".obj", b"v 0 0 0\0\0", "it is not text, which files of this kind are"),
    (".txt", "", "is none of .obj"),
]
ALL = [
    *((".obj", *row) for row in OBJ), *((".ply", *row) for row in PLY), *((".off", *row) for row in OFF),
    *((".stl", *row) for row in STL), *((".vtk", *row) for row in VTK), *((".vtp", *row) for row in VTP), *GLTF,
    *NEURO, *OTHERS,
]  # fmt: skip


@pytest.mark.parametrize(("suffix", "content", "sentence"), ALL, ids=[f"{row[0]} {row[2]}" for row in ALL])
def test_what_cannot_be_read_is_one_sentence_that_says_why(tmp_path, suffix, content, sentence):
    said = refusal(mesh_files.read, tmp_path / f"a{suffix}", content)
    assert any(words in said for words in sentence.split("|")), said


@pytest.mark.parametrize("name", ["a.obj", "x" * 300 + ".ply", "a\0.obj"])
def test_a_file_that_is_not_there_or_cannot_be_is_one_sentence(tmp_path, name):
    with pytest.raises(InputError, match="There is no file"):
        mesh_files.read(tmp_path / name)


def test_a_file_that_cannot_be_opened_or_needs_more_memory_than_there_is_is_one_sentence(tmp_path, monkeypatch):
    path = tmp_path / "a.obj"
    path.write_bytes(obj())
    failures = [
        (OSError(5, "Input/output error"), "cannot be read: Input/output error."),
        (MemoryError(), "not enough memory"),
        (ValueError(), "cannot be read: ValueError."),
    ]
    for error, sentence in failures:
        monkeypatch.setitem(mesh_files.READERS, ".obj", failing(error))
        with pytest.raises(InputError, match=sentence):
            mesh_files.read(path)


def test_files_of_brains_say_what_to_install_where_nibabel_is_missing(tmp_path, monkeypatch):
    monkeypatch.setattr(neuro_files.importlib.util, "find_spec", lambda name: None)
    sentence = refusal(mesh_files.read, tmp_path / "a.gii", gii())
    assert sentence.endswith("it needs nibabel, which is not installed; pip install paradesc[neuro].")


def test_what_reaches_too_far_for_the_library_is_one_sentence():
    with pytest.raises(InputError, match="reaches 1e\\+40 far, which is more than 32-bit floats hold"):
        origin.near_origin(np.array([[-1e40, 0, 0], [1e40, 0, 0]]))


READERS = (
    gltf_file, mesh_files, neuro_files, obj_file, off_file, ply_file, polygons, stl_file, text_rows, vtk_legacy_file,
    vtp_file, wrong_kinds,
)  # fmt: skip


def test_every_refusal_of_the_readers_is_provoked_above(tmp_path, monkeypatch):
    def provoke():
        for suffix, content, _ in ALL:
            refusal(mesh_files.read, tmp_path / f"a{suffix}", content)
        test_a_file_that_is_not_there_or_cannot_be_is_one_sentence(tmp_path, "b.obj")
        with monkeypatch.context() as patched:
            test_files_of_brains_say_what_to_install_where_nibabel_is_missing(tmp_path, patched)
        test_a_file_that_cannot_be_opened_or_needs_more_memory_than_there_is_is_one_sentence(tmp_path, monkeypatch)

    check_all_provoked(READERS, provoke)
