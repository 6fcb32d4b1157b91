"""Other Python packages (tests/bench/python_peers.py): how lines and errors count; the manual has what is kept."""

import json
import sys
from functools import partial

import numpy as np
import pytest

from conftest import blender_program
from shapes import ADDON, ROOT

if blender_program():
    pytest.skip("the figures are made by a program of Python, not of Blender", allow_module_level=True)

for folder in ("accuracy", "bench"):
    if str(ROOT / "tests" / folder) not in sys.path:
        sys.path.insert(0, str(ROOT / "tests" / folder))

import python_jobs  # noqa: E402
import python_peers  # noqa: E402
import speed_page  # noqa: E402
from programs import MissingError  # noqa: E402
from python_jobs import Job  # noqa: E402

STORED = ROOT / "tests" / "bench" / "results" / speed_page.PYTHON


@pytest.fixture(scope="module")
def stored():
    """The figures that are kept."""
    return json.loads(STORED.read_text(encoding="utf-8"))


@pytest.fixture(scope="module")
def torus():
    """A mesh with a closed form."""
    return python_peers.torus(4000)


def exact(torus, mean=1.0):
    """A job that knows the truth, or a multiple of it."""
    return Job("Exact", "exact", lambda vertices, faces, radius: (mean * torus.mean, torus.gaussian), "a point")


def of_seven_lines(vertices, faces, radius):
    """A docstring

    of several lines.
    """
    import math  # a comment beside code

    # A comment alone, and a blank line above.
    mean = np.full_like(
        vertices[:, 0],
        math.pi,
    )
    gaussian = None
    return mean, gaussian


def of_one_line(vertices, faces, radius, scale):
    return vertices[:, 0] * scale, None


def test_lines_of_code_are_those_that_hold_code():
    assert python_jobs.lines_of(of_seven_lines) == 7  # four of them are one statement
    assert python_jobs.lines_of(of_one_line) == 1
    assert python_jobs.lines_of(partial(of_one_line, scale=2.0)) == 1


def test_the_better_sign_of_mean_curvature_counts_and_gaussian_curvature_has_but_one(torus):
    for sign in (1, -1):
        found = python_peers.once(exact(torus, sign), torus)
        assert found["error_mean"] == 0
        assert found["error_gaussian"] == 0
    assert python_peers.error_of(python_peers.K, -torus.gaussian, torus) > 10


def test_the_error_is_a_share_of_the_range_and_what_is_undefined_counts_whole(torus):
    low, high = np.percentile(torus.mean, [2.5, 97.5])
    assert python_peers.error_of(python_peers.H, torus.mean + (high - low) / 50, torus) == pytest.approx(2)
    half = np.where(np.arange(len(torus.mean)) % 2, torus.mean, np.nan)
    assert python_peers.error_of(python_peers.H, half, torus) == pytest.approx(50, abs=0.1)
    assert python_peers.error_of(python_peers.K, None, torus) is None


def test_a_package_that_is_missing_or_fails_is_a_sentence_and_costs_no_other_row(torus):
    def missing(vertices, faces, radius):
        import no_such_package  # noqa: F401

    def failing(vertices, faces, radius):
        raise ValueError("no")

    def short(vertices, faces, radius):
        return torus.mean[1:], None

    jobs = {
        "missing": Job("Missing", "no-such-package", missing, ""),
        "failing": Job("Failing", "failing", failing, ""),
    }
    jobs |= {"short": Job("Short", "short", short, ""), "paradesc": python_jobs.JOBS["paradesc"]}
    rows, reasons = python_peers.measure({"torus": torus}, jobs, 1)
    assert list(rows) == ["paradesc"]
    assert reasons["missing"] == "no-such-package is not installed (pip install no-such-package)."
    assert reasons["failing"] == "Failing failed: no"
    assert reasons["short"].startswith("Short failed: ")
    with pytest.raises(MissingError, match="pip install no-such-package"):
        python_peers.once(jobs["missing"], torus)


def test_paradesc_does_the_job_that_is_timed(torus):
    found = python_peers.once(python_jobs.JOBS["paradesc"], torus)
    assert found["error_mean"] < 0.5  # %; what remains is the finite radius, and so many vertices
    assert found["error_gaussian"] < 0.5
    assert found["seconds"] > 0


@pytest.mark.parametrize("name", [name for name in python_jobs.JOBS if name != "paradesc"])
def test_each_package_that_is_installed_does_the_job(name, torus, stored):
    job = python_jobs.JOBS[name]
    try:
        found = python_peers.once(job, python_peers.torus(600) if name == "trimesh" else torus)
    except MissingError as error:
        pytest.skip(str(error))
    assert found["error_mean"] < 40  # % of the range: another unit would be more
    assert (found["error_gaussian"] is None) == (stored["rows"][name]["torus"]["error_gaussian"] is None)


# ---- What is kept


def test_the_stored_rows_are_the_jobs_there_are_with_their_lines(stored):
    assert stored["rows"].keys() | stored["reasons"].keys() >= python_jobs.JOBS.keys()
    for name, row in stored["rows"].items():
        job = python_jobs.JOBS[name]
        assert (row["label"], row["size"], row["lacks"]) == (job.label, job.size, job.lacks)
        assert row["lines"] == python_jobs.lines_of(job.function), f"{name}: measure again, or write the page again"


def test_manual_and_report_have_the_figures_that_are_stored(stored):
    manual = (ADDON / "manual" / "python.md").read_text(encoding="utf-8")
    inside = manual.split(speed_page.PYTHON_START)[1].split(speed_page.PYTHON_END)[0]
    assert inside.strip() == "\n".join(speed_page.manual_lines(stored)).strip()
    report = (ROOT / "tests" / "bench" / "REPORT.md").read_text(encoding="utf-8")
    assert "\n".join(speed_page.python_lines(stored)) in report


def test_what_the_manual_says_of_the_nearest_package_is_so(stored):
    on_torus = {name: row["torus"] for name, row in stored["rows"].items()}
    ours, apss = on_torus.pop("paradesc"), on_torus["pymeshlab_apss8"]
    on_torus.pop("paradesc_auto", None)  # ours, too
    assert min(row["error_mean"] for row in on_torus.values()) == apss["error_mean"] > ours["error_mean"]
    assert apss["error_gaussian"] < ours["error_gaussian"]
