"""The add-on's folders use those that they may, no import runs in a circle, and files and functions are short."""

import ast
from graphlib import TopologicalSorter

import pytest

from shapes import ADDON

PACKAGE = ADDON / "paradesc"
# What each folder uses, in the order of the data.
USES = {
    "bridge": set(),
    "core": {"bridge"},
    "files": {"bridge", "core"},
    "numpy_api": {"bridge", "core", "files"},
    "settings": {"bridge", "core", "files"},
    "scene": {"bridge", "core", "files", "settings"},
    "bake": {"bridge", "core", "files", "settings", "scene"},
    "animation": {"bridge", "core", "files", "settings", "scene", "bake"},
    "show": {"bridge", "core", "files", "settings", "scene", "bake"},
    "ui": {"bridge", "core", "files", "settings", "scene", "bake", "animation", "show"},
    "commands": {"bridge", "core", "files", "settings", "scene", "bake", "animation", "show"},
}
WITHOUT_BLENDER = ("bridge", "core", "files", "numpy_api")
BLENDER = {"bgl", "blf", "bl_math", "bl_operators", "bmesh", "bpy", "bpy_extras", "freestyle", "gpu", "mathutils"}
BLENDER |= {"addon_utils", "aud", "bl_ui", "idprop", "imbuf", "nodeitems_utils", "rna_prop_ui"}
MODULES = {
    ".".join(path.relative_to(PACKAGE).with_suffix("").parts): path
    for path in PACKAGE.rglob("*.py")
    if path.relative_to(PACKAGE).parts[0] != "lib"
}


def folder_of(name):
    """The folder of a module; "" for those at the root."""
    return name.split(".")[0] if "." in name else ""


def reached(name, node):
    """The add-on's modules that an import statement in this module reaches."""
    if isinstance(node, ast.Import) or node.level == 0:
        return []
    base = name.split(".")[: -node.level]
    parts = base + (node.module.split(".") if node.module else [])
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
    """The first words of the modules that an import names, if they are not the add-on's."""
    if isinstance(node, ast.Import):
        return {alias.name.split(".")[0] for alias in node.names}
    return {node.module.split(".")[0]} if node.level == 0 else set()


def test_the_folders_are_those_that_are_named_here():
    assert {folder_of(name) for name in MODULES} - {""} == set(USES)
    assert len([name for name in MODULES if not folder_of(name)]) <= 6


@pytest.mark.parametrize("name", sorted(name for name in MODULES if folder_of(name)))
def test_modules_use_what_comes_before_them_and_nothing_else(name):
    own = folder_of(name)
    for node, _ in statements(name):
        for other in reached(name, node):
            if other == "__init__":  # the package itself, whose version is all that may be asked for
                assert [alias.name for alias in node.names] == ["__version__"], ast.unparse(node)
            else:
                assert folder_of(other) in USES[own] | {own}, f"{name}: {ast.unparse(node)}"


def test_no_import_runs_in_a_circle_wherever_it_stands():
    graph = {
        name: {
            other for node, _ in statements(name) for other in reached(name, node) if other not in (name, "__init__")
        }
        for name in MODULES
    }
    order = list(TopologicalSorter(graph).static_order())  # raises CycleError, which names the circle
    assert len(order) == len(MODULES)
    folders = {
        own: {folder_of(other) for name in MODULES if folder_of(name) == own for other in graph[name]} for own in USES
    }
    assert list(TopologicalSorter({own: used - {own} for own, used in folders.items()}).static_order())


@pytest.mark.parametrize("name", sorted(name for name in MODULES if folder_of(name) in WITHOUT_BLENDER))
def test_what_is_no_part_of_blender_never_imports_it(name):
    assert not [ast.unparse(node) for node, _ in statements(name) if outside(node) & BLENDER]


@pytest.mark.parametrize("name", sorted(name for name in MODULES if folder_of(name) in ("commands", "")))
def test_commands_import_what_needs_blender_where_it_is_used_only(name):
    free = {*WITHOUT_BLENDER, "commands", ""}
    for node, at_once in statements(name):
        if at_once:
            assert not outside(node) & BLENDER, ast.unparse(node)
            assert {folder_of(other) for other in reached(name, node)} <= free, ast.unparse(node)


@pytest.mark.parametrize("name", sorted(name for name in MODULES if folder_of(name) not in ("commands", "")))
def test_imports_of_our_own_hide_in_no_function(name):
    assert not [ast.unparse(node) for node, at_once in statements(name) if not at_once and reached(name, node)]


@pytest.mark.parametrize("folder", sorted(USES))
def test_every_folder_says_what_it_is_for(folder):
    lines = (PACKAGE / folder / "README.md").read_text().splitlines()
    assert lines[0] == f"# {folder}"
    assert 3 < len(lines) < 12
    assert ast.get_docstring(ast.parse((PACKAGE / folder / "__init__.py").read_text()))


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
