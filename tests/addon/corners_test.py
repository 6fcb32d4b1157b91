"""Corners: found by their Harris response, painted and listed."""

import json

import numpy as np
import pytest

from paradesc import bridge
from paradesc.core import color_maps, corners, job
from shapes import as_arrays, cube_sphere, write_obj

FILLET = 0.25
CORNER = 1 - FILLET + FILLET / np.sqrt(3)  # each coordinate of the middle of a rounded corner


def rounded_cube(steps=24):
    """A cube of half side 1 with rounded edges: cube_sphere's grid, laid along arcs and flats in turn."""
    points, quads, uvs = cube_sphere(steps, 1.0)
    cube = points / np.abs(points).max(axis=1, keepdims=True)
    inner, arc = 1 - FILLET, FILLET * np.pi / 4
    along = np.abs(cube) * (inner + arc)
    turn = np.where(np.abs(cube) > 1 - 1e-9, 1.0, np.tan(np.clip((along - inner) / FILLET, 0, np.pi / 4)))
    normals = np.sign(cube) * turn
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return np.sign(cube) * np.minimum(along, inner) + FILLET * normals, quads, uvs


def atlas_across_faces(points, quads):
    """Three charts on the strips between parallel planes that cut through the faces, each cut open: (n, 4, 2)."""
    direction = np.array([1.0, 0.4, 0.2]) / np.linalg.norm([1.0, 0.4, 0.2])
    middles = points[quads].mean(axis=1)
    chart = np.digitize(middles @ direction, [-0.45, 0.45])
    axes = np.linalg.svd(direction[None])[2][1:]
    flat = points @ axes.T
    angle = np.arctan2(flat[:, 1], flat[:, 0])
    uvs = np.empty((*quads.shape, 2))
    for number in (0, 2):  # caps: seen along the direction
        uvs[chart == number] = (flat[quads[chart == number]] / 3.6 + 0.5) * 0.45 + [0.02 + 0.25 * number, 0.02]
    turned = angle[quads[chart == 1]]
    turned[np.ptp(turned, axis=1) > np.pi] %= 2 * np.pi
    heights = (points @ direction)[quads[chart == 1]]
    across = 0.02 + (turned + np.pi) / (3 * np.pi) * 0.96
    uvs[chart == 1] = np.stack([across, 0.55 + (heights + 0.7) / 1.4 * 0.4], axis=-1)
    return uvs


def expect_the_eight(found, arrays, radius):
    places = arrays.positions[found.vertices]
    assert len(places) == 8
    assert {tuple(np.sign(place)) for place in places} == {(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)}
    # The response is flat at its top: it is 1 % lower at a third of the radius. Vertices are half a radius apart.
    assert np.abs(np.abs(places) - CORNER).max() < 0.5 * radius


@pytest.mark.slow
@pytest.mark.parametrize("backend", ["cpu", "reference"])
def test_the_corners_of_a_rounded_cube_are_found_on_two_atlases(backend):
    points, quads, uvs = rounded_cube()
    settings = job.Settings(("harris",), bridge.Options(radius=0.05, buffer_size=512), backend)
    for atlas in (uvs, atlas_across_faces(points, quads)):
        arrays = as_arrays(points, quads, atlas)
        results = job.run(arrays, settings)
        expect_the_eight(results.corners, arrays, results.radius)
        if backend == "reference":
            break  # it needs no atlas


def strip(values):
    """Triangles along a row of points at distance 1, two points for each step, and a value for each step."""
    steps = np.arange(len(values), dtype=np.float32)
    positions = np.array([[x, y, 0] for x in steps for y in (0, 1)], np.float32)
    triangles = [[2 * i, 2 * i + 2, 2 * i + 1] for i in range(len(values) - 1)]
    triangles += [[2 * i + 1, 2 * i + 2, 2 * i + 3] for i in range(len(values) - 1)]
    response = np.full(2 * len(values), np.nan, np.float32)
    response[::2] = values
    return positions, np.array(triangles, np.int32), response


@pytest.mark.parametrize(("radius", "expected"), [(1.5, [10, 2, 6]), (3.5, [10, 2]), (100.0, [10])])
def test_only_the_largest_within_the_radius_stays(radius, expected):
    positions, triangles, response = strip([0, 3, 0, 2, 0, 4, 0.1])
    found = corners.find_corners(positions, triangles, response, radius)
    assert list(found.vertices) == expected
    assert list(np.flatnonzero(found.painted)) == sorted(expected)


