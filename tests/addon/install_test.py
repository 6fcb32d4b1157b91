"""The add-on as users get it: packed, installed from the zips, updated, disabled and enabled; and its versions."""

import ast
import os
import re
import shutil
import subprocess
import sys
import zipfile
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from importlib.util import find_spec
from pathlib import Path
from threading import Thread

import pytest

from paradesc.bridge import library
from shapes import ADDON, ROOT

bpy = pytest.importorskip("bpy", reason="needs Blender")
from processes import run_blender, script_words  # noqa: E402

DROPPED = "ui/README.md"
SCRIPT = Path(__file__).with_name("install_in_blender.py")
LIBRARIES = sorted((ADDON / "paradesc" / "lib").glob("*.so*"))
EXTENSIONS = pytest.mark.skipif(bpy.app.version < (4, 2, 0), reason="extensions came with Blender 4.2")


def in_blender(tmp_path, *words):
    """Runs one action of install_in_blender.py in a Blender whose user folders are those of tmp_path."""
    said = run_blender([*script_words(SCRIPT), *words], tmp_path / "user")
    assert f"{words[0]} done" in said, said
    return said


def pack(root, output, *words):
    """Packs the sources below root, with the library under test unless words name another."""
    given = words or ("--files", *LIBRARIES)
    words = [sys.executable, root / "native" / "cmake" / "package.py", "--output", output, *given]
    # The tool comes with the Python module bpy, which lies beside pytest even if Blender itself runs the tests.
    environment = {**os.environ, "PYTHONPATH": str(Path(pytest.__file__).parents[1])}
    done = subprocess.run(list(map(str, words)), env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    return zips_of(output)


def zips_of(output):
    """The zips that package.py wrote for this system, or for the only one."""
    (legacy,) = output.glob("*-legacy.zip")
    extensions = sorted((output / "repository").glob("*.zip"))
    extension = next((path for path in extensions if path.stem.endswith("-linux-x64")), extensions[0])
    return {"legacy": legacy, "extension": extension, "index": output / "repository" / "index.json"}


def copy_sources(root):
    """Copies what package.py reads, to be changed."""
    for name in ("paradesc", "paradesc_blender", "manual"):
        left_out = shutil.ignore_patterns("lib", "__pycache__")
        shutil.copytree(ADDON / name, root / "addon" / name, ignore=left_out)
    for name in (
        "CMakeLists.txt",
        "LICENSE",
        "pyproject.toml",
        "addon/CHANGELOG.md",
        "addon/PACKAGE.md",
        *(f"native/cmake/{script}.py" for script in ("manual", "package", "release", "wheels")),
    ):
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
    """This version's zips; those of the release if tests/release.sh has built one."""
    release = os.environ.get("PARADESC_RELEASE")
    return zips_of(Path(release) / "packages") if release else request.getfixturevalue("packed")


@pytest.fixture(scope="module")
def newer_packages(tmp_path_factory):
    """Zips of a version 9.9.9 with its library, one more name in a module behind the first, and one file less."""
    root = tmp_path_factory.mktemp("newer")
    copy_sources(root)
    addon, package = root / "addon" / "paradesc_blender", root / "addon" / "paradesc"
    replace(root / "CMakeLists.txt", r"^project\(paradesc VERSION \S+", "project(paradesc VERSION 9.9.9")
    replace(package / "__init__.py", r'^__version__ = ".*"', '__version__ = "9.9.9"')
    replace(addon / "blender_manifest.toml", r'^version = ".*"', 'version = "9.9.9"')
    replace(addon / "__init__.py", r'"version": \(.*\)', '"version": (9, 9, 9)')
    with (addon / "__init__.py").open("a") as module:
        module.write('\nFRESH = "9.9.9"\n')
    (addon / DROPPED).unlink()
    return pack(root, tmp_path_factory.mktemp("newer_packages"), "--files", *newer_libraries(root / "lib"))


def newer_libraries(folder):
    """Copies of the libraries in which ours calls itself 9.9.9."""
    folder.mkdir()
    old, new = (b"\0" + word.encode() + b"\0" for word in (manifest("version"), "9.9.9"))
    for path in LIBRARIES:
        content = path.read_bytes()
        if path.name == "libparadesc.so":
            assert content.count(old) == 1
            assert len(old) == len(new)
            content = content.replace(old, new)
        (folder / path.name).write_bytes(content)
    return sorted(folder.iterdir())


@pytest.fixture
def served(monkeypatch):
    """Gives the address of an index.json on a web server that has its folder."""
    servers = []

    def serve(index):
        handler = partial(QuietHandler, directory=str(index.parent))
        servers.append(ThreadingHTTPServer(("127.0.0.1", 0), handler))
        Thread(target=servers[-1].serve_forever, daemon=True).start()
        return f"http://127.0.0.1:{servers[-1].server_port}/{index.name}"

    monkeypatch.setenv("no_proxy", "127.0.0.1")
    yield serve
    for server in servers:
        server.shutdown()
        server.server_close()


class QuietHandler(SimpleHTTPRequestHandler):
    """Serves files and writes no log."""

    def log_message(self, *_words):
        """Logs nothing."""


def installed(tmp_path, module):
    """Names of the files of an installed add-on, except what Python has compiled."""
    folder = tmp_path / "user" / module
    files = {str(path.relative_to(folder)) for path in folder.rglob("*") if path.is_file()}
    return {name for name in files if "__pycache__" not in name}


def names_in(package):
    """Names of the files in a zip."""
    return {name for name in zipfile.ZipFile(package).namelist() if not name.endswith("/")}


@pytest.mark.slow
def test_legacy_zip_installs_and_bakes(packages, tmp_path):
    in_blender(tmp_path, "legacy", packages["legacy"])
    assert installed(tmp_path, "scripts/addons") == names_in(packages["legacy"])


@EXTENSIONS
def test_extension_zip_installs_and_bakes(packages, tmp_path):
    in_blender(tmp_path, "extension", packages["extension"])
    assert installed(tmp_path, "extensions/user_default/paradesc") == names_in(packages["extension"])


@pytest.mark.slow
@EXTENSIONS
def test_extension_zip_of_another_system_is_refused_by_blender(tmp_path):
    library_file = tmp_path / "libparadesc-arm64.dylib"
    library_file.write_bytes(b"of a Mac")
    other = pack(ROOT, tmp_path / "output", "--folder", f"macos-arm64={tmp_path}")
    said = in_blender(tmp_path, "refused", other["extension"])
    assert "This platform (linux-x64) isn't one of (macos-arm64)" in said, said
    assert not installed(tmp_path, "extensions/user_default/paradesc")


# Each of them also starts Blender again, and uses the older version's library before the newer one comes.
UPDATES = {
    "legacy": ("scripts/addons", "paradesc_blender"),
    "extension": ("extensions/user_default/paradesc", "bl_ext.user_default.paradesc"),
    "index": ("extensions/paradesc_releases/paradesc", "bl_ext.paradesc_releases.paradesc"),
}


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["legacy", *(pytest.param(kind, marks=EXTENSIONS) for kind in ("extension", "index"))])
def test_update_keeps_settings_and_presets_and_leaves_no_old_file(kind, packages, newer_packages, served, tmp_path):
    folder, module = UPDATES[kind]
    name = "legacy" if kind == "legacy" else "extension"
    zips = packages[name], newer_packages[name]
    assert any(name.endswith(DROPPED) for name in names_in(zips[0]) - names_in(zips[1]))
    if kind == "index":
        in_blender(tmp_path, "upgrade_remote", served(packages["index"]), served(newer_packages["index"]))
    else:
        in_blender(tmp_path, f"upgrade_{kind}", *zips)
    assert installed(tmp_path, folder) == names_in(zips[1])
    restarted(tmp_path, module)


