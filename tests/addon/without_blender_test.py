"""In a Python with numpy and without bpy, what needs no Blender works, and what needs it says so."""

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from mesh_kinds import NEURO, SOUND
from paradesc.files import cache, exr
from shapes import ADDON, RADIUS, cube_sphere, write_obj

COMMANDS = ("bake", "animate", "library", "tasks", "compare", "info", "list")


@pytest.fixture
def python(tmp_path):
    """Runs a Python whose path has only numpy and the package, as a wheel installs it."""
    modules = tmp_path / "modules"
    modules.mkdir()
    for path in Path(np.__file__).parents[1].glob("numpy*"):
        (modules / path.name).symlink_to(path)
    (modules / "paradesc").symlink_to(ADDON / "paradesc")

    def run(*words):
        return subprocess.run(
            [sys.executable, "-S", *words],
            env={**os.environ, "PYTHONPATH": str(modules), "PYTHONNOUSERSITE": "1"},
            cwd=tmp_path,
            capture_output=True,
            text=True,
            timeout=120,
            check=False,
        )

    assert run("-c", "import numpy").returncode == 0
    assert "ModuleNotFoundError" in run("-c", "import bpy").stderr
    return run


def test_the_package_and_every_command_can_be_imported(python):
    code = "import paradesc, paradesc.cli, paradesc.commands as commands\n"
    code += "from paradesc.commands.main import main, make_parser\n"
    code += "print(*[module.__name__.split('.')[-1] for module in commands.modules()])\n"
    done = python("-c", code)
    assert done.returncode == 0, done.stderr
    assert tuple(done.stdout.split()) == COMMANDS


@pytest.mark.parametrize("words", [(), *[(name,) for name in COMMANDS]])
def test_help_is_given(python, words):
    done = python("-m", "paradesc", *words, "--help")
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("usage: paradesc")
    assert not done.stderr


def test_descriptors_and_devices_are_listed(python):
    done = python("-m", "paradesc", "list", "--json", "-")
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    assert "mean_curvature" in [row["name"] for row in found["descriptors"]]
    assert "reference" in [row["backend"] for row in found["devices"]]


def sphere_obj(folder, name="sphere.obj", size=(1, 1, 1), with_uvs=True):
    points, quads, uvs = cube_sphere(4)
    return write_obj(folder / name, points * size, quads, uvs if with_uvs else None)


def report_of(done):
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


# ---- What needs Blender


def test_a_file_that_only_blender_opens_says_so_in_one_sentence(python, tmp_path):
    (tmp_path / "scene.blend").write_bytes(b"BLENDER")
    done = python("-m", "paradesc", "bake", "scene.blend", "--output", "out.npz")
    assert (done.returncode, done.stdout) == (4, "")
    assert done.stderr == (
        'paradesc: Blender\'s Python module bpy is not installed here to open "scene.blend"; pip install bpy and '
        "put the folder that holds paradesc_blender on PYTHONPATH, or give "
        "one of .obj, .ply, .stl, .glb, .gltf, .off, .vtp, .vtk, .gii, .white, .pial, .smoothwm, .inflated, .orig, "
        ".sphere.\n"
    )


