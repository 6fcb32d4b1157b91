"""Files that VTK writes in each of its ways are read into its own points and polygons, in their order."""

import itertools

import numpy as np
import pytest

from mesh_kinds import rows, sphere
from paradesc.files import mesh_files
from shapes import cube_sphere

vtk = pytest.importorskip("vtk", reason="VTK is not installed")
from vtk.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray, vtk_to_numpy  # noqa: E402


def polydata(points, faces):
    made, cells, places = vtk.vtkPolyData(), vtk.vtkCellArray(), vtk.vtkPoints()
    places.SetData(numpy_to_vtk(points, deep=True))
    offsets = np.concatenate([[0], np.cumsum([len(face) for face in faces])])
    parts = (np.asarray(part, np.int64) for part in (offsets, np.concatenate(faces)))
    cells.SetData(*(numpy_to_vtkIdTypeArray(part, deep=True) for part in parts))
    made.SetPoints(places)
    made.SetPolys(cells)
    values = numpy_to_vtk(np.linspace(0, 1, len(points), dtype=np.float32), deep=True)
    values.SetName("values with a long name")
    made.GetPointData().SetScalars(values)
    return made


def quads_and_triangles():
    """Faces of two sizes, on a sphere far enough from the origin that 64 bits tell."""
    points, quads, _ = cube_sphere(6)
    return points.astype(np.float64), [*quads[:100].tolist(), *(face[:3] for face in quads[100:].tolist())]


def check(path, points, faces):
    (mesh,) = mesh_files.read(path)
    np.testing.assert_array_equal(mesh.arrays.positions, points.astype(np.float32))
    np.testing.assert_array_equal(mesh.arrays.corner_vertices, np.concatenate(faces))
    assert mesh.face_count == len(faces)


WAYS = list(itertools.product((0, 1, 2), *[(False, True)] * 4))


@pytest.mark.parametrize(("mode", "base64", "packed", "wide", "big"), WAYS)
def test_vtp_that_vtk_writes_is_read(tmp_path, mode, base64, packed, wide, big):
    points, faces = quads_and_triangles()
    writer = vtk.vtkXMLPolyDataWriter()
    writer.SetInputData(polydata(points, faces))
    writer.SetFileName(str(tmp_path / "a.vtp"))
    writer.SetDataMode(mode)  # text, base64, appended
    writer.SetEncodeAppendedData(base64)
    writer.SetBlockSize(1000)  # so that arrays have several
    (writer.SetCompressorTypeToZLib if packed else writer.SetCompressorTypeToNone)()
    (writer.SetHeaderTypeToUInt64 if wide else writer.SetHeaderTypeToUInt32)()
    (writer.SetByteOrderToBigEndian if big else writer.SetByteOrderToLittleEndian)()
    assert writer.Write()
    check(tmp_path / "a.vtp", np.round(points, 9) if mode == 0 else points, faces)


@pytest.mark.parametrize(("kind", "version"), itertools.product((1, 2), (42, 51)))
def test_vtk_that_vtk_writes_is_read(tmp_path, kind, version):
    points, faces = quads_and_triangles()
    points = np.round(points, 4)  # text has six digits
    writer = vtk.vtkPolyDataWriter()
    writer.SetInputData(polydata(points, faces))
    writer.SetFileName(str(tmp_path / "a.vtk"))
    writer.SetFileType(kind)  # text, binary
    writer.SetFileVersion(version)
    assert writer.Write()
    check(tmp_path / "a.vtk", points, faces)


def test_vtk_reads_what_the_tests_make_by_hand(tmp_path):
    from mesh_kinds import VTK, VTP

    for (name, content), reader in [
        *((item, vtk.vtkPolyDataReader) for item in VTK.items()),
        *((item, vtk.vtkXMLPolyDataReader) for item in VTP.items()),
    ]:
        path = tmp_path / "a"
        path.write_bytes(content)
        one = reader()
        one.SetFileName(str(path))
        one.Update()
        triangles = vtk.vtkTriangleFilter()
        triangles.SetInputData(one.GetOutput())
        triangles.PassLinesOff()
        triangles.PassVertsOff()
        triangles.Update()
        found = triangles.GetOutput()
        assert np.allclose(vtk_to_numpy(found.GetPoints().GetData()), sphere()[0], atol=1e-6), name
        assert found.GetPolys().GetNumberOfCells() == len(sphere()[1]), name


def test_a_file_of_several_pieces_is_one_mesh(tmp_path):
    from mesh_kinds import vtp

    (tmp_path / "a.vtp").write_bytes(vtp(pieces=3))
    (mesh,) = mesh_files.read(tmp_path / "a.vtp")
    points, triangles = sphere()
    assert len(mesh.arrays.positions) == 3 * len(points)
    assert np.array_equal(mesh.arrays.triangle_vertices % len(points), triangles)


def test_polygons_of_other_sizes_than_three_are_kept_in_legacy_files(tmp_path):
    points, quads, _ = cube_sphere(2)
    faces = [*quads.tolist(), quads[0, :3].tolist()]
    table = "".join(f"{len(face)} {' '.join(map(str, face))}\n" for face in faces)
    text = f"# vtk DataFile Version 2.0\nx\nASCII\nDATASET POLYDATA\nPOINTS {len(points)} double\n{rows(points)}"
    text += f"POLYGONS {len(faces)} {sum(map(len, faces)) + len(faces)}\n{table}"
    (tmp_path / "a.vtk").write_text(text)
    (mesh,) = mesh_files.read(tmp_path / "a.vtk")
    assert (mesh.face_count, len(mesh.arrays.triangle_corners)) == (len(quads) + 1, 2 * len(quads) + 1)
