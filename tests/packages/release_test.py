"""The libraries of a release as users get them: what they need and export, and that all compute the same bits.

tests/release.sh runs this; it builds them and names their folder in PARADESC_RELEASE.
"""

import io
import math
import os
import re
import shutil
import subprocess
import zipfile
from pathlib import Path

import lief
import pytest

RELEASE = Path(os.environ["PARADESC_RELEASE"])
HEADERS = sorted((Path(__file__).resolve().parents[2] / "native" / "include" / "paradesc").glob("*.h"))
NEWEST_GLIBC = (2, 28)  # of the systems that Blender is built on: Rocky Linux 8
LIBRARIES = {
    "linux-x64": "libparadesc.so",
    "windows-x64": "paradesc.dll",
    "windows-arm64": "paradesc.dll",
    "macos-x64": "libparadesc-x86_64.dylib",
    "macos-arm64": "libparadesc-arm64.dylib",
}
WITHOUT_BLENDER = {"linux-arm64": "libparadesc.so"}  # for wheels alone
LINUX = {"linux-x64": "ld-linux-x86-64.so.2", "linux-arm64": "ld-linux-aarch64.so.1"}
WINDOWS = {"windows-x64": "AMD64", "windows-arm64": "ARM64"}
MACS = {"macos-x64": "x86_64", "macos-arm64": "arm64"}
WINE = next((path for path in map(Path, ("/usr/lib/wine/wine64", "/usr/bin/wine64")) if path.is_file()), None)
# Who runs another processor's program: words before it, and how to get them.
ON_ARM = ("qemu-aarch64-static", "-L", "/usr/aarch64-linux-gnu")
ON_OLD_X64 = ("qemu-x86_64-static", "-cpu", "qemu64")  # without AVX
# Zig's C++ library leaves these visible on a Mac: marks of every library, and operators new and delete as weak symbols,
# which those of the system replace.
MAC_EXTRAS = re.compile(r"__mh_dylib_header|___dso_handle|__Zn[wa]m.*|__Zd[la]Pv.*")


def path_of(platform):
    """The path of a platform's library."""
    return RELEASE / platform / {**LIBRARIES, **WITHOUT_BLENDER}[platform]


def public_functions():
    """The functions that the headers declare."""
    text = "".join(header.read_text() for header in HEADERS)
    return set(re.findall(r"^PDESC_API .*?\b(pdesc_\w+)\(", text, re.M))


def exports(platform):
    """The names that a library exports."""
    binary = lief.parse(str(path_of(platform)))
    entries = binary.get_export().entries if platform in WINDOWS else binary.exported_symbols
    return {entry.name for entry in entries}


def test_header_declares_functions():
    assert {"pdesc_abi_version", "pdesc_compute", "pdesc_field_destroy"} <= public_functions()


@pytest.mark.parametrize("platform", [*LINUX, *WINDOWS])
def test_library_shows_the_public_functions_alone(platform):
    assert exports(platform) == public_functions()


@pytest.mark.parametrize("platform", MACS)
def test_mac_library_shows_the_public_functions(platform):
    names = {name for name in exports(platform) if not MAC_EXTRAS.fullmatch(name)}
    assert names == {f"_{name}" for name in public_functions()}


@pytest.mark.parametrize("platform", LINUX)
def test_linux_library_runs_with_glibc_2_28(platform):
    binary = lief.parse(str(path_of(platform)))
    names = {aux.name for need in binary.symbols_version_requirement for aux in need.get_auxiliary_symbols()}
    versions = sorted(tuple(map(int, re.findall(r"\d+", name))) for name in names)
    print(f"lowest glibc of {platform}:", ".".join(map(str, versions[-1])))  # noqa: T201
    assert all(name.startswith("GLIBC_") for name in names)
    assert versions[-1] <= NEWEST_GLIBC


@pytest.mark.parametrize(("platform", "loader"), LINUX.items())
def test_linux_library_needs_the_c_library_alone(platform, loader):
    binary = lief.parse(str(path_of(platform)))
    assert set(binary.libraries) <= {"libc.so.6", "libm.so.6", "libpthread.so.0", "libdl.so.2", loader}


@pytest.mark.parametrize(("platform", "machine"), WINDOWS.items())
def test_windows_library_needs_windows_alone(platform, machine):
    binary = lief.parse(str(path_of(platform)))  # kept, because its parts live only as long as it does
    names = {entry.name.lower() for entry in binary.imports}
    assert all(name in {"kernel32.dll", "ntdll.dll"} or name.startswith("api-ms-win-crt-") for name in names), names
    assert str(binary.header.machine).rsplit(".", 1)[-1].upper() == machine


@pytest.mark.parametrize(("platform", "machine"), MACS.items())
def test_mac_library_needs_the_system_alone_and_is_found_by_its_name(platform, machine):
    binary = lief.parse(str(path_of(platform)))
    own, *needed = [library.name for library in binary.libraries]
    assert own == f"@rpath/libparadesc-{machine}.dylib"
    assert needed == ["/usr/lib/libSystem.B.dylib"]
    assert str(binary.header.cpu_type).lower().endswith(machine)
    assert machine != "arm64" or binary.has_code_signature  # macOS kills an unsigned one


