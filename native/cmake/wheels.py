"""Packs the Python package: an sdist, and from what lies in it a wheel for each platform whose library is given.

Usage: wheels.py --output FOLDER (--folder PLATFORM=FOLDER)...    libraries of release builds, by platform
       wheels.py --output FOLDER --files FILE...                  those built for this system
       wheels.py ... --website ADDRESS                            names an address for indexes to link

A wheel that pip builds from the sdist differs in one thing: CMake builds its library. Needs scikit-build-core.
"""

import argparse
import contextlib
import json
import shutil
import sys
import tarfile
import tempfile
from pathlib import Path

from release import LIBRARIES, ROOT, given_libraries, library_arguments, version
from scikit_build_core.build import build_sdist, build_wheel

# The platform tags of the libraries, by the names of zig.cmake. Those for this system make no such promise.
TAGS = {
    "linux-x64": "manylinux_2_28_x86_64",
    "linux-arm64": "manylinux_2_28_aarch64",
    "windows-x64": "win_amd64",
    "windows-arm64": "win_arm64",
    "macos-x64": "macosx_10_13_x86_64",
    "macos-arm64": "macosx_11_0_arm64",
}
NAMES = {**LIBRARIES, "linux-arm64": LIBRARIES["linux-x64"]}


def make_sdist(source: Path, output: Path) -> Path:
    """The source archive of a checkout, or of an unpacked archive."""
    with contextlib.chdir(source):
        return output / build_sdist(str(output))


def link_website(source: Path, address: str) -> None:
    """Adds the address to the project's metadata in an unpacked sdist."""
    project, place = source / "pyproject.toml", "[project.optional-dependencies]\n"
    text = project.read_text(encoding="utf-8")
    if text.count(place) != 1:
        sys.exit(f"wheels.py: {project.name} has no one place for the website.")
    linked = text.replace(place, f"[project.urls]\nHomepage = {json.dumps(address)}\n\n{place}")
    project.write_text(linked, encoding="utf-8")


def make_wheel(source: Path, output: Path, files: list[Path], tag: str) -> Path:
    """A wheel of the unpacked sdist and these libraries, for the platform of a tag, or for this one."""
    settings = {"wheel.cmake": "false", "wheel.platlib": "true"}
    settings |= {f"wheel.force-include.{file.resolve()}": f"paradesc/lib/{file.name}" for file in files}
    if tag:
        settings["wheel.tags"] = f"py3-none-{tag}"
    with contextlib.chdir(source):
        return output / build_wheel(str(output), settings)


def package(output: Path, libraries: dict[str, list[Path]], tags: dict[str, str], website: str = "") -> list[Path]:
    """Writes the sdist and all wheels into an empty folder; returns them."""
    version()  # those of all files agree
    shutil.rmtree(output, ignore_errors=True)
    output.mkdir(parents=True)
    written = [make_sdist(ROOT, output)]
    with tempfile.TemporaryDirectory() as work:
        with tarfile.open(written[0]) as archive:
            archive.extractall(work)
        source = Path(work) / written[0].name.removesuffix(".tar.gz")
        if website:
            link_website(source, website)
            written = [make_sdist(source, output)]  # in place of the first
        for name, files in libraries.items():
            written.append(make_wheel(source, output, files, tags.get(name, "")))
    return written


def main() -> int:
    """Packs, and says what was written."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter, parents=[library_arguments()]
    )
    parser.add_argument("--website", default="", metavar="ADDRESS", help="the project's home page; default: none")
    arguments = parser.parse_args()
    tags = TAGS if arguments.folder else {}
    libraries = given_libraries(arguments, NAMES)
    for path in package(arguments.output.resolve(), libraries, tags, arguments.website):
        sys.stdout.write(f"{path.stat().st_size:>9,} bytes  {path}\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
