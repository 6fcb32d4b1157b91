"""The content of a release's wheels and sdist; tests/wheels.sh, which runs this, also tests that they run.

PARADESC_WHEELS names their folder, PARADESC_RELEASE that of the libraries.
"""

import base64
import csv
import email
import hashlib
import io
import os
import re
import tarfile
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
WHEELS = Path(os.environ["PARADESC_WHEELS"])
RELEASE = Path(os.environ["PARADESC_RELEASE"])
SIZE = 3e6  # bytes of a wheel, at most
# By the tag of a wheel: the release build whose library it holds, and that library.
PLATFORMS = {
    "manylinux_2_28_x86_64": ("linux-x64", "libparadesc.so"),
    "manylinux_2_28_aarch64": ("linux-arm64", "libparadesc.so"),
    "win_amd64": ("windows-x64", "paradesc.dll"),
    "win_arm64": ("windows-arm64", "paradesc.dll"),
    "macosx_10_13_x86_64": ("macos-x64", "libparadesc-x86_64.dylib"),
    "macosx_11_0_arm64": ("macos-arm64", "libparadesc-arm64.dylib"),
}
# The targets of native/cmake/zig.cmake that each tag stands for.
TARGETS = {
    r"manylinux_(\d+)_(\d+)_(\w+)": r"\3-linux-gnu.\1.\2",
    r"macosx_(\d+)_(\d+)_x86_64": r"x86_64-macos.\1.\2",
    r"macosx_(\d+)_(\d+)_arm64": r"aarch64-macos.\1.\2",
    "win_amd64": "x86_64-windows-gnu",
    "win_arm64": "aarch64-windows-gnu",
}
SOURCES = {
    path.relative_to(ROOT / "addon").as_posix(): path
    for path in (ROOT / "addon" / "paradesc").rglob("*")
    if path.is_file() and not {"lib", "__pycache__"} & set(path.parts)
}


def version():
    """The version of the package's source."""
    return re.search(r'^__version__ = "(.+)"', SOURCES["paradesc/__init__.py"].read_text(), re.M)[1]


@pytest.fixture(params=PLATFORMS)
def tag(request):
    """The platform of a wheel."""
    return request.param


@pytest.fixture
def wheel(tag):
    """A wheel as an archive."""
    with zipfile.ZipFile(WHEELS / f"paradesc-{version()}-py3-none-{tag}.whl") as archive:
        yield archive


def described(wheel, name):
    """A file of a wheel's own description, of which there is one."""
    return wheel.read(f"paradesc-{version()}.dist-info/{name}").decode()


def test_there_is_a_wheel_for_each_platform_and_one_sdist():
    expected = {f"paradesc-{version()}-py3-none-{tag}.whl" for tag in PLATFORMS} | {f"paradesc-{version()}.tar.gz"}
    assert {path.name for path in WHEELS.iterdir()} == expected


def test_tag_promises_what_the_library_was_built_for(tag):
    pattern = next(pattern for pattern in TARGETS if re.fullmatch(pattern, tag))
    target = re.sub(pattern, TARGETS[pattern], tag)
    assert f'"{PLATFORMS[tag][0]}|{target}|' in (ROOT / "native" / "cmake" / "zig.cmake").read_text()


def test_wheel_is_small(wheel):
    assert Path(wheel.filename).stat().st_size <= SIZE


def test_wheel_holds_the_package_and_the_library_of_its_platform(wheel, tag):
    folder, library = PLATFORMS[tag]
    found = {name for name in wheel.namelist() if not name.startswith(f"paradesc-{version()}.dist-info/")}
    assert found == {*SOURCES, f"paradesc/lib/{library}"}
    assert wheel.read(f"paradesc/lib/{library}") == (RELEASE / folder / library).read_bytes()
    assert all(wheel.read(name) == path.read_bytes() for name, path in SOURCES.items())


def test_record_names_every_file_with_its_hash_and_size(wheel):
    rows = {name: (digest, size) for name, digest, size in csv.reader(io.StringIO(described(wheel, "RECORD")))}
    own = f"paradesc-{version()}.dist-info/RECORD"
    assert set(rows) == set(wheel.namelist())
    assert rows.pop(own) == ("", "")
    for name, (digest, size) in rows.items():
        content = wheel.read(name)
        expected = base64.urlsafe_b64encode(hashlib.sha256(content).digest()).rstrip(b"=").decode()
        assert (digest, int(size)) == (f"sha256={expected}", len(content)), name


def test_wheel_says_that_it_is_for_one_platform_and_any_python(wheel, tag):
    fields = email.message_from_string(described(wheel, "WHEEL"))
    assert fields["Root-Is-Purelib"] == "false"
    assert fields.get_all("Tag") == [f"py3-none-{tag}"]


def test_wheel_needs_numpy_alone(wheel):
    fields = email.message_from_string(described(wheel, "METADATA"))
    needed = [need for need in fields.get_all("Requires-Dist") if "extra ==" not in need]
    assert [re.match(r"\w+", need)[0] for need in needed] == ["numpy"]
    assert (fields["Name"], fields["Version"]) == ("paradesc", version())
    assert fields["License-Expression"] == "GPL-3.0-or-later"
    assert {"LICENSE", "addon/paradesc/NOTICE.txt"} <= set(fields.get_all("License-File"))
    assert "paradesc = paradesc.cli:command" in described(wheel, "entry_points.txt")


def test_sdist_holds_what_the_library_is_built_from_and_no_library():
    with tarfile.open(WHEELS / f"paradesc-{version()}.tar.gz") as archive:
        found = {Path(*Path(name).parts[1:]).as_posix() for name in archive.getnames()}
    sources = [path for folder in ("native", "shaders") for path in (ROOT / folder).rglob("*") if path.is_file()]
    needed = {path.relative_to(ROOT).as_posix() for path in sources if "__pycache__" not in path.parts}
    needed |= {f"addon/{name}" for name in [*SOURCES, "PACKAGE.md"]} | {"CMakeLists.txt", "LICENSE", "pyproject.toml"}
    assert needed <= found
    assert not [name for name in found if name.endswith((".so", ".dll", ".dylib", ".png", ".pyc"))]
