"""paradesc.profile() and radius "auto": where noise of a mesh and what a radius blurs balance."""

import json

import numpy as np
import pytest

import paradesc
from paradesc import InputError, cli
from paradesc.core import balance
from python_api_test import torus
from shapes import cube_sphere


@pytest.fixture(scope="module")
def rough():
    """Positions with noise of a tenth of the mean edge along normals, quads, and exact mean curvatures of a torus."""
    points, quads, mean, _ = torus(96, 40)
    edge = np.linalg.norm(points[quads[:, 0]] - points[quads[:, 1]], axis=1).mean()
    return points + np.random.default_rng(3).normal(size=points.shape) * 0.1 * edge, quads, mean


@pytest.fixture(scope="module")
def profile(rough):
    return paradesc.profile(*rough[:2])


def test_a_profile_has_a_row_for_each_radius_and_a_column_for_each_vertex(rough, profile):
    points, quads, _ = rough
    diagonal = np.linalg.norm(np.ptp(points, axis=0))
    assert profile.radii[-1] == pytest.approx(0.16 * diagonal)
    assert np.allclose(profile.radii[1:] / profile.radii[:-1], 2**0.5, rtol=0.1)  # steps end at 16 % exactly
    shape = (len(profile.radii), len(points))
    assert profile.values.shape == profile.standard_error.shape == profile.bias.shape == shape
    assert profile.best.shape == (len(points),)
    assert set(profile.best) <= set(profile.radii)
    one = paradesc.compute(points, quads, radius=float(profile.radii[1]), radius_unit="absolute")
    assert np.array_equal(profile.values[1], one["mean_curvature"])


@pytest.mark.parametrize(("unit", "radii"), [("mean-edge", (2, 3)), ("diagonal", (0.1, 0.2)), ("absolute", (0.8, 1))])
def test_radii_of_any_unit_are_those_of_compute(unit, radii):
    ball, faces, _ = cube_sphere(6)
    faces = faces[:-9]  # with edges that only one face has
    found = paradesc.profile(ball, faces, radii=radii[::-1], radius_unit=unit)
    one = paradesc.compute(ball, faces, radius=radii, radius_unit=unit)
    assert found.radii.tolist() == list(one.radii.values())
    assert np.array_equal(found.values, one.over_radii("mean_curvature"), equal_nan=True)


def test_the_radius_is_about_the_one_of_least_error(rough, profile):
    errors = np.abs(profile.values - rough[2]).mean(axis=1)
    found = errors[list(profile.radii).index(profile.radius)]
    assert profile.radii[0] < profile.radius < profile.radii[-1]
    assert found <= 1.25 * errors.min()  # the next radius is larger by a root of two
    own = profile.values[np.searchsorted(profile.radii, profile.best), np.arange(len(rough[2]))]
    assert np.abs(own - rough[2]).mean() <= 1.2 * errors.min()


def test_standard_error_and_bias_are_those_that_there_are(rough, profile):
    points, quads, mean = rough
    clean = paradesc.profile(torus(96, 40)[0], quads, radii=profile.radii, radius_unit="absolute")
    noise = profile.values - clean.values
    for row in (1, 2, 3):  # the noise of one mesh at some radii, and an estimate: within a third
        assert np.sqrt((profile.standard_error[row] ** 2).mean()) == pytest.approx(noise[row].std(), rel=0.33)
    blurred = clean.values[-2] - mean
    assert np.corrcoef(clean.bias[-2], blurred)[0, 1] > 0.95
    assert np.abs(clean.bias[-2]).mean() == pytest.approx(np.abs(blurred).mean(), rel=0.25)  # b r² is its first term


def test_more_noise_makes_a_larger_radius_and_none_a_small_one(rough, profile):
    points, quads, _ = rough
    smooth = torus(96, 40)[0]
    assert paradesc.profile(smooth, quads).radius < profile.radius / 2
    assert paradesc.profile(smooth + 3 * (points - smooth), quads).radius > profile.radius


def test_lengths_follow_the_unit_of_the_vertices(rough, profile):
    large = paradesc.profile(1024 * rough[0], rough[1])
    assert large.radius == pytest.approx(1024 * profile.radius)
    assert np.isclose(large.best, 1024 * profile.best).mean() > 0.99  # rounding decides between radii that are as good


def test_vertices_may_be_asked_for(rough, profile):
    some = paradesc.profile(*rough[:2], at=[7, 3])
    assert some.radius == profile.radius
    assert np.array_equal(some.values, profile.values[:, [7, 3]])
    assert np.array_equal(some.best, profile.best[[7, 3]])


def test_vertices_of_no_face_have_no_best_radius(rough):
    points, quads, _ = rough
    found = paradesc.profile(np.vstack([points, [[0, 0, 0]]]), quads, radii=(0.04, 0.08, 0.16))
    assert np.isnan(found.best[-1])
    assert np.isfinite(found.best[:-1]).all()


