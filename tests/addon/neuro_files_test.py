"""GIFTI and FreeSurfer's files go in and out: nibabel writes what is read, and reads what was written."""

import numpy as np
import pytest

from mesh_kinds import sphere
from paradesc import bridge
from paradesc.bridge import InputError
from paradesc.commands.main import main
from paradesc.core import job
from paradesc.files import mesh_files, neuro_files, results
from shapes import RADIUS, as_arrays, cube_sphere

nibabel = pytest.importorskip("nibabel", reason="nibabel is not installed")
NAMES = ("mean_curvature", "principal_direction_max")


@pytest.fixture(scope="module")
def baked():
    arrays = as_arrays(*cube_sphere(4))
    found = job.run(arrays, job.Settings(NAMES, bridge.Options(radius=0.1), "cpu"))
    return results.Baked("sphere", found, arrays, np.eye(4))


@pytest.mark.parametrize("encoding", ["ASCII", "B64BIN", "B64GZ"])
@pytest.mark.parametrize("endian", ["big", "little"])
def test_surfaces_of_gifti_are_read_as_nibabel_writes_them(tmp_path, encoding, endian):
    points, triangles = sphere()
    made = nibabel.gifti.GiftiDataArray
    moved = nibabel.gifti.GiftiCoordSystem(0, 1, np.diag([2.0, 2.0, 2.0, 1.0]))
    arrays = [
        made(points.astype("f4"), "NIFTI_INTENT_POINTSET", encoding=encoding, endian=endian, coordsys=moved),
        made(triangles.astype("i4"), "NIFTI_INTENT_TRIANGLE", encoding=encoding, endian=endian),
        made(points[:, 0].astype("f4"), "NIFTI_INTENT_SHAPE", encoding=encoding),
    ]
    (tmp_path / "lh.gii").write_bytes(nibabel.GiftiImage(darrays=arrays).to_bytes())
    (mesh,) = mesh_files.read(tmp_path / "lh.gii")
    assert np.array_equal(mesh.arrays.positions, points.astype("f4"))
    assert np.array_equal(mesh.arrays.triangle_vertices, triangles)


@pytest.mark.parametrize("name", ["lh.white", "rh.pial", "lh.inflated", "lh.sphere", "lh.orig", "rh.smoothwm"])
def test_surfaces_of_freesurfer_are_read_as_nibabel_writes_them(tmp_path, name):
    points, triangles = sphere()
    nibabel.freesurfer.write_geometry(tmp_path / name, points, triangles)
    (mesh,) = mesh_files.read(tmp_path / name)
    assert np.array_equal(mesh.arrays.positions, points.astype("f4"))
    assert np.array_equal(mesh.arrays.triangle_vertices, triangles)
    assert mesh.name == name.split(".")[0]


def test_values_in_place_of_a_surface_are_told_apart(tmp_path):
    nibabel.freesurfer.write_morph_data(tmp_path / "lh.sphere", np.arange(100))
    with pytest.raises(InputError, match="it holds no triangles of points, but values perhaps"):
        mesh_files.read(tmp_path / "lh.sphere")


def test_gifti_holds_each_value_under_its_name(tmp_path, baked):
    neuro_files.write_gifti(tmp_path / "a.gii", baked)
    found = {array.meta["Name"]: array for array in nibabel.load(tmp_path / "a.gii").darrays}
    assert list(found) == [
        "mean_curvature", *(f"principal_direction_max_{axis}" for axis in "xyz"), "coverage", "paradesc_mask"
    ]  # fmt: skip
    assert {array.intent for array in found.values()} == {nibabel.nifti1.intent_codes["NIFTI_INTENT_SHAPE"]}
    assert np.array_equal(found["mean_curvature"].data, baked.results.values["mean_curvature"])
    directions = baked.results.values["principal_direction_max"]
    assert np.array_equal(found["principal_direction_max_y"].data, directions[:, 1])


@pytest.mark.slow
def test_the_command_line_writes_both_from_a_surface_of_freesurfer(tmp_path, capsys):
    points, triangles = sphere()
    path = tmp_path / "lh.white"
    nibabel.freesurfer.write_geometry(path, points, triangles)
    out = [word for name in ("lh.curv", "lh.shape.gii") for word in ("-o", str(tmp_path / name))]
    assert main(["bake", str(path), "--radius", "0.15", *out]) == 0
    curv = nibabel.freesurfer.read_morph_data(tmp_path / "lh.curv")
    np.testing.assert_allclose(curv, 1 / RADIUS, rtol=0.03)  # what facets of this size leave
    assert np.array_equal(nibabel.load(tmp_path / "lh.shape.gii").darrays[0].data, curv.astype("f4"))
    raw = (tmp_path / "lh.curv").read_bytes()
    assert raw[:15] == b"\xff\xff\xff" + np.array([len(points), len(triangles), 1], ">i4").tobytes()
    assert "wrote" in capsys.readouterr().out


def test_what_does_not_fit_into_one_number_at_a_vertex_is_refused_before_it_is_computed(tmp_path, capsys):
    points, triangles = sphere()
    nibabel.freesurfer.write_geometry(tmp_path / "lh.white", points, triangles)
    for more in (["--descriptors", "mean_curvature,shape_index"], ["--radius", "0.1,0.2"],
                 ["--descriptors", "principal_direction_max"]):  # fmt: skip
        assert main(["bake", str(tmp_path / "lh.white"), "-o", str(tmp_path / "lh.curv"), *more]) == 2
        assert "holds one number at each vertex; ask for one descriptor" in capsys.readouterr().err
    assert not (tmp_path / "lh.curv").exists()


def test_without_nibabel_nothing_is_computed_for_its_files(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(neuro_files.importlib.util, "find_spec", lambda name: None)
    for name in ("a.gii", "lh.curv"):
        assert main(["bake", str(tmp_path / "a.obj"), "-o", str(tmp_path / name)]) == 4
        assert "it needs nibabel, which is not installed; pip install paradesc[neuro]." in capsys.readouterr().err
