"""A small sphere as the bytes of a mesh file of every kind, as programs write them, for the tests and the fuzzer."""

import base64
import json
import struct
import zlib

import numpy as np

from shapes import RADIUS, cube_sphere

STEPS = 6


def sphere(steps=STEPS):
    """Positions (n, 3) and triangles (m, 3)."""
    points, quads, _ = cube_sphere(steps)
    return np.round(points, 6), np.concatenate([quads[:, :3], quads[:, [0, 2, 3]]])


def rows(array, form="{:.9g}"):
    return "".join(" ".join(form.format(value) for value in row) + "\n" for row in array)


# ---- OBJ


def obj(first="", more="", end="\n", corner="{0}"):
    points, triangles = sphere()
    faces = "".join("f " + " ".join(corner.format(vertex + 1) for vertex in face) + "\n" for face in triangles)
    lines = first + "".join(f"v {line}\n" for line in rows(points).splitlines()) + more + faces
    return lines.replace("\n", end).encode()


OBJ = {
    "plain": obj(),
    "mark": b"\xef\xbb\xbf" + obj(),
    "mac": obj(end="\r"),
    "windows": obj(end="\r\n"),
    "named": obj("o Part#3\n"),
    "paths": obj("# D:\\models\\\n", more="#D:\\\n"),
    "normals that are not there": obj(corner="{0}//{0}"),
    "texture vertices that are not there": obj(corner="{0}/{0}/{0}"),
    "one coordinate": obj(more="vt 0.5\n", corner="{0}/1"),
    "no numbers": obj(more="vt -1.#IND nan(ind)\nvn 0 1\n", corner="{0}/1/1"),
    "corners of all forms": obj(more="vt 0 0\nvn 0 0 1\n") + b"f 1/1 2 3//1\nf 1 2/1/1 3/1\n",
}

# ---- PLY


def ply(order="ascii", end="\n", before="", lists="vertex_indices", tail="", surface=None, kind="float"):
    points, triangles = surface or sphere()
    header = f"ply\nformat {order} 1.0\n{before}element vertex {len(points)}\n"
    header += "".join(f"property {kind} {name}\n" for name in "xyz") + f"element face {len(triangles)}\n"
    header = (header + f"property list uchar int {lists}\nend_header\n").replace("\n", end).encode()
    if order == "ascii":
        body = rows(points) + "".join(f"3 {line}{tail}\n" for line in rows(triangles, "{}").splitlines())
        return header + body.replace("\n", end).encode()
    bytes_order = "<" if "little" in order else ">"
    faces = np.empty(len(triangles), [("n", "u1"), ("v", bytes_order + "i4", 3)])
    faces["n"], faces["v"] = 3, triangles
    return header + points.astype(bytes_order + {"float": "f4", "double": "f8"}[kind]).tobytes() + faces.tobytes()


def ply_strips():
    points, triangles = sphere()
    strip = np.column_stack([triangles, np.full(len(triangles), -1)]).reshape(-1)
    header = f"ply\nformat ascii 1.0\nelement vertex {len(points)}\nproperty float x\nproperty float y\n"
    header += "property float z\nelement tristrips 1\nproperty list int int vertex_indices\nend_header\n"
    return (header + rows(points) + f"{len(strip)} " + " ".join(map(str, strip)) + "\n").encode()


PLY = {
    "text": ply(),
    "little": ply("binary_little_endian"),
    "big": ply("binary_big_endian"),
    "mac": ply(end="\r"),
    "windows": ply(end="\r\n"),
    "mac header": ply("binary_little_endian", end="\r"),
    "mark": b"\xef\xbb\xbf" + ply(),
    "comments": ply(before="comment\n\nobj_info x 1\n").replace(b"end_header\n", b"end_header\ncomment here\n"),
    "more in a row": ply(tail=" 255 0 0"),
    "indexes": ply(lists="vertex_indexes"),
    "strips": ply_strips(),
    "one line": ply().split(b"end_header\n")[0] + b"end_header\n" + b" ".join(ply().split(b"end_header\n")[1].split()),
}

