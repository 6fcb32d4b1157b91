"""Packs the add-on, its manual and the Python package: an extension a platform, an index, a zip for Blender before 4.2.

Usage: package.py --output FOLDER (--folder PLATFORM=FOLDER)...    libraries of release builds, by platform
       package.py --output FOLDER --files FILE...                  those built for this system
       package.py ... --website ADDRESS                            names an address for Blender to link

An extension holds the package as the wheel that wheels.py makes. Blender's own extension tool builds and validates:
that of the Python module bpy if it is installed, else that of a Blender from 4.2 on.
"""

import argparse
import importlib.util
import json
import re
import shutil
import subprocess
import sys
import tempfile
import zipfile
from pathlib import Path

from release import ADDON, LIBRARIES, PACKAGE, ROOT, first, given_libraries, library_arguments, version

from manual import write_manual

# Blender runs there from 4.5 on: the zip for older ones has nothing for it, and one place for each name.
ONLY_EXTENSIONS = {"windows-arm64"}
# The folders' pages are packed: whoever opens an installed add-on finds its way by them.
LEFT_OUT = shutil.ignore_patterns("__pycache__", "*.pyc", "lib")


def extension_tool() -> list[str]:
    """The words that start Blender's extension tool."""
    found = importlib.util.find_spec("bpy")
    if found and found.origin:
        for script in sorted(Path(found.origin).parent.glob("*/scripts/addons_core/bl_pkg/cli/blender_ext.py")):
            return [sys.executable, str(script)]
    blender = shutil.which("blender")
    if blender:
        said = subprocess.run([blender, "--version"], capture_output=True, text=True, check=False).stdout
        if tuple(map(int, (first(r"Blender (\d+\.\d+)", said) or "0.0").split("."))) >= (4, 2):
            return [blender, "--command", "extension"]
    sys.exit("package.py: Blender's extension tool is missing; install the Python module bpy, or Blender 4.2 or later.")


def run(*words: object) -> None:
    """Runs a command; its failure ends this script."""
    done = subprocess.run([str(word) for word in words], capture_output=True, text=True, check=False)
    if done.returncode != 0:
        sys.exit(f"package.py: {' '.join(map(str, words))} failed:\n{done.stdout}{done.stderr}")


def stage(folder: Path, website: str) -> None:
    """The add-on as it is installed, with its manual."""
    shutil.copytree(ADDON, folder, ignore=LEFT_OUT)
    shutil.copy(ROOT / "LICENSE", folder)
    write_manual(folder / "manual", ROOT / "addon")
    if website:
        link_website(folder, website)


def stage_extension(folder: Path, platform: str, wheel: Path, website: str) -> None:
    """An extension for one platform, which brings the package as a wheel."""
    stage(folder, website)
    (folder / "wheels").mkdir()
    shutil.copy(wheel, folder / "wheels")
    manifest = folder / "blender_manifest.toml"
    lines = f'platforms = ["{platform}"]\nwheels = ["./wheels/{wheel.name}"]'
    text = re.sub(r"^platforms = .*$", lines, manifest.read_text(encoding="utf-8"), flags=re.M)
    manifest.write_text(text, encoding="utf-8")


def stage_legacy(folder: Path, libraries: dict[str, list[Path]], website: str = "") -> None:
    """Both packages side by side, with the libraries of these platforms, as Blender before 4.2 has them."""
    stage(folder / ADDON.name, website)
    shutil.copytree(PACKAGE, folder / PACKAGE.name, ignore=LEFT_OUT)
    (folder / PACKAGE.name / "lib").mkdir()
    for file in (file for files in libraries.values() for file in files):
        shutil.copy(file, folder / PACKAGE.name / "lib")


def link_website(folder: Path, address: str) -> None:
    """Names an address in the manifest and in bl_info."""
    for name, line, link in (
        ("blender_manifest.toml", r"^tagline = .*$", f"website = {json.dumps(address)}"),
        ("__init__.py", r'^ +"category": .*$', f'    "doc_url": {json.dumps(address)},'),
    ):
        file = folder / name
        text = file.read_text(encoding="utf-8")
        found = re.search(line, text, re.M)
        if found is None:
            sys.exit(f"package.py: {name} has no line to put the website behind.")
        file.write_text(f"{text[: found.end()]}\n{link}{text[found.end() :]}", encoding="utf-8")


def write_zip(folder: Path, target: Path) -> None:
    """All that is in a folder, in an order that does not depend on the file system.

    Folders have to be entries: only then does Blender remove an installed add-on before it unpacks a newer one. Else it
    would write into a library that is loaded, and crash.
    """
    with zipfile.ZipFile(target, "w", zipfile.ZIP_DEFLATED, compresslevel=9) as archive:
        for path in sorted(folder.rglob("*")):
            archive.write(path, path.relative_to(folder))


def package(output: Path, libraries: dict[str, list[Path]], is_release: bool, website: str) -> list[Path]:
    """Writes all packages into an empty folder and has them validated; returns the zips."""
    import wheels  # which needs scikit-build-core

    tool = extension_tool()
    known = valid_tags(tool)
    name = f"paradesc-{version()}"
    repository = output / "repository"
    shutil.rmtree(output, ignore_errors=True)
    repository.mkdir(parents=True)
    zips = [output / f"{name}-legacy.zip"]
    with tempfile.TemporaryDirectory() as work:
        older = {name: files for name, files in libraries.items() if name not in ONLY_EXTENSIONS}
        stage_legacy(Path(work) / "legacy", older, website)
        write_zip(Path(work) / "legacy", zips[0])
        _, *made = wheels.package(Path(work) / "wheels", libraries, wheels.TAGS if is_release else {}, website)
        for platform, wheel in zip(libraries, made, strict=True):
            source = Path(work) / platform
            stage_extension(source, platform, wheel, website)
            target = repository / f"{name}-{platform}.zip"
            run(*tool, "build", "--source-dir", source, "--output-filepath", target, *known)
            zips.append(target)
    for path in zips[1:]:
        run(*tool, "validate", path, *known)
    run(*tool, "server-generate", "--repo-dir", repository, "--html")
    return zips


def valid_tags(tool: list[str]) -> list[str]:
    """The list of tags that Blender knows, which its own executable finds by itself."""
    if not tool[-1].endswith(".py"):
        return []
    return ["--valid-tags", str(Path(tool[-1]).parents[3] / "modules" / "_bpy_internal" / "extensions" / "tags.py")]


def main() -> int:
    """Packs, and says what was written."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter, parents=[library_arguments()]
    )
    parser.add_argument("--website", default="", metavar="ADDRESS", help="linked as doc_url and website; default: none")
    arguments = parser.parse_args()
    libraries = given_libraries(arguments, LIBRARIES)
    for path in package(arguments.output.resolve(), libraries, bool(arguments.folder), arguments.website):
        sys.stdout.write(f"{path.stat().st_size:>9,} bytes  {path}\n")
    sys.stdout.write(f"repository       {arguments.output.resolve() / 'repository' / 'index.json'}\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
