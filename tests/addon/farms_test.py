"""Lists of tasks, and the job descriptions of the package as Open Job Description and Flamenco read them."""

import contextlib
import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from conftest import blender_program
from libraries import all_hash, make_library, process_environment, rows_of, waited_for
from paradesc.commands import bundles
from paradesc.commands import main as main_module
from paradesc.commands.common import UsageError, split_words, with_also
from paradesc.commands.main import main
from paradesc.files import cache
from shapes import cube_sphere, write_obj

QUICK = ("--radius", "0.2", "--samples", "16", "--backend", "cpu")
OPENJD = bundles.FARMS / "openjd"


@pytest.fixture
def library(tmp_path):
    """A folder of seven assets."""
    return make_library(tmp_path / "library", 7)


@pytest.fixture
def scene(tmp_path):
    """A cylinder that bends, as a file, of whose frames the last is 20."""
    bpy = pytest.importorskip("bpy", reason="needs Blender")
    import animated

    animated.bent_cylinder()
    path = tmp_path / "bends.blend"
    bpy.context.scene.frame_end = 20
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    return path


def tasks(tmp_path, *words, code=0):
    """The tasks that the command lists."""
    path = tmp_path / "tasks.jsonl"
    assert main(["tasks", "--list", str(path), *map(str, words)]) == code
    return [json.loads(line) for line in path.read_text().splitlines()]


def contents(folder):
    """The bytes of every frame by its name."""
    return {path.name: path.read_bytes() for path in folder.rglob("*.pdframe")}


# ---- Tasks


def test_tasks_of_an_animation_have_every_frame_once_and_their_words_compute_it(scene, tmp_path):
    found = tasks(tmp_path, "animate", scene, "--cache", tmp_path / "cache", "--chunk", "8", *QUICK)
    assert [task["name"] for task in found] == ["frames 1:8", "frames 9:16", "frames 17:20"]
    outputs = [path for task in found for path in task["outputs"]]
    assert outputs == [str(cache.frame_path(tmp_path / "cache" / "cylinder", frame)) for frame in range(1, 21)]
    for task in found[1:]:
        assert task["command"][0] == "paradesc"
        assert task["stage"] == 1
        assert main([*task["command"][1:], "--quiet"]) == 0
    assert [os.path.exists(path) for path in outputs] == [False] * 8 + [True] * 12  # noqa: PTH110


def test_frames_that_are_given_count(scene, tmp_path):
    words = (
        "animate",
        scene,
        "--frames=-5:12:3",
        "--cache",
        tmp_path,
        "--program",
        "blender -c paradesc",
        "--chunk",
        "4",
    )
    found = tasks(tmp_path, *words)
    assert [task["command"][-1] for task in found] == ["--frames=-5:4:3", "--frames=7:10:3"]
    assert found[0]["command"][:4] == ["blender", "-c", "paradesc", "animate"]
    assert not [word for task in found for word in task["command"] if word == "--frames=-5:12:3"]


def test_tasks_of_a_sequence_of_files_leave_out_its_gaps(tmp_path):
    for frame in (1, 2, 3, 5, 6):
        write_obj(tmp_path / f"a_{frame:04}.obj", *cube_sphere(3, radius=frame))
    words = ("animate", tmp_path / "a_####.obj", "--cache", tmp_path / "cache", "--chunk", "2", *QUICK)
    found = tasks(tmp_path, *words)
    assert [task["name"] for task in found] == ["frames 1:2", "frames 3", "frames 5:6"]
    assert main([*found[2]["command"][1:], "--quiet"]) == 0
    assert sorted(map(str, (tmp_path / "cache").rglob("*.pdframe"))) == found[2]["outputs"]
    assert main(["tasks", *map(str, words), "--bundle", str(tmp_path / "bundle")]) == 2


