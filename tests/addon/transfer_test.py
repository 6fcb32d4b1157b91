"""High to low: values of detailed surfaces over the UV map of a coarse one, as arrays, and pairs told by names."""

import tracemalloc
from dataclasses import replace

import numpy as np
import pytest

from paradesc import bridge
from paradesc.bridge import ParadescError, abi
from paradesc.core import job, pair_names, texel_centers, transfer
from paradesc.files.results import Baked, joined
from shapes import as_arrays, cube_sphere

QUICK = bridge.Options(radius=0.08, samples=32)
SIZE = 96


def part(name, arrays, matrix=None):
    """An object that is measured in its own space."""
    return transfer.Part(name, arrays, arrays, np.eye(4) if matrix is None else matrix)


def settings_of(*names, space="object"):
    return job.Settings(names, QUICK, "cpu", space=space)


def bumpy(points):
    """A smooth function of the place on the sphere."""
    return np.sin(1.5 * points[:, 0]) + np.cos(points[:, 1] * points[:, 2])


@pytest.fixture(scope="module")
def low():
    return part("ball_low", as_arrays(*cube_sphere(5)))


@pytest.fixture(scope="module")
def high():
    return part("ball_high", as_arrays(*cube_sphere(24)))


def rays_of(low, size):
    """The centers of the texels in the world and the normals there, as numpy alone finds them: (size, size, 3) each."""
    normals = transfer.smooth_normals(low.points, low.triangles)
    uvs = low.arrays.corner_uvs[low.arrays.triangle_corners].astype(np.float64)
    places, across = np.full((size, size, 3), np.nan), np.full((size, size, 3), np.nan)
    centers = np.stack(np.meshgrid((np.arange(size) + 0.5) / size, (np.arange(size) + 0.5) / size), axis=-1)
    for uv, corners in zip(uvs, low.triangles, strict=True):
        shares = np.linalg.solve(np.vstack([uv.T, np.ones(3)]), np.vstack([centers.reshape(-1, 2).T, np.ones(size**2)]))
        inside = (shares >= 0).all(axis=0).reshape(size, size)
        weights = shares.T.reshape(size, size, 3)[inside]
        places[inside], across[inside] = weights @ low.points[corners], weights @ normals[corners]
    return places, across


# ---- Values


def test_every_texel_of_a_coarse_sphere_has_the_curvature_of_the_fine_one(low, high):
    results = transfer.run(low, [high], settings_of("mean_curvature"), SIZE)
    image = results.transfer.images["mean_curvature"]
    there = np.isfinite(image)
    assert results.transfer.missed == 0
    assert there.sum() == results.transfer.texels > 0.7 * SIZE**2
    np.testing.assert_allclose(image[there], 0.5, atol=1e-3)  # that of the fine sphere's own vertices
    np.testing.assert_allclose(results.values["mean_curvature"], 0.5, atol=1e-3)
    assert len(results.values["mean_curvature"]) == len(low.arrays.positions)
    own = job.run(low.measured, settings_of("mean_curvature"))
    assert np.abs(own.values["mean_curvature"] - 0.5).max() > 0.003  # the coarse sphere alone would not do


def test_a_texel_has_the_value_of_where_its_line_along_the_normal_meets_the_sphere(low, monkeypatch):
    def known(arrays, settings, _progress=None, _with_buffers=False):
        found = measured(arrays, settings)
        found.values["mean_curvature"] = bumpy(arrays.positions).astype(np.float32)
        return found

    measured = job.run
    monkeypatch.setattr(job, "run", known)
    high = part("fine", as_arrays(*cube_sphere(48)))
    image = transfer.run(low, [high], settings_of("mean_curvature"), SIZE).transfer.images["mean_curvature"][:, :, 0]
    places, normals = rays_of(low, SIZE)
    normals /= np.linalg.norm(normals, axis=2, keepdims=True)
    along = (places * normals).sum(axis=2)
    place = places + normals * (np.sqrt(4.0 - (places**2).sum(axis=2) + along**2) - along)[:, :, None]
    there = np.isfinite(image) & np.isfinite(place[:, :, 0])
    assert there.sum() > 0.7 * SIZE**2
    # Linear over triangles whose edges are up to 0.12 long: with second derivatives up to 5 it is off by 5 0.12² / 8.
    np.testing.assert_allclose(image[there], bumpy(place[there]), atol=0.009)


def test_directions_turn_with_the_objects(low):
    points, quads, uvs = cube_sphere(20)
    high = as_arrays(points * [1.0, 1.0, 1.6], quads, uvs)
    turn = np.array([[0.0, 0, 1, 0], [1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 0, 1]])  # z becomes x, x y, y z
    name = "principal_direction_max"
    straight = transfer.run(low, [part("h", high)], settings_of(name), 64, 2.0).transfer.images[name]
    both = transfer.run(part("l", low.arrays, turn), [part("h", high, turn)], settings_of(name), 64, 2.0)
    same = np.abs((both.transfer.images[name] * straight).sum(axis=2)[np.isfinite(straight[:, :, 0])])
    np.testing.assert_allclose(same, 1, atol=1e-3)
    found = transfer.run(low, [part("h", high, turn)], settings_of(name), 64, 2.0).values[name]
    long = np.abs(low.arrays.positions[:, 0]) < 0.3  # beside the equator of what is long along x
    assert np.nanmax(np.abs(found[long][:, 0])) < 0.2  # the larger curvature runs around it


