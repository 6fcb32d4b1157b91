"""The arithmetic of the benchmarks (tests/bench): which times make a ratio, and what replaces a missing part."""

import struct
import sys

import bpy
import numpy as np
import pytest

from shapes import ROOT

for folder in ("accuracy", "bench"):
    if str(ROOT / "tests" / folder) not in sys.path:
        sys.path.insert(0, str(ROOT / "tests" / folder))

import figures  # noqa: E402
import programs  # noqa: E402

from paradesc import bridge  # noqa: E402

IN_PYTHON = pytest.mark.skipif(
    bool(bpy.app.binary_path), reason="the page is made by a program of Python, not of Blender"
)


def frame(seconds, evaluate=0.0, error=0.4):
    """A frame as timing.timed gives it."""
    return {"seconds": seconds, "seconds_evaluate": evaluate, "error": error}


@pytest.fixture
def measured():
    """Every part, with times that each ratio can tell apart."""
    detail = {
        "triangles": 2_000_000,
        "once": {"mesh": 0.5, "first_frame": 0.8},
        "baseline": {"seconds": 60.0, "neighbors_per_second_and_core": 5e7},
        "at_256": frame(0.4),
        "fewest": frame(0.2),
        "fine": frame(0.25),
        "max_normals": frame(0.1),
    }
    times = {"libigl5": 2, "dirty": 4, "pymeshlab_pca": 8, "cgal": 1, "pymeshlab_discrete": 0.05}
    several = {"eight": frame(1.1), "sixteen": frame(1.2), "twenty": frame(3.0), "three_radii": {"seconds": 1.3}}
    bunny = {"at_256": frame(0.02, error=0.07), "fewest": frame(0.01), "one_core": frame(0.04)}
    return {
        **{f"detail_{name}": detail for name in ("100k", "1m", "2m")},
        "radius": {"small": frame(0.1), "large": frame(0.12)},
        "bunny": bunny | {"baseline": {"seconds": 1.0}},
        "peers": {name: {"seconds": seconds, "error_closed": 0.3} for name, seconds in times.items()},
        "together": {"one": frame(1.0), **several},
        "memory": {"peak_bytes": 400, "input_bytes": 100},
        "first_bake": {"first": 1.2, "later": 1.0},
        "errors_closed": {"at_256": 0.15, "fewest": 0.2},
        "models": {"as they are": 3, "subdivided": 30},
        "python": {"overhead_seconds": 0.004},
    }


def test_ratios_are_made_of_the_times_that_they_name(measured):
    values, reasons = figures.figures(measured, {})
    assert reasons == {}
    assert values == {
        "bunny_frame_ms": 20,
        "bunny_error": 0.07,
        "over_libigl5": 100,
        "over_dirty": 200,
        "over_pymeshlab_pca": 400,
        "over_cgal": 25,  # both on one core
        "discrete_over_bunny_fewest": 5,
        "error_over_peers": 0.5,
        "speedup_1m": 240,  # with the error that is asked for there
        "speedup_2m": 240,
        "speedup_models": 3,
        "speedup_models_subdivided": 30,
        "radius_growth": 1.2,
        "three_radii_over_one": 1.3,
        "eight_over_one": 1.1,
        "sixteen_over_one": 1.2,
        "twenty_over_one": 3,
        "peak_memory_over_input": 4,
        "preprocess_s_per_million": 0.45,  # 0.5 s for the mesh, 0.8 − 0.4 s for the first frame, two million triangles
        "first_over_later": 1.2,
        "python_overhead_ms": 4,
    }
    assert figures.beside(measured)["speedup_1m_256_samples"] == 150
    assert figures.beside(measured)["speedup_1m_max_normals"] == 600


def test_targets_bound_from_below_or_from_above():
    assert figures.FIGURES["speedup_1m"].met(25)
    assert not figures.FIGURES["speedup_1m"].met(24.9)
    assert figures.FIGURES["eight_over_one"].met(1.3)
    assert not figures.FIGURES["eight_over_one"].met(1.31)


def test_a_missing_peer_is_null_with_the_reason_and_costs_no_other_key(measured):
    del measured["peers"]["libigl5"], measured["memory"]
    values, reasons = figures.figures(measured, {"libigl5": "libigl is not installed."})
    assert values["over_libigl5"] is None
    assert reasons == {
        "over_libigl5": "libigl is not installed.",
        "peak_memory_over_input": "Not measured.",
    }
    assert values["over_dirty"] == 200


def test_a_mesh_is_handed_over_with_a_vertex_and_a_place_for_every_corner(tmp_path):
    corners = np.array([3, 1, 0, 2, 1, 3], np.int32)
    arrays = bridge.MeshArrays(
        positions=np.arange(12, dtype=np.float32).reshape(4, 3),
        corner_vertices=corners,
        triangle_corners=np.array([[3, 4, 5], [0, 1, 2]], np.int32),
        corner_uvs=np.arange(12, dtype=np.float32).reshape(6, 2),
    )
    data = programs.write_mesh(tmp_path / "mesh", arrays).read_bytes()
    assert struct.unpack_from("2i", data) == (4, 6)
    assert struct.unpack_from("6i", data, 8 + 4 * 12) == (2, 1, 3, 3, 1, 0)
    assert struct.unpack_from("2f", data, 8 + 4 * 12 + 4 * 6) == (6, 7)
    assert len(data) == 8 + 4 * 12 + 4 * 6 + 4 * 12


def test_values_of_a_program_are_read_as_they_were_written(tmp_path):
    path = tmp_path / "values"
    path.write_bytes(struct.pack("i2i2f", 2, 7, 5, 0.5, -1.5))
    found = programs.read_values(path)
    assert found.vertices.tolist() == [7, 5]
    assert found.values.tolist() == [0.5, -1.5]


def test_a_program_that_cannot_be_built_is_a_sentence(tmp_path, monkeypatch):
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(programs.MissingError, match="no CMake"):
        programs.program(tmp_path, programs.OBJECT_SPACE)


@IN_PYTHON
def test_the_page_writes_between_the_markers_of_a_manual_and_nowhere_else(tmp_path):
    import speed_page

    manual = tmp_path / "README.md"
    manual.write_text(f"before\n{speed_page.START}\nold\n{speed_page.END}\nafter\n")
    speed_page.fill(manual, ["new", ""])
    assert manual.read_text() == f"before\n{speed_page.START}\nnew\n{speed_page.END}\nafter\n"
    manual.write_text("no markers\n")
    speed_page.fill(manual, ["new"])
    assert manual.read_text() == "no markers\n"
    assert (ROOT / "README.md").read_text().count(speed_page.START) == 1


@IN_PYTHON
def test_the_page_says_of_every_key_whether_it_is_met_or_why_it_is_missing(measured):
    import speed_page

    del measured["memory"]
    values, reasons = figures.figures(measured, {})
    stamp = dict.fromkeys(("date", "device", "cpu", "cores", "commit", "load_before", "command"), "x")
    found = {**stamp, **values, "reasons": reasons, "beside": {}, "measured": measured}
    rows = [line.split(" | ") for line in speed_page.ratio_lines(found) if line.startswith("| `")]
    assert {row[0].strip("|` "): row[-1].strip("| ") for row in rows} == {
        name: "Not measured." if name == "peak_memory_over_input" else "yes" for name in figures.FIGURES
    }
