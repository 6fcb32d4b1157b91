"""The command line for pipelines: inputs, several objects, reports, checks, exit codes. Most run in this process."""

import json
import os
import re
import shlex
import signal
import subprocess
import sys
import threading
from dataclasses import dataclass

import numpy as np
import pytest

from conftest import environment
from picture_test import decode
from shapes import ADDON, RADIUS, cube_sphere, write_obj

bpy = pytest.importorskip("bpy", reason="needs Blender")

import paradesc  # noqa: E402
from paradesc import bridge, cli_command, job, results, scene_io  # noqa: E402
from paradesc.commands import COMMANDS, common  # noqa: E402
from paradesc.commands.main import main, make_parser  # noqa: E402
from scene import add_sphere, attribute_values, empty_scene  # noqa: E402

QUICK = ("--radius", "0.08", "--samples", "32", "--buffer", "128", "--backend", "software")


@dataclass
class Ended:
    """What a command left behind."""

    code: int
    output: str
    error: str


@pytest.fixture
def run(tmp_path, monkeypatch, capfd):
    """Runs a command in this process, in an empty folder."""
    monkeypatch.chdir(tmp_path)

    def call(*words):
        capfd.readouterr()
        code = main([str(word) for word in words])
        return Ended(code, *capfd.readouterr())

    return call


@pytest.fixture
def report(tmp_path):
    """Reads a JSON report."""
    return lambda name="report.json": json.loads((tmp_path / name).read_text())


def saved_scene(path):
    """Saves the open scene."""
    bpy.ops.wm.save_as_mainfile(filepath=str(path), check_existing=False)
    return path


@pytest.fixture
def three_objects(tmp_path):
    """Two spheres of their own, one that shares a mesh, and objects that are no use."""
    empty_scene()
    first = add_sphere("first", steps=6)
    second = add_sphere("second/large", steps=8)
    second.location, second.scale = (10, 0, 0), (2, 2, 2)
    copy = first.copy()
    copy.name, copy.location = "twin", (0, 10, 0)
    bpy.context.collection.objects.link(copy)
    add_sphere("hidden", steps=4).hide_render = True
    bpy.context.collection.objects.link(bpy.data.objects.new("bare", bpy.data.meshes.new("bare")))
    return saved_scene(tmp_path / "three.blend")


# ---- Inputs


def export(suffix, path):
    """Writes the open scene in another format, by whichever exporter this Blender has."""
    names = {
        ".stl": ("wm.stl_export", "export_mesh.stl"),
        ".fbx": ("export_scene.fbx",),
        ".gltf": ("export_scene.gltf",),
    }.get(suffix, ("wm.usd_export",))
    name = next(name for name in reversed(names) if scene_io.has_operator(name))
    category, _, member = name.partition(".")
    words = {"export_format": "GLTF_SEPARATE"} if suffix == ".gltf" else {}
    getattr(getattr(bpy.ops, category), member)(filepath=str(path), **words)


@pytest.mark.parametrize("suffix", [".stl", ".fbx", ".gltf", ".usd", ".usda", ".usdc", ".usdz"])
def test_every_input_gives_the_curvature_of_the_sphere(run, report, tmp_path, monkeypatch, suffix):
    empty_scene()
    add_sphere(steps=10)
    path = tmp_path / f"sphere{suffix}"
    if suffix.startswith(".usd") and not scene_io.has_operator("wm.usd_import"):
        path.write_text("#usda 1.0")
        ended = run("bake", path, *QUICK, "--output", "out.npz")
        assert ended.code == common.EXIT_INPUT
        assert f"importer of {suffix}" in ended.error
        return
    export(suffix, path)
    monkeypatch.chdir(tmp_path)  # Blender's exporter of .usdz leaves another one
    ended = run("bake", path, *QUICK, "--output", "out.npz", "--json", "report.json")
    assert ended.code == 0, ended.error
    with np.load(tmp_path / "out.npz") as arrays:
        size = np.linalg.norm(arrays["vertices"], axis=1).mean()
        np.testing.assert_allclose(arrays["mean_curvature"] * size, 1.0, rtol=0.06)  # 32 samples on a coarse sphere
        np.testing.assert_allclose(
            size * np.abs(np.linalg.det(arrays["matrix_world"][:3, :3])) ** (1 / 3), RADIUS, rtol=1e-3
        )
        if suffix == ".stl":
            assert len(arrays["vertices"]) == len(cube_sphere(10)[0])
    if suffix == ".stl":
        assert "1,200 were welded into 602 vertices" in report()["notes"][0]
        assert "note: An STL file holds loose triangles" in ended.output