def test_tasks_of_a_library_have_every_asset_once_and_their_words_compute_it(library, tmp_path):
    words = ("library", library, "--output", tmp_path / "out", *QUICK, "--workers", "1")
    single, parts = tasks(tmp_path, *words), tasks(tmp_path, "--chunk", "3", *words)
    assert sorted(task["name"] for task in single[:-1]) == sorted(
        path.relative_to(library).as_posix() for path in library.rglob("*.obj")
    )
    outputs = sorted(path for task in single[:-1] for path in task["outputs"])
    assert sorted(path for task in parts[:-1] for path in task["outputs"]) == outputs
    assert len(parts) <= 4
    for task in [single[0], *parts]:
        assert main([*task["command"][1:], "--quiet"]) == 0
    assert (parts[-1]["stage"], parts[-1]["outputs"]) == (2, [str(tmp_path / "out" / "library.jsonl")])
    assert all(map(os.path.exists, outputs))
    assert len(rows_of(tmp_path / "out")) == 7


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ([], "no command to divide"),
        (["bake", "a.obj"], '"bake" is not divided'),
        (["library"], "directly after library"),
        (["library", "FOLDER", "-o", "OUT", "--part", "1/2"], "--part"),
        (["library", "FOLDER", "-o", "OUT", "--wrong"], "--wrong"),
        (["library", "FOLDER", "-o", "OUT", "--chunk", "0"], "at least 1"),
        (["animate", "a.blend", "--json=x.json"], "--json"),
        (["animate", "a.blend", "--descriptors", "wobbliness"], "wobbliness"),
    ],
)
def test_what_cannot_be_divided_is_refused(tmp_path, monkeypatch, capfd, words, said):
    monkeypatch.chdir(tmp_path)
    assert main(["tasks", *words]) == 2
    found = [line for line in capfd.readouterr().err.splitlines() if line.startswith("paradesc: ")]
    assert len(found) == 1
    assert said in found[0]


# ---- What job descriptions need of the command line


def test_one_word_holds_many_options_or_none():
    assert with_also(["bake", "--also", "--radius 0.1 --object 'a b'", "x"]) == [
        "bake",
        "--radius",
        "0.1",
        "--object",
        "a b",
        "x",
    ]
    assert with_also(["bake", "--also", "", "--also=-q"]) == ["bake", "-q"]
    with pytest.raises(UsageError, match="cannot be told apart"):
        with_also(["bake", "--also", "'"])
    assert split_words("--object My\\ Cube", "--also", escapes=True) == ["--object", "My Cube"]
    windows = r""" "C:\Program Files\py.exe" -m paradesc 'a b' C:\x\y.json #1 """
    words = [r"C:\Program Files\py.exe", "-m", "paradesc", "a b", r"C:\x\y.json", "#1"]
    assert split_words(windows, "--program", escapes=False) == words


def test_a_list_on_the_standard_output_has_no_other_lines(run, sphere_obj, tmp_path):
    ended = run("tasks", "library", ".", "-o", "out", "--flamenco", "scripts")
    assert ended.code == 0
    assert [json.loads(line)["name"] for line in ended.output.splitlines()] == ["sphere.obj", "listing"]
    assert "wrote scripts" in ended.error
    ended = run("tasks", "--json", "report.json", "library", ".", "-o", "out", "--list", "tasks.jsonl")
    assert (ended.output, ended.error) == ("wrote report.json\n", "wrote tasks.jsonl\n")
    assert json.loads((tmp_path / "report.json").read_text())["outputs"] == ["tasks.jsonl"]
    listed = (tmp_path / "tasks.jsonl").read_text()
    ended = run("tasks", "--quiet", "library", ".", "-o", "out", "--list", "tasks.jsonl")
    assert (ended.output, ended.error) == ("", "")
    ended = run("tasks", "--quiet", "library", ".", "-o", "out")
    assert (ended.output, ended.error) == (listed, "")
    ended = run("tasks", "--json", "-", "library", ".", "-o", "out")
    assert ended.code == 2
    assert ended.error == "paradesc: --json - and the list both write to the standard output; give --list a file.\n"


