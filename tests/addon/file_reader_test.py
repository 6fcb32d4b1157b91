"""The file reader beside Blender's importers: the same meshes, and the same results to the bit."""

import json

import numpy as np
import pytest

pytest.importorskip("bpy", reason="needs Blender")

from mesh_kinds import GLB, OBJ, PLY, STL, ball, glb, obj, ply, stl_binary
from paradesc import cli
from paradesc.files import png
from shapes import RADIUS, cube_sphere, write_obj

WORDS = ("--radius", "0.1", "--backend", "cpu", "--descriptors", "mean_curvature,shape_index", "--quiet")


def baked(folder, path, *words):
    out = folder / "out.npz"
    assert cli.main(["bake", str(path), "--output", str(out), *WORDS, *words]) == 0
    with np.load(out) as arrays:
        return dict(arrays)


def compare(folder, path, *words):
    blender, files = (baked(folder, path, "--reader", reader, *words) for reader in ("blender", "files"))
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


@pytest.mark.parametrize("space", ["object", "world"])
def test_a_displaced_ply_has_the_same_bits(tmp_path, space):
    import bpy

    if bpy.app.version < (4, 0, 0):
        pytest.skip("importers of Blender 3 turn faces that end with the first vertex")
    path, image = sheet_ply(tmp_path / "sheet.ply", 9, 0.05), tmp_path / "heights.png"
    waves = np.add.outer(*2 * [np.sin(np.arange(96) / 5)])
    heights = np.repeat((30000 + 8000 * waves)[:, :, None], 3, axis=2) * (1, 0.9, 0.8)
    image.write_bytes(png.encode_png(heights.astype(np.uint16), {}))
    words = ("--displacement", str(image), "--displacement-scale", "0.2", "--midlevel", "0.4", "--space", space)
    compare(tmp_path, path, *words)
    flat, bumpy = baked(tmp_path, path, "--reader", "files"), baked(tmp_path, path, "--reader", "files", *words)
    assert np.abs(flat["mean_curvature"] - bumpy["mean_curvature"]).max() > 1


def test_a_normal_map_gives_what_it_gives_in_blender(tmp_path):
    points, quads, uvs = cube_sphere(8)
    path, image = write_obj(tmp_path / "sphere.obj", points, quads, uvs), tmp_path / "normals.png"
    lines = path.read_text().splitlines()
    corners = [line.split()[1:] for line in lines if line.startswith("f ")]
    lines = [line for line in lines if not line.startswith("f ")] + ["s 1"]
    lines += ["vn {:.7f} {:.7f} {:.7f}".format(*point) for point in points / 2]
    lines += ["f " + " ".join(f"{word}/{word.split('/')[0]}" for word in words) for words in corners]
    path.write_text("\n".join(lines) + "\n")
    tilt = 0.2 * np.sin(np.arange(64) / 4)
    normals = np.stack([*np.meshgrid(tilt, tilt), np.ones((64, 64))], axis=2)
    image.write_bytes(png.encode_png(np.round((0.5 + 0.5 * normals / 1.1) * 65535).astype(np.uint16), {}))
    found = [baked(tmp_path, path, "--reader", reader, "--normal-map", str(image)) for reader in ("blender", "files")]
    plain = baked(tmp_path, path, "--reader", "files")
    difference = np.abs(found[0]["mean_curvature"] - found[1]["mean_curvature"])
    assert difference.max() < 1e-3 < 0.1 < np.abs(plain["mean_curvature"] - found[1]["mean_curvature"]).max()


# ---- High to low


def bumpy(steps):
    """A sphere with bumps, which a coarse one does not have."""
    points, quads, uvs = cube_sphere(steps)
    return points * (1 + 0.04 * np.cos(9 * points).prod(axis=1, keepdims=True)), quads, uvs


def sheet_ply(path, steps, height):
    """A sheet with waves as a .ply that has texture coordinates at its vertices."""
    u, v = (axis.ravel() for axis in np.meshgrid(*2 * [np.linspace(0, 1, steps + 1)], indexing="ij"))
    rows = np.column_stack([u, v, height * np.sin(9 * u) * np.cos(7 * v), 0.1 + 0.8 * u, 0.1 + 0.8 * v])
    first = (np.arange(steps)[:, None] * (steps + 1) + np.arange(steps)).ravel()
    quads = first[:, None] + (0, steps + 1, steps + 2, 1)
    header = ["ply", "format ascii 1.0", f"element vertex {len(rows)}"]
    header += [f"property float {name}" for name in "xyzst"]
    header += [f"element face {len(quads)}", "property list uchar int vertex_indices", "end_header"]
    lines = [" ".join(f"{value:.6f}" for value in row) for row in rows]
    lines += [" ".join(map(str, [4, *quad])) for quad in quads.tolist()]
    path.write_text("\n".join([*header, *lines]) + "\n")
    return path