def test_stl_of_few_digits_is_welded_into_a_closed_surface(run, report, tmp_path):
    points, quads, _ = cube_sphere(6)
    noise = np.random.default_rng(3).uniform(-1e-6, 1e-6, (len(quads), 2, 3, 3))
    lines = ["solid sphere"]
    for number, quad in enumerate(quads):
        for side, corners in enumerate((quad[[0, 1, 2]], quad[[0, 2, 3]])):
            lines += ["facet normal 0 0 0", "outer loop"]
            lines += ["vertex {:.8f} {:.8f} {:.8f}".format(*row) for row in points[corners] + noise[number, side]]
            lines += ["endloop", "endfacet"]
    (tmp_path / "rough.stl").write_text("\n".join([*lines, "endsolid sphere", ""]))
    assert run("info", "rough.stl", "--json", "report.json").code == 0
    (row,) = report()["objects"]
    assert row["vertices"] == len(points)
    assert row["boundary_edges"] == 0


@pytest.mark.parametrize("suffix", [".stl", ".fbx", ".gltf"])
def test_broken_file_of_every_kind_is_one_sentence(run, tmp_path, suffix):
    (tmp_path / f"junk{suffix}").write_text("junk")
    ended = run("bake", f"junk{suffix}", *QUICK, "--output", "out.npz")
    assert ended.code == common.EXIT_INPUT
    sentence = ended.error.splitlines()[-1]  # this process' own streams also show what Python add-ons print
    assert sentence.startswith(f'paradesc: Blender cannot read "junk{suffix}": ')
    assert "Location" not in sentence
    assert not (tmp_path / "out.npz").exists()


# ---- Several objects


def test_all_objects_go_into_one_file_each_kind_in_its_way(run, report, tmp_path, three_objects):
    words = [word for name in ("a.npz", "a.ply", "a.png", "a.blend") for word in ("--output", name)]
    names = "mean_curvature,principal_direction_max"
    ended = run("bake", three_objects, "--all", "--descriptors", names, *QUICK, *words, "--json", "report.json")
    assert ended.code == 0, ended.error
    rows = report()["objects"]
    assert [row["object"] for row in rows] == ["first", "second/large", "twin"]
    assert rows[2]["notes"] == ['It shares the mesh of "first" and has its results.']
    assert any('"hidden" is disabled in renders' in note for note in report()["notes"])
    assert any('"bare" has no faces' in note for note in report()["notes"])
    with np.load(tmp_path / "a.npz") as file:
        arrays = dict(file)
    assert {name.rpartition("/")[0] for name in arrays} == {"first", "second/large", "twin"}
    np.testing.assert_array_equal(arrays["first/mean_curvature"], arrays["twin/mean_curvature"])
    np.testing.assert_allclose(arrays["twin/matrix_world"][:3, 3], (0, 10, 0))
    counts = [len(cube_sphere(steps)[0]) for steps in (6, 8, 6)]
    assert decode((tmp_path / "a.png").read_bytes()).std() > 1
    from cli_test import read_ply

    vertices, faces = read_ply(tmp_path / "a.ply")
    assert len(vertices) == sum(counts)
    assert faces["vertices"].max() == len(vertices) - 1
    large = np.stack([vertices[axis] for axis in "xyz"], axis=1)[counts[0] : counts[0] + counts[1]]
    np.testing.assert_allclose(np.linalg.norm(large - (10, 0, 0), axis=1), 2 * RADIUS, rtol=1e-5)
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "a.blend"))
    for name in ("first", "second/large"):
        found = attribute_values(bpy.data.objects[name].data, "mean_curvature")
        np.testing.assert_array_equal(found, arrays[f"{name}/mean_curvature"])
    assert "mean_curvature" not in bpy.data.objects["hidden"].data.attributes


