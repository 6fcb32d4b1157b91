"""A small sphere as the bytes of a mesh file of every kind, as programs write them, for the tests and the fuzzer."""

import base64
import json
import struct

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


def without(names):
    header, content = ball()
    return {key: value for key, value in header.items() if key not in names}, content


GLB = {
    "plain": glb(*ball()),
    "long indices": glb(*ball("u4")),
    "strips and fans": glb(*fans_and_strips()),
    "quantised": glb(*quantised()),
    "sparse": glb(*sparse()),
    "no scenes": glb(*without(("scene", "scenes"))),
    "no nodes": glb(*without(("scene", "scenes", "nodes"))),
    "nodes are hidden": glb(*ball(extensionsRequired=["KHR_node_visibility", "VRMC_vrm"])),
}
GLTF = {"embedded": embedded(*ball()), "mark": b"\xef\xbb\xbf" + embedded(*ball())}

# By suffix and name.
SOUND = {
    (suffix, name): content
    for suffix, kinds in (
        (".obj", OBJ), (".ply", PLY), (".off", OFF), (".stl", STL), (".glb", GLB), (".gltf", GLTF),
    )
    for name, content in kinds.items()
}  # fmt: skip