REFUSALS = [
    (("bake", "sphere.obj", "--output", "out.blend"), 4, "A .blend is written by Blender, and"),
    (("bake", "sphere.obj", "-o", "o.npz", "--scene-settings"), 4, "--scene-settings takes the panel's settings"),
    (("bake", "sphere.obj", "-o", "o.npz", "--preset", "wear"), 2, "choose one of cavity, edge_wear, curvature"),
    (("bake", "sphere.obj", "-o", "o.npz", "--displacement", "x.png"), 3, 'There is no image "x.png"'),
    (
        ("bake", "sphere.obj", "-o", "o.npz", "--displacement", "x.tif"),
        3,
        "is none of .png, .exr, which are read",
    ),
    (("bake", "bare.obj", "-o", "o.npz", "--displacement", "x.png"), 3, "has no UV map for displacement and normal"),
    (("bake", "sphere.obj", "-o", "o.npz", "--normal-map", "x.png"), 3, "has no normals for"),
    (("bake", "sphere.obj", "-o", "o.npz", "--from", "x", "--displacement", "x.png"), 2, "Maps belong to the mesh"),
    (("bake", "sphere.obj", "-o", "o.npz", "--material-maps"), 4, "--material-maps takes images from"),
    (("bake", "sphere.obj", "-o", "o.npz", "--from-file", "x.obj"), 3, 'There is no file "x.obj"'),
    (("bake", "sphere.obj", "-o", "o.npz", "--from-file", "scene.fbx"), 4, '"scene.fbx" is opened by Blender, and'),
    (("bake", "sphere.obj", "-o", "o.npz", "--pairs"), 3, "No mesh object has a name that ends in _low"),
    (("bake", "sphere.obj", "-o", "o.npz", "--pairs", "--object", "sphere"), 3, 'is named as "sphere" with _high'),
    (("bake", "low.obj", "--from-file", "high.ply", "-o", "high.ply"), 2, '"high.ply" is the input; add --force'),
    (("bake", "sphere.obj", "--displacement", "h.exr", "--map", "h.exr"), 2, '"h.exr" is the input; add --force'),
    (("bake", "sphere.obj", "-o", "o.npz", "--from", "ball"), 3, 'There is no object "ball"; mesh objects: "sphere"'),
    (("bake", "sphere.obj", "-o", "o.npz", "--from", "sphere"), 2, "cannot be detailed and low-poly at once"),
    (("bake", "bare.obj", "-o", "o.npz", "--from-file", "sphere.obj"), 3, "has no UV map"),
    (("bake", "sphere.obj", "-o", "o.npz", "--cage", "1"), 2, "give --from, --from-file or --pairs"),
    (("bake", "sphere.obj", "-o", "o.npz", "--reader", "blender"), 4, "leave --reader blender out"),
    (("bake", "bare.obj", "--map", "o.exr"), 3, "has no UV map, and without Blender it cannot be unwrapped"),
    (("bake", "bare.obj", "-o", "o.npz", "--evaluate", "texel"), 3, "it cannot be unwrapped"),
    (("bake", "sphere.obj", "-o", "o.npz", "--normals", "mesh"), 3, "has no normals"),
    (("bake", "sphere.obj", "-o", "o.npz", "--object", "cube"), 3, 'There is no object "cube"'),
    (("bake", "gone.obj", "-o", "o.npz"), 3, 'There is no file "gone.obj"'),
    (("bake", "gone.blend", "-o", "o.npz"), 3, 'There is no file "gone.blend"'),
    (("bake", "-o", "o.npz"), 2, "INPUT is missing"),
    (("animate", "sphere.obj", "--cache", "c"), 2, "is one mesh and no animation"),
    (("animate", "x_####.ply", "--cache", "c"), 3, "has a number in its name"),
    (("animate", "nowhere/x_####.ply", "--cache", "c"), 3, 'There is no folder "nowhere"'),
    (("info", "ball.stl"), 3, "has no faces"),
]
# Runs the command line many times in one process; gives each code with what was said.
MANY = """
import contextlib, io, json, sys
from paradesc.cli import main
for words in json.loads(sys.argv[1]):
    said, printed = io.StringIO(), io.StringIO()
    with contextlib.redirect_stderr(said), contextlib.redirect_stdout(printed):
        code = main(words)
    print(json.dumps([code, said.getvalue(), printed.getvalue()]))
"""


def many(python, runs):
    """[code, standard error, standard output] of each run."""
    done = python("-c", MANY, json.dumps(runs))
    assert done.returncode == 0, done.stderr
    return [json.loads(line) for line in done.stdout.splitlines()]


def test_what_needs_more_says_so_in_one_sentence(python, tmp_path):
    sphere_obj(tmp_path)
    sphere_obj(tmp_path, "bare.obj", with_uvs=False)
    (tmp_path / "ball.stl").write_text("solid\nendsolid\n")
    (tmp_path / "scene.fbx").write_bytes(b"Kaydara")
    results = many(python, [words for words, _, _ in REFUSALS])
    for (words, code, sentence), (given, said, printed) in zip(REFUSALS, results, strict=True):
        assert (given, printed) == (code, ""), words
        assert sentence in said, words
        assert said.count("\n") == 1, words
    assert not list(tmp_path.glob("o.*"))


