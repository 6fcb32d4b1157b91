"""Files for ParaView hold what .npz holds; VTK reads them to the bit where it is installed."""

import re
import struct

import numpy as np
import pytest

from paradesc import bridge
from paradesc.core import job
from paradesc.files import results, vtk_files
from shapes import as_arrays, cube_sphere

NAMES = ("mean_curvature", "principal_direction_max")


@pytest.fixture(scope="module")
def baked():
    arrays = as_arrays(*cube_sphere(4))
    settings = job.Settings(NAMES, bridge.Options(radius=0.1), "cpu")
    return results.Baked("sphere", job.run(arrays, settings), arrays, np.eye(4))


def expected(baked):
    return {**baked.results.values, **baked.results.extras}


def test_vtp_holds_positions_triangles_and_values(tmp_path, baked):
    vtk_files.write_vtp(tmp_path / "a.vtp", baked)
    content = (tmp_path / "a.vtp").read_bytes()
    header, _, raw = content.partition(b'encoding="raw">\n_')
    found = {}
    for kind, name, at in re.findall(rb'type="(\w+)" Name="(\w+)".*offset="(\d+)"', header):
        (length,) = struct.unpack_from("<Q", raw, int(at))
        kinds = {b"Float32": "<f4", b"Int64": "<i8"}
        found[name.decode()] = np.frombuffer(raw[int(at) + 8 : int(at) + 8 + length], kinds[kind])
    assert np.array_equal(found["Points"], baked.arrays.positions.reshape(-1))
    assert np.array_equal(found["connectivity"], baked.arrays.triangle_vertices.reshape(-1))
    assert np.array_equal(found["offsets"], 3 * np.arange(1, len(baked.arrays.triangle_corners) + 1))
    for name, values in expected(baked).items():
        assert np.array_equal(found[name], values.reshape(-1), equal_nan=True)


@pytest.mark.parametrize("suffix", ["vtp", "vtk"])
def test_vtk_reads_the_same(tmp_path, baked, suffix):
    vtk = pytest.importorskip("vtk", reason="VTK is not installed")
    from vtk.util.numpy_support import vtk_to_numpy

    path = tmp_path / f"a.{suffix}"
    {"vtp": vtk_files.write_vtp, "vtk": vtk_files.write_vtk}[suffix](path, baked)
    reader = vtk.vtkXMLPolyDataReader() if suffix == "vtp" else vtk.vtkPolyDataReader()
    if suffix == "vtk":
        reader.ReadAllScalarsOn()
        reader.ReadAllVectorsOn()
    reader.SetFileName(str(path))
    reader.Update()
    found = reader.GetOutput()
    assert np.array_equal(vtk_to_numpy(found.GetPoints().GetData()), baked.arrays.positions)
    faces = vtk_to_numpy(found.GetPolys().GetConnectivityArray()).reshape(-1, 3)
    assert np.array_equal(faces, baked.arrays.triangle_vertices)
    data = found.GetPointData()
    arrays = {data.GetArrayName(k): vtk_to_numpy(data.GetArray(k)) for k in range(data.GetNumberOfArrays())}
    assert arrays.keys() == expected(baked).keys()
    for name, values in expected(baked).items():
        assert np.array_equal(arrays[name], values, equal_nan=True)
    assert data.GetScalars().GetName() == NAMES[0]
