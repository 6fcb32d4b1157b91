"""The add-on uses no network, no library except its own, and writes files only where the user says."""

import ast
import json
import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from paradesc.bridge import library
from shapes import ADDON, PACKAGES, ROOT, cube_sphere, write_obj

SOURCES = sorted(path for package in PACKAGES for path in package.rglob("*.py"))
NETWORK = {"asyncio", "ftplib", "http", "imaplib", "nntplib", "poplib", "requests", "smtplib", "socket", "socketserver"}
NETWORK |= {"ssl", "telnetlib", "urllib", "urllib3", "webbrowser", "websockets", "xmlrpc"}
# Other programs, and files that run code when they are read.
CODE = {"code", "codeop", "dill", "marshal", "multiprocessing", "pickle", "pip", "runpy", "shelve", "subprocess"}
# paradesc library alone starts processes of this program, and reaches the Dask scheduler that --dask names.
SPREADS = "commands/spreading.py"
CALLS = {"compile", "eval", "exec", "__import__"}

# Everything that a bake with all of its files opens, makes and loads is written to watched.json.
WATCH = """
import json, sys
written, loaded, other = [], [], []
def watch(event, arguments):
    if event == "open" and isinstance(arguments[0], (str, bytes)):
        if isinstance(arguments[1], str) and set(arguments[1]) & set("wax+") or arguments[2] & 0o1103:
            written.append(str(arguments[0]))
    elif event in ("os.mkdir", "os.remove", "os.rmdir", "os.link", "os.symlink", "os.truncate", "tempfile.mkstemp"):
        written.append(str(arguments[0]))
    elif event in ("os.rename", "shutil.move", "shutil.copyfile"):
        written.extend(map(str, arguments[:2]))
    elif event == "ctypes.dlopen":
        loaded.append(str(arguments[0]))
    elif event.startswith(("socket.", "subprocess.", "os.system", "os.exec", "os.posix_spawn", "urllib.", "http.")):
        other.append(event)
sys.path[:0] = [{addon!r}, {numpy!r}, {tests!r}]
sys.dont_write_bytecode = True
import bpy
import numpy
from scene import add_sphere, small_bake, empty_scene
import paradesc_blender
sys.addaudithook(watch)
empty_scene()
paradesc_blender.register()
target = add_sphere(steps=4)
settings = small_bake()
settings.descriptors = {{"mean_curvature", "harris"}}
assert bpy.ops.paradesc.bake() == {{"FINISHED"}}
bpy.context.preferences.filepaths.file_preview_type = "NONE"  # Blender's own thumbnail of what the test saves
bpy.ops.wm.save_as_mainfile(filepath={blend!r})
settings.texels, settings.descriptors = 32, {{"mean_curvature"}}
assert bpy.ops.paradesc.bake_image() == {{"FINISHED"}}
bpy.context.scene.paradesc_animation.cache_folder = {cache!r}
bpy.context.scene.frame_end = 2
assert bpy.ops.paradesc.bake_frames() == {{"FINISHED"}}
paradesc_blender.unregister()
libraries = sorted({{line.split(maxsplit=5)[-1].strip() for line in open("/proc/self/maps") if ".so" in line}})
content = {{"written": written[:], "loaded": loaded, "other": other, "libraries": libraries}}
open({report!r}, "w").write(json.dumps(content))
"""


def imported(path):
    """The first words of the modules that a file imports from outside the add-on."""
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            yield from (name.name.partition(".")[0] for name in node.names)
        elif isinstance(node, ast.ImportFrom) and node.level == 0:
            yield node.module.partition(".")[0]


@pytest.mark.parametrize("path", SOURCES, ids=lambda path: str(path.relative_to(ADDON)))
def test_no_module_reaches_the_network_or_runs_code_of_others(path):
    allowed = {"multiprocessing"} if path == ADDON / "paradesc" / SPREADS else set()
    assert not set(imported(path)) & (NETWORK | CODE) - allowed
    calls = [node for node in ast.walk(ast.parse(path.read_text())) if isinstance(node, ast.Call)]
    assert not {node.func.id for node in calls if isinstance(node.func, ast.Name)} & CALLS
    loads = [node for node in calls if ast.unparse(node.func) in ("np.load", "numpy.load")]
    assert all("allow_pickle=True" not in ast.unparse(node) for node in loads)


def test_processes_and_dask_are_reached_from_one_place_and_dask_only_when_it_is_asked_for():
    found = {path for path in SOURCES if set(imported(path)) & {"concurrent", "distributed", "multiprocessing"}}
    assert found == {ADDON / "paradesc" / SPREADS}
    code = "import sys, paradesc.commands as commands; commands.modules(); print('distributed' in sys.modules)"
    path = [str(ADDON), str(Path(np.__file__).parents[1])]
    words = [sys.executable, "-c", f"import sys; sys.path[:0] = {path}\n{code}"]
    done = subprocess.run(words, capture_output=True, text=True, timeout=60, check=True)
    assert done.stdout == "False\n"


