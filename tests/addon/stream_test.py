"""A stream of positions has, frame for frame, the bits of bakes of their own; without Blender."""

from dataclasses import replace

import numpy as np
import pytest

from paradesc import bridge
from paradesc.core import job, stream
from shapes import RADIUS, as_arrays, cube_sphere

NAMES = ("mean_curvature", "shape_index", "principal_direction_max")


def settings(names=NAMES, more_radii=(), **options):
    given = {"radius": 0.08, "samples": 64, "buffer_size": 256, **options}
    return job.Settings(names, bridge.Options(**given), "software", more_radii=more_radii)


def bent(positions, strength):
    """Positions that are turned about z by an angle that grows along z."""
    angle = strength * positions[:, 2]
    x, y = positions[:, 0], positions[:, 1]
    turned = [np.cos(angle) * x - np.sin(angle) * y, np.sin(angle) * x + np.cos(angle) * y, positions[:, 2]]
    return np.stack(turned, axis=1).astype(np.float32)


def pear(positions, strength):
    """Positions that move outwards the higher they are, so that the areas of charts change by different factors."""
    return (positions * np.exp(strength * positions[:, 2:])).astype(np.float32)


def stacked(arrays):
    """Puts all charts in one place of the UV map."""
    return replace(arrays, corner_uvs=(arrays.corner_uvs * (3, 2)) % 1.0)


def shrunk(arrays):
    """Shrinks charts, so that they leave most of the UV map empty."""
    return replace(arrays, corner_uvs=(0.3 * arrays.corner_uvs).astype(np.float32))


def assert_same(results, expected):
    """Checks that all bits are the same, and the reports except for times."""
    for name in expected.values:
        assert results.values[name].tobytes() == expected.values[name].tobytes(), name
    assert results.coverage.tobytes() == expected.coverage.tobytes()
    assert results.mask.tobytes() == expected.mask.tobytes()
    for ours, theirs in ((results.mesh_report, expected.mesh_report), (results.field_report, expected.field_report)):
        timeless = {name: value for name, value in theirs.items() if not name.startswith("seconds")}
        assert {name: ours[name] for name in timeless} == timeless
    assert results.warnings == expected.warnings


def check_frames(arrays, chosen, frames, made=1):
    """Compares each frame with a bake of its own, and how often the native mesh was made."""
    with stream.Stream(arrays, chosen) as opened:
        for positions in frames:
            assert_same(opened.compute(positions), job.run(replace(arrays, positions=positions), chosen))
        assert opened.made == made


@pytest.fixture
def sound_sphere():
    """Charts that fill enough of their square for the UV map itself to be baked."""
    return as_arrays(*cube_sphere())


def test_a_soup_that_rounding_keeps_together_is_made_anew_in_every_frame(sound_sphere):
    corners = sound_sphere.positions[sound_sphere.corner_vertices]
    moved = corners + np.random.default_rng(2).uniform(-2e-7, 2e-7, corners.shape)
    vertices = np.arange(len(corners), dtype=np.int32)
    soup = replace(sound_sphere, positions=moved.astype(np.float32), corner_vertices=vertices)
    check_frames(soup, settings(NAMES[:1]), [soup.positions, bent(soup.positions, 0.3)], made=2)


@pytest.mark.parametrize(
    ("chosen", "made"),
    [
        (settings(), 1),
        (settings(more_radii=(0.12,)), 1),
        (settings(relocation="affine", normals="max"), 1),
        (settings(evaluate="texel", texels=32), 1),
    ],
    ids=["connected", "two radii", "affine", "texel"],
)
def test_every_frame_has_the_bits_of_a_bake_of_its_own(sound_sphere, chosen, made):
    frames = [bent(sound_sphere.positions, strength) for strength in (0.0, 0.3, -0.2)]
    check_frames(sound_sphere, chosen, frames, made)


def test_corners_are_those_of_the_frame():
    coarse = as_arrays(*cube_sphere(5))
    chosen = settings(("harris",), samples=16, radius=0.15, buffer_size=128)
    with stream.Stream(coarse, chosen) as opened:
        for strength in (0.0, 0.6):
            positions = bent(coarse.positions, strength)
            found, alone = opened.compute(positions), job.run(replace(coarse, positions=positions), chosen)
            assert_same(found, alone)
            assert np.array_equal(found.corners.vertices, alone.corners.vertices)


def test_order_of_frames_does_not_matter(sound_sphere):
    frames = [bent(sound_sphere.positions, strength) for strength in (0.1, 0.3)]
    with stream.Stream(sound_sphere, settings()) as opened:
        first, second, again = (opened.compute(frames[k]) for k in (0, 1, 0))
    assert_same(again, first)
    assert first.values["mean_curvature"].tobytes() != second.values["mean_curvature"].tobytes()