def printed(words):
    """The lines that a caller of the library prints."""
    environment = {**os.environ, "WINEPREFIX": str(RELEASE / "wine"), "WINEDEBUG": "-all"}
    environment["WINEDLLOVERRIDES"] = "mscoree=;mshtml="
    done = subprocess.run(
        list(map(str, words)), env=environment, capture_output=True, text=True, timeout=600, check=True
    )
    return done.stdout.splitlines()


def curvatures(words):
    """The values that sphere_curvature prints: version, device, and values by descriptor."""
    return dict(line.split(" ", 1) for line in printed(words))


def under_wine(program):
    """The words that run a Windows program with the Windows library."""
    if WINE is None:
        pytest.skip("wine64 is not here")
    library = "Z:" + str(path_of("windows-x64")).replace("/", "\\")
    return [WINE, RELEASE / "windows-x64" / f"{program}.exe", library]


@pytest.fixture(scope="module")
def bits():
    """The lines of the Linux library on this processor."""
    found = printed([RELEASE / "linux-x64" / "bits", path_of("linux-x64")])
    assert len(found) == len(set(found)) >= (3 * 7 + 2) * 20  # shapes and settings, those at texels, descriptors
    return found


def emulated(words, platform):
    """The words that run the caller of a platform by an emulator, if that is here."""
    if shutil.which(words[0]) is None or not all(Path(word).is_dir() for word in words if word.startswith("/")):
        pytest.skip(f"{words[0]} is not here, or the libraries that it needs")
    return [*words, RELEASE / platform / "bits", RELEASE / platform / "libparadesc.so"]


@pytest.mark.parametrize("threads", [1, 3])
def test_any_number_of_threads_computes_the_same_bits(bits, threads):
    assert printed([RELEASE / "linux-x64" / "bits", path_of("linux-x64"), threads]) == bits


def test_another_compilers_library_computes_the_same_bits(bits):
    library = os.environ.get("PARADESC_OTHER_LIBRARY")
    if not library:
        pytest.skip("PARADESC_OTHER_LIBRARY names none")
    assert printed([RELEASE / "linux-x64" / "bits", library]) == bits


def test_windows_library_computes_the_same_bits(bits):
    assert printed(under_wine("bits")) == bits


def test_windows_library_computes_the_same_bits_by_opengl():
    if shutil.which("xvfb-run") is None:
        pytest.skip("xvfb-run is not here")
    ours = printed([RELEASE / "linux-x64" / "bits", path_of("linux-x64"), "software"])
    assert len(ours) == len(set(ours)) >= 2 * 5 * 20  # shapes with a map, settings, descriptors
    # Wine hands OpenGL on to the same rasterizer; a screen is where it begins.
    assert printed(["xvfb-run", "-a", *under_wine("bits"), "software"]) == ours


def test_arm_processors_compute_the_same_bits(bits):
    assert printed(emulated(ON_ARM, "linux-arm64")) == bits


def test_processors_without_avx_compute_the_same_bits(bits):
    assert printed(emulated(ON_OLD_X64, "linux-x64")) == bits


def test_windows_library_computes_as_the_linux_one_does():
    linux = RELEASE / "linux-x64"
    ours = curvatures([linux / "sphere_curvature", path_of("linux-x64")])
    theirs = curvatures(under_wine("sphere_curvature"))
    assert theirs["device"].startswith("CPU")  # found by backend auto
    assert theirs["version"] == ours["version"]
    for name in ("mean_curvature", "gaussian_curvature", "sphere_volume"):
        values, expected = ([float(word) for word in found[name].split()] for found in (theirs, ours))
        assert len(values) == len(expected) == 17 * 24
        # The library has the same bits; the sines that the mesh is made of may differ in the last one.
        assert all(math.isclose(a, b, rel_tol=1e-6) for a, b in zip(values, expected, strict=True)), name
    middle = float(theirs["mean_curvature"].split()[8 * 24])
    assert math.isclose(middle, 0.5, rel_tol=0.02)  # a sphere of radius 2, as a polyhedron


def test_zips_hold_the_libraries_that_were_tested():
    zips = {path.name: path for path in (RELEASE / "packages").rglob("*.zip")}
    assert len(zips) == 1 + len(LIBRARIES)
    for platform, name in LIBRARIES.items():
        extension = next(path for key, path in zips.items() if key.endswith(f"-{platform}.zip"))
        archive = zipfile.ZipFile(extension)
        (wheel,) = (entry for entry in archive.namelist() if entry.startswith("wheels/"))
        with zipfile.ZipFile(io.BytesIO(archive.read(wheel))) as package:
            assert [entry for entry in package.namelist() if "/lib/" in entry] == [f"paradesc/lib/{name}"]
            assert package.read(f"paradesc/lib/{name}") == path_of(platform).read_bytes()
        assert f'platforms = ["{platform}"]' in archive.read("blender_manifest.toml").decode()
    legacy = zipfile.ZipFile(next(path for key, path in zips.items() if key.endswith("-legacy.zip")))
    found = [Path(entry) for entry in legacy.namelist() if "/lib/l" in entry or "/lib/p" in entry]
    assert sorted(path.name for path in found) == sorted(set(LIBRARIES.values()))
    inside = next(entry for entry in legacy.namelist() if entry.endswith("paradesc.dll"))
    assert legacy.read(inside) == path_of("windows-x64").read_bytes()  # Windows on ARM has no Blender that reads it


def test_libraries_are_stripped_and_small():
    for platform in (*LIBRARIES, *WITHOUT_BLENDER):
        assert path_of(platform).stat().st_size < 4e6, platform
