"""Frames of a cache are played, held and computed on the mesh, in Blender without a window."""

import numpy as np
import pytest

bpy = pytest.importorskip("bpy", reason="needs Blender")

import animated  # noqa: E402
import paradesc_blender  # noqa: E402
from paradesc import bridge  # noqa: E402
from paradesc.core import color_maps, job  # noqa: E402
from paradesc.files import cache  # noqa: E402
from paradesc_blender.animation import frames, sessions  # noqa: E402
from paradesc_blender.scene import record  # noqa: E402
from paradesc_blender.settings import animation as animation_settings  # noqa: E402
from paradesc_blender.ui import report_panel  # noqa: E402
from scene import attribute_values, measure_curvature, subdivide  # noqa: E402

NAME = "mean_curvature"
SETTINGS = job.Settings((NAME,), bridge.Options(radius=0.1, samples=64, buffer_size=256), "software")


@pytest.fixture
def swelling(tmp_path):
    """The sphere that swells, with frames 1, 6 and 11 in the cache of its file."""
    target = animated.swelling_sphere()
    paradesc_blender.register()
    measure_curvature()
    scene = bpy.context.scene
    scene.paradesc_animation.cache_folder = str(tmp_path)
    group = scene.paradesc
    group.radius_percent, group.samples, group.buffer_size, group.backend = 10.0, 64, 256, "software"
    request = frames.FrameRequest(SETTINGS, animation_settings.object_cache(scene, target))
    with frames.FrameBaker(scene, target, request) as baker, frames.frame_kept(scene):
        for frame in (1, 6, 11):
            baker.run(baker.prepare(frame))
    yield target
    paradesc_blender.unregister()


def play(target):
    """Switches playback on and gives the sentence that results."""
    target.paradesc_live.mode = "CACHE"
    return target.paradesc_live.sentence


def radius_now(target):
    """The radius of the sphere that the values on the mesh are of."""
    return 1 / np.median(attribute_values(target.data, NAME))


def note(target):
    """The note in the panel."""
    return sessions.session_at(target).note


def test_frames_of_the_cache_are_played_and_nothing_is_computed(swelling, monkeypatch):
    monkeypatch.setattr(bridge.Mesh, "compute", None)
    assert play(swelling) == ""
    for frame, radius in ((6, 3.0), (11, 4.0), (1, 2.0)):
        bpy.context.scene.frame_set(frame)
        assert radius_now(swelling) == pytest.approx(radius, rel=0.02)
        path = cache.frame_path(animation_settings.object_cache(bpy.context.scene, swelling), frame)
        assert np.array_equal(attribute_values(swelling.data, NAME), cache.read_frame(path).values[NAME])
        assert np.isfinite(attribute_values(swelling.data, "coverage")).all()
        assert note(swelling) == ""


def test_frames_of_another_file_that_are_replaced_are_told(swelling, tmp_path):
    scene, folder = bpy.context.scene, tmp_path / "frames"
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "first.blend"))

    def notes(**request):
        with frames.FrameBaker(scene, swelling, frames.FrameRequest(SETTINGS, folder, **request)) as baker:
            for task in map(baker.prepare, (6, 11)):
                if task is not None:
                    baker.run(task)
            return [note for note in baker.notes if "replaced" in note]

    assert notes() == []
    assert notes(force=True) == []
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "other.blend"))
    assert notes() == []  # the same frames, which are kept
    swelling.data.shape_keys.key_blocks["Large"].mute = True
    replaced = notes()
    assert replaced == [
        f'Frames that "first.blend" had in "{folder}" were replaced; to keep the frames of both files, give each its '
        "own cache folder."
    ]
    assert notes(force=True) == []  # they are those of this file now
    assert cache.read_frame(cache.frame_path(folder, 11)).info["scene"] == "other.blend"


def test_frames_of_another_file_are_played_and_the_panel_says_so(swelling, tmp_path):
    scene = bpy.context.scene
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "first.blend"))
    request = frames.FrameRequest(SETTINGS, animation_settings.object_cache(scene, swelling), force=True)
    with frames.FrameBaker(scene, swelling, request) as baker, frames.frame_kept(scene):
        baker.run(baker.prepare(6))
    play(swelling)
    scene.frame_set(6)
    assert note(swelling) == ""
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "second.blend"))
    scene.frame_set(1)
    assert note(swelling) == ""  # whose file had no name
    scene.frame_set(6)
    assert radius_now(swelling) == pytest.approx(3.0, rel=0.02)
    assert note(swelling) == 'These frames were baked in "first.blend".'