def test_where_objects_stand_counts_and_mirrored_ones_keep_their_outside(low, high):
    moved = np.diag([-2.0, 2.0, 2.0, 1.0])
    moved[:3, 3] = 100, -50, 7
    both = transfer.run(
        part("l", low.arrays, moved), [part("h", high.arrays, moved)], settings_of("mean_curvature"), SIZE
    )
    assert both.transfer.missed == 0
    assert both.transfer.cage == pytest.approx(0.1 * 2 * np.linalg.norm(np.ptp(low.arrays.positions, axis=0)))
    one = transfer.run(part("l", low.arrays, np.diag([-1.0, 1, 1, 1])), [high], settings_of("mean_curvature"), SIZE)
    other = transfer.run(low, [part("h", high.arrays, np.diag([1.0, -1, 1, 1]))], settings_of("mean_curvature"), SIZE)
    assert one.transfer.missed == other.transfer.missed == 0
    away = part("high", high.arrays, moved)
    with pytest.raises(ParadescError, match=r'No texel of "ball_low" meets "high" within the cage distance .* lay the'):
        transfer.run(low, [away], settings_of("mean_curvature"), SIZE)


def test_several_meshes_give_each_texel_the_nearest_of_them(low):
    points, quads, uvs = cube_sphere(24)
    upper = points[quads][:, :, 2].mean(axis=1) > 0
    last = len(points) - 1
    halves = [
        part("ball_high_0", as_arrays(points, quads[upper], uvs[upper])),
        part("ball_high_1", as_arrays(points[::-1], last - quads[~upper], uvs[~upper])),  # vertices of its own
    ]
    results = transfer.run(low, halves, settings_of("sphere_volume_normalized"), SIZE)
    assert results.transfer.missed == 0
    assert results.transfer.sources == ["ball_high_0", "ball_high_1"]
    assert len(results.transfer.measured["sphere_volume_normalized"]) == 2 * len(points)


def test_several_coarse_meshes_in_one_file_share_a_range_of_colors(low, high):
    found = [transfer.run(low, [high], settings_of("mean_curvature"), 32) for _ in range(2)]
    found[1].transfer.measured["mean_curvature"] = 3 + found[1].transfer.measured["mean_curvature"]
    whole = joined([Baked(f"low {k}", results, low.arrays, np.eye(4)) for k, results in enumerate(found)])
    assert whole.results.shown("mean_curvature").maximum == pytest.approx(3.5, abs=0.01)


def test_masks_of_several_meshes_in_one_file_share_a_range_of_colors(low, high):
    settings = job.Settings(("convexity",), bridge.Options(radius=0.3), "cpu")
    bakes = [job.run(one.arrays, settings) for one in (low, high)]
    baked = [Baked(one.name, results, one.arrays, np.eye(4)) for one, results in zip((low, high), bakes, strict=True)]
    shown = joined(baked).results.shown("convexity")
    assert (shown.minimum, shown.maximum) == job.with_one_scale(bakes[0].look, bakes).ranges["convexity"]


def test_a_layout_that_was_made_for_the_detailed_mesh_stays_with_it(low, high, monkeypatch):
    measured = job.run

    def unwrapping(*arguments):
        found = measured(*arguments)
        found.unwrapped = bridge.Layout(high.arrays.corner_uvs, "has no UV map", "", False)
        return found

    monkeypatch.setattr(job, "run", unwrapping)
    assert transfer.run(low, [high], settings_of("mean_curvature"), 32).unwrapped is None


def test_normals_are_those_of_a_sphere_and_one_at_vertices_of_one_place(low):
    points = low.points
    apart = points[low.triangles].reshape(-1, 3)
    normals = transfer.smooth_normals(apart, np.arange(len(apart)).reshape(-1, 3))
    together = transfer.smooth_normals(points, low.triangles)
    np.testing.assert_allclose(normals, together[low.triangles].reshape(-1, 3), atol=1e-12)
    unit = together / np.linalg.norm(together, axis=1, keepdims=True)
    assert np.abs(unit - points / 2.0).max() < 0.05


# ---- Misses


def test_texels_that_meet_nothing_are_counted_and_filled_from_beside_them(low, high):
    smaller = transfer.run(low, [high], settings_of("mean_curvature"), SIZE, 0.03)
    found = smaller.transfer
    places, normals = rays_of(low, SIZE)
    normals /= np.linalg.norm(normals, axis=2, keepdims=True)
    along = (places * normals).sum(axis=2)
    away = np.sqrt(4.0 - (places**2).sum(axis=2) + along**2) - along
    expected = np.nansum(away > 0.03)
    # The fine sphere's faces lie up to 0.002 below its radius.
    assert np.nansum(away > 0.033) <= found.missed <= expected
    assert 0 < found.missed < found.texels
    assert f"{found.missed:,} of {found.texels:,} texels" in smaller.warnings[-1]
    assert "raise the cage distance" in smaller.warnings[-1]
    image = found.images["mean_curvature"]
    assert np.isfinite(image).sum() == found.texels
    np.testing.assert_allclose(image[np.isfinite(image)], 0.5, atol=1e-3)