def test_images_of_several_objects_are_a_file_each(run, report, tmp_path, three_objects):
    words = ("--object", "first", "--object", "second/large", "--texels", "64", "--map", "m.exr", "--map", "m.png")
    ended = run("bake", three_objects, *words, *QUICK, "--dump-buffers", "dump", "--json", "report.json")
    assert ended.code == 0, ended.error
    stems = ("m_first", "m_second_large")
    assert sorted(path.name for path in tmp_path.glob("m_*")) == [f"{s}{e}" for s in stems for e in (".exr", ".png")]
    assert (tmp_path / "dump" / "second_large" / "buffers.npz").is_file()
    assert {row["object"] for row in report()["maps"]} == {"first", "second/large"}


def test_bad_object_among_several_is_named(run, tmp_path, three_objects):
    bpy.ops.wm.open_mainfile(filepath=str(three_objects))
    bpy.data.objects["second/large"].data.vertices[3].co.x = float("nan")
    ended = run("bake", "--all", *QUICK, "--output", "out.npz")
    assert ended.code == common.EXIT_INPUT
    assert 'Object "second/large": ' in ended.error
    assert not (tmp_path / "out.npz").exists()


def test_shapes_of_bones_are_no_objects(run, tmp_path, three_objects):
    bpy.ops.wm.open_mainfile(filepath=str(three_objects))
    rig = bpy.data.objects.new("rig", bpy.data.armatures.new("rig"))
    bpy.context.collection.objects.link(rig)
    bpy.context.view_layer.objects.active = rig
    bpy.ops.object.mode_set(mode="EDIT")
    rig.data.edit_bones.new("bone").tail = (0, 0, 1)
    bpy.ops.object.mode_set(mode="OBJECT")
    rig.pose.bones[0].custom_shape = bpy.data.objects["second/large"]
    ended = run("bake", "--all", *QUICK, "--output", "out.npz")
    assert 'The object "second/large" is the shape of a bone and was left out.' in ended.output
    with np.load(tmp_path / "out.npz") as arrays:
        assert {name.rpartition("/")[0] for name in arrays.files} == {"first", "twin"}
    assert "second/large" not in run("info").output


def test_world_space_counts_the_scale_of_each_object(run, tmp_path, three_objects):
    bpy.ops.wm.open_mainfile(filepath=str(three_objects))
    bpy.data.objects["twin"].scale = (3, 3, 3)
    saved_scene(three_objects)
    words = ("--all", *QUICK, "--space", "world", "--output", "a.npz", "--output", "a.blend")
    ended = run("bake", three_objects, *words)
    assert ended.code == 0, ended.error
    with np.load(tmp_path / "a.npz") as arrays:
        for name, scale in (("first", 1), ("second/large", 2), ("twin", 3)):
            found = arrays[f"{name}/mean_curvature"]
            np.testing.assert_allclose(found, 1 / (scale * RADIUS), rtol=0.06)  # 32 samples on a coarse sphere
            np.testing.assert_allclose(np.linalg.norm(arrays[f"{name}/vertices"], axis=1), RADIUS, rtol=1e-5)
    assert "it was measured as" in ended.output


def test_uneven_scale_that_is_not_measured_is_said(run, three_objects):
    bpy.ops.wm.open_mainfile(filepath=str(three_objects))
    bpy.data.objects["first"].scale = (1, 1, 2)
    assert "give --space world" in run("bake", "--object", "first", *QUICK, "--output", "a.npz").output


def test_shape_key_is_measured_where_asked_for(run, report, tmp_path):
    empty_scene()
    target = add_sphere(steps=6)
    target.shape_key_add(name="Basis")
    key = target.shape_key_add(name="half")
    points = 0.5 * cube_sphere(6)[0]
    key.data.foreach_set("co", points.astype(np.float32).ravel())
    target.active_shape_key_index = 1
    path = saved_scene(tmp_path / "keys.blend")
    for shape, size in (("basis", 1.0), ("active", 0.5)):
        words = ("--shape-key", shape, "--output", f"{shape}.npz", "--json", "report.json")
        assert run("bake", path, *QUICK, *words).code == 0
        with np.load(tmp_path / f"{shape}.npz") as arrays:
            np.testing.assert_allclose(arrays["mean_curvature"] * size * RADIUS, 1, rtol=0.06)
    assert report()["objects"][0]["notes"] == ['The shape key "half" was measured, at its full value.']