# ---- OFF


def off(word="OFF\n", vertex="", face="", end="\n", surface=None, number="{:.9g}"):
    points, triangles = surface or sphere()
    text = f"{word}{len(points)} {len(triangles)} 0\n"
    text += "".join(f"{line}{vertex}\n" for line in rows(points, number).splitlines())
    text += "".join(f"3 {line}{face}\n" for line in rows(triangles, "{}").splitlines())
    return text.replace("\n", end).encode()


def off_in_words():
    points, triangles = sphere()
    words = " ".join(f"{value:.9g}" for value in points.reshape(-1))
    faces = "".join(f"3\n{a} {b}\n{c}\n" for a, b, c in triangles)
    return f"OFF\n{len(points)} {len(triangles)} 0\n{words}\n{faces}".encode()


def off_over_lines():
    points, triangles = sphere()
    faces = "".join(f"3 {a}\n{b} {c} 255 0 0\n" for a, b, c in triangles)
    return f"OFF\n{len(points)} {len(triangles)} 0\n{rows(points)}{faces}".encode()


OFF = {
    "plain": off(),
    "lower": off("off\n"),
    "no keyword": off(""),
    "at once": off("OFF"),
    "mark": b"\xef\xbb\xbf" + off(),
    "colors": off("COFF\n", " 255 0 0 255"),
    "colors unsaid": off("OFF\n", " 0.5 0.5 0.5"),
    "normals": off("NOFF\n", " 0 0 1"),
    "texture": off("STOFF\n", " 0.1 0.2"),
    "face colors": off(face=" 0.5 0.2 0.1"),
    "comments": off("OFF # made by hand\n#\n\n"),
    "mac": off(end="\r"),
    "words": off_in_words(),
    "colors over lines": off_over_lines(),
    "all in one line": off(end=" "),
}

# ---- STL


def stl(name="x", end="\n", ending=True, surface=None, number="{:.9g}"):
    points, triangles = surface or sphere()
    text = f"solid {name}\n"
    for triangle in points[triangles]:
        corners = "".join(f"vertex {line}\n" for line in rows(triangle, number).splitlines())
        text += f"facet normal 0 0 0\nouter loop\n{corners}endloop\nendfacet\n"
    return (text + (f"endsolid {name}\n" if ending else "")).replace("\n", end).encode("latin-1")


def stl_binary(header=b"", count=None, tail=b""):
    points, triangles = sphere()
    corners = np.empty(len(triangles), [("n", "<f4", 3), ("v", "<f4", (3, 3)), ("a", "<u2")])
    corners["n"], corners["v"], corners["a"] = 0, points[triangles], 0
    count = len(triangles) if count is None else count
    return header.ljust(80, b" ")[:80] + struct.pack("<I", count) + corners.tobytes() + tail


STL = {
    "binary": stl_binary(),
    "binary that begins as text": stl_binary(b"solid exported"),
    "binary with a tail": stl_binary(tail=b"made by a scanner"),
    "binary that begins as text with a tail": stl_binary(b"solid exported", tail=b"made by a scanner"),
    "binary with zeros": stl_binary(tail=bytes(100)),
    "text": stl(),
    "mark": b"\xef\xbb\xbf" + stl(),
    "mac": stl(end="\r"),
    "windows": stl(end="\r\n"),
    "one line": stl(end=" "),
    "latin name": stl("Gehäuse"),
    "name of words": stl("facet vertex 1 2 3 facet"),
    "no end": stl(ending=False),
    "upper": stl().upper(),
    "end of two words": stl().replace(b"endfacet", b"end facet"),
}

# ---- glTF

KINDS = {"f4": 5126, "u1": 5121, "u2": 5123, "u4": 5125, "i2": 5122, "i1": 5120}