def test_no_environment_variable_changes_what_is_loaded_or_computed():
    native = [path for folder in ("native/src", "shaders") for path in (ROOT / folder).rglob("*") if path.is_file()]
    if not native:
        pytest.skip("the native sources are not here")
    for path in [*SOURCES, *native]:
        assert not re.search(r"\b(environ|getenv)\b", path.read_text()), path


def test_only_the_bridge_loads_libraries_and_by_absolute_path():
    opened = {
        path.name
        for path in SOURCES
        for node in ast.walk(ast.parse(path.read_text()))
        if isinstance(node, ast.Call) and re.search(r"CDLL$|LoadLibrary$|find_library$|dlopen$", ast.unparse(node.func))
        if [ast.unparse(word) for word in node.args] != ["None"]  # the process itself
    }
    assert opened == {"library.py"}
    assert library.library_path().is_absolute()
    assert library.library_path().parent == (ADDON / "paradesc" / "lib").resolve()


@pytest.fixture(scope="module")
def watched(tmp_path_factory):
    """The actions of a bake, of images and of frames, in a process with an empty home and decoys around it."""
    pytest.importorskip("bpy", reason="needs Blender")
    from processes import script_words

    if not sys.platform.startswith("linux"):
        pytest.skip("reads /proc")
    folder = tmp_path_factory.mktemp("watched")
    for name in ("home", "asked", "user", "decoy"):
        (folder / name).mkdir()
    (folder / "decoy" / "libparadesc.so").write_bytes(b"not a library")
    (folder / "decoy" / "libOpenMeshCore.so.9.0").write_bytes(b"not a library")
    words = {"addon": str(ADDON), "numpy": str(Path(np.__file__).parents[1]), "tests": str(Path(__file__).parent)}
    words.update(blend=str(folder / "asked" / "shot.blend"))
    words.update(cache=str(folder / "asked" / "frames"), report=str(folder / "watched.json"))
    script = folder / "watch.py"
    script.write_text(WATCH.format(**words))
    user = {f"BLENDER_USER_{name}": str(folder / "user") for name in ("CONFIG", "SCRIPTS", "DATAFILES", "EXTENSIONS")}
    home = {"HOME": str(folder / "home"), "XDG_CACHE_HOME": str(folder / "home" / ".cache")}
    search = {"LD_LIBRARY_PATH": str(folder / "decoy"), "TMPDIR": str(folder / "user")}
    done = subprocess.run(
        script_words(script),
        cwd=folder / "decoy",
        env={**os.environ, **user, **home, **search},
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return folder, json.loads((folder / "watched.json").read_text())


@pytest.mark.slow
def test_a_bake_writes_only_where_the_user_said(watched):
    folder, seen = watched
    allowed = (str(folder / "asked"), str(folder / "user"), "/dev/null")
    assert seen["written"], "nothing was watched"
    assert not [path for path in seen["written"] if not path.startswith(allowed)]
    assert list((folder / "asked").glob("sphere_*.png"))
    assert {path.name for path in (folder / "decoy").iterdir()} == {"libparadesc.so", "libOpenMeshCore.so.9.0"}


@pytest.mark.slow
def test_a_bake_leaves_nothing_in_the_home_but_the_drivers_own_cache(watched):
    folder, _ = watched
    found = {path.relative_to(folder / "home") for path in (folder / "home").rglob("*") if path.is_file()}
    assert all("mesa_shader_cache" in str(path) for path in found), found


def test_a_bake_starts_no_program_and_opens_no_connection(watched):
    assert watched[1]["other"] == []


def test_the_library_comes_from_the_addons_own_folder_whatever_the_search_path(watched):
    _, seen = watched
    own = str((ADDON / "paradesc" / "lib").resolve())
    ours = [path for path in seen["libraries"] if "paradesc" in Path(path).name or "OpenMesh" in Path(path).name]
    assert ours
    assert all(path.startswith(own) for path in ours), ours
    assert all(path.startswith(own) or path == "None" for path in seen["loaded"]), seen["loaded"]


def test_the_command_line_writes_only_its_outputs(tmp_path, paradesc):
    mesh = write_obj(tmp_path / "sphere.obj", *cube_sphere(4))
    (tmp_path / "empty").mkdir()
    done = paradesc("bake", mesh, "--buffer", 128, "--radius", 0.1, "--output", "out.npz", cwd=tmp_path / "empty")
    assert done.returncode == 0, done.stderr
    assert [path.name for path in (tmp_path / "empty").iterdir()] == ["out.npz"]
