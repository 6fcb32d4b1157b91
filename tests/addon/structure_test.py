"""The add-on's folders use those that they may, no import runs in a circle, and files and functions are short."""

import ast
import os
import subprocess
import sys
from graphlib import TopologicalSorter
from pathlib import Path

import numpy as np
import pytest

from shapes import ADDON

# The Python package, and the add-on that uses it. Each folder has the set of folders that it may use.
PACKAGES = ("paradesc", "paradesc_blender")
PACKAGE = {
    "bridge": set(),
    "core": {"bridge"},
    "files": {"bridge", "core"},
    "numpy_api": {"bridge", "core", "files"},
    "commands": {"bridge", "core", "files"},
}
BASE = {"bridge", "core", "files"}
ADDED = {
    "settings": BASE,
    "scene": {*BASE, "settings"},
    "bake": {*BASE, "settings", "scene"},
    "animation": {*BASE, "settings", "scene", "bake"},
    "show": {*BASE, "settings", "scene", "bake"},
    "ui": {*BASE, "settings", "scene", "bake", "animation", "show"},
}
USES = PACKAGE | ADDED
BLENDER = {"bgl", "blf", "bl_math", "bl_operators", "bmesh", "bpy", "bpy_extras", "freestyle", "gpu", "mathutils"}
BLENDER |= {"addon_utils", "aud", "bl_ui", "idprop", "imbuf", "nodeitems_utils", "rna_prop_ui"}
MODULES = {
    ".".join(path.relative_to(ADDON).with_suffix("").parts): path
    for package in PACKAGES
    for path in (ADDON / package).rglob("*.py")
    if path.relative_to(ADDON).parts[1] != "lib"
}
ROOTS = tuple(f"{package}.__init__" for package in PACKAGES)


def folder_of(name):
    """The folder of a module; the package for those at its root."""
    package, *parts = name.split(".")
    return parts[0] if len(parts) > 1 else package


def is_package(name):
    """Returns whether a module belongs to the Python package, not to the add-on."""
    return name.startswith("paradesc.")


def reached(name, node):
    """Our modules that an import statement in this module reaches."""
    if isinstance(node, ast.Import):
        return [f"{alias.name}.__init__" for alias in node.names if alias.name in PACKAGES]
    base = name.split(".")[: -node.level] if node.level else []
    parts = base + (node.module.split(".") if node.module else [])
    if parts[0] not in PACKAGES:
        return []
    found = []
    for alias in node.names:
        named = [*parts, alias.name]
        candidates = (named, [*named, "__init__"], parts, [*parts, "__init__"])
        found.append(next(name for name in map(".".join, candidates) if name in MODULES))
    return found


def statements(name):
    """Every import of a module, with True if it runs when the module itself is imported."""
    tree = ast.parse(MODULES[name].read_text())
    later = set()
    for node in ast.walk(tree):
        hidden = isinstance(node, (ast.FunctionDef, ast.Lambda))
        typing = isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING"
        if hidden or typing:
            later.update(ast.walk(node))
    for node in ast.walk(tree):
        if isinstance(node, (ast.Import, ast.ImportFrom)):
            yield node, node not in later


def outside(node):
    """The first words of the modules that an import names, if they are not ours."""
    if isinstance(node, ast.Import):
        return {alias.name.split(".")[0] for alias in node.names}
    return {node.module.split(".")[0]} if node.level == 0 else set()


def test_the_folders_are_those_that_are_named_here():
    for package, folders in zip(PACKAGES, (PACKAGE, ADDED), strict=True):
        found = {folder_of(name) for name in MODULES if name.startswith(f"{package}.")}
        assert found - {package} == set(folders)
    assert len([name for name in MODULES if folder_of(name) in PACKAGES]) <= 9


@pytest.mark.parametrize("name", sorted(name for name in MODULES if folder_of(name) not in PACKAGES))
def test_modules_use_what_comes_before_them_and_nothing_else(name):
    own = folder_of(name)
    for node, _ in statements(name):
        for other in reached(name, node):
            if other in ROOTS:  # the package itself, whose version is all that may be asked for
                assert [alias.name for alias in node.names] == ["__version__"], ast.unparse(node)
            else:
                assert folder_of(other) in USES[own] | {own}, f"{name}: {ast.unparse(node)}"


def test_no_import_runs_in_a_circle_wherever_it_stands():
    graph = {
        name: {
            other
            for node, _ in statements(name)
            for other in reached(name, node)
            if other not in (name, *ROOTS)
        }
        for name in MODULES
    }
    order = list(TopologicalSorter(graph).static_order())  # raises CycleError, which names the circle
    assert len(order) == len(MODULES)
    folders = {
        own: {folder_of(other) for name in MODULES if folder_of(name) == own for other in graph[name]} for own in USES
    }
    assert list(TopologicalSorter({own: used - {own} for own, used in folders.items()}).static_order())


def test_the_package_names_the_addon_in_no_import_and_never_blenders_modules():
    for name in filter(is_package, MODULES):
        for node, _ in statements(name):
            assert not outside(node) & BLENDER, f"{name}: {ast.unparse(node)}"
            assert all(map(is_package, reached(name, node))), f"{name}: {ast.unparse(node)}"


@pytest.mark.parametrize("name", sorted(name for name in MODULES if folder_of(name) not in (*PACKAGES, "commands", "numpy_api")))
def test_imports_of_our_own_hide_in_no_function(name):
    assert not [ast.unparse(node) for node, at_once in statements(name) if not at_once and reached(name, node)]


def test_importing_the_package_imports_few_of_its_modules():
    code = f"import sys; sys.path.insert(0, {str(ADDON)!r}); import paradesc; paradesc.compute\n"
    code += "print(len([name for name in sys.modules if name.partition('.')[0] == 'paradesc']))"
    path = {**os.environ, "PYTHONPATH": str(Path(np.__file__).parents[1])}
    done = subprocess.run([sys.executable, "-c", code], env=path, capture_output=True, text=True, check=True)
    assert int(done.stdout) <= 15


@pytest.mark.parametrize("folder", sorted(USES))
def test_every_folder_says_what_it_is_for(folder):
    place = ADDON / PACKAGES[folder in ADDED] / folder
    lines = (place / "README.md").read_text().splitlines()
    assert lines[0] == f"# {folder}"
    assert 3 < len(lines) < 12
    assert ast.get_docstring(ast.parse((place / "__init__.py").read_text()))


def test_files_and_functions_stay_short():
    texts = {name: path.read_text() for name, path in MODULES.items()}
    assert not [name for name, text in texts.items() if len(text.splitlines()) >= 450]
    found = {
        f"{name}.{node.name}": node.end_lineno - node.lineno + 1 - len((ast.get_docstring(node, clean=False) or "").splitlines())
        for name, text in texts.items()
        for node in ast.walk(ast.parse(text))
        if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef))
    }
    assert not [name for name, length in found.items() if length > 60]
    assert sum(length < 30 for length in found.values()) > 0.9 * len(found)