def test_what_is_below_the_threshold_is_no_corner():
    positions, triangles, response = strip([0, 3, 0, 2, 0, 4, 0.1])
    assert list(corners.find_corners(positions, triangles, response, 1.0, 0.6).vertices) == [10, 2]
    assert len(corners.find_corners(positions, triangles, -np.abs(response), 1.0).vertices) == 0
    assert len(corners.find_corners(positions, triangles, response * np.nan, 1.0).vertices) == 0


def test_a_higher_one_on_another_part_of_the_mesh_does_not_count():
    positions, triangles, response = strip([0, 3, 0])
    both = np.concatenate([positions, positions + np.float32([0, 0, 0.1])]).astype(np.float32)
    found = corners.find_corners(
        both, np.concatenate([triangles, triangles + 6]), np.concatenate([response, 2 * response]), 2.0
    )
    assert list(found.vertices) == [8, 2]


def test_vertices_split_by_an_exporter_are_one_place():
    positions, triangles, response = strip([0, 3, 0, 2, 0])
    split = triangles.reshape(-1)
    loose = np.arange(len(split), dtype=np.int32).reshape(-1, 3)
    found = corners.find_corners(positions[split], loose, response[split], 1.5)
    assert list(split[found.vertices]) == [2, 6]
    assert list(np.unique(split[np.flatnonzero(found.painted)])) == [2, 6]
    assert found.painted.sum() == np.isin(split, [2, 6]).sum()


def test_of_equal_neighbors_one_stays():
    positions, triangles, response = strip([0, 3, 3, 0])
    assert list(corners.find_corners(positions, triangles, response, 2.0).vertices) == [2]


def plainly(positions, triangles, response, radius, threshold):
    """The corners as their definition says, place by place."""
    at = [tuple(place + np.float32(0)) for place in positions]
    first = {place: index for index, place in reversed(list(enumerate(at)))}
    height = {place: (-np.inf, -first[place]) for place in first}
    for place, value in zip(at, response, strict=True):
        if np.isfinite(value):
            height[place] = max(height[place], (float(value), -first[place]))
    beside = {place: set() for place in first}
    for triangle in triangles:
        for corner in range(3):
            one, other = at[triangle[corner]], at[triangle[corner - 1]]
            beside[one].add(other)
            beside[other].add(one)
    least = max(0, threshold * max(value for value, _ in height.values()))
    found = []
    for place in sorted(first, key=height.get, reverse=True):
        reached, waiting = {place}, [place]
        while waiting:
            for other in beside[waiting.pop()] - reached:
                if np.linalg.norm(np.subtract(other, place, dtype=np.float64)) <= radius:
                    reached.add(other)
                    waiting.append(other)
        higher = any(height[other] > height[place] for other in reached | beside[place])
        if height[place][0] > least and not higher:
            found.append(first[place])
    return found


@pytest.mark.parametrize("seed", range(6))
def test_corners_are_those_that_the_definition_says(seed, monkeypatch):
    if seed % 2:
        for name in ("PART", "GROUP", "RING"):  # many short steps
            monkeypatch.setattr(corners, name, 7)
    random = np.random.default_rng(seed)
    points, quads, uvs = cube_sphere(5)
    arrays = as_arrays(np.round(points) if seed > 3 else points, quads, uvs)  # many vertices at one place, -0 and 0
    response = np.round(2 * random.standard_normal(len(points))) / 2  # many are equal
    response[random.random(len(points)) < 0.2] = np.nan
    for radius in (0.01, 1.0, 2.0, 10.0):
        given = (arrays.positions, arrays.triangle_vertices, response.astype(np.float32), radius, 0.3)
        found = corners.find_corners(*given)
        assert list(found.vertices) == plainly(*given)
        same_place = (arrays.positions[:, None] == arrays.positions[found.vertices]).all(axis=2)
        assert np.array_equal(found.painted, same_place.any(axis=1))


