"""In a Python with numpy and without bpy, what needs no Blender works, and what needs it says so."""

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from shapes import ADDON, cube_sphere, write_obj

COMMANDS = ("bake", "animate", "library", "tasks", "compare", "info", "list")


@pytest.fixture
def python(tmp_path):
    """Runs a Python whose path has only numpy and the add-on."""
    modules = tmp_path / "modules"
    modules.mkdir()
    for path in Path(np.__file__).parents[1].glob("numpy*"):
        (modules / path.name).symlink_to(path)

    def run(*words):
        return subprocess.run(
            [sys.executable, "-S", *words],
            env={**os.environ, "PYTHONPATH": os.pathsep.join(map(str, (modules, ADDON))), "PYTHONNOUSERSITE": "1"},
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


@pytest.mark.parametrize(
    "words", [("bake", "--output", "out.npz"), ("animate", "--cache", "frames"), ("compare",), ("info",)]
)
def test_what_needs_blender_says_so_in_one_sentence(python, tmp_path, words):
    name, *more = words
    done = python("-m", "paradesc", name, write_obj(tmp_path / "sphere.obj", *cube_sphere(3)), *more)
    assert (done.returncode, done.stdout) == (4, "")
    assert done.stderr == "paradesc: Blender's Python module bpy is not installed here.\n"


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
    assert {task["cost_seconds"] for task in found} == {None}
    assert "costs are left out" in done.stderr
