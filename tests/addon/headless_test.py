"""The command line for pipelines: reports, checks, exit codes, the manual, the add-on, mostly in this process."""

import argparse
import json
import math
import os
import re
import shlex
import signal
import subprocess
import sys
import threading

import pytest

from conftest import environment
from shapes import ADDON, RADIUS, cube_sphere, write_obj

bpy = pytest.importorskip("bpy", reason="needs Blender")

import paradesc_blender  # noqa: E402
from paradesc import bridge  # noqa: E402
from paradesc.commands import (  # noqa: E402
    COMMANDS,
    common,
    signals,
)
from paradesc.commands.main import make_parser  # noqa: E402
from paradesc.core import job  # noqa: E402
from paradesc.files import results  # noqa: E402
from paradesc_blender import source  # noqa: E402
from scene import add_sphere, empty_scene, saved_scene  # noqa: E402

QUICK = ("--radius", "0.08", "--samples", "32", "--buffer", "128", "--backend", "software")


# ---- Reports, checks and codes


def test_report_has_its_documented_keys(run, report, sphere_obj):
    assert run("bake", sphere_obj, *QUICK, "--json", "report.json").code == 0
    found = report()
    assert found["schema"] == 1
    assert (found["status"], found["exit_code"], found["error"]) == ("ok", 0, None)
    manual = (ADDON / "manual" / "reference.md").read_text()
    for name in [*found, *found["objects"][0], *found["seconds"]]:
        assert f"`{name}`" in manual, f"{name} is not in the manual"
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
        (["--memory-limit", "0.001"], 1, "memory limit"),
        (["--memory-limit", "4"], 0, ""),
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


def test_radius_below_the_mean_edge_is_said(run, report, sphere_obj):
    for radius, said in (("0.9", True), ("1.1", False)):
        words = (*QUICK[2:], "--radius", radius, "--radius-unit", "mean-edge", "--json", "report.json")
        ended = run("bake", sphere_obj, *words, "--backend", "cpu", "--fail-on-warnings")
        assert ended.code == (5 if said else 0), ended.error
        for part in (report(), report()["objects"][0]):
            assert sum("0.9 of the mean edge" in line for line in part["warnings"]) == said
        assert ("of the mean edge" in ended.output) == said


@pytest.mark.parametrize("words", [("compare", "ball1.obj"), ("animate", "ball#.obj", "--cache", "cache")])
def test_every_command_says_a_radius_below_the_mean_edge(run, report, sphere_obj, words):
    sphere_obj.rename(sphere_obj.with_name("ball1.obj"))
    write_obj(sphere_obj.with_name("ball2.obj"), *cube_sphere(radius=1.1 * RADIUS))
    ended = run(*words, *QUICK[2:], "--radius", "0.9", "--radius-unit", "mean-edge", "--json", "report.json")
    assert ended.code == 0, ended.error
    assert sum("only 0.9 of the mean edge" in line for line in report()["warnings"]) == 1
    assert ended.output.count("of the mean edge") == 1


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (
            ["--radius", "0.1,x"],
            '"0.1,x" is not a radius; give a number, several with commas, or auto; see paradesc bake --help.',
        ),
        (
            ["--memory-limit", "0"],
            '"0" is not an amount of memory; give a number of gigabytes above 0; see paradesc bake --help.',
        ),
        (["--memory-limit", "1e300"], '"1e300" is not an amount of memory'),
        (["--memory-limit", "nan"], '"nan" is not an amount of memory'),
        (["--colour-map", "heat"], 'There is no option "--colour-map"; see paradesc bake --help.'),
        (["second.obj"], 'There is no place for "second.obj"; see paradesc bake --help.'),
    ],
    ids=["number", "no memory", "too much memory", "undefined memory", "option", "word"],
)
def test_words_that_cannot_be_read_are_named(run, words, sentence):
    ended = run("bake", "first.obj", "--output", "out.npz", *words)
    assert ended.code == common.EXIT_USAGE
    assert sentence in ended.error


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
    def missing(*_words, **_more):
        raise bridge.ParadescError(bridge.abi.STATUS_UNSUPPORTED, "native library missing.")

    monkeypatch.setattr(bridge, "Context", missing)
    assert run("bake", sphere_obj, "--output", "out.npz").code == common.EXIT_DEVICE


