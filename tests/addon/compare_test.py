"""The definition of error, on arrays small enough to check by hand."""

import dataclasses
import math

import numpy as np
import pytest

from paradesc import bridge
from paradesc.bridge import Descriptor, abi
from paradesc.core import compare, job
from shapes import as_arrays, cube_sphere

CURVATURE = Descriptor("h", "H", "", -1, True, 0.0, math.nan, math.nan)
SQUARED = Descriptor("k", "K", "", -2, True, 0.0, math.nan, math.nan)
VOLUME = Descriptor("v", "V", "", 3, False, math.nan, math.nan, math.nan)
SHARE = Descriptor("s", "S", "", 0, False, math.nan, math.nan, math.nan)
REFERENCE = np.linspace(0.0, 40.0, 41)  # P97.5 - P2.5 = 39 - 1
EVERYWHERE = np.ones(41, bool)


def errors(values, reference=REFERENCE, with_face=None, row=CURVATURE, radius=0.1):
    """Percent errors."""
    faces = np.ones(len(reference), bool) if with_face is None else with_face
    return compare.percent_errors(np.asarray(values), np.asarray(reference), faces, row, radius).percent


def test_error_is_relative_to_the_inner_range_of_the_reference():
    np.testing.assert_allclose(errors(REFERENCE + 0.38), 1.0)


def test_exact_values_have_no_error():
    assert (errors(REFERENCE) == 0).all()


def test_undefined_on_both_sides_is_left_out():
    values, reference = REFERENCE.copy(), REFERENCE.copy()
    values[3] = reference[3] = np.nan
    found = errors(values, reference)
    assert np.isnan(found[3])
    assert np.isfinite(np.delete(found, 3)).all()


@pytest.mark.parametrize("side", ["values", "reference"])
def test_undefined_on_one_side_counts_a_hundred(side):
    arrays = {"values": REFERENCE.copy(), "reference": REFERENCE.copy()}
    arrays[side][7] = np.nan
    assert errors(**arrays)[7] == 100.0


def test_vertex_without_face_is_left_out():
    faces = EVERYWHERE.copy()
    faces[0] = False
    values = REFERENCE.copy()
    values[0] = np.nan
    found = errors(values, with_face=faces)
    assert np.isnan(found[0])
    assert np.nanmax(found) == 0


def test_vertex_without_face_does_not_stretch_the_range():
    reference = np.append(REFERENCE, 1e9)
    faces = np.append(EVERYWHERE, False)
    np.testing.assert_allclose(errors(reference + 0.38, reference, faces)[:-1], 1.0)


def test_constant_reference_is_measured_against_its_size():
    reference = np.full(50, -0.25) + np.linspace(0, 1e-5, 50)
    np.testing.assert_allclose(errors(reference + 0.0025, reference), 1.0, rtol=1e-3)


@pytest.mark.parametrize(("row", "scale"), [(CURVATURE, 10.0), (SQUARED, 100.0)])
def test_plane_is_measured_against_the_radius(row, scale):
    reference = np.linspace(-1e-9, 1e-9, 41)
    np.testing.assert_allclose(errors(reference + 0.01 * scale, reference, row=row, radius=0.1), 1.0, rtol=1e-6)


@pytest.mark.parametrize("row", [VOLUME, SHARE])
def test_constant_without_inverse_length_is_measured_against_its_size(row):
    reference = np.full(9, 0.5)
    np.testing.assert_allclose(errors(reference + 0.005, reference, row=row), 1.0)


def test_values_that_hardly_differ_are_measured_by_their_range_and_said_to():
    reference = np.linspace(1.0, 1.01, 1001, dtype=np.float32)
    faces = np.ones(1001, bool)
    found = compare.percent_errors(reference + np.float32(1e-3), reference, faces, CURVATURE, 0.1)
    assert found.percent == pytest.approx(np.full(1001, 100 * 1e-3 / 0.0095), rel=1e-2)
    assert found.spread == pytest.approx(0.0095 / 1.01, rel=1e-3)
    note = compare.spread_note({"descriptor": "mean_curvature", "spread": found.spread})
    assert "mean_curvature differ by 0.94 % only" in note
    wide = compare.percent_errors(reference, np.linspace(0, 1, 1001), faces, CURVATURE, 0.1)
    assert compare.spread_note({"descriptor": "mean_curvature", "spread": wide.spread}) == ""
    assert compare.spread_note({"descriptor": "mean_curvature", "spread": float("nan")}) == ""


def test_nothing_defined_gives_no_statistic():
    found = errors(np.full(4, np.nan), np.full(4, np.nan))
    assert math.isnan(compare.statistic(found, np.mean))


def results(values, reference_side, mask, near_seam=None):
    """Results that hold these arrays and nothing else of interest."""
    name = "mean_curvature"
    return job.Results(
        settings=job.Settings((name,), bridge.Options(radius=0.02)),
        values={name: values},
        coverage=np.ones(len(values), np.float32),
        mask=mask,
        mesh_report={},
        field_report={"radius": 0.1, "coverage_mean": 0.999},
        backend="reference" if reference_side else "software",
        device="",
        warnings=[],
        near_seam=near_seam,
    )