def test_frames_of_a_scene_without_the_object_play_nothing(swelling):
    play(swelling)
    bpy.context.scene.frame_set(6)
    other = bpy.data.scenes.new("other")
    other.paradesc_animation.cache_folder = bpy.context.scene.paradesc_animation.cache_folder
    other.frame_set(11)
    assert radius_now(swelling) == pytest.approx(3.0, rel=0.02)
    assert (swelling.paradesc_live.mode, swelling.paradesc_live.sentence) == ("CACHE", "")


def test_colors_are_by_the_range_over_all_frames(swelling):
    bpy.context.scene.frame_set(11)
    play(swelling)
    folder = animation_settings.object_cache(bpy.context.scene, swelling)
    shown = cache.locked_ranges({folder: ""})[NAME]
    assert shown.maximum == pytest.approx(0.5, rel=0.02)
    expected = color_maps.linear_rgba(color_maps.colors(attribute_values(swelling.data, NAME), shown))
    np.testing.assert_allclose(attribute_values(swelling.data, f"{NAME}_color"), expected, atol=1e-3)


def test_range_and_neutral_value_of_the_colors_panel_hold_for_played_frames(swelling):
    group = bpy.context.scene.paradesc_looks
    group.span, group.minimum, group.maximum = "fixed", 0.0, 3.0
    group.use_neutral, group.neutral, group.color_map = True, 1.0, "purple-green"
    play(swelling)
    shown = color_maps.ValueRange(0.0, 3.0, True, 1.0, "purple-green")
    expected = color_maps.linear_rgba(color_maps.colors(attribute_values(swelling.data, NAME), shown))
    np.testing.assert_allclose(attribute_values(swelling.data, f"{NAME}_color"), expected, atol=1e-3)


def test_missing_frames_are_held_from_the_nearest_and_said(swelling):
    play(swelling)
    bpy.context.scene.frame_set(8)
    assert radius_now(swelling) == pytest.approx(3.0, rel=0.02)
    assert note(swelling) == "Frame 8 is not in the cache: showing frame 6."


def test_missing_frames_are_computed_on_request_and_said(swelling):
    bpy.context.scene.paradesc_live.missing = "COMPUTE"
    play(swelling)
    bpy.context.scene.frame_set(8)
    assert radius_now(swelling) == pytest.approx(3.4, rel=0.02)
    assert "computed" in note(swelling)
    bpy.context.scene.frame_set(6)
    assert radius_now(swelling) == pytest.approx(3.0, rel=0.02)
    assert note(swelling) == ""


def test_a_frame_that_was_baked_again_is_read_again(swelling):
    play(swelling)
    folder = animation_settings.object_cache(bpy.context.scene, swelling)
    frame = cache.read_frame(cache.frame_path(folder, 1))
    frame.values[NAME][:] = 7.0
    cache.write_frame(folder, frame)
    bpy.context.scene.frame_set(1)
    assert (attribute_values(swelling.data, NAME) == 7.0).all()


def test_a_damaged_frame_is_one_sentence(swelling):
    play(swelling)
    path = cache.frame_path(animation_settings.object_cache(bpy.context.scene, swelling), 6)
    path.write_bytes(path.read_bytes()[:-9])
    bpy.context.scene.frame_set(6)
    assert swelling.paradesc_live.mode == "OFF"
    assert "damaged" in swelling.paradesc_live.sentence


def test_frames_of_another_mesh_are_one_sentence(swelling):
    subdivide()
    assert "vertices" in play(swelling)
    assert NAME not in swelling.data.attributes


def test_a_mesh_that_becomes_another_while_its_frames_are_played_is_the_same_sentence(swelling):
    play(swelling)
    subdivide()
    bpy.context.scene.frame_set(1)  # whose file is known
    assert "bake them again, or play them on their own object" in swelling.paradesc_live.sentence


def test_an_empty_cache_is_one_sentence(swelling, tmp_path):
    bpy.context.scene.paradesc_animation.cache_folder = str(tmp_path / "elsewhere")
    assert "Bake frames first" in play(swelling)


def test_live_values_follow_when_playback_is_left(swelling):
    play(swelling)
    bpy.context.scene.frame_set(8)
    swelling.paradesc_live.mode = "LIVE"
    assert radius_now(swelling) == pytest.approx(3.4, rel=0.02)


def test_the_report_of_the_last_bake_is_not_asked_of_played_frames(swelling):
    play(swelling)
    assert record.attributes_of(swelling.data)
    assert not report_panel.PARADESC_PT_report.poll(bpy.context)