def test_charts_that_share_texture_space_are_laid_out_by_each_frame(sound_sphere):
    overlapping = stacked(sound_sphere)
    frames = [overlapping.positions * np.float32([1, 1, stretch]) for stretch in (1.0, 2.5)]
    check_frames(overlapping, settings(), [*frames, pear(overlapping.positions, 0.6)], made=3)


def test_a_map_that_is_sparse_in_one_frame_only_is_laid_out_in_that_one(sound_sphere):
    small = shrunk(sound_sphere)
    frames = [small.positions, bent(small.positions, 0.4), pear(small.positions, 0.6)]
    check_frames(small, settings(radius=0.15), frames, made=3)


@pytest.mark.parametrize(("laid_out", "radius"), [(stacked, 0.08), (shrunk, 0.15)], ids=["overlaps", "sparse"])
def test_a_layout_made_before_a_late_cancel_is_not_that_of_the_next_frame(sound_sphere, laid_out, radius):
    mesh, chosen = laid_out(sound_sphere), settings(radius=radius)
    moved = pear(mesh.positions, 0.6)
    with bridge.Context("software") as context:
        layouts = [layout_at(context, replace(mesh, positions=at), chosen) for at in (mesh.positions, moved)]
    assert not np.allclose(*layouts, atol=0.1)  # otherwise the test would show nothing
    with stream.Stream(mesh, chosen) as opened:
        with pytest.raises(bridge.ParadescError) as caught:
            opened.compute(mesh.positions, lambda stage, _fraction: stage != "evaluate")
        assert caught.value.status == bridge.abi.STATUS_CANCELLED
        assert_same(opened.compute(moved), job.run(replace(mesh, positions=moved), chosen))


def layout_at(context, arrays, chosen):
    """(triangle_count, 3, 2) places in the layout that a computation makes for these positions."""
    with context.mesh(arrays) as mesh, mesh.compute(["mean_curvature"], chosen.options) as field:
        assert field.report()["private_layout"]
        return mesh.layout()


def test_vertices_that_part_or_meet_are_found(sound_sphere):
    count = len(sound_sphere.positions)
    corners = np.arange(len(sound_sphere.corner_vertices), dtype=np.int32)  # every corner has a vertex of its own
    split = replace(
        sound_sphere, positions=sound_sphere.positions[sound_sphere.corner_vertices], corner_vertices=corners
    )
    parted = split.positions.copy()
    parted[:4] *= np.float32(1.1)
    check_frames(split, settings(), [split.positions, parted, bent(split.positions, 0.2)], made=3)
    assert count < len(split.positions)


def test_triangles_that_lose_their_area_are_left_out(sound_sphere):
    collapsed = sound_sphere.positions.copy()
    first, second, _ = sound_sphere.triangle_vertices[5]
    collapsed[first] = collapsed[second] + np.float32([0, 0, 0])
    check_frames(sound_sphere, settings(), [sound_sphere.positions, collapsed, sound_sphere.positions], made=3)


def test_a_triangle_drawn_out_to_a_line_is_found_though_no_vertices_meet(sound_sphere):
    line = sound_sphere.positions.copy()
    a, b, c = sound_sphere.triangle_vertices[9]
    line[a], line[b], line[c] = (0, 0, 0.5), (0, 0, 1), (0, 0, 1.5)  # within the sphere, where no vertex is
    assert len(np.unique(line, axis=0)) == len(np.unique(sound_sphere.positions, axis=0)) == len(line)
    contact = stream.Contact(sound_sphere)
    assert contact.holds(sound_sphere.positions)
    assert contact.holds(bent(sound_sphere.positions, 0.3))
    assert not contact.holds(line)
    assert stream.Contact(replace(sound_sphere, positions=line)).holds(line)
    check_frames(sound_sphere, settings(), [sound_sphere.positions, line, sound_sphere.positions], made=3)


def test_fans_that_meet_in_one_vertex_are_weighed_in_each_frame(sound_sphere):
    """Two spheres share a vertex. The wider fan stands for it, first that of the one and then that of the other."""
    count, corners = len(sound_sphere.positions), len(sound_sphere.corner_vertices)
    tip = int(np.argmax(sound_sphere.positions[:, 2]))
    height = np.float32(2 * sound_sphere.positions[tip, 2])
    other = sound_sphere.positions * np.float32([1, 1, -1]) + np.float32([0, 0, height])
    vertices = np.where(sound_sphere.corner_vertices == tip, tip, sound_sphere.corner_vertices + count)
    uvs = sound_sphere.corner_uvs * np.float32([0.5, 1])
    pair = replace(
        sound_sphere,
        positions=np.concatenate([sound_sphere.positions, other]).astype(np.float32),
        corner_vertices=np.concatenate([sound_sphere.corner_vertices, vertices]).astype(np.int32),
        triangle_corners=np.concatenate([sound_sphere.triangle_corners, sound_sphere.triangle_corners + corners]),
        corner_uvs=np.concatenate([uvs, uvs + np.float32([0.5, 0])]),
    )
    drawn = pair.positions.copy()  # the first sphere drawn out to a needle at the vertex
    drawn[:count, :2] *= np.float32(0.2)
    drawn_other = pair.positions.copy()
    drawn_other[count:, :2] *= np.float32(0.2)
    chosen = settings(relocation="affine", radius=0.04, buffer_size=512)
    check_frames(pair, chosen, [drawn, drawn_other], made=2)


