"""Packs the add-on, its manual and native libraries: a zip for Blender before 4.2, an extension a platform, an index.

Usage: package.py --output FOLDER (--folder PLATFORM=FOLDER)...    libraries of release builds, by platform
       package.py --output FOLDER --files FILE...                  those built for this system
       package.py ... --website ADDRESS                            names an address for Blender to link

Blender's own extension tool builds and validates: that of the Python module bpy if it is installed, else that of a
Blender from 4.2 on.
"""

import argparse
import ast
import importlib.util
import json
import platform
import re
import shutil
import subprocess
import sys
import tempfile
import zipfile
from pathlib import Path

from manual import write_manual

ROOT = Path(__file__).resolve().parents[2]
ADDON = ROOT / "addon" / "paradesc"
# By platform, as Blender's manifests name it: the library, as bridge/library.py looks for it.
LIBRARIES = {
    "linux-x64": "libparadesc.so",
    "windows-x64": "paradesc.dll",
    "windows-arm64": "paradesc.dll",
    "macos-x64": "libparadesc-x86_64.dylib",
    "macos-arm64": "libparadesc-arm64.dylib",
}
# Blender runs there from 4.5 on: the zip for older ones has nothing for it, and one place for each name.
ONLY_EXTENSIONS = {"windows-arm64"}
SYSTEMS = {"Linux": "linux", "Windows": "windows", "Darwin": "macos"}
MACHINES = {"x86_64": "x64", "AMD64": "x64", "arm64": "arm64", "aarch64": "arm64"}
# The folders' pages are packed: whoever opens an installed add-on finds its way by them.
LEFT_OUT = shutil.ignore_patterns("__pycache__", "*.pyc", "lib")


def version() -> str:
    """The version that CMakeLists.txt, the manifest and bl_info agree on."""
    manifest = (ADDON / "blender_manifest.toml").read_text(encoding="utf-8")
    tree = ast.parse((ADDON / "__init__.py").read_text(encoding="utf-8"))
    info = next(
        ast.literal_eval(node.value)
        for node in tree.body
        if isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == "bl_info"
    )
    project = (ROOT / "CMakeLists.txt").read_text(encoding="utf-8")
    found = {
        "CMakeLists.txt": first(r"^project\(paradesc VERSION (\S+)", project),
        "blender_manifest.toml": first(r'^version = "(.*)"', manifest),
        "bl_info": ".".join(map(str, info["version"])),
    }
    if len(set(found.values())) > 1:
        sys.exit(f"package.py: the versions differ: {found}; write the same one everywhere.")
    return found["bl_info"]


def first(pattern: str, text: str) -> str:
    """What the pattern's group finds in the text."""
    match = re.search(pattern, text, re.M)
    return match.group(1) if match else ""


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


def stage(folder: Path, libraries: dict[str, list[Path]], website: str) -> None:
    """The add-on as it is installed, with its manual and the libraries of these platforms."""
    shutil.copytree(ADDON, folder, ignore=LEFT_OUT)
    shutil.copy(ROOT / "LICENSE", folder)
    write_manual(folder / "manual", ROOT / "addon")
    (folder / "lib").mkdir()
    for files in libraries.values():
        for file in files:
            shutil.copy(file, folder / "lib" / file.name)
    manifest = folder / "blender_manifest.toml"
    names = ", ".join(f'"{name}"' for name in libraries)
    text = re.sub(r"^platforms = .*$", f"platforms = [{names}]", manifest.read_text(encoding="utf-8"), flags=re.M)
    manifest.write_text(text, encoding="utf-8")
    if website:
        link_website(folder, website)


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
    """A folder and all that is in it, in an order that does not depend on the file system.

    The folder itself has to be an entry: only then does Blender remove an installed add-on before it unpacks a newer
    one. Else it would write into a library that is loaded, and crash.
    """
    with zipfile.ZipFile(target, "w", zipfile.ZIP_DEFLATED, compresslevel=9) as archive:
        for path in (folder, *sorted(folder.rglob("*"))):
            archive.write(path, path.relative_to(folder.parent))


def package(output: Path, libraries: dict[str, list[Path]], website: str) -> list[Path]:
    """Writes all packages into an empty folder and has them validated; returns the zips."""
    tool = extension_tool()
    tags = valid_tags(tool)
    name = f"paradesc-{version()}"
    repository = output / "repository"
    shutil.rmtree(output, ignore_errors=True)
    repository.mkdir(parents=True)
    zips = [output / f"{name}-legacy.zip"]
    with tempfile.TemporaryDirectory() as work:
        older = {name: files for name, files in libraries.items() if name not in ONLY_EXTENSIONS}
        stage(Path(work) / "legacy" / "paradesc", older, website)
        write_zip(Path(work) / "legacy" / "paradesc", zips[0])
        for platform_name, files in libraries.items():
            source = Path(work) / platform_name
            stage(source, {platform_name: files}, website)
            target = repository / f"{name}-{platform_name}.zip"
            run(*tool, "build", "--source-dir", source, "--output-filepath", target, *tags)
            zips.append(target)
    for path in zips:
        run(*tool, "validate", path, *tags)
    run(*tool, "server-generate", "--repo-dir", repository, "--html")
    return zips


def valid_tags(tool: list[str]) -> list[str]:
    """The list of tags that Blender knows, which its own executable finds by itself."""
    if not tool[-1].endswith(".py"):
        return []
    return ["--valid-tags", str(Path(tool[-1]).parents[3] / "modules" / "_bpy_internal" / "extensions" / "tags.py")]


def given_libraries(arguments: argparse.Namespace, names: dict[str, str]) -> dict[str, list[Path]]:
    """Files by platform, all of which are there; names: the library's by platform, as in LIBRARIES."""
    libraries = {}
    for pair in arguments.folder:
        name, _, folder = pair.partition("=")
        if name not in names:
            sys.exit(f"{sys.argv[0]}: there is no platform '{name}'; choose from {', '.join(names)}.")
        libraries[name] = [Path(folder) / names[name]]
    if arguments.files:
        name = f"{SYSTEMS.get(platform.system())}-{MACHINES.get(platform.machine())}"
        libraries[name] = [Path(file) for file in arguments.files]
    for file in [file for files in libraries.values() for file in files]:
        if not file.is_file():
            sys.exit(f"{sys.argv[0]}: {file} is missing; build the native library first.")
    if not libraries:
        sys.exit(f"{sys.argv[0]}: no library was given; name them by --folder or --files.")
    return libraries


def library_arguments() -> argparse.ArgumentParser:
    """The options that name libraries and where packages of them go."""
    parser = argparse.ArgumentParser(add_help=False)
    parser.add_argument("--output", type=Path, required=True, help="emptied first")
    parser.add_argument("--folder", action="append", default=[], metavar="PLATFORM=FOLDER")
    parser.add_argument("--files", nargs="+", default=[], metavar="FILE")
    return parser


def main() -> int:
    """Packs, and says what was written."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter, parents=[library_arguments()]
    )
    parser.add_argument("--website", default="", metavar="ADDRESS", help="linked as doc_url and website; default: none")
    arguments = parser.parse_args()
    libraries = given_libraries(arguments, LIBRARIES)
    for path in package(arguments.output.resolve(), libraries, arguments.website):
        sys.stdout.write(f"{path.stat().st_size:>9,} bytes  {path}\n")
    sys.stdout.write(f"repository       {arguments.output.resolve() / 'repository' / 'index.json'}\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