def test_the_words_of_the_other_command_are_parsed_once(library, tmp_path, monkeypatch):
    parsers = []
    make_parser = main_module.make_parser
    monkeypatch.setattr(main_module, "make_parser", lambda: parsers.append(make_parser()) or parsers[-1])
    words = ("--json", tmp_path / "report.json", "library", library, "-o", tmp_path / "out")
    assert len(tasks(tmp_path, *words)) == 8
    assert len(parsers) == 2  # of tasks, and of library


def test_a_program_whose_words_cannot_be_told_apart_is_refused(run, sphere_obj):
    ended = run("tasks", "library", ".", "-o", "out", "--program", "'python -m paradesc")
    assert (ended.code, ended.error) == (
        2,
        "paradesc: The words of --program, 'python -m paradesc, cannot be told apart: No closing quotation.\n",
    )


def test_frames_are_written_as_farms_write_them():
    for text, wanted in {
        "1-10": range(1, 11), "-5--1": range(-5, 0), "-3-3:2": range(-3, 4, 2), "7": range(7, 8), "1:4": range(1, 5),
    }.items():  # fmt: skip
        assert cache.parse_frames(text) == wanted


def test_progress_and_failure_are_told_as_open_job_description_reads_them(library, tmp_path, capfd, monkeypatch):
    monkeypatch.setattr(sys, "__stdout__", sys.stdout)
    words = ["library", str(library), "-o", str(tmp_path / "out"), *QUICK, "--workers", "1", "--progress", "openjd"]
    assert main([*words, "--quiet", "--descriptors", "", "--also", ""]) == 0
    said = [line for line in capfd.readouterr().out.splitlines() if line.startswith("openjd_progress: ")]
    fractions = [float(line.split(": ")[1]) for line in said]
    assert fractions == sorted(fractions)
    assert fractions[-1] == 100
    (library / "empty.obj").write_text("")
    assert main(words) == 5
    (told,) = [line for line in capfd.readouterr().out.splitlines() if line.startswith("openjd_fail: ")]
    assert "1 of 8 assets" in told
    assert main([*words, "--json", "-"]) == 2


# ---- Open Job Description


def openjd(*words):
    """The words that run its command line, or the test is skipped."""
    pytest.importorskip("openjd.cli", reason="openjd-cli is not installed")
    if blender_program():
        pytest.skip("runs in Python, not in Blender")
    return [sys.executable, "-m", "openjd", *map(str, words)]


def done(words):
    """The output of a program, which has to end well."""
    found = subprocess.run(words, env=process_environment(), capture_output=True, text=True, timeout=300, check=False)
    assert found.returncode == 0, found.stdout + found.stderr
    return found.stdout


@pytest.fixture
def program(tmp_path):
    """A program that is called as an installed paradesc is."""
    path = tmp_path / "bin" / "paradesc"
    path.parent.mkdir()
    path.write_text(f'#!/bin/sh\nexec "{sys.executable}" -m paradesc "$@"\n')
    path.chmod(0o755)
    return path


def parameters(bundle):
    """The values of a bundle as words for a run."""
    values = (bundle / "parameter_values.yaml").read_text().split("  - name: ")[1:]
    pairs = [text.split("\n    value: ") for text in values]
    return [word for name, value in pairs for word in ("-p", json.dumps({name: str(json.loads(value))}))]


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["animation", "library"])
def test_openjd_accepts_the_templates(kind):
    assert "passes validation" in done(openjd("check", OPENJD / kind / "template.yaml"))