def test_auto_computes_by_the_profile_that_expects_the_smaller_error(rough, profile):
    points, quads, mean = rough
    extrapolated = paradesc.profile(points, quads, estimator="extrapolated")
    assert extrapolated.expected < 0.8 * profile.expected
    assert extrapolated.radius > profile.radius
    found = paradesc.compute(points, quads, ["curvedness", "mean_curvature"], radius="auto")
    assert found.report["settings"]["estimator"] == "extrapolated"
    assert found.radius == pytest.approx(extrapolated.radius, rel=0.005)  # it has three digits
    assert found.radii["curvedness"] == found.radius
    errors = found["mean_curvature"] - mean
    assert np.sqrt((errors**2).mean()) == pytest.approx(extrapolated.expected, rel=0.5)
    fitted = profile.values[list(profile.radii).index(profile.radius)] - mean
    assert np.abs(errors).mean() < 0.7 * np.abs(fitted).mean()
    options = {"radius": found.radius, "radius_unit": "absolute", "estimator": "extrapolated"}
    same = paradesc.compute(points, quads, "curvedness", **options)
    assert np.array_equal(found["curvedness"], same["curvedness"])
    with paradesc.Mesh(points, quads) as mesh:
        assert np.array_equal(mesh.compute("curvedness", radius="auto")["curvedness"], found["curvedness"])


def test_progress_to_an_auto_radius_never_falls(rough):
    told = []
    paradesc.compute(*rough[:2], radius="auto", progress=lambda _, fraction: told.append(fraction))
    assert told[0] == 0
    assert told[-1] == 1
    assert told == sorted(told)


def test_auto_stays_with_the_estimator_that_is_asked_for(rough):
    points, quads, _ = rough
    found = paradesc.compute(points, quads, radius="auto", estimator="integral")
    assert found.report["settings"]["estimator"] == "integral"


def test_extrapolation_takes_what_the_radius_blurs_away():
    points, quads, mean, _ = torus(96, 40)
    errors = [np.abs(paradesc.compute(points, quads, radius=0.12, estimator=estimator)["mean_curvature"] - mean).mean()
              for estimator in ("shape-operator", "extrapolated")]  # fmt: skip
    assert errors[1] < 0.15 * errors[0]


@pytest.mark.parametrize(("estimator", "power"), [("shape-operator", 2), ("extrapolated", 4)])
def test_bias_grows_with_the_power_of_the_radius_that_the_estimator_leaves(rough, estimator, power):
    found = paradesc.profile(torus(96, 40)[0], rough[1], radii=(0.06, 0.12, 0.16), estimator=estimator)
    sizes = np.abs(found.bias).mean(axis=1)
    assert sizes[2] / sizes[1] == pytest.approx((0.16 / 0.12) ** power, rel=1e-6)


def test_coarse_meshes_have_an_auto_radius_too():
    cube = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], float)
    faces = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    assert 0 < paradesc.compute(cube, faces, radius="auto").radius < 1


@pytest.mark.parametrize(
    ("call", "sentence"),
    [
        (lambda *mesh: paradesc.profile(*mesh, "curvedness"), "'curvedness'; only mean_curvature has a standard error"),
        (lambda *mesh: paradesc.profile(*mesh, radii=[0.1]), "give two or more"),
        (lambda *mesh: paradesc.profile(*mesh, radii=[0.1, 0.1]), "each once"),
        (lambda *mesh: paradesc.profile(*mesh, at=[-1]), "Entry 0 of at names vertex -1"),
        (lambda *mesh: paradesc.profile(*mesh, radius_unit="meter"), "radius_unit is 'meter'"),
        *((lambda *mesh, given=given: paradesc.profile(*mesh, **given), "noise is not known here")
          for given in ({"normals": "max"}, {"normals": "mesh"}, {"backend": "software"}, {"precision": "half"})),
        (lambda *mesh: paradesc.compute(*mesh, radius="auto", normals="max"), "noise is not known here"),
        (lambda *mesh: paradesc.compute(*mesh, radius="Auto"), "radius is 'Auto'"),
    ],
)
def test_what_has_no_profile_is_refused_in_a_sentence(rough, call, sentence):
    with pytest.raises(InputError, match=sentence):
        call(*rough[:2])


def test_noise_that_falls_slowly_is_told_from_what_the_radius_blurs():
    r = np.geomspace(0.03, 0.16, 6)
    first, second = balance.changes_between(r)
    errors = r**-5.0  # of the mean square, of independent vertices
    for power, factor, bias in ((0.0, 1.0, 3e9), (1.0, 2.0, 3e9), (0.5, 2.0, 0.0), (0.0, 0.0, 3e9)):
        true = factor * errors * (r / r[0]) ** power
        slopes = (true[first] + true[second]) / (r[second] ** 2 - r[first] ** 2) ** 2 + bias
        found = balance.explained(r, slopes, errors, first, second)
        wrong = found[1] * errors * (r / r[0]) ** found[0] + found[2] * r**4
        assert np.allclose(wrong, true + bias * r**4, rtol=0.2), (power, factor, bias)


def test_the_command_line_takes_auto(rough, profile, tmp_path):
    points, quads, _ = rough
    lines = [f"v {x} {y} {z}" for x, y, z in points] + ["f {} {} {} {}".format(*(quad + 1)) for quad in quads]
    (tmp_path / "rough.obj").write_text("\n".join(lines))
    report = tmp_path / "report.json"
    words = ["bake", str(tmp_path / "rough.obj"), "--reader", "files", "--radius", "auto", "--progress", "off"]
    assert cli.main([*words, "--output", str(tmp_path / "out.npz"), "--json", str(report)]) == 0
    found = json.loads(report.read_text())["objects"][0]
    assert found["field_report"]["radius"] == pytest.approx(paradesc.compute(points, quads, radius="auto").radius, rel=0.005)
