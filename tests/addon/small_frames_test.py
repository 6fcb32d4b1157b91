"""Frames in which a mesh is smaller than the radius have no values, and the others go on."""

from dataclasses import replace

import numpy as np
import pytest

bpy = pytest.importorskip("bpy", reason="needs Blender")

from animate_test import SETTINGS, bake  # noqa: E402

import animated  # noqa: E402
from paradesc import bridge  # noqa: E402
from paradesc.files import cache  # noqa: E402
from paradesc_blender.animation import frames  # noqa: E402


def test_a_frame_that_is_smaller_than_the_radius_is_undefined_and_the_others_go_on(tmp_path):
    target = animated.swelling_sphere()
    for point in target.data.shape_keys.key_blocks[1].data:
        point.co = 0, 0, 0
    names = ("mean_curvature", "principal_direction_max", "harris", "cavity")
    several = replace(SETTINGS, descriptors=names, more_radii=(0.2,))
    request = frames.FrameRequest(settings=several, folder=tmp_path, relative=True)
    with frames.FrameBaker(bpy.context.scene, target, request) as baker:
        made = [baker.run(task).frame for task in map(baker.prepare, (1, 10, 11, 2))]
        assert made == [1, 10, 11, 2]
        assert next(note for note in baker.notes if "smaller than the radius" in note).endswith(": 10, 11.")
    sound, small = (cache.read_frame(cache.frame_path(tmp_path, frame)).values for frame in (2, 11))
    assert {name: array.shape for name, array in sound.items()} == {name: array.shape for name, array in small.items()}
    assert {name for name in small if not np.isnan(small[name]).all()} == {"paradesc_mask", "harris_corner"}
    assert np.isfinite(sound["mean_curvature_r0.1"]).all()
    assert cache.locked_ranges({tmp_path: ""})["mean_curvature_r0.1"].maximum > 0.4


def test_a_radius_larger_than_the_mesh_at_rest_is_refused(tmp_path):
    large = replace(SETTINGS, options=bridge.Options(radius=9.0, radius_unit="absolute"), backend="cpu")
    with pytest.raises(bridge.ParadescError, match="The radius is 9, but the mesh's diagonal is only"):
        bake(animated.swelling_sphere(), tmp_path, (1,), settings=large)