@pytest.mark.slow
def test_openjd_runs_a_library_and_goes_on_where_it_was_killed(tmp_path, program):
    words = openjd("run")
    library = make_library(tmp_path / "library", 24, (10, 14))
    (library / "set_0").rename(library / "it's a set")
    output, whole, bundle = tmp_path / "out", tmp_path / "whole", tmp_path / "bundle"
    assert main(["library", str(library), "-o", str(whole), *QUICK, "--workers", "1"]) == 0
    rest = ["-o", str(output), *QUICK, "--program", str(program), "--bundle", str(bundle)]
    assert main(["tasks", "library", str(library), "--chunk", "6", *rest]) == 0
    words += [str(bundle / "template.yaml"), *parameters(bundle), "--step", "Listing", "--run-dependencies"]
    killed = subprocess.Popen(words, env=process_environment(), stdout=subprocess.DEVNULL, start_new_session=True)
    rows = (output / "results").rglob  # an asset is kept if its row is there; the arrays come first
    waited_for(lambda: len(list(rows("*.json"))) >= 4)
    os.killpg(killed.pid, signal.SIGKILL)
    killed.wait()
    waited_for(lambda: no_process_of(output))
    kept = [path.with_suffix(".npz") for path in rows("*.json")]
    before = {path: path.stat().st_mtime_ns for path in kept}
    assert 4 <= len(before) < 24
    said = done(words)
    assert "openjd_progress: 100.0" in said
    assert "24 assets: 0 computed, 24 kept" in said
    assert all(path.stat().st_mtime_ns == time for path, time in before.items())
    assert all_hash(output) == all_hash(whole)


def no_process_of(output):
    """Ends the processes that work on this folder, as openjd's tasks have sessions of their own; if none was left."""
    left = []
    for path in Path("/proc").glob("[0-9]*/cmdline"):
        with contextlib.suppress(OSError):
            words = path.read_bytes().split(b"\0")
            if b"library" in words and str(output).encode() in words:
                left.append(int(path.parent.name))
    for number in left:
        with contextlib.suppress(ProcessLookupError):
            os.kill(number, signal.SIGKILL)
    return not left


@pytest.mark.slow
def test_openjd_runs_an_animation_with_mapped_paths_and_keeps_what_is_there(scene, tmp_path, program):
    words = openjd("run")
    output, whole, bundle = tmp_path / "cache", tmp_path / "whole", tmp_path / "bundle"
    assert main(["animate", str(scene), "--frames", "1-9", "--cache", str(whole), *QUICK]) == 0
    rest = ["--frames", "1:9", "--cache", str(output), *QUICK, "--program", str(program), "--bundle", str(bundle)]
    assert main(["tasks", "animate", str(scene), "--chunk", "3", *rest]) == 0
    values = parameters(bundle)
    values += ["-p", json.dumps({"Scene": f"/elsewhere/{scene.name}", "Cache": "/elsewhere/cache"})]
    rule = {"source_path_format": "POSIX", "source_path": "/elsewhere", "destination_path": str(tmp_path)}
    mapping = {"version": "pathmapping-1.0", "path_mapping_rules": [rule]}
    words += [str(bundle / "template.yaml"), *values, "--step", "Frames", "--path-mapping-rules", json.dumps(mapping)]
    done([*words, "--maximum-tasks", "2"])
    first = {path: path.stat().st_mtime_ns for path in output.rglob("*.pdframe")}
    assert len(first) == 6
    said = done(words)
    assert said.count("0 frames made, 3 kept") == 2
    assert said.count("3 frames made, 0 kept") == 1
    assert all(path.stat().st_mtime_ns == time for path, time in first.items())
    assert {name: result(content) for name, content in contents(output).items()} == {
        name: result(content) for name, content in contents(whole).items()
    }


def result(content):
    """The values that the bytes of a frame hold; beside them it says when it was made."""
    frame = cache.decode(content, cache.frame_path(Path(), 1).with_name("any"))
    return {name: values.tobytes() for name, values in frame.values.items()}


# ---- Flamenco

