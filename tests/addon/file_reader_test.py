"""The file reader beside Blender's importers: the same meshes, and the same results to the bit."""

import json

import numpy as np
import pytest

pytest.importorskip("bpy", reason="needs Blender")

from paradesc import cli
from shapes import cube_sphere, write_obj

WORDS = ("--radius", "0.1", "--backend", "cpu", "--descriptors", "mean_curvature,shape_index", "--quiet")


def baked(folder, path, *words):
    out = folder / f"{'_'.join(words) or 'auto'}.npz"
    assert cli.main(["bake", str(path), "--output", str(out), *WORDS, *words]) == 0
    return np.load(out)


def compare(folder, path):
    blender, files = (baked(folder, path, "--reader", reader) for reader in ("blender", "files"))
    assert np.array_equal(blender["vertices"], files["vertices"])
    for name in ("mean_curvature", "shape_index", "coverage"):
        assert np.array_equal(blender[name], files[name], equal_nan=True), name


@pytest.mark.parametrize("with_uvs", [True, False])
def test_obj_of_quads_has_the_same_bits(tmp_path, with_uvs):
    points, quads, uvs = cube_sphere(8)
    compare(tmp_path, write_obj(tmp_path / "sphere.obj", points * (1, 1.5, 0.7), quads, uvs if with_uvs else None))


def test_obj_of_quads_that_bend_inwards_has_the_same_bits(tmp_path):
    points, quads, uvs = cube_sphere(8)
    moved = points + np.random.default_rng(1).normal(0, 0.12, points.shape)
    compare(tmp_path, write_obj(tmp_path / "rough.obj", moved, quads, uvs))


def test_ply_has_the_same_bits(tmp_path):
    import bpy

    if bpy.app.version < (4, 0, 0):
        pytest.skip("importers of Blender 3 turn faces that end with the first vertex")
    path, ply = write_obj(tmp_path / "sphere.obj", *cube_sphere(8)), tmp_path / "sphere.ply"
    assert cli.main(["bake", str(path), "--reader", "files", "--output", str(ply), "--quiet"]) == 0
    compare(tmp_path, ply)


def test_reader_is_blender_unless_another_is_asked_for(tmp_path, capsys):
    path = write_obj(tmp_path / "sphere.obj", *cube_sphere(3))
    reports = []
    for words in ((), ("--reader", "files")):
        capsys.readouterr()
        assert cli.main(["info", str(path), *words, "--json", "-"]) == 0
        reports.append(json.loads(capsys.readouterr().out)["objects"][0])
    assert reports[0].keys() == reports[1].keys()
    own = {"mesh", "memory"}  # Blender's name of the mesh; what is free at the moment
    assert [{name: row[name] for name in row.keys() - own} for row in reports[1:]] == [
        {name: row[name] for name in row.keys() - own} for row in reports[:1]
    ]


def test_off_is_read_where_blender_has_no_importer(tmp_path):
    pytest.importorskip("trimesh", reason="trimesh reads .off; blend_samples/setup.sh installs it")
    path = tmp_path / "square.off"
    path.write_text("OFF\n4 2 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2\n3 0 2 3\n")
    assert cli.main(["bake", str(path), "--output", str(tmp_path / "out.npz"), "--quiet"]) == 0
    assert np.allclose(np.load(tmp_path / "out.npz")["mean_curvature"], 0, atol=1e-6)


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (("bake", "square.off", "-o", "out.blend"), "A .blend is written by Blender; choose --reader blender"),
        (("bake", "ball.obj", "-o", "o.npz", "--reader", "files", "--material-maps"), "choose --reader blender"),
        (("animate", "ball_#.obj", "--reader", "blender"), "A sequence of files is read without Blender"),
    ],
)
def test_options_that_do_not_go_together_are_refused(tmp_path, monkeypatch, capsys, words, sentence):
    monkeypatch.chdir(tmp_path)
    assert cli.main(list(words)) == 2
    assert sentence in capsys.readouterr().err
