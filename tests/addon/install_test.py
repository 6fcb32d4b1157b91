"""The add-on as users get it: packed, installed from the zips, updated, disabled and enabled; and its versions."""

import ast
import os
import re
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

from paradesc.bridge import library
from shapes import ADDON, ROOT

bpy = pytest.importorskip("bpy", reason="needs Blender")

SCRIPT = Path(__file__).with_name("install_in_blender.py")
LIBRARIES = sorted((ADDON / "paradesc" / "lib").glob("*.so*"))
EXTENSIONS = pytest.mark.skipif(bpy.app.version < (4, 2, 0), reason="extensions came with Blender 4.2")


def in_blender(tmp_path, *words):
    """Runs one action of install_in_blender.py in a Blender with empty user folders."""
    if bpy.app.binary_path:
        start = [bpy.app.binary_path, "-b", "--factory-startup", "--python-exit-code", "1", "-P", SCRIPT, "--"]
    else:
        start = [sys.executable, SCRIPT, "--"]
    user = tmp_path / "user"
    folders = {f"BLENDER_USER_{name}": str(user / name) for name in ("CONFIG", "SCRIPTS", "EXTENSIONS", "DATAFILES")}
    environment = {**os.environ, **folders, "PARADESC_TEST_USER": str(user)}
    environment.pop("PYTHONPATH", None)
    process = subprocess.run(
        [str(word) for word in (*start, *words)],
        env=environment,
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    said = process.stdout + process.stderr
    assert process.returncode == 0, said
    assert f"{words[0]} done" in process.stdout, said
    assert "Traceback" not in said
    return process.stdout


def pack(root, output):
    """Packs the sources below root with the library that is tested here, which says where the zips are."""
    words = [sys.executable, root / "native" / "cmake" / "package.py", "--output", output, "--files", *LIBRARIES]
    # The tool comes with the Python module bpy, which lies beside pytest also where Blender itself runs the tests.
    environment = {**os.environ, "PYTHONPATH": str(Path(pytest.__file__).parents[1])}
    done = subprocess.run(list(map(str, words)), env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    return zips_of(output)


def zips_of(output):
    """What package.py wrote for this system."""
    (legacy,) = output.glob("*-legacy.zip")
    (extension,) = (output / "repository").glob("*-linux-x64.zip")
    return {"legacy": legacy, "extension": extension, "index": output / "repository" / "index.json"}


def copy_sources(root):
    """What package.py reads, to be changed."""
    shutil.copytree(
        ADDON / "paradesc", root / "addon" / "paradesc", ignore=shutil.ignore_patterns("lib", "__pycache__")
    )
    for name in ("CMakeLists.txt", "LICENSE", "native/cmake/package.py"):
        (root / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(ROOT / name, root / name)


def replace(path, old, new):
    """Replaces text that has to be there."""
    text = path.read_text()
    assert re.search(old, text, re.M)
    path.write_text(re.sub(old, new, text, count=1, flags=re.M))


@pytest.fixture(scope="module")
def packed(tmp_path_factory):
    """This version's zips, with the library of this build."""
    return pack(ROOT, tmp_path_factory.mktemp("packages"))


@pytest.fixture(scope="module")
def packages(request):
    """This version's zips: the release's where tests/release.sh has built one."""
    release = os.environ.get("PARADESC_RELEASE")
    return zips_of(Path(release) / "packages") if release else request.getfixturevalue("packed")


@pytest.fixture(scope="module")
def newer_packages(tmp_path_factory):
    """Zips of a version 9.9.9, which has one name more in a module behind the first."""
    root = tmp_path_factory.mktemp("newer")
    copy_sources(root)
    addon = root / "addon" / "paradesc"
    replace(root / "CMakeLists.txt", r"^project\(paradesc VERSION \S+", "project(paradesc VERSION 9.9.9")
    replace(addon / "blender_manifest.toml", r'^version = ".*"', 'version = "9.9.9"')
    replace(addon / "__init__.py", r'"version": \(.*\)', '"version": (9, 9, 9)')
    with (addon / "bridge" / "__init__.py").open("a") as module:
        module.write('\nFRESH = "9.9.9"\n')
    return pack(root, tmp_path_factory.mktemp("newer_packages"))


def test_legacy_zip_installs_and_bakes(packages, tmp_path):
    in_blender(tmp_path, "legacy", packages["legacy"])


@EXTENSIONS
def test_extension_zip_installs_and_bakes(packages, tmp_path):
    in_blender(tmp_path, "extension", packages["extension"])


@EXTENSIONS
def test_legacy_zip_installs_as_an_extension_too(packages, tmp_path):
    in_blender(tmp_path, "extension", packages["legacy"])


def test_update_in_a_session_gives_new_code_and_asks_for_a_restart(packages, newer_packages, tmp_path):
    in_blender(tmp_path, "upgrade_legacy", packages["legacy"], newer_packages["legacy"])


@EXTENSIONS
def test_repository_installs_and_updates(packages, newer_packages, tmp_path):
    in_blender(tmp_path, "remote", packages["index"], newer_packages["index"])


def test_enabling_and_disabling_twenty_times_leaks_nothing(packages, tmp_path):
    in_blender(tmp_path, "cycles", packages["legacy"])


def test_zips_hold_the_addon_and_nothing_else(packed):
    expected = {str(path.relative_to(ADDON / "paradesc")) for path in (ADDON / "paradesc").rglob("*") if path.is_file()}
    expected = {name for name in expected if "__pycache__" not in name and not name.startswith("lib")}
    expected |= {f"lib/{path.name}" for path in LIBRARIES} | {"LICENSE"}
    assert set(zipfile.ZipFile(packed["extension"]).namelist()) == expected
    legacy = zipfile.ZipFile(packed["legacy"]).namelist()
    assert {name for name in legacy if not name.endswith("/")} == {f"paradesc/{name}" for name in expected}
    assert legacy[0] == "paradesc/"  # or Blender would unpack a newer zip into the folder of the older one


def test_sources_of_two_versions_are_not_packed(tmp_path):
    copy_sources(tmp_path)
    replace(tmp_path / "addon" / "paradesc" / "blender_manifest.toml", r'^version = ".*"', 'version = "0.0.1"')
    with pytest.raises(AssertionError, match="the versions differ"):
        pack(tmp_path, tmp_path / "output")


def bl_info():
    """What Blender before 4.2 reads without running the file."""
    tree = ast.parse((ADDON / "paradesc" / "__init__.py").read_text())
    return next(
        ast.literal_eval(node.value)
        for node in tree.body
        if isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == "bl_info"
    )


def manifest(name):
    """One text of the extension's manifest."""
    return re.search(rf'^{name} = "(.*)"', (ADDON / "paradesc" / "blender_manifest.toml").read_text(), re.M).group(1)


def test_all_say_the_same_version():
    project = re.search(r"^project\(paradesc VERSION (\S+)", (ROOT / "CMakeLists.txt").read_text(), re.M).group(1)
    native = library.text(library.load_library().pdesc_version())
    assert project == native == manifest("version") == ".".join(map(str, bl_info()["version"]))
    assert manifest("name") == bl_info()["name"]


def test_manifest_tagline_fits_the_platform():
    assert len(manifest("tagline")) <= 64
    assert manifest("tagline")[-1].isalnum()


def test_source_archive_without_library_says_so_in_one_sentence(tmp_path, monkeypatch):
    monkeypatch.setattr(library, "library_path", lambda: tmp_path / "lib" / "libparadesc.so")
    library.load_library.cache_clear()
    sentence = library.missing_sentence()
    library.load_library.cache_clear()
    assert sentence.startswith("native library missing – libparadesc.so is not in ")
    assert "release package" in sentence
    assert sentence.count(". ") == 0


def test_system_without_a_release_is_named(tmp_path, monkeypatch):
    monkeypatch.setattr(library.platform, "machine", lambda: "riscv64")
    with pytest.raises(library.ParadescError, match="this is Linux on riscv64"):
        library.open_library(tmp_path / "libparadesc.so")


def test_windows_loads_a_copy_that_does_not_lock_the_addon(tmp_path, monkeypatch):
    monkeypatch.setattr(library.sys, "platform", "win32")
    monkeypatch.setattr(library.tempfile, "gettempdir", lambda: str(tmp_path / "temporary"))
    (tmp_path / "temporary").mkdir()
    original = tmp_path / "paradesc.dll"
    original.write_bytes(b"first")
    first = library.unlocked(original)
    assert first.parent.parent == tmp_path / "temporary"
    assert first.read_bytes() == b"first"
    assert library.unlocked(original) == first
    original.write_bytes(b"second")
    assert library.unlocked(original) != first
    assert not list(first.parent.glob("tmp*"))


@pytest.mark.parametrize(("system", "says"), [("linux", False), ("win32", True), ("darwin", True)])
def test_panel_says_where_no_device_is_used(monkeypatch, system, says):
    monkeypatch.setattr(library.sys, "platform", system)
    assert ("slower" in library.without_devices()) == says