def test_zero_and_minus_zero_are_one_place():
    places = np.array([[0.0, 1.0, 2.0], [-0.0, 1.0, 2.0], [0.0, 1.0, 3.0]], np.float32)
    keys = bridge.origin.place_keys(places.T)
    assert keys[0] == keys[1] != keys[2]
    assert stream.distinct(keys) == 2


def test_own_normals_follow_the_positions_or_are_asked_for(sound_sphere):
    chosen = settings(normals="mesh")
    normals = (sound_sphere.positions / RADIUS)[sound_sphere.corner_vertices]
    with stream.Stream(sound_sphere, chosen) as opened:
        with pytest.raises(bridge.ParadescError, match="own normals"):
            opened.compute(sound_sphere.positions)
        for flip in (1, -1):
            arrays = replace(sound_sphere, corner_normals=(flip * normals).astype(np.float32))
            found = opened.compute(arrays.positions, corner_normals=arrays.corner_normals)
            assert_same(found, job.run(arrays, chosen))
            assert flip * np.nanmedian(found.values["mean_curvature"]) == pytest.approx(0.5, rel=0.05)


def test_displacement_stays_on_the_moving_surface(sound_sphere):
    heights = np.random.default_rng(1).random((32, 32)).astype(np.float32)
    mapped = replace(sound_sphere, maps=bridge.SurfaceMaps(heights=heights, scale=0.05))
    check_frames(mapped, settings(), [mapped.positions, bent(mapped.positions, 0.3)])
    normal_mapped = replace(sound_sphere, maps=bridge.SurfaceMaps(normals=np.full((4, 4, 3), 0.5, np.float32)))
    with stream.Stream(normal_mapped, settings()) as opened, pytest.raises(bridge.ParadescError, match="tangents"):
        opened.compute(mapped.positions)


def test_reference_streams_too(sound_sphere):
    coarse = as_arrays(*cube_sphere(5))
    chosen = replace(settings(radius=0.2), backend="reference")
    check_frames(replace(coarse, corner_uvs=None), chosen, [coarse.positions, bent(coarse.positions, 0.3)])
    assert len(coarse.positions) < len(sound_sphere.positions)


def test_match_is_everything_but_positions(sound_sphere):
    with stream.Stream(sound_sphere, settings()) as opened:
        assert opened.matches(replace(sound_sphere, positions=bent(sound_sphere.positions, 0.2)))
        assert not opened.matches(replace(sound_sphere, corner_uvs=sound_sphere.corner_uvs * np.float32(0.5)))
        assert not opened.matches(replace(sound_sphere, triangle_corners=sound_sphere.triangle_corners[::-1].copy()))
        assert not opened.matches(replace(sound_sphere, maps=bridge.SurfaceMaps(heights=np.ones((2, 2), np.float32))))
        assert not opened.matches(as_arrays(*cube_sphere(5)))


def test_another_mesh_goes_on_the_same_device(sound_sphere):
    other = as_arrays(*cube_sphere(9))
    with stream.Stream(sound_sphere, settings()) as opened:
        opened.compute(sound_sphere.positions)
        opened.replace(other)
        assert_same(opened.compute(other.positions), job.run(other, settings()))


def test_wrong_positions_are_one_sentence_and_the_stream_goes_on(sound_sphere):
    chosen = settings()
    broken = sound_sphere.positions.copy()
    broken[7, 1] = np.nan
    shapes = (sound_sphere.positions[:-1], sound_sphere.positions.ravel(), sound_sphere.positions[:, :0])
    with stream.Stream(sound_sphere, chosen) as opened:
        for positions, words in (*((shape, "vertices") for shape in shapes), (broken, "vertex 7")):
            with pytest.raises(bridge.ParadescError, match=words):
                opened.compute(positions)
        with pytest.raises(bridge.ParadescError) as caught:
            opened.compute(sound_sphere.positions, lambda _stage, _fraction: False)
        assert caught.value.status == bridge.abi.STATUS_CANCELLED
        assert_same(opened.compute(sound_sphere.positions), job.run(sound_sphere, chosen))


def test_stream_refuses_what_a_bake_refuses(sound_sphere):
    with pytest.raises(bridge.ParadescError, match="no UV coordinates"):
        stream.Stream(replace(sound_sphere, corner_uvs=None), settings())
    with pytest.raises(bridge.ParadescError, match="no descriptor"):
        stream.Stream(sound_sphere, settings(("mean_curvatura",)))