def test_detail_of_another_file_has_the_same_bits(tmp_path):
    import bpy

    if bpy.app.version < (4, 0, 0):
        pytest.skip("importers of Blender 3 turn faces that end with the first vertex")
    low, high = sheet_ply(tmp_path / "low.ply", 6, 0.03), sheet_ply(tmp_path / "high.ply", 40, 0.05)
    found, names = {}, ("mean_curvature", "principal_direction_max")
    for reader in ("blender", "files"):
        out = [tmp_path / f"{reader}.{suffix}" for suffix in ("npz", "exr", "json")]
        words = ["--output", out[0], "--map", out[1], "--json", out[2], "--texels", "64", "--radius", "0.1"]
        words += ["--from-file", high, "--cage", "0.3", "--descriptors", ",".join(names), "--backend", "cpu"]
        assert cli.main(["bake", str(low), "--reader", reader, "--quiet", *map(str, words)]) == 0
        (row,) = json.loads(out[2].read_text())["objects"]
        found[reader] = (np.load(out[0]), out[1].read_bytes(), row["transfer"], row["descriptors"])
    blender, files = found["blender"], found["files"]
    assert np.isfinite(blender[0]["mean_curvature"]).mean() > 0.6  # lines at the border may miss
    for name in blender[0]:
        assert np.array_equal(blender[0][name], files[0][name], equal_nan=True), name
    assert blender[1:] == files[1:]
    assert files[2]["sources"] == ["high"]
    assert 10 * files[2]["missed"] < files[2]["texels"]


def shifted(line, counts):
    """A line of an .obj that comes after so many vertices and texture vertices."""
    if not line.startswith("f "):
        return line
    corners = [np.array(word.split("/"), int) + counts for word in line.split()[1:]]
    return "f " + " ".join(f"{vertex}/{uv}" for vertex, uv in corners)


def test_pairs_of_one_obj_are_those_of_blender_but_for_its_axes(tmp_path):
    path, counts, text = tmp_path / "pairs.obj", np.zeros(2, int), ""
    for name, steps in (("a_low", 4), ("a_high", 12), ("b_high", 10), ("b_low", 3)):
        points, quads, uvs = bumpy(steps)
        lines = (
            write_obj(path, points + np.array([9 * name.startswith("b"), 0, 0]), quads, uvs).read_text().splitlines()
        )
        text += f"o {name}\n" + "".join(f"{shifted(line, counts)}\n" for line in lines[1:])
        counts += len(points), quads.size
    path.write_text(text)
    rows = {}
    for reader in ("blender", "files"):
        out = tmp_path / f"{reader}.npz"
        words = ["--pairs", "--output", str(out), "--map", str(tmp_path / f"{reader}.png"), "--texels", "64", *WORDS]
        words += ["--json", str(tmp_path / f"{reader}.json"), "--reader", reader]
        assert cli.main(["bake", str(path), *words]) == 0
        rows[reader] = json.loads((tmp_path / f"{reader}.json").read_text())["objects"]
    for blender, files in zip(rows["blender"], rows["files"], strict=True):
        assert (blender["object"], blender["transfer"]["sources"]) == (files["object"], files["transfer"]["sources"])
    arrays = {reader: np.load(tmp_path / f"{reader}.npz") for reader in rows}
    for name in (name for name in arrays["blender"] if not name.endswith("matrix_world")):
        np.testing.assert_allclose(arrays["files"][name], arrays["blender"][name], rtol=1e-4, atol=1e-5, err_msg=name)


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


# ---- Far from the origin


def test_what_blender_rounds_far_away_is_said(tmp_path, capsys):
    points, quads, _ = cube_sphere(8)
    path = write_obj(tmp_path / "far.obj", points + np.array([500000, 5400000, 100]), quads)
    found = {}
    for reader in ("files", "blender"):
        words = ["--reader", reader, "--radius", "0.2", "--backend", "cpu", "--output", str(tmp_path / "o.npz")]
        assert cli.main(["bake", str(path), *words]) == 0
        with np.load(tmp_path / "o.npz") as arrays:
            found[reader] = arrays["mean_curvature"]
        said = "32-bit floats are 0.5 apart: its vertices are rounded to" in capsys.readouterr().out
        assert said == (reader == "blender")
    assert np.allclose(found["files"], 1 / RADIUS, rtol=0.02)
    assert not np.allclose(found["blender"], 1 / RADIUS, rtol=0.02)  # which the note is about: steps of half a unit