def gltf(primitives, arrays, nodes=None, **more):
    """The header and the buffer of a file whose accessors are these arrays; a dict in their place is one itself."""
    header = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": nodes or [{"mesh": 0}],
              "meshes": [{"name": "ball", "primitives": primitives}], "accessors": [], "bufferViews": []}  # fmt: skip
    content = b""
    for array in arrays:
        row = array if isinstance(array, dict) else {}
        array = row.pop("array") if row else array
        content += bytes(-len(content) % 4)
        header["bufferViews"].append({"buffer": 0, "byteOffset": len(content), "byteLength": array.nbytes})
        row.setdefault("bufferView", len(header["bufferViews"]) - 1)
        if row["bufferView"] is None:
            del row["bufferView"]
        kind = "SCALAR" if array.ndim == 1 else f"VEC{array.shape[1]}"
        code = KINDS[array.dtype.str[1:]]
        header["accessors"].append({"componentType": code, "count": len(array), "type": kind, **row})
        content += array.tobytes()
    header["buffers"] = [{"byteLength": len(content)}]
    header.update(more)
    return header, content


def glb(header, content):
    text = json.dumps(header).encode()
    text += b" " * (-len(text) % 4)
    content += bytes(-len(content) % 4)
    chunks = struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(content), b"BIN\0") + content
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


def embedded(header, content):
    address = "data:application/octet-stream;base64," + base64.b64encode(content).decode()
    return json.dumps({**header, "buffers": [{**header["buffers"][0], "uri": address}]}).encode()


def ball(indices="u2", surface=None, **more):
    points, triangles = surface or sphere()
    arrays = [points.astype("<f4"), triangles.reshape(-1).astype("<" + indices)]
    return gltf([{"attributes": {"POSITION": 0}, "indices": 1}], arrays, **more)


def fans_and_strips():
    """Each pair of triangles as a strip, a fan or two triangles, of one table of positions."""
    points, _ = sphere()
    _, quads, _ = cube_sphere(STEPS)
    third = len(quads) // 3
    a, b, c, d = quads.T
    strips = np.column_stack([a, b, d, c, np.full(len(quads), 65535)])[:third].reshape(-1)
    rest = np.concatenate([quads[third:][:, [0, 1, 2]], quads[third:][:, [0, 2, 3]]])
    fans = [[a[0], b[0], c[0], d[0]]]
    strips = strips[5:]  # the first quad is the fan
    arrays = [points.astype("<f4"), *(np.array(each, "<u2").reshape(-1) for each in (strips, fans, rest))]
    modes = ((1, 5), (2, 6), (3, 4))
    return gltf([{"attributes": {"POSITION": 0}, "indices": at, "mode": mode} for at, mode in modes], arrays)


def quantised():
    points, triangles = sphere()
    whole = np.round(points / RADIUS * 32767).astype("<i2")
    arrays = [{"array": whole, "normalized": True}, triangles.reshape(-1).astype("<u4")]
    node = [{"mesh": 0, "name": "ball", "scale": [RADIUS] * 3}]
    used = {"extensionsUsed": ["KHR_mesh_quantization"], "extensionsRequired": ["KHR_mesh_quantization"]}
    return gltf([{"attributes": {"POSITION": 0}, "indices": 1}], arrays, node, **used)


def sparse():
    """Positions of which every other one is at the origin, but for the sparse rows that replace it."""
    points, triangles = sphere()
    places = np.arange(0, len(points), 2)
    wrong = points.copy()
    wrong[places] = 0
    arrays = [
        wrong.astype("<f4"),
        triangles.reshape(-1).astype("<u2"),
        places.astype("<u2"),
        points[places].astype("<f4"),
    ]
    header, content = gltf([{"attributes": {"POSITION": 0}, "indices": 1}], arrays)
    at = {"bufferView": 2, "componentType": 5123}
    header["accessors"][0]["sparse"] = {"count": len(places), "indices": at, "values": {"bufferView": 3}}
    return header, content


