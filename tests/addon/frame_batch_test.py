"""Bake Frames gives each of several objects its cache, one after the other, one range over all, beside live values."""

import numpy as np
import pytest

bpy = pytest.importorskip("bpy", reason="needs Blender")

from live_values import (  # noqa: E402
    NAME,
    baked_shape,
    count_computations,
    live_settings,
    stretching_sphere,
    switch,
    values,
)
from paradesc import bridge  # noqa: E402
from paradesc.core import color_maps  # noqa: E402
from paradesc.files import cache  # noqa: E402
from paradesc_blender.animation import frame_batch, live, pausing, sessions  # noqa: E402
from paradesc_blender.settings import animation as animation_settings  # noqa: E402
from paradesc_blender.settings import looks  # noqa: E402
from scene import add_sphere, fingerprint  # noqa: E402

pytestmark = pytest.mark.usefixtures("registered")


@pytest.fixture
def pair(tmp_path):
    """A sphere that stretches and a small one at rest, both selected, and settings for three frames of both."""
    large = stretching_sphere()
    small = add_sphere("small", steps=6)
    small.data.transform([[0.5, 0, 0, 0], [0, 0.5, 0, 0], [0, 0, 0.5, 0], [0, 0, 0, 1]])
    large.select_set(True)
    bpy.context.view_layer.objects.active = large
    animation = bpy.context.scene.paradesc_animation
    animation.use_scene_range = False
    animation.frame_start, animation.frame_end = 1, 3
    animation.cache_folder = str(tmp_path)
    yield large, small
    assert not pausing.is_held()


def folders(pair):
    """The folders of the frames of both."""
    return [animation_settings.object_cache(bpy.context.scene, item) for item in pair]


def batch(beside=True):
    """Begins a bake of frames as the operator does."""
    scene = bpy.context.scene
    return frame_batch.FrameBatch(
        bpy.context, animation_settings.wanted_frames(scene), animation_settings.cache_root(scene), beside
    )


def take_steps(running, until=lambda: False):
    """Does what the window's timer does; gives the fractions on the way."""
    seen = []
    while not running.done and not until():
        running.step()
        if running.worker is not None:
            running.worker.join()
        seen.append(running.fraction)
    return seen


def test_every_selected_mesh_has_its_frames_in_a_folder_of_its_own(pair):
    before = [fingerprint(item) for item in pair]
    bpy.context.scene.frame_set(2)
    assert bpy.ops.paradesc.bake_frames() == {"FINISHED"}
    for folder in folders(pair):
        assert list(cache.frames_in(folder)) == [1, 2, 3]
    assert bpy.context.scene.frame_current == 2
    assert [fingerprint(item) for item in pair] == before
    medians = [np.median(cache.read_frame(cache.frame_path(folder, 1)).values[NAME]) for folder in folders(pair)]
    assert medians == pytest.approx([0.5, 1.0], rel=0.02)


def test_beside_the_window_the_files_are_the_same(pair, tmp_path):
    assert bpy.ops.paradesc.bake_frames() == {"FINISHED"}
    expected = {path.relative_to(tmp_path): path.read_bytes() for path in tmp_path.rglob("*.pdframe")}
    for path in tmp_path.rglob("*.pdframe"):
        path.unlink()
    running = batch()
    seen = take_steps(running)
    running.close()
    assert {path.relative_to(tmp_path): path.read_bytes() for path in tmp_path.rglob("*.pdframe")} == expected
    assert running.made == 6
    assert seen == sorted(seen)
    assert seen[-1] == 1.0


def test_one_range_spans_all_frames_of_all_objects_when_they_are_played(pair):
    assert bpy.ops.paradesc.bake_frames() == {"FINISHED"}
    shown = cache.locked_ranges(dict.fromkeys(folders(pair), ""), looks.scene_look(bpy.context.scene))[NAME]
    assert shown.maximum > 0.95
    for item in pair:
        assert switch(item, "CACHE") == ""
        expected = color_maps.linear_rgba(color_maps.colors(values(item), shown))
        np.testing.assert_allclose(values(item, f"{NAME}_color"), expected, atol=2e-3)


def test_a_range_that_was_typed_stays(pair):
    assert bpy.ops.paradesc.bake_frames() == {"FINISHED"}
    item = bpy.context.scene.paradesc_live.ranges[NAME]
    found = item.maximum
    pair[0].data.transform([[2, 0, 0, 0], [0, 2, 0, 0], [0, 0, 2, 0], [0, 0, 0, 1]])
    pair[1].data.transform([[2, 0, 0, 0], [0, 2, 0, 0], [0, 0, 2, 0], [0, 0, 0, 1]])
    assert bpy.ops.paradesc.bake_frames() == {"FINISHED"}
    assert item.maximum < 0.8 * found
    item.maximum = 7.0
    bpy.context.scene.paradesc_animation.overwrite = True
    assert bpy.ops.paradesc.bake_frames() == {"FINISHED"}
    assert item.maximum == 7.0