def test_the_search_asks_between_short_steps_whether_to_stop(monkeypatch):
    monkeypatch.setattr(corners, "PART", 100)
    monkeypatch.setattr(corners, "RING", 100)
    arrays = as_arrays(*cube_sphere(12))
    response = np.random.default_rng(0).standard_normal(len(arrays.positions)).astype(np.float32)
    given = (arrays.positions, arrays.triangle_vertices, response, 1.0, 0.05)
    asked = []
    expected = corners.find_corners(*given, lambda *words: asked.append(words) or True)
    assert set(asked) == {("corners", 1.0)}
    assert len(asked) > 50
    for last in range(len(asked)):
        left = iter(range(last))
        with pytest.raises(bridge.ParadescError) as caught:
            corners.find_corners(*given, lambda *_words, left=left: next(left, None) is not None)
        assert caught.value.status == bridge.abi.STATUS_CANCELLED
    assert list(corners.find_corners(*given).vertices) == list(expected.vertices)


def test_a_bake_can_be_cancelled_while_corners_are_looked_for():
    arrays = as_arrays(*cube_sphere(6))
    settings = job.Settings(("harris",), bridge.Options(radius=0.1, samples=32), "cpu")
    seen = []
    with pytest.raises(bridge.ParadescError) as caught:
        job.run(arrays, settings, lambda stage, fraction: seen.append((stage, fraction)) or stage != "corners")
    assert caught.value.status == bridge.abi.STATUS_CANCELLED
    assert seen[-1] == ("corners", 1.0)
    fractions = [fraction for _, fraction in seen]
    assert fractions == sorted(fractions)


@pytest.mark.slow
def test_the_command_line_lists_and_paints_them(paradesc, tmp_path):
    points, quads, uvs = rounded_cube(16)
    mesh = write_obj(tmp_path / "cube.obj", points, quads, uvs)
    words = ["--descriptors", "harris", "--radius", "0.05", "--buffer", "256", "--samples", "64"]
    done = paradesc("bake", mesh, *words, "--output", "cube.npz", "--corners", "corners.json", "--json", "report.json")
    assert done.returncode == 0, done.stderr
    listed = json.loads((tmp_path / "corners.json").read_text())
    painted = np.load(tmp_path / "cube.npz")
    assert len(listed) == 8
    assert sorted(row["vertex"] for row in listed) == list(np.flatnonzero(painted["harris_corner"]))
    for row in listed:
        assert row["response"] == pytest.approx(painted["harris"][row["vertex"]])
        assert row["position"] == pytest.approx(painted["vertices"][row["vertex"]])
    assert json.loads((tmp_path / "report.json").read_text())["objects"][0]["corners"] == listed


def test_corners_without_harris_are_refused(paradesc, sphere_obj):
    done = paradesc("bake", sphere_obj, "--output", "a.npz", "--corners", "c.json")
    assert done.returncode == 2
    assert done.stderr == "paradesc: Corners are found by the descriptor harris; add it to --descriptors.\n"


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        ({"map_descriptor": "harris"}, "cannot be the map"),
        ({"map_descriptor": "principal_direction_max"}, "cannot be the map"),
        ({"map_descriptor": "nothing"}, "There is no descriptor 'nothing'"),
        ({"map_sigma": 0.0}, "map_sigma"),
        ({"map_sigma": float("nan")}, "map_sigma"),
        ({"harris_k": 0.25}, "harris_k"),
    ],
)
def test_options_that_make_no_sense_are_refused(sphere, options, sentence):
    settings = job.Settings(("harris",), bridge.Options(**options), "reference")
    with pytest.raises(bridge.ParadescError, match=sentence):
        job.run(sphere, settings)


def test_the_colors_of_a_response_show_what_is_small_against_one():
    row = next(row for row in bridge.descriptors() if row.name == "harris")
    shown = color_maps.value_range(np.linspace(-1e-7, 1e-6, 100, dtype=np.float32), row, 0.1)
    assert shown.maximum == pytest.approx(1e-6, rel=0.1)
    assert shown.minimum == -shown.maximum


def test_a_unit_is_that_of_the_map_to_the_degree_of_the_operator():
    rows = {row.name: row for row in bridge.descriptors()}
    assert rows["laplacian"].unit_on("sphere_volume_normalized") == "1/length^2"
    assert rows["laplacian"].unit_on("mean_curvature") == "1/length^3"
    assert rows["harris"].unit_on("mean_curvature") == "1/length^4"
    assert rows["mean_curvature"].unit_on("sphere_volume") == "1/length"
