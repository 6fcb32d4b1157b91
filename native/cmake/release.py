"""Facts about a release: its version, its platforms, and the libraries that a packing script is given for them."""

import argparse
import ast
import platform
import re
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PACKAGE = ROOT / "addon" / "paradesc"
ADDON = ROOT / "addon" / "paradesc_blender"
# The file name of the library for each platform. Blender's manifests name the platforms; bridge/library.py opens the files.
LIBRARIES = {
    "linux-x64": "libparadesc.so",
    "windows-x64": "paradesc.dll",
    "windows-arm64": "paradesc.dll",
    "macos-x64": "libparadesc-x86_64.dylib",
    "macos-arm64": "libparadesc-arm64.dylib",
}
SYSTEMS = {"Linux": "linux", "Windows": "windows", "Darwin": "macos"}
MACHINES = {"x86_64": "x64", "AMD64": "x64", "arm64": "arm64", "aarch64": "arm64"}


def version() -> str:
    """The version that CMakeLists.txt, the package, the manifest and bl_info agree on."""
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
        "paradesc/__init__.py": first(r'^__version__ = "(.*)"', (PACKAGE / "__init__.py").read_text(encoding="utf-8")),
        "blender_manifest.toml": first(r'^version = "(.*)"', manifest),
        "bl_info": ".".join(map(str, info["version"])),
    }
    if len(set(found.values())) > 1:
        sys.exit(f"{sys.argv[0]}: the versions differ: {found}; write the same one everywhere.")
    return found["bl_info"]


def first(pattern: str, text: str) -> str:
    """The text that the pattern's group finds."""
    match = re.search(pattern, text, re.M)
    return match.group(1) if match else ""


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