def test_directions_are_turned_with_their_object():
    arrays = bridge.MeshArrays(np.zeros((2, 3), np.float32), np.zeros(0, np.int32), np.zeros((0, 3), np.int32))
    turned = np.array([[0, -2, 0, 5], [2, 0, 0, 0], [0, 0, 2, 0], [0, 0, 0, 1.0]])

    class Found:
        settings = job.Settings()
        values = {"principal_direction_max": np.array([[1, 0, 0], [np.nan] * 3], np.float32)}

    found = results.world_values(results.Baked("a", Found(), arrays, turned), "principal_direction_max")
    np.testing.assert_allclose(found, [[0, 1, 0], [np.nan] * 3])


# ---- Reports, checks and codes


def test_report_has_its_documented_keys(run, report, sphere_obj):
    assert run("bake", sphere_obj, *QUICK, "--json", "report.json").code == 0
    found = report()
    assert found["schema"] == 1
    assert (found["status"], found["exit_code"], found["error"]) == ("ok", 0, None)
    readme = (ADDON / "README.md").read_text()
    for name in [*found, *found["objects"][0], *found["seconds"]]:
        assert f"`{name}`" in readme, f"{name} is not in the manual"
    assert found["seconds"]["compute"] > 0


def test_failure_leaves_a_report_that_says_why(run, report):
    ended = run("bake", "nothing.obj", "--output", "out.npz", "--json", "report.json")
    found = report()
    assert (found["status"], found["exit_code"]) == ("failed", common.EXIT_INPUT) == ("failed", ended.code)
    assert ended.error.strip() == f"paradesc: {found['error']}"


def test_report_on_the_standard_output_is_alone_there(run, sphere_obj):
    ended = run("bake", sphere_obj, *QUICK, "--json", "-")
    assert json.loads(ended.output)["objects"][0]["object"] == "sphere"


def test_quiet_prints_nothing(run, sphere_obj):
    ended = run("bake", sphere_obj, *QUICK, "--output", "out.npz", "--json", "report.json", "--quiet")
    assert (ended.code, ended.output, ended.error) == (0, "", "")


def test_progress_as_lines_ends_with_all_of_it(run, sphere_obj):
    ended = run("bake", sphere_obj, *QUICK, "--output", "out.npz", "--progress", "lines")
    lines = ended.error.splitlines()
    shares = [int(line.split()[1].rstrip("%")) for line in lines]
    assert all(line.startswith("Progress: ") for line in lines)
    assert shares == sorted(shares)
    assert 1 < len(shares) < 25


@pytest.mark.parametrize(
    ("words", "code", "sentence"),
    [
        ([], 0, ""),
        (["--fail-under-coverage", "0.9", "--fail-over-undefined", "0"], 0, ""),
        (["--fail-under-coverage", "1.5"], 5, "below the 1.5 asked for"),
        (["--radius", "0.01", "--fail-on-warnings"], 5, "texels"),
        (["--descriptors", "nothing"], 2, "no descriptor"),
        (["--samples", "0"], 2, "samples"),
        (["--all", "--object", "a"], 2, "not both"),
        (["--object", "nobody"], 3, "nobody"),
        (["--device", "1000"], 4, "1000"),
        (["--backend", "reference", "--dump-buffers", "d"], 2, "reference"),
    ],
    ids=str,
)
def test_code_says_what_went_wrong(run, report, tmp_path, sphere_obj, words, code, sentence):
    ended = run("bake", sphere_obj, *QUICK, "--output", "out.npz", "--json", "report.json", *words)
    assert ended.code == code, ended.error
    assert sentence in ended.error
    assert (tmp_path / "out.npz").exists() == (code in (0, 5))
    assert report()["exit_code"] == code