@pytest.mark.parametrize("beside", [False, True])
def test_the_scene_comes_back_to_the_part_of_a_frame_where_it_was(pair, beside):
    scene = bpy.context.scene
    scene.frame_set(7, subframe=0.25)
    if beside:
        running = batch()
        take_steps(running)
        running.close()
    else:
        assert bpy.ops.paradesc.bake_frames() == {"FINISHED"}
    assert (scene.frame_current, scene.frame_subframe) == (7, 0.25)


def test_cancelling_keeps_the_frames_so_far_and_comes_back(pair):
    bpy.context.scene.frame_set(2)
    running = batch()
    take_steps(running, until=lambda: running.made == 4)
    running.cancel()
    take_steps(running)
    assert running.done
    assert running.cancelled
    running.close()
    assert [len(cache.frames_in(folder)) for folder in folders(pair)] == [3, 2]
    assert bpy.context.scene.frame_current == 2


def test_an_object_that_cannot_be_measured_does_not_stop_the_others(pair):
    pair[0].data.clear_geometry()
    assert bpy.ops.paradesc.bake_frames() == {"FINISHED"}
    assert [len(cache.frames_in(folder)) for folder in folders(pair)] == [0, 3]
    pair[1].data.clear_geometry()
    with pytest.raises(RuntimeError, match=r"(?s)\"sphere\".*\"small\""):
        bpy.ops.paradesc.bake_frames()


def test_an_object_that_is_removed_on_the_way_does_not_stop_the_others(pair):
    small, large = folders(pair)[::-1]
    running = batch()
    take_steps(running, until=lambda: running.made == 1)
    bpy.data.objects.remove(running.baker.target)
    take_steps(running)
    running.close()
    assert "gone" in running.failed[0].failure
    assert sorted(len(cache.frames_in(folder)) for folder in (small, large)) == [2, 3]


@pytest.mark.parametrize("beside", [False, True])
def test_live_values_wait_while_frames_are_baked_and_are_right_after(pair, monkeypatch, beside):
    large, _ = pair
    assert switch(large) == ""
    bpy.context.scene.frame_set(2)
    done = count_computations(monkeypatch)
    if beside:
        running = batch()
        take_steps(running)
        running.close()
    else:
        assert bpy.ops.paradesc.bake_frames() == {"FINISHED"}
    assert not done
    assert np.array_equal(values(large), baked_shape(large, live_settings(large)).values[NAME])
    bpy.context.scene.frame_set(3)
    assert len(done) == 1
    assert isinstance(sessions.session_at(large), live.Session)


def test_a_damaged_range_is_one_sentence_and_all_frames_stay(pair):
    path = folders(pair)[0] / cache.RANGE_FILE
    path.parent.mkdir()
    path.write_text("{")
    with pytest.raises(RuntimeError) as raised:
        bpy.ops.paradesc.bake_frames()
    (line,) = str(raised.value).strip().splitlines()
    assert line.startswith(f'Error: The file "{path}" is damaged (')
    assert line.endswith("); remove it, or give the range again.")
    assert [list(cache.frames_in(folder)) for folder in folders(pair)] == [[1, 2, 3]] * 2


def test_frames_wait_for_no_mode_but_those_that_hold_the_mesh(pair):
    assert bpy.ops.paradesc.bake_frames.poll()
    bpy.context.view_layer.objects.active = pair[0]
    bpy.ops.object.mode_set(mode="EDIT")
    assert not bpy.ops.paradesc.bake_frames.poll()
    bpy.ops.object.mode_set(mode="OBJECT")


def test_numbers_without_effect_are_noted_once_for_all_frames_of_an_object(pair, capfd):
    scene, note = bpy.context.scene, "The buffer size is ignored on the processor"
    scene.paradesc.backend = "cpu"
    pair[1].select_set(False)
    running = batch()
    take_steps(running)
    running.close()
    assert running.made == 3
    assert [sentence.count(note) for sentence in running.pieces[0].notes] == [1]
    capfd.readouterr()
    assert bpy.ops.paradesc.bake_frames() == {"FINISHED"}
    assert capfd.readouterr().out.count(note) == 1
    scene.paradesc.buffer_size = bridge.Options().buffer_size
    assert bpy.ops.paradesc.bake_frames() == {"FINISHED"}
    assert "ignored on the processor" not in capfd.readouterr().out


def test_live_values_say_nothing_of_numbers_without_effect(pair, capfd):
    bpy.context.scene.paradesc.backend = "cpu"
    assert switch(pair[0]) == ""
    bpy.context.scene.frame_set(2)
    assert sessions.session_at(pair[0]).results.backend == "cpu"
    assert "ignored on the processor" not in capfd.readouterr().out
