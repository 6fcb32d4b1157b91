"""Writes what a bake left behind for ParaView: .vtp (XML with raw bytes behind it) and .vtk (legacy, binary).

Positions are in object space; descriptors, coverage and masks are point data, or cell data, under their own names.
"""

import struct
from pathlib import Path

import numpy as np

from .results import Baked

# VTK's names of number types, by numpy's type strings.
KINDS = {"<f4": "Float32", "<f8": "Float64", "<i4": "Int32", "<i8": "Int64"}


def write_vtp(path: Path, baked: Baked) -> None:
    """Writes the results as .vtp."""
    write_polydata(path, *parts_of(baked), baked.at_faces)


def write_polydata(
    path: Path, positions: np.ndarray, triangles: np.ndarray, values: dict[str, np.ndarray], at_faces: bool
) -> None:
    """Writes VTK's PolyData as XML; arrays lie behind it, each after its length in bytes.

    positions: (n, 3). triangles: (m, 3) int32. values: (n,) or (n, 3) float32 by name, or (m,) and (m, 3) at_faces.
    """
    blocks: list[bytes] = []
    at = 0

    def array(name: str, values: np.ndarray) -> str:
        nonlocal at
        content = values.tobytes()
        blocks.append(struct.pack("<Q", len(content)) + content)
        width = f' NumberOfComponents="{values.shape[1]}"' if values.ndim == 2 else ""
        line = f'<DataArray type="{KINDS[values.dtype.str]}" Name="{name}"{width} format="appended" offset="{at}"/>\n'
        at += len(blocks[-1])
        return line

    ends = 3 * np.arange(1, len(triangles) + 1, dtype="<i8")
    first = next(iter(values))
    active = "Scalars" if values[first].ndim == 1 else "Vectors"
    domain = "CellData" if at_faces else "PointData"
    header = (
        '<?xml version="1.0"?>\n'
        '<VTKFile type="PolyData" version="1.0" byte_order="LittleEndian" header_type="UInt64">\n<PolyData>\n'
        f'<Piece NumberOfPoints="{len(positions)}" NumberOfVerts="0" NumberOfLines="0" NumberOfStrips="0" '
        f'NumberOfPolys="{len(triangles)}">\n'
        f'<{domain} {active}="{first}">\n{"".join(array(*item) for item in values.items())}</{domain}>\n'
        f"<Points>\n{array('Points', positions)}</Points>\n"
        f"<Polys>\n{array('connectivity', triangles.astype('<i8').reshape(-1))}{array('offsets', ends)}</Polys>\n"
        '</Piece>\n</PolyData>\n<AppendedData encoding="raw">\n_'
    )
    path.write_bytes(header.encode() + b"".join(blocks) + b"\n</AppendedData>\n</VTKFile>\n")


def write_vtk(path: Path, baked: Baked) -> None:
    """Writes VTK's PolyData in the legacy format, whose numbers are big-endian."""
    positions, triangles, values = parts_of(baked)
    faces = np.column_stack([np.full(len(triangles), 3, np.int32), triangles])
    content = [b"# vtk DataFile Version 3.0\nParadesc\nBINARY\nDATASET POLYDATA\n"]
    kind = b"double" if positions.dtype.itemsize == 8 else b"float"
    content += [b"POINTS %d %s\n" % (len(positions), kind), big(positions), b"\n"]
    content += [b"POLYGONS %d %d\n" % (len(faces), faces.size), big(faces), b"\n"]
    content += [b"CELL_DATA %d\n" % len(faces) if baked.at_faces else b"POINT_DATA %d\n" % len(positions)]
    for name, array in values.items():
        if array.ndim == 1:
            content.append(f"SCALARS {name} float 1\nLOOKUP_TABLE default\n".encode())
        else:
            content.append(f"VECTORS {name} float\n".encode())
        content += [big(array), b"\n"]
    path.write_bytes(b"".join(content))


def parts_of(baked: Baked) -> tuple[np.ndarray, np.ndarray, dict[str, np.ndarray]]:
    """(n, 3) positions, (m, 3) triangles, and values (n,) or (n, 3) by name."""
    found = {**baked.results.values, **baked.results.extras}
    positions = np.ascontiguousarray(baked.arrays.positions, baked.arrays.positions.dtype.newbyteorder("<"))
    triangles = np.ascontiguousarray(baked.arrays.triangle_vertices, "<i4")
    return positions, triangles, {name: np.ascontiguousarray(array, "<f4") for name, array in found.items()}


def big(array: np.ndarray) -> bytes:
    """The bytes of an array in big-endian order."""
    return array.astype(array.dtype.newbyteorder(">")).tobytes()