def test_row_gathers_errors_and_seams():
    mask = np.zeros(42, np.uint8)
    mask[41] = abi.MASK_NO_FACE
    reference = np.append(REFERENCE, np.nan)
    values = reference + 0.38
    values[:10] = reference[:10] + 0.76
    values[40] = np.nan
    near = np.arange(42) < 10
    row = compare.row("mean_curvature", results(values, False, mask, near), results(reference, True, mask))
    assert row["descriptor"] == "mean_curvature"
    assert row["radius"] == 0.02
    assert row["undefined"] == 1
    assert row["coverage_mean"] == 0.999
    np.testing.assert_allclose(row["mean_percent_ae"], (10 * 2 + 30 * 1 + 100) / 41)
    np.testing.assert_allclose(row["median_percent_ae"], 1.0)
    np.testing.assert_allclose(row["max_percent_ae"], 100.0)
    np.testing.assert_allclose(row["seam_mean_percent_ae"], 2.0)


def test_several_radii_are_named_and_equal_those_alone(sphere):
    options = bridge.Options(radius=0.06, samples=64, buffer_size=256)
    both = job.run(sphere, job.Settings(("curvedness",), options, "software", more_radii=(0.1,)))
    assert list(both.values) == ["curvedness_r0.06", "curvedness_r0.1"]
    for radius in (0.06, 0.1):
        alone = job.run(sphere, job.Settings(("curvedness",), dataclasses.replace(options, radius=radius), "software"))
        name = f"curvedness_r{radius:g}"
        assert np.array_equal(both.values[name], alone.values["curvedness"])
        assert both.radius_of(name) == alone.radius
        assert both.asked_radius(name) == radius


@pytest.mark.parametrize("radii", [(0.3, 0.05), (0.05, 0.3)], ids=str)
def test_mask_and_coverage_are_the_worst_of_all_radii(radii):
    """On an open bowl without jumps over seams, the large neighborhood is cut and the small one is whole."""
    points, quads, uvs = cube_sphere(12)
    kept = (points[quads, 2] < 0.5).all(axis=1)
    bowl = as_arrays(points, quads[kept], uvs[kept])
    options = bridge.Options(samples=64, buffer_size=256, relocation="affine", max_jumps=0)

    def at(radius, *more):
        chosen = dataclasses.replace(options, radius=radius)
        return job.run(bowl, job.Settings(("curvedness",), chosen, "software", more_radii=more))

    both, alone = at(*radii), {radius: at(radius) for radius in radii}
    for bit in (abi.MASK_BOUNDARY, abi.MASK_LOW_COVERAGE):
        assert (alone[0.05].mask & bit != 0).sum() < (alone[0.3].mask & bit != 0).sum() < len(points)
    assert np.array_equal(both.mask, alone[0.05].mask | alone[0.3].mask)
    whole = alone[0.05].mask & abi.MASK_LOW_COVERAGE == 0
    assert (alone[0.3].coverage < alone[0.05].coverage)[whole].any()
    assert np.array_equal(both.coverage, np.minimum(alone[0.05].coverage, alone[0.3].coverage), equal_nan=True)
    loose = ~np.isin(np.arange(len(points)), quads[kept])
    assert loose.any()
    assert np.array_equal(both.mask & abi.MASK_NO_FACE != 0, loose)
    assert np.array_equal(both.undefined, np.maximum(alone[0.05].undefined, alone[0.3].undefined))
    assert both.undefined[loose].all()


def test_a_radius_asked_for_twice_is_refused(sphere):
    with pytest.raises(bridge.ParadescError, match="twice"):
        job.run(sphere, job.Settings(options=bridge.Options(radius=0.05), more_radii=(0.05,)))


def test_directions_are_compared_by_weighted_angles_without_sign():
    turned = np.radians([0.0, 2.0, 180.0, 4.0])
    values = np.stack([np.cos(turned), np.sin(turned), np.zeros(4)], axis=1).astype(np.float32)
    expected = np.tile(np.float32([1, 0, 0]), (4, 1))
    reference = results(np.zeros(4), True, np.zeros(4, np.uint8))
    reference.values = {
        "principal_direction_max": expected,
        "principal_curvature_max": np.float32([1, 1, 1, 3]),
        "principal_curvature_min": np.zeros(4, np.float32),
    }
    errors = compare.angle_errors(values, reference, np.ones(4, bool), "principal_direction_max")
    np.testing.assert_allclose(errors.percent, [0, 2 / 1.5, 0, 4 * 3 / 1.5], atol=0.05)


def test_reference_is_compared_with_a_device_on_the_same_settings():
    points, quads, uvs = cube_sphere(20)
    ellipsoid = as_arrays(points * (1.0, 0.8, 0.6), quads, uvs)
    settings = job.Settings(("mean_curvature", "curvedness"), bridge.Options(radius=0.04, samples=128), "software")
    rows, device, reference = compare.compare(ellipsoid, settings)
    assert [row["descriptor"] for row in rows] == ["mean_curvature", "curvedness"]
    assert (device.backend, reference.backend) == ("software", "reference")
    for row in rows:
        # 128 samples on a smooth ellipsoid: a few tenths of a percent are to be expected.
        assert row["mean_percent_ae"] < 1.0
        assert row["undefined"] == 0


def test_reference_against_itself_is_refused(sphere):
    with pytest.raises(bridge.ParadescError, match="no device"):
        compare.compare(sphere, job.Settings(backend="reference"))