def test_undefined_vertices_can_fail_a_bake(run, tmp_path):
    empty_scene()
    mesh = bpy.data.meshes.new("loose")
    mesh.from_pydata([(0, 0, 0), (1, 0, 0), (0, 1, 0), (5, 5, 5)], [], [(0, 1, 2)])
    bpy.context.collection.objects.link(bpy.data.objects.new("loose", mesh))
    path = saved_scene(tmp_path / "loose.blend")
    words = ("bake", path, *QUICK, "--output", "out.npz", "--fail-over-undefined")
    assert run(*words, "0.25").code == 0
    ended = run(*words, "0.2")
    assert ended.code == 5
    assert "0.25 of the vertices are undefined" in ended.error


def test_missing_library_is_a_missing_device(run, sphere_obj, monkeypatch):
    def missing(*_words):
        raise bridge.ParadescError(bridge.abi.STATUS_UNSUPPORTED, "native library missing.")

    monkeypatch.setattr(bridge, "Context", missing)
    assert run("bake", sphere_obj, "--output", "out.npz").code == common.EXIT_DEVICE


def test_compare_fails_over_an_error_that_is_too_large(run, report, sphere_obj):
    ended = run("compare", sphere_obj, *QUICK, "--fail-over-error", "1e-9", "--json", "report.json")
    assert ended.code == 5
    assert "mean_curvature" in ended.error
    assert report()["status"] == "check failed"
    assert report()["rows"][0]["descriptor"] == "mean_curvature"


def test_terminated_computation_is_one_sentence_and_leaves_no_file(run, tmp_path):
    path = write_obj(tmp_path / "fine.obj", *cube_sphere(60))
    timer = threading.Timer(0.7, os.kill, (os.getpid(), signal.SIGTERM))
    timer.start()
    try:
        ended = run(
            "bake", path, "--radius", "0.3", "--samples", "4096", "--backend", "software", "--output", "out.npz"
        )
    finally:
        timer.join()
    assert (ended.code, ended.error) == (143, "paradesc: Terminated.\n")
    assert [path.name for path in tmp_path.iterdir()] == ["fine.obj"]


def test_writer_that_is_stopped_leaves_the_old_file(tmp_path):
    (tmp_path / "out.npz").write_bytes(b"old")

    def stopped(path, _content):
        path.write_bytes(b"half")
        raise common.Terminated

    with pytest.raises(common.Terminated):
        results.write_whole(tmp_path / "out.npz", None, stopped)
    assert [path.name for path in tmp_path.iterdir()] == ["out.npz"]
    assert (tmp_path / "out.npz").read_bytes() == b"old"


def test_input_is_written_over_only_by_force(run, tmp_path):
    empty_scene()
    add_sphere(steps=6)
    path = saved_scene(tmp_path / "scene.blend")
    before = path.read_bytes()
    ended = run("bake", path, *QUICK, "--output", "scene.blend")
    assert ended.code == 2
    assert "--force" in ended.error
    assert path.read_bytes() == before
    bpy.ops.wm.open_mainfile(filepath=str(path))
    assert run("bake", *QUICK, "--output", "scene.blend").code == 2
    assert path.read_bytes() == before
    assert run("bake", path, *QUICK, "--output", "scene.blend", "--force").code == 0
    bpy.ops.wm.open_mainfile(filepath=str(path))
    assert "mean_curvature" in bpy.data.objects["sphere"].data.attributes


# ---- The manual


def documented_commands():
    """Every command line of the two manuals, as words after the program."""
    for path in (ADDON.parent / "README.md", ADDON / "README.md"):
        blocks = re.findall(r"```(?:sh|yaml)\n(.*?)```", path.read_text().replace("\\\n", " "), re.DOTALL)
        for line in "\n".join(blocks).splitlines():
            found = re.search(r"(?:-m paradesc|-c paradesc|cli\.py --) (.+?)(?: \|\| .*)?$", line)
            if found:
                yield shlex.split(found[1], comments=True)


def test_every_command_in_the_manual_is_one():
    words = list(documented_commands())
    assert {line[0] for line in words} >= {"bake", "compare", "info", "list"}
    for line in words:
        if line[0] in COMMANDS:
            make_parser().parse_args(line)


# ---- info and list