# ---- What works with numpy alone


def test_a_file_is_baked_into_all_kinds_of_files(python, tmp_path):
    sphere_obj(tmp_path)
    outputs = ["out.npz", "out.ply", "out.vtp", "out.vtk", "out.exr"]
    more = [word for name in outputs for word in ("--output", name)]
    descriptors = "mean_curvature,principal_direction_max"
    done = python(
        "-m", "paradesc", "bake", "sphere.obj", *more, "--map", "map.png", "--descriptors", descriptors, "--radius",
        "0.1", "--texels", "64", "--json", "-",
    )  # fmt: skip
    report = report_of(done)
    assert report["outputs"][: len(outputs) - 1] == outputs[:-1]
    assert all((tmp_path / name).stat().st_size for name in outputs)
    assert report["objects"][0]["object"] == "sphere"
    assert report["backend"] == "cpu"
    found = np.load(tmp_path / "out.npz")
    assert found["vertices"].shape == (98, 3)
    assert np.allclose(found["mean_curvature"], 0.5, rtol=0.05)


def test_a_preset_gives_the_bits_of_the_same_options(python, tmp_path):
    sphere_obj(tmp_path)
    settings = {"descriptors": ["harris", "cavity"], "radius_percent": 9.7, "more_radii": "14.1; 20", "samples": 99,
                "harris_k": 0.05, "corner_threshold": 7.3, "estimator": "integral", "creases": "none"}  # fmt: skip
    colors = {"color_map": "heat", "span": "fixed", "minimum": -0.5, "maximum": 0.75}
    about = {"paradesc_preset": 1, "name": "Studio", "settings": settings, "colors": colors, "image": {"texels": 64}}
    (tmp_path / "studio.json").write_text(json.dumps(about))
    words = ("--descriptors", "cavity,harris", "--radius", "0.097,0.141,0.2", "--samples", "99", "--harris-k", "0.05",
             "--corner-threshold", "0.073", "--estimator", "integral", "--creases", "none", "--texels", "64",
             "--color-map", "heat", "--range=-0.5:0.75")  # fmt: skip
    runs = {"preset": ("--preset", "studio.json"), "options": words, "packaged": ("--preset", "edge_wear")}
    outputs = {name: ["-o", f"{name}.npz", "-o", f"{name}.exr", "--json", f"{name}.report"] for name in runs}
    for code, said, _ in many(python, [["bake", "sphere.obj", *outputs[name], *runs[name]] for name in runs]):
        assert (code, said) == (0, "")
    preset, options = (np.load(tmp_path / f"{name}.npz") for name in ("preset", "options"))
    assert set(preset) == set(options) >= {"harris_r0.097", "cavity_r0.2"}
    for name in preset:
        assert preset[name].tobytes() == options[name].tobytes(), name
    assert (tmp_path / "preset.exr").read_bytes() == (tmp_path / "options.exr").read_bytes()
    reports = {name: json.loads((tmp_path / f"{name}.report").read_text()) for name in runs}
    assert reports["preset"]["settings"] == reports["options"]["settings"]
    assert reports["packaged"]["settings"]["descriptors"] == ["convexity"]
    assert reports["packaged"]["settings"]["radius_fit"] == "medium"


def test_detail_comes_from_meshes_without_a_uv_map_too(python, tmp_path):
    write_obj(tmp_path / "low.obj", *cube_sphere(4))
    write_obj(tmp_path / "high.obj", *cube_sphere(20)[:2])
    words = ("-m", "paradesc", "bake", "low.obj", "--from-file", "high.obj", "--radius", "0.08", "--texels", "48")
    report = report_of(python(*words, "--map", "x.exr", "-o", "x.npz", "--json", "-"))
    (row,) = report["objects"]
    assert (row["object"], row["transfer"]["sources"], row["transfer"]["missed"]) == ("sphere", ["sphere"], 0)
    found = np.load(tmp_path / "x.npz")
    np.testing.assert_allclose(found["mean_curvature"], 0.5, atol=2e-3)
    assert len(found["mean_curvature"]) == len(found["vertices"]) == 98
    assert (tmp_path / "x.exr").stat().st_size