def zeros():
    """Texture coordinates that are an accessor without a buffer view, which stands for zeros."""
    header, content = ball()
    header["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"] = len(header["accessors"])
    header["accessors"].append({**header["accessors"][0], "type": "VEC2"})
    del header["accessors"][-1]["bufferView"]
    return header, content


def without(names):
    header, content = ball()
    return {key: value for key, value in header.items() if key not in names}, content


GLB = {
    "plain": glb(*ball()),
    "long indices": glb(*ball("u4")),
    "strips and fans": glb(*fans_and_strips()),
    "quantised": glb(*quantised()),
    "sparse": glb(*sparse()),
    "zeros": glb(*zeros()),
    "no scenes": glb(*without(("scene", "scenes"))),
    "no nodes": glb(*without(("scene", "scenes", "nodes"))),
    "nodes are hidden": glb(*ball(extensionsRequired=["KHR_node_visibility", "VRMC_vrm"])),
}
GLTF = {"embedded": embedded(*ball()), "mark": b"\xef\xbb\xbf" + embedded(*ball())}

# ---- VTK, legacy and XML


def vtk(kind="ASCII", version="3.0", end="\n", before="", after="", strips=False):
    points, triangles = sphere()
    count, binary = len(triangles), kind == "BINARY"
    text = f"# vtk DataFile Version {version}\na ball\n{kind}\nDATASET POLYDATA\n{before}".replace("\n", end).encode()

    def table(words, array, number):
        body = array.astype(">" + number).tobytes() if binary else rows(array, "{:.9g}").replace("\n", end).encode()
        return f"{words}{end}".encode() + body + end.encode()

    text += table(f"POINTS {len(points)} float", points, "f4")
    if version == "5.1":
        text += f"POLYGONS {count + 1} {3 * count}{end}".encode()
        text += table("OFFSETS vtktypeint64", np.arange(0, 3 * count + 1, 3)[:, None], "i8")
        text += table("CONNECTIVITY vtktypeint64", triangles, "i8")
    else:
        faces = np.column_stack([np.full(count, 3), triangles])
        text += table(f"{'TRIANGLE_STRIPS' if strips else 'POLYGONS'} {count} {4 * count}", faces, "i4")
    return text + after.replace("\n", end).encode()


VALUES = "CELL_DATA 432\nSCALARS a float 1\nLOOKUP_TABLE default\n" + "nan\n" * 432
FIELD = "FIELD FieldData 2\nTimeValue 1 1 double\n0.5\nMETADATA\nINFORMATION 0\n\nSteps 1 2 int\n1 2\n"
VTK = {
    "text": vtk(),
    "binary": vtk("BINARY"),
    "text since 5": vtk(version="5.1", after="METADATA\nINFORMATION 0\n\n" + VALUES),
    "binary since 5": vtk("BINARY", "5.1"),
    "windows": vtk(end="\r\n"),
    "field": vtk(before=FIELD),
    "strips": vtk("BINARY", strips=True),
    "lines and values": vtk(before="VERTICES 2 4\n1 0\n1 1\nLINES 1 3\n2 0 1\n", after=VALUES),
}