def test_info_foresees_the_texels_of_a_bake(run, report, sphere_obj):
    assert run("info", sphere_obj, "--json", "report.json").code == 0
    (row,) = report()["objects"]
    assert row["uv_map"] == {"name": "UVMap", "fault": "", "charts": 6, "seam_edges": 168}
    assert not any(row["defects"].values())
    hint = row["suggested"]
    assert hint["radius_in_texels"] >= 4
    words = ("--radius", hint["radius"], "--buffer", hint["buffer"], "--samples", "16", "--backend", "software")
    assert run("bake", sphere_obj, *words, "--json", "bake.json").code == 0
    found = report("bake.json")["objects"][0]["field_report"]["radius_in_texels"]
    np.testing.assert_allclose(found, hint["radius_in_texels"], rtol=0.1)  # a median over triangles, not over vertices


def test_info_tells_what_is_wrong_with_each_object(run, tmp_path, three_objects):
    bpy.ops.wm.open_mainfile(filepath=str(three_objects))
    first = bpy.data.objects["first"]
    first.data.uv_layers[0].data.foreach_set("uv", np.zeros(2 * len(first.data.loops), np.float32))
    first.modifiers.new("s", "SUBSURF")
    saved_scene(three_objects)
    ended = run("info", three_objects)
    assert ended.code == 0
    assert 'object "bare": The mesh "bare" has no faces' in ended.output
    assert "has a UV map without area; it is unwrapped for a bake" in ended.output
    assert ended.output.count("object ") == 5
    assert run("info", three_objects, "--object", "twin").output.count("object ") == 1


def test_list_describes_descriptors_and_devices(run, report):
    ended = run("list", "--json", "report.json")
    assert ended.code == 0
    rows = {row["name"]: row for row in report()["descriptors"]}
    assert list(rows) == [row.name for row in bridge.descriptors()]
    assert rows["gaussian_curvature"]["unit"] == "1/length^2"
    assert rows["principal_direction_max"]["kind"] == "direction"
    assert rows["harris"]["kind"] == "operator"
    devices = report()["devices"]
    assert list(dict.fromkeys(row["backend"] for row in devices)) == ["gpu", "software", "reference"]
    for row in devices:
        assert bool(row["device"]) != bool(row["missing"])
        assert row["missing"] in ended.output
    assert [row["index"] for row in devices if row["backend"] == "reference"] == [None]


# ---- The add-on


@pytest.fixture
def addon():
    """The add-on, registered."""
    paradesc.register()
    yield
    if hasattr(bpy.types.Scene, "paradesc"):
        paradesc.unregister()


def test_panel_settings_of_a_file_are_taken_and_options_go_first(run, report, tmp_path, addon):
    empty_scene()
    add_sphere(steps=6)
    group = bpy.context.scene.paradesc
    group.descriptors, group.radius_unit, group.radius_edges = {"curvedness", "cavity"}, "mean-edge", 2.5
    group.samples, group.buffer_size, group.backend, group.space = 24, 128, "software", "world"
    path = saved_scene(tmp_path / "scene.blend")
    paradesc.unregister()
    words = ("--scene-settings", "--samples", "16", "--output", "out.npz", "--json", "report.json")
    assert run("bake", path, *words).code == 0
    found = report()["settings"]
    assert found["descriptors"] == ["curvedness", "cavity"]
    assert (found["radius"], found["radius_unit"]) == (2.5, "mean-edge")
    assert (found["samples"], found["buffer_size"], found["backend"]) == (16, 128, "software")
    assert found["space"] == "world"
    assert not hasattr(bpy.types.Scene, "paradesc")


def test_preset_says_what_and_how_and_options_go_first(run, report, sphere_obj):
    words = ("--backend", "software", "--buffer", "128", "--output", "out.npz", "--json", "report.json")
    assert run("bake", sphere_obj, "--preset", "edge_wear", *words).code == 0
    found = report()["settings"]
    assert (found["descriptors"], found["radius"], found["samples"]) == (["convexity"], 0.015, 128)
    assert (found["buffer_size"], found["backend"]) == (128, "software")
    ended = run("bake", sphere_obj, "--preset", "wear", *words)
    assert ended.code == 2
    assert "edge_wear" in ended.error


