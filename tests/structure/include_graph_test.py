"""The folders of the native half stand in the order of the data path: includes point upward, never in a circle."""

import re
from graphlib import CycleError, TopologicalSorter
from pathlib import Path, PurePosixPath

import pytest

from sources import ROOT

SOURCES = ROOT / "native" / "src"
INCLUDE = re.compile(r'^\s*#\s*include\s+[<"]([^>"]+)[>"]', re.MULTILINE)
# A folder, or a file without its suffix, may include what stands in itself and in the rows above. Names in one row may
# not include each other.
DIRECTION: tuple[tuple[str, ...], ...] = (
    ("support",),
    ("mesh",),
    ("descriptor",),
    ("gather",),
    ("bake",),
    ("sample",),
    ("engine",),  # engine.h, the seam
    ("engine/kernels",),  # what shaders/kernel is in C++
    ("engine/creases",),  # what they make of the results of any engine
    ("engine/paper", "engine/reference", "engine/cpu"),
    ("engine/engines",),  # makes them
    ("context",),  # holds one of them
    ("compute",),
    ("api_edge",),
    ("api", "api_images", "api_rays"),
    ("exports",),
)
RANK = {folder: rank for rank, row in enumerate(DIRECTION) for folder in row}
OPENGL = "engine/paper"
OPENGL_HEADER = re.compile(r"^(GL|EGL|GLES\d?|KHR|epoxy|glad|GLFW)/|^paper/")


def includes() -> dict[str, list[str]]:
    """The headers that each source file names, our own ones from native/src on."""
    found = {}
    for path in sorted(SOURCES.rglob("*")):
        if path.suffix in (".h", ".cpp", ".c", ".def"):
            name = path.relative_to(SOURCES)
            found[name.as_posix()] = [own(name.parent, header) for header in INCLUDE.findall(path.read_text())]
    return found


def own(folder: Path, header: str) -> str:
    """A header's path from native/src on, if it stands beside the file that includes it."""
    beside = folder / header
    return beside.as_posix() if (SOURCES / beside).is_file() else header


def folder(name: str) -> str:
    """The name in DIRECTION that a file goes by."""
    path = PurePosixPath(name)
    alone = path.with_suffix("").as_posix()
    return alone if alone in RANK or len(path.parts) == 1 else path.parent.as_posix()


GRAPH = includes()
ARROWS = [(name, header) for name, headers in GRAPH.items() for header in headers if header in GRAPH]


def test_every_folder_has_its_place_in_the_direction():
    unknown = {folder(name) for name in GRAPH} - RANK.keys()
    assert len(GRAPH) > 50
    assert not unknown, f"give {sorted(unknown)} a place in DIRECTION"


def test_no_include_points_against_the_direction():
    wrong = [
        f"{name} includes {header}"
        for name, header in ARROWS
        if folder(name) != folder(header) and RANK[folder(header)] >= RANK[folder(name)]
    ]
    assert len(ARROWS) > 100
    assert not wrong, "\n".join(wrong)


def test_no_include_runs_in_a_circle():
    own_headers = {name: [header for header in headers if header in GRAPH] for name, headers in GRAPH.items()}
    try:
        TopologicalSorter(own_headers).prepare()
    except CycleError as error:
        pytest.fail(" → ".join(error.args[1]))


def test_no_file_outside_the_engine_of_opengl_sees_opengl():
    seen = [
        f"{name} includes {header}"
        for name, headers in GRAPH.items()
        for header in headers
        if OPENGL_HEADER.match(header) and folder(name) != OPENGL
    ]
    assert not seen, "\n".join(seen)
    assert any(OPENGL_HEADER.match(header) for headers in GRAPH.values() for header in headers)


def test_one_file_alone_knows_the_engine_of_opengl():
    knows = {name: header for name, header in ARROWS if folder(header) == OPENGL and folder(name) != OPENGL}
    assert len(knows) <= 1, "\n".join(f"{name} includes {header}" for name, header in knows.items())