def test_compare_fails_over_an_error_that_is_too_large(run, report, sphere_obj):
    ended = run("compare", sphere_obj, *QUICK, "--fail-over-error", "1e-9", "--json", "report.json")
    assert ended.code == 5
    assert "mean_curvature" in ended.error
    assert report()["status"] == "check failed"
    assert report()["rows"][0]["descriptor"] == "mean_curvature"


@pytest.mark.slow
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


def test_signals_are_as_before_after_a_command(run, sphere_obj):
    before = [signal.getsignal(number) for number in signals.NUMBERS]
    native = [signals.swap_native(number, signal.SIG_IGN) for number in signals.NUMBERS]
    for number, handler in zip(signals.NUMBERS, native, strict=True):
        signals.swap_native(number, handler)
    assert run("bake", sphere_obj, *QUICK, "--output", "out.npz").code == 0
    for number, handler in zip(signals.NUMBERS, native, strict=True):
        assert signals.swap_native(number, handler) == handler
    if None not in before:
        assert [signal.getsignal(number) for number in signals.NUMBERS] == before


def test_writer_that_is_stopped_leaves_the_old_file(tmp_path):
    (tmp_path / "out.npz").write_bytes(b"old")

    def stopped(path, _content):
        path.write_bytes(b"half")
        raise signals.Terminated

    with pytest.raises(signals.Terminated):
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
    """Every command line of the manual and of README, as words after the program."""
    for path in (ADDON.parent / "README.md", *sorted((ADDON / "manual").glob("*.md"))):
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


def test_list_describes_descriptors_and_devices(run, report):
    ended = run("list", "--json", "report.json")
    assert ended.code == 0
    rows = {row["name"]: row for row in report()["descriptors"]}
    assert list(rows) == [row.name for row in bridge.descriptors()]
    assert rows["gaussian_curvature"]["unit"] == "1/length^2"
    assert rows["principal_direction_max"]["kind"] == "direction"
    assert rows["harris"]["kind"] == "operator"
    devices = report()["devices"]
    assert list(dict.fromkeys(row["backend"] for row in devices)) == ["gpu", "software", "reference", "cpu"]
    for row in devices:
        assert bool(row["device"]) != bool(row["missing"])
        assert row["missing"] in ended.output
    assert [row["index"] for row in devices if row["backend"] == "reference"] == [None]


# ---- The add-on


@pytest.fixture
def addon():
    """The add-on, registered."""
    paradesc_blender.register()
    yield
    if hasattr(bpy.types.Scene, "paradesc"):
        paradesc_blender.unregister()


def test_panel_settings_of_a_file_are_taken_and_options_go_first(run, report, tmp_path, addon):
    empty_scene()
    add_sphere(steps=6)
    group = bpy.context.scene.paradesc
    group.descriptors, group.radius_unit, group.radius_edges = {"curvedness", "cavity"}, "mean-edge", 2.5
    group.samples, group.buffer_size, group.backend, group.space = 24, 128, "software", "world"
    looks = bpy.context.scene.paradesc_looks
    looks.color_map, looks.span, looks.minimum, looks.maximum = "heat", "fixed", 0.0, 7.0
    path = saved_scene(tmp_path / "scene.blend")
    paradesc_blender.unregister()
    words = ("--scene-settings", "--samples", "16", "--output", "out.npz", "--json", "report.json")
    assert run("bake", path, *words).code == 0
    found = report()["settings"]
    assert found["descriptors"] == ["curvedness", "cavity"]
    assert (found["radius"], found["radius_unit"]) == (2.5, "mean-edge")
    assert (found["samples"], found["buffer_size"], found["backend"]) == (16, 128, "software")
    assert found["space"] == "world"
    shown = report()["objects"][0]["descriptors"]["curvedness"]
    assert (shown["shown_minimum"], shown["shown_maximum"], shown["color_map"]) == (0.0, 7.0, "heat")
    for name in ("paradesc", "paradesc_looks", "paradesc_animation"):
        assert not hasattr(bpy.types.Scene, name)


def test_a_mesh_that_is_a_single_point_is_described(run, tmp_path):
    path = tmp_path / "point.obj"
    path.write_text(3 * "v 0 0 0\n" + "f 1 2 3\n")
    ended = run("info", path, "--reader", "files")
    assert ended.code == 0, ended.error
    assert "diagonal 0, mean edge 0\n" in ended.output