def restarted(tmp_path, module):
    """Starts again with the preferences that the first start saved."""
    words = [word for word in script_words(SCRIPT) if word != "--factory-startup"]
    said = run_blender([*words, "after_restart", module], tmp_path / "user")
    assert "after_restart done" in said, said


@pytest.mark.slow
@EXTENSIONS
def test_repository_in_a_folder_installs_too(packages, tmp_path):
    in_blender(tmp_path, "remote", packages["index"].as_uri())


@EXTENSIONS
def test_blenders_extension_command_lists_and_installs_from_the_repository(packages, served, tmp_path):
    folder, address = tmp_path / "local", served(packages["index"])
    said = extension_command("list", "--remote-url", address, "--local-dir", folder)
    assert f"paradesc({manifest('version')})" in said, said
    place = ["--remote-url", address, "--local-dir", folder]
    extension_command("sync", *place)
    extension_command("install", *place, "--blender-version", "{}.{}.{}".format(*bpy.app.version), "paradesc")
    names = {str(path.relative_to(folder / "paradesc")) for path in (folder / "paradesc").rglob("*") if path.is_file()}
    assert names == names_in(packages["extension"])


def extension_command(*words):
    """Runs what `blender -c extension` runs, because only the program has that command; gives its output."""
    script = Path(bpy.utils.system_resource("SCRIPTS")) / "addons_core" / "bl_pkg" / "cli" / "blender_ext.py"
    words = [sys.executable, script, *words]
    done = subprocess.run(list(map(str, words)), capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.mark.slow
def test_enabling_and_disabling_twenty_times_leaks_nothing(packages, tmp_path):
    in_blender(tmp_path, "cycles", packages["legacy"])


def test_zips_hold_the_addon_and_nothing_else(packed):
    addon = sources_of("paradesc_blender") | {"LICENSE"} | names_of_the_manual()
    extension = names_in(packed["extension"])
    (wheel,) = extension - addon
    assert re.fullmatch(r"wheels/paradesc-[\d.]+-py3-none-linux_\w+\.whl", wheel)
    assert f'wheels = ["./{wheel}"]' in read_in(packed["extension"], "blender_manifest.toml")
    assert extension == addon | {wheel}
    package = sources_of("paradesc") | {f"lib/{path.name}" for path in LIBRARIES}
    expected = {f"paradesc_blender/{name}" for name in addon} | {f"paradesc/{name}" for name in package}
    assert names_in(packed["legacy"]) == expected
    legacy = zipfile.ZipFile(packed["legacy"]).namelist()  # folders, or Blender would unpack a newer zip into the older one
    assert {"paradesc/", "paradesc_blender/"} <= set(legacy)


def sources_of(name):
    """The files of a package in the source tree, without libraries."""
    found = {str(path.relative_to(ADDON / name)) for path in (ADDON / name).rglob("*") if path.is_file()}
    return {name for name in found if "__pycache__" not in name and not name.startswith("lib")}


def read_in(package, name):
    """The text of a file in a zip."""
    return zipfile.ZipFile(package).read(name).decode()


def names_of_the_manual():
    """Every page and picture, as web pages where the Python package that makes them is there."""
    pictures = ADDON / "manual" / "pictures"
    shown = [path for ending in ("png", "jpg", "gif") for path in pictures.rglob(f"*.{ending}")]
    names = {f"manual/pictures/{path.relative_to(pictures)}" for path in shown}
    pages = {path.stem for path in (ADDON / "manual").glob("*.md")} | {"CHANGELOG"}
    if find_spec("markdown") is None:
        return names | {f"manual/{page}.md" for page in pages}
    return names | {f"manual/{page.lower()}.html" for page in pages - {"README"}} | {"manual/index.html"}


@pytest.mark.slow
def test_packages_link_an_address_where_one_is_given(packed, tmp_path):
    address = "https://example.org/paradesc"
    linked = pack(ROOT, tmp_path / "linked", "--files", *LIBRARIES, f"--website={address}")
    for zips, times in ((packed, 0), (linked, 1)):
        manifest_text = zipfile.ZipFile(zips["extension"]).read("blender_manifest.toml").decode()
        module = zipfile.ZipFile(zips["legacy"]).read("paradesc_blender/__init__.py").decode()
        assert manifest_text.count(f'website = "{address}"') == times
        assert module.count(f'"doc_url": "{address}"') == times


def test_sources_of_two_versions_are_not_packed(tmp_path):
    copy_sources(tmp_path)
    replace(tmp_path / "addon" / "paradesc_blender" / "blender_manifest.toml", r'^version = ".*"', 'version = "0.0.1"')
    with pytest.raises(AssertionError, match="the versions differ"):
        pack(tmp_path, tmp_path / "output")


def bl_info():
    """The dictionary that Blender before 4.2 reads without running the file."""
    tree = ast.parse((ADDON / "paradesc_blender" / "__init__.py").read_text())
    return next(
        ast.literal_eval(node.value)
        for node in tree.body
        if isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == "bl_info"
    )


def manifest(name):
    """One text of the extension's manifest."""
    return re.search(rf'^{name} = "(.*)"', (ADDON / "paradesc_blender" / "blender_manifest.toml").read_text(), re.M).group(1)


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