def test_every_preset_of_the_panel_is_one_here():
    from paradesc import presets
    from paradesc.commands.options import with_preset

    for name in presets.PRESETS:
        settings = with_preset(name, None)
        job.check_descriptors(settings.descriptors)
        assert set(settings.descriptors) == presets.PRESETS[name].members["descriptors"]


def test_blender_gets_the_command_where_it_knows_commands(run, monkeypatch, sphere_obj):
    known, taken = {}, []

    def keep(name, function):
        known[name] = function
        return name

    monkeypatch.setattr(bpy.utils, "register_cli_command", keep, raising=False)
    monkeypatch.setattr(bpy.utils, "unregister_cli_command", taken.append, raising=False)
    cli_command.register()
    assert known["paradesc"](["bake", str(sphere_obj), *QUICK, "--output", "out.npz"]) == 0
    assert known["paradesc"](["bake", "nothing.obj", "--output", "out.npz"]) == common.EXIT_INPUT
    cli_command.unregister()
    cli_command.unregister()
    assert taken == ["paradesc"]


@pytest.mark.skipif(not bpy.app.binary_path or bpy.app.version < (4, 2), reason="needs Blender 4.2's own executable")
def test_enabled_addon_answers_to_blenders_own_command_option(tmp_path, sphere_obj):
    (tmp_path / "scripts" / "addons").mkdir(parents=True)
    (tmp_path / "scripts" / "addons" / "paradesc").symlink_to(ADDON / "paradesc")
    start = [bpy.app.binary_path, "--factory-startup", "--addons", "paradesc", "-c", "paradesc"]
    for words, code in ((["bake", sphere_obj, *QUICK, "--output", "out.npz"], 0), (["info", "nothing.obj"], 3)):
        process = subprocess.run(
            [*start, *map(str, words)],
            cwd=tmp_path,
            env={**os.environ, "BLENDER_USER_SCRIPTS": str(tmp_path / "scripts")},
            capture_output=True, text=True, timeout=120, check=False,
        )  # fmt: skip
        assert process.returncode == code, process.stdout + process.stderr
    assert (tmp_path / "out.npz").is_file()


def test_older_blender_without_commands_is_left_alone(monkeypatch):
    monkeypatch.delattr(bpy.utils, "register_cli_command", raising=False)
    cli_command.register()
    assert cli_command.handles == []


SCRIPT = """
import sys
sys.path[:0] = {paths!r}
import bpy, paradesc
from scene import add_sphere, empty_scene
paradesc.register()
empty_scene()
target = add_sphere(steps=8)
settings = bpy.context.scene.paradesc
settings.descriptors = {{"mean_curvature", "shape_index"}}
settings.radius_percent = 8
settings.samples, settings.buffer_size, settings.backend = 32, 128, "software"
assert bpy.ops.paradesc.bake() == {{"FINISHED"}}
assert "shape_index_color" in target.data.attributes
from paradesc.commands.main import main
files = ["--output", "a.png", "--output", "a.exr", "--texels", "64", "--json", "a.json"]
code = main(["bake", "--scene-settings", "--descriptors", "shape_index", "--quiet", *files])
bpy.ops.wm.save_as_mainfile(filepath={blend!r})
sys.exit(code)
"""


def test_script_bakes_as_the_panel_does_and_writes_files(tmp_path, report):
    script = tmp_path / "script.py"
    script.write_text(
        SCRIPT.format(paths=[str(ADDON), str(ADDON.parent / "tests" / "addon")], blend=str(tmp_path / "a.blend"))
    )
    start = [bpy.app.binary_path, "-b", "--factory-startup", "-P"] if bpy.app.binary_path else [sys.executable]
    words = [*start, str(script)]
    process = subprocess.run(
        words, cwd=tmp_path, env=environment(), capture_output=True, text=True, timeout=120, check=False
    )
    assert process.returncode == 0, process.stdout + process.stderr
    assert decode((tmp_path / "a.png").read_bytes()).std() > 10
    assert (tmp_path / "a.exr").read_bytes().startswith(b"\x76\x2f\x31\x01")
    assert report("a.json")["settings"]["radius"] == pytest.approx(0.08)
    assert list(report("a.json")["objects"][0]["descriptors"]) == ["shape_index"]
    assert (tmp_path / "a.blend").is_file()