def test_frames_are_displaced_by_an_image_and_gone_on_with(python, tmp_path):
    images = pytest.importorskip("OpenImageIO", reason="OpenImageIO is not installed")
    for frame, size in ((1, (1, 1, 1)), (2, (1, 1, 1.5))):
        sphere_obj(tmp_path, f"ball_{frame}.obj", size)
    write_obj(tmp_path / "ball_3.obj", *cube_sphere(5))
    heights = np.add.outer(*2 * [np.sin(np.arange(64) / 4)]).astype(np.float32)
    exr.write_exr(tmp_path / "h.exr", {"Y": heights})
    words = ("-m", "paradesc", "animate", "ball_#.obj", "--radius", "0.1", "--json", "-", "--displacement", "h.exr")
    refused = python(*words)
    assert refused.returncode == 3
    assert "it needs OpenImageIO, which is not installed; pip install paradesc[io]." in refused.stderr
    (tmp_path / "modules" / "OpenImageIO").symlink_to(Path(images.__file__).parent)
    report = report_of(python(*words, "--displacement-scale", "0.1"))
    (done,) = report["objects"]
    assert done["made"] == [1, 2, 3]
    frames = [cache.read_frame(cache.frame_path(tmp_path / done["folder"], frame)) for frame in (1, 2, 3)]
    assert all(np.ptp(frame.values["mean_curvature"]) > 0.3 for frame in frames)  # of a sphere they are all 1/2
    (done,) = report_of(python(*words, "--displacement-scale", "0.1"))["objects"]
    assert done["kept"] == [1, 2, 3]
    (done,) = report_of(python(*words, "--displacement-scale", "0.2"))["objects"]
    assert done["made"] == [1, 2, 3]
    refused = python(*words[:-2], "--normal-map", "h.exr")
    assert (refused.returncode, "Normal maps are followed in single bakes only" in refused.stderr) == (3, True)


def test_every_command_takes_a_preset(python, tmp_path):
    (tmp_path / "frames").mkdir()
    sphere_obj(tmp_path / "frames", "ball_1.obj")
    preset = ["--preset", "cavity", "--json", "r.json"]
    runs = [["animate", "frames"], ["compare", "frames/ball_1.obj"], ["library", "frames", "--output", "out"]]
    for words, (code, said, _) in zip(runs, many(python, [[*words, *preset] for words in runs]), strict=True):
        assert (code, said) == (0, ""), words


def test_info_and_compare_take_files(python, tmp_path):
    sphere_obj(tmp_path)
    (row,) = report_of(python("-m", "paradesc", "info", "sphere.obj", "--json", "-"))["objects"]
    assert (row["vertices"], row["faces"], row["uv_map"]["fault"], row["uv_map"]["charts"]) == (98, 96, "", 6)
    report = report_of(python("-m", "paradesc", "compare", "sphere.obj", "--radius", "0.1", "--json", "-"))
    assert report["rows"][0]["mean_percent_ae"] < 1


def test_a_sequence_of_files_is_baked_as_an_animation_and_gone_on_with(python, tmp_path):
    (tmp_path / "frames").mkdir()
    for frame in (1, 2, 3):
        sphere_obj(tmp_path / "frames", f"ball_{frame:04}.obj", (1, 1, frame))
    words = ("-m", "paradesc", "animate", "frames", "--relative-to-rest", "--radius", "0.1", "--json", "-")
    (done,) = report_of(python(*words, "--frames", "1:2"))["objects"]
    assert (done["object"], done["made"], done["kept"]) == ("ball", [1, 2], [])
    (done,) = report_of(python(*words))["objects"]
    assert (done["made"], done["kept"]) == ([3], [1, 2])
    first, third = (cache.read_frame(cache.frame_path(tmp_path / done["folder"], frame)) for frame in (1, 3))
    assert np.abs(first.values["mean_curvature_change"]).max() == 0
    assert np.abs(third.values["mean_curvature_change"]).max() > 0.1