def test_a_few_texels_that_meet_nothing_are_a_note(low, high, monkeypatch):
    monkeypatch.setattr(transfer, "WORTH_WARNING", 0.9)
    results = transfer.run(low, [high], settings_of("mean_curvature"), SIZE, 0.03)
    assert "met nothing" in results.notes[-1]
    assert not results.warnings


def test_a_surface_that_faces_the_other_way_is_not_met(low, high):
    inside_out = as_arrays(*cube_sphere(10))
    inside_out.triangle_corners = inside_out.triangle_corners[:, ::-1].copy()
    with pytest.raises(ParadescError, match="No texel"):
        transfer.run(low, [part("h", inside_out)], settings_of("mean_curvature"), SIZE)


def test_an_object_that_is_scaled_to_nothing_is_one_sentence(low, high):
    flat = np.diag([1.0, 1.0, 0.0, 1.0])
    for one, other in ((part("flat", low.arrays, flat), high), (low, part("flat", high.arrays, flat))):
        with pytest.raises(ParadescError, match='The object "flat" is scaled to nothing'):
            transfer.run(one, [other], settings_of("principal_direction_max"), SIZE)


@pytest.mark.parametrize("cage", [-1.0, float("nan"), float("inf")])
def test_a_cage_distance_that_is_none_is_one_sentence(low, high, cage):
    with pytest.raises(ParadescError, match="The cage distance is"):
        transfer.run(low, [high], settings_of("mean_curvature"), SIZE, cage)


def test_it_is_cancelled_at_any_time(low, high):
    for least in (0.0, 0.5, 0.7, 0.9):
        with pytest.raises(ParadescError) as error:
            transfer.run(low, [high], settings_of("mean_curvature"), 512, 0, lambda _s, done, at=least: done < at)
        assert error.value.status == abi.STATUS_CANCELLED


def test_vertices_and_texels_look_through_one_tree(low, high, monkeypatch):
    seen, cast = [], bridge.cast_rays
    monkeypatch.setattr(bridge, "cast_rays", lambda *words: seen.append(len(words[2])) or cast(*words))
    found = transfer.run(low, [high], settings_of("mean_curvature"), SIZE).transfer
    assert seen == [len(low.arrays.positions) + found.texels]


def test_images_that_need_more_memory_than_is_allowed_are_refused_before_anything_is_measured(low, high, monkeypatch):
    settings = replace(settings_of("mean_curvature", "cavity"), memory_limit=10**8)
    monkeypatch.setattr(job, "run", None)
    with pytest.raises(ParadescError) as error:
        transfer.run(low, [high], settings, 2048)
    assert error.value.status == abi.STATUS_OUT_OF_MEMORY
    assert error.value.sentence == (
        "Images of 2,048 × 2,048 texels from high to low need about 0.21 GB of memory, and 0.1 GB may be used "
        "(the memory limit); choose fewer texels, or set a higher limit."
    )


@pytest.mark.parametrize("names", [("mean_curvature",), ("mean_curvature", "cavity", "principal_direction_max")])
def test_the_forecast_of_memory_holds(low, high, names):
    tracemalloc.start()
    try:
        transfer.run(low, [high], settings_of(*names), 1024, 0.03)
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    # Charts cover four fifths of the texels; beside images there are arrays of the meshes.
    assert 0.6 < peak / transfer.memory_of_images(settings_of(*names), 1024) < 1.05


def test_colors_span_the_values_of_the_detailed_surface(low):
    points, quads, uvs = cube_sphere(24)
    rough = part("h", as_arrays(points * (1 + 0.05 * np.sin(9 * points[:, :1])), quads, uvs))
    results = transfer.run(low, [rough], settings_of("mean_curvature"), SIZE)
    alone = job.run(rough.measured, settings_of("mean_curvature"))
    assert results.shown("mean_curvature") == alone.shown("mean_curvature")
    assert texel_centers.with_texels(settings_of("mean_curvature"), SIZE, "vertex").options == results.settings.options


# ---- Names


def test_names_tell_which_meshes_belong_together():
    names = ["a_low", "a_high", "a_high_bolts", "a_high.001", "A_HIGH2", "a_highlight", "b_low", "b", "b_high_low",
             "c.low.002", "c.high", "d_high", "long_name_low", "long_name_high"]  # fmt: skip
    assert pair_names.pairs_of(names) == {
        "a_low": ["a_high", "a_high_bolts", "a_high.001", "A_HIGH2"],
        "b_low": ["b_high_low"],
        "c.low.002": ["c.high"],
        "long_name_low": ["long_name_high"],
    }
    assert not pair_names.is_one_of_a_pair("slow")
    assert not pair_names.is_one_of_a_pair("a_highlight")