# ---- One result of a file, whoever reads it

DAMAGED = {
    "a place that is no number": (".obj", obj("v nan 0 0\n")),
    "a comma in a number": (".obj", obj().replace(b"v -", b"v -0,", 1)),
    "a vertex that is not there": (".obj", obj()[:-100] + b"f 1 2 999"),
    "vertex 0": (".obj", obj().replace(b"f ", b"f 0 ", 1)),
    "UTF-16": (".obj", obj().decode().encode("utf-16")),
    "the end of a text is missing": (".ply", ply()[:-200]),
    "a row too many": (
        ".ply",
        ply().replace(b"end_header\n", b"end_header\nnan nan nan\n").replace(b"vertex 218", b"vertex 219"),
    ),
    "the end is missing": (".ply", ply("binary_little_endian")[:-5]),
    "too few facets": (".stl", stl_binary(count=1000)),
    "half a file": (".stl", STL["text"][: len(STL["text"]) // 2]),
    "the end of a buffer is missing": (".glb", GLB["plain"][:-500]),
    "a pointer of Git LFS": (".gltf", b"version https://git-lfs.github.com/spec/v1"),
}


@pytest.mark.parametrize(("suffix", "content"), DAMAGED.values(), ids=DAMAGED)
def test_a_damaged_file_is_refused_with_the_same_sentence_by_blender(tmp_path, capsys, suffix, content):
    path, good = tmp_path / f"bad{suffix}", write_obj(tmp_path / "good.obj", *cube_sphere(4))
    path.write_bytes(content)
    said = []
    for words in ((path, "--reader", "files"), (path,), (good, "--from-file", path)):
        assert cli.main(["bake", *map(str, words), "-o", str(tmp_path / "o.npz"), "--quiet"]) == 3
        said.append(capsys.readouterr().err)
    assert len(set(said)) == 1
    assert str(path) in said[0]


@pytest.mark.parametrize(
    ("suffix", "kinds"), [(".obj", OBJ), (".ply", PLY), (".stl", STL), (".glb", GLB)], ids=["obj", "ply", "stl", "glb"]
)
def test_a_sound_file_of_any_kind_is_right_by_blender_or_refused_with_the_way_out(tmp_path, capsys, suffix, kinds):
    expected = {}
    for name, content in kinds.items():
        path = tmp_path / f"ball{suffix}"
        path.write_bytes(content)
        arguments = ["bake", str(path), "--space", "world", *WORDS]
        code = cli.main([*arguments, "-o", str(tmp_path / "o.npz")])
        said = capsys.readouterr().err
        if code == 0:
            expected[name] = np.load(tmp_path / "o.npz")["mean_curvature"]
        else:
            assert code == 3, name
            assert said.rstrip().endswith(("--reader files reads it.", "--reader files reads all of it.")), (name, said)
            assert cli.main([*arguments, "-o", str(tmp_path / "o.npz"), "--reader", "files"]) == 0
    assert len(expected) >= 2
    for name, values in expected.items():
        assert np.allclose(values, 1 / RADIUS, rtol=0.05), name  # what facets of this size leave


def test_what_only_blender_reads_is_left_to_it(tmp_path):
    path = tmp_path / "ball.glb"
    draco = ["KHR_draco_mesh_compression"]
    path.write_bytes(glb(*ball(extensionsUsed=draco, extensionsRequired=draco)))
    assert cli.main(["bake", str(path), "--reader", "files", "-o", str(tmp_path / "o.npz"), *WORDS]) == 3
    assert cli.main(["bake", str(path), "-o", str(tmp_path / "o.npz"), *WORDS]) == 0


@pytest.mark.parametrize(("uv", "reason"), [(0.5, "has a UV map without area"), (np.nan, "that are not finite")])
def test_a_uv_map_of_blender_that_cannot_be_used_is_told_from_none(tmp_path, capsys, uv, reason):
    import bpy

    from scene import add_sphere, empty_scene

    empty_scene()
    mesh = add_sphere().data
    mesh.uv_layers.active.data.foreach_set("uv", np.full(2 * len(mesh.loops), uv, np.float32))
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "a.blend"))
    words = ["bake", str(tmp_path / "a.blend"), "--backend", "cpu", "--map", str(tmp_path / "o.exr")]
    assert cli.main(words) == 2
    assert reason in capsys.readouterr().err