def test_frames_with_other_faces_are_baked_and_have_no_change(python, tmp_path):
    sphere_obj(tmp_path, "a1.obj")
    write_obj(tmp_path / "a2.obj", *cube_sphere(5))
    words = ("-m", "paradesc", "animate", "a#.obj", "--cache", "c", "--radius", "0.1", "--json", "-")
    (done,) = report_of(python(*words))["objects"]
    assert done["made"] == [1, 2]
    refused = python(*words, "--relative-to-rest")
    assert refused.returncode == 3
    assert "Frame 2 has other faces than the first file" in refused.stderr


def test_files_of_all_formats_are_read_where_only_numpy_is_beside_it(python, tmp_path):
    kinds = {suffix: content for (suffix, _), content in reversed(SOUND.items()) if suffix not in NEURO}
    for suffix, content in kinds.items():
        (tmp_path / f"ball{suffix}").write_bytes(content)
    more = ("--radius", "0.2", "--space", "world", "--all")
    runs = [
        ["bake", f"ball{kind}", "--output", f"{kind[1:]}.npz", "--json", f"{kind[1:]}.json", *more] for kind in kinds
    ]
    for kind, (code, said, _) in zip(kinds, many(python, runs), strict=True):
        assert (code, said) == (0, "")
        report = json.loads((tmp_path / f"{kind[1:]}.json").read_text())
        assert report["objects"][0]["mesh_report"]["triangle_count"] == 432
        assert np.allclose(np.load(tmp_path / f"{kind[1:]}.npz")["mean_curvature"], 1 / RADIUS, rtol=0.05)


def test_files_of_brains_say_what_to_install_where_only_numpy_is_beside_it(python, tmp_path):
    for suffix in NEURO:
        (tmp_path / f"lh{suffix}").write_bytes(next(content for (kind, _), content in SOUND.items() if kind == suffix))
        done = python("-m", "paradesc", "bake", f"lh{suffix}", "--output", "out.npz")
        assert done.returncode == 3
        assert "it needs nibabel, which is not installed; pip install paradesc[neuro]." in done.stderr


# ---- What makes no sense


def test_options_that_make_no_sense_are_refused_before_blender_is_missed(python):
    done = python("-m", "paradesc", "bake", "sphere.obj", "--descriptors", "wobbliness", "--output", "out.npz")
    assert done.returncode == 2
    assert "wobbliness" in done.stderr


def test_a_file_that_is_no_preset_is_refused_before_blender_is_missed(python, tmp_path):
    (tmp_path / "mask.json").write_text('{"paradesc_preset": 2}')
    done = python("-m", "paradesc", "bake", "sphere.obj", "--preset", "mask.json", "--output", "out.npz")
    assert (done.returncode, done.stdout) == (3, "")
    assert done.stderr.startswith('paradesc: The preset file "mask.json" is of version 2')


def test_a_library_is_computed(python, tmp_path):
    (tmp_path / "library").mkdir()
    write_obj(tmp_path / "library" / "sphere.obj", *cube_sphere(3))
    words = ("library", "library", "--output", "out", "--workers", "1", "--json", "-")
    done = python("-m", "paradesc", *words)
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["made"] == 1
    assert (tmp_path / "out" / "library.jsonl").read_text().count("\n") == 1


def test_tasks_of_an_animation_are_listed_for_machines_with_blender(python, tmp_path):
    done = python("-m", "paradesc", "tasks", "animate", "shot.blend", "--frames", "1:20", "--cache", "frames")
    assert done.returncode == 0, done.stderr
    found = [json.loads(line) for line in done.stdout.splitlines()]
    assert [task["command"][-1] for task in found] == ["--frames=1:10", "--frames=11:20"]
    assert {tuple(task["outputs"]) for task in found} == {("frames",)}
    assert "outputs are the folder of all" in done.stderr