def vtp(way="binary", packed=True, head="UInt32", order="<", pieces=1, raw=False):
    """way: of the arrays. raw: what is appended is not base64."""
    points, triangles = sphere()
    behind = b""

    def array(name, values, kind, components=1):
        nonlocal behind
        start = f'<DataArray type="{kind}" Name="{name}" NumberOfComponents="{components}" format="{way}"'.encode()
        if way == "ascii":
            return start + b">" + " ".join(f"{value:.9g}" for value in values.reshape(-1)).encode() + b"</DataArray>"
        number = {"Float32": "f4", "Int64": "i8"}[kind]
        content = block(values.astype(order + number).tobytes())
        if way == "binary":
            return start + b">" + content + b"</DataArray>"
        behind, at = behind + content, len(behind)
        return start + f' offset="{at}"/>'.encode()

    def block(content):
        sizes = {"UInt32": "u4", "UInt64": "u8"}[head]
        if not packed:
            whole = np.array(len(content), order + sizes).tobytes() + content
            return whole if raw else base64.b64encode(whole)
        parts = [zlib.compress(content[at : at + 1000]) for at in range(0, len(content), 1000)]
        numbers = [len(parts), 1000, len(content) % 1000, *map(len, parts)]
        both = np.array(numbers, order + sizes).tobytes(), b"".join(parts)
        return b"".join(both if raw else map(base64.b64encode, both))

    text = b""
    for part in np.array_split(triangles, pieces):
        text += f'<Piece NumberOfPoints="{len(points)}" NumberOfPolys="{len(part)}"><PointData/>'.encode()
        text += b"<Points>" + array("Points", points, "Float32", 3) + b"</Points><Verts/><Polys>"
        text += array("connectivity", part, "Int64") + array("offsets", 3 * np.arange(1, len(part) + 1), "Int64")
        text += b"</Polys></Piece>"
    words = f'byte_order="{"Big" if order == ">" else "Little"}Endian" header_type="{head}"'
    words += ' compressor="vtkZLibDataCompressor"' if packed else ""
    text = f'<?xml version="1.0"?>\n<VTKFile type="PolyData" version="1.0" {words}><PolyData>'.encode() + text
    if behind:
        behind = f'<AppendedData encoding="{"raw" if raw else "base64"}">\n _'.encode() + behind + b"\n</AppendedData>"
    return text + b"</PolyData>\n" + behind + b"</VTKFile>\n"


VTP = {
    "packed": vtp(),
    "text": vtp("ascii", packed=False),
    "base64": vtp(packed=False, head="UInt64"),
    "appended": vtp("appended", head="UInt64"),
    "appended raw": vtp("appended", packed=False, raw=True),
    "appended packed raw": vtp("appended", order=">", raw=True),
}

# ---- GIFTI and FreeSurfer


def gii(way="GZipBase64Binary", codes=("NIFTI_INTENT_POINTSET", "NIFTI_INTENT_TRIANGLE")):
    text = '<?xml version="1.0" encoding="UTF-8"?>\n'
    text += '<!DOCTYPE GIFTI SYSTEM "http://www.nitrc.org/frs/download.php/1594/gifti.dtd">\n'
    text += '<GIFTI Version="1.0" NumberOfDataArrays="2">'
    for code, values, kind in zip(codes, sphere(), ("FLOAT32", "INT32"), strict=True):
        content = values.astype({"FLOAT32": "<f4", "INT32": "<i4"}[kind]).tobytes()
        packed = base64.b64encode(zlib.compress(content) if "GZip" in way else content).decode()
        text += f'<DataArray Intent="{code}" DataType="NIFTI_TYPE_{kind}" ArrayIndexingOrder="RowMajorOrder" '
        text += f'Dimensionality="2" Dim0="{len(values)}" Dim1="3" Encoding="{way}" Endian="LittleEndian" '
        data = rows(values) if way == "ASCII" else packed
        text += f'ExternalFileName="" ExternalFileOffset=""><Data>{data}</Data></DataArray>'
    return (text + "</GIFTI>\n").encode()


def freesurfer():
    points, triangles = sphere()
    counts = np.array([len(points), len(triangles)], ">i4")
    first = b"\xff\xff\xfecreated by a test\n\n" + counts.tobytes()
    return first + points.astype(">f4").tobytes() + triangles.astype(">i4").tobytes()


NEURO = (".gii", ".white")  # which nibabel reads
GII = {"packed": gii(), "base64": gii("Base64Binary"), "text": gii("ASCII")}

# By suffix and name.
SOUND = {
    (suffix, name): content
    for suffix, kinds in (
        (".obj", OBJ), (".ply", PLY), (".off", OFF), (".stl", STL), (".glb", GLB), (".gltf", GLTF),
        (".vtk", VTK), (".vtp", VTP), (".gii", GII), (".white", {"triangles": freesurfer()}),
    )
    for name, content in kinds.items()
}  # fmt: skip