# Stands for what Flamenco's manager gives to the scripts.
STUB = """
var author = {
    Task: function (name, type) {
        var task = {name: name, type: type, commands: [], before: []};
        task.addCommand = function (command) { task.commands.push(command); };
        task.addDependency = function (other) { task.before.push(other.name); };
        return task;
    },
    Command: function (name, parameters) { return {name: name, parameters: parameters}; }
};
var tasks = [];
function frameChunker(frames, size) { return dukpy.chunks; }
"""


KNOWN = {"key", "type", "subtype", "choices", "required", "default", "eval", "evalInfo", "visible", "description"}


def compiled(script, settings, chunks=()):
    """The job type, and the tasks that a script makes of these settings."""
    dukpy = pytest.importorskip("dukpy", reason="no JavaScript engine is installed")
    text = (bundles.FARMS / "flamenco" / script).read_text()
    end = "compileJob({settings: dukpy.settings, addTask: function (task) { tasks.push(task); }});\n"
    end += "JSON.parse(JSON.stringify([JOB_TYPE, tasks]));"
    return dukpy.evaljs(STUB + text + end, settings=settings, chunks=list(chunks))


def defaults(kind):
    """The default settings of a job type."""
    return {setting["key"]: setting.get("default", "") for setting in kind["settings"]}


def test_flamenco_makes_a_task_of_each_chunk_whose_words_compute_it(scene, tmp_path):
    kind, _ = compiled("paradesc.js", {"program": "", "options": ""})
    settings = {**defaults(kind), "blendfile": str(scene), "cache": str(tmp_path / "cache"), "radius": "0.2"}
    settings["options"] = "--samples 16 --object cylinder"
    _, found = compiled("paradesc.js", settings, ["1-3", "4,7-8"])
    assert [(task["name"], task["type"]) for task in found] == [("frames-1-3", "blender"), ("frames-4,7-8", "blender")]
    commands = [command for task in found for command in task["commands"]]
    assert {command["name"] for command in commands} == {"exec"}
    assert {command["parameters"]["exe"] for command in commands} == {"{blender}"}
    for command in commands:
        start, words = command["parameters"]["args"][:3], command["parameters"]["args"][3:]
        assert start == ["--background", "--command", "paradesc"]
        assert main([*words, "--quiet"]) == 0
    assert sorted(contents(tmp_path / "cache")) == [f"frame_{frame:05}.pdframe" for frame in (1, 2, 3, 4, 7, 8)]


def test_flamenco_makes_a_task_of_each_part_and_one_that_lists_them(library, tmp_path):
    kind, _ = compiled("paradesc_library.js", {"program": "", "parts": 0})
    settings = {**defaults(kind), "library": str(library), "output": str(tmp_path / "out"), "parts": 3}
    settings["options"] = "--samples 16 --workers 1"
    _, found = compiled("paradesc_library.js", settings)
    assert [task["name"] for task in found] == ["part-1", "part-2", "part-3", "listing"]
    assert found[-1]["before"] == ["part-1", "part-2", "part-3"]
    for task in found:
        (command,) = task["commands"]
        assert command["parameters"]["exe"] == "paradesc"
        assert main([*command["parameters"]["args"], "--quiet"]) == 0
    assert len(rows_of(tmp_path / "out")) == 7


def test_settings_of_flamenco_have_types_that_it_knows():
    for script in ("paradesc.js", "paradesc_library.js"):
        kind, _ = compiled(script, {"program": "", "parts": 0, "options": ""})
        for setting in kind["settings"]:
            assert setting["type"] in ("string", "int32", "float", "bool")
            assert {"key", "type", "description"} <= set(setting)
            assert set(setting) <= KNOWN


def test_job_types_are_copied_to_where_flamenco_looks(tmp_path):
    assert main(["tasks", "--flamenco", str(tmp_path / "scripts")]) == 0
    assert sorted(path.name for path in (tmp_path / "scripts").iterdir()) == ["paradesc.js", "paradesc_library.js"]