def test_report_never_takes_the_place_of_the_open_file(run, tmp_path, addon):
    empty_scene()
    path = saved_scene(tmp_path / "scene.blend")
    before = path.read_bytes()
    assert run("info", "--json", path).code == 2
    assert path.read_bytes() == before


def test_preset_says_what_and_how_and_options_go_first(run, report, sphere_obj):
    words = ("--backend", "software", "--buffer", "128", "--output", "out.npz", "--json", "report.json")
    assert run("bake", sphere_obj, "--preset", "edge_wear", *words).code == 0
    found = report()["settings"]
    assert (found["descriptors"], found["radius_fit"], found["samples"]) == (["convexity"], "medium", 256)
    assert (found["buffer_size"], found["backend"]) == (128, "software")
    ended = run("bake", sphere_obj, "--preset", "wear", *words)
    assert ended.code == 2
    assert "edge_wear" in ended.error


def test_every_preset_of_the_panel_is_one_here():
    from paradesc.commands.options import found_preset
    from paradesc.files import preset_rules
    from paradesc_blender.settings import presets

    for name in presets.PRESETS:
        settings = preset_rules.settings_of(found_preset(argparse.Namespace(preset=name)), None)
        job.check_descriptors(settings.descriptors)
        assert set(settings.descriptors) == set(presets.PRESETS[name].settings["descriptors"])


def test_blender_gets_the_command_where_it_knows_commands(run, monkeypatch, sphere_obj):
    known, taken = {}, []

    def keep(name, function):
        known[name] = function
        return name

    monkeypatch.setattr(bpy.utils, "register_cli_command", keep, raising=False)
    monkeypatch.setattr(bpy.utils, "unregister_cli_command", taken.append, raising=False)
    source.register()
    assert known["paradesc"](["bake", str(sphere_obj), *QUICK, "--output", "out.npz"]) == 0
    assert known["paradesc"](["bake", "nothing.obj", "--output", "out.npz"]) == common.EXIT_INPUT
    source.unregister()
    source.unregister()
    assert taken == ["paradesc"]


def test_what_is_no_number_is_null_in_reports():
    text = results.json_text({"a": math.nan, "b": [math.inf, 1.5, {"c": -math.inf}], "d": ("x", True, None, 3)})
    assert json.loads(text) == {"a": None, "b": [None, 1.5, {"c": None}], "d": ["x", True, None, 3]}


@pytest.mark.skipif(not bpy.app.binary_path or bpy.app.version < (4, 2), reason="needs Blender 4.2's own executable")
def test_enabled_addon_answers_to_blenders_own_command_option(tmp_path, sphere_obj):
    (tmp_path / "scripts" / "addons").mkdir(parents=True)
    for name in ("paradesc", "paradesc_blender"):
        (tmp_path / "scripts" / "addons" / name).symlink_to(ADDON / name)
    start = [bpy.app.binary_path, "--factory-startup", "--addons", "paradesc_blender", "-c", "paradesc"]
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
    source.register()
    assert source.handles == []


SCRIPT = """
import sys
sys.path[:0] = {paths!r}
import bpy, paradesc_blender
from scene import add_sphere, empty_scene
paradesc_blender.register()
empty_scene()
target = add_sphere(steps=8)
settings = bpy.context.scene.paradesc
settings.descriptors = {{"mean_curvature", "shape_index"}}
settings.radius_percent = 8
settings.samples, settings.buffer_size, settings.backend = 32, 128, "software"
assert bpy.ops.paradesc.bake() == {{"FINISHED"}}
assert "shape_index_color" in target.data.attributes
from paradesc.commands.main import main
files = ["--output", "a.ply", "--output", "a.exr", "--texels", "64", "--json", "a.json"]
code = main(["bake", "--scene-settings", "--descriptors", "shape_index", "--quiet", *files])
bpy.ops.wm.save_as_mainfile(filepath={blend!r})
sys.exit(code)
"""


@pytest.mark.slow
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
    assert (tmp_path / "a.ply").read_bytes().startswith(b"ply")
    assert (tmp_path / "a.exr").read_bytes().startswith(b"\x76\x2f\x31\x01")
    assert report("a.json")["settings"]["radius"] == pytest.approx(0.08)
    assert list(report("a.json")["objects"][0]["descriptors"]) == ["shape_index"]
    assert (tmp_path / "a.blend").is_file()
