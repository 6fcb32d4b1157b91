"""Frames of an animation in a cache: the command line as a process, the operator, and runs that are killed."""

import json
import os
import signal
import subprocess
import time
from dataclasses import replace

import numpy as np
import pytest

from conftest import command_line, environment, real_mesh

bpy = pytest.importorskip("bpy", reason="needs Blender")

import animated  # noqa: E402
import paradesc_blender as package  # noqa: E402
from cli_test import accepted  # noqa: E402
from paradesc import bridge, cli  # noqa: E402
from paradesc.core import job  # noqa: E402
from paradesc.files import cache, frame_baking  # noqa: E402
from paradesc.files.frame_baking import at_fixed_radii  # noqa: E402
from paradesc_blender.animation import frames  # noqa: E402
from paradesc_blender.scene import mesh_io, source_meshes, unwrap  # noqa: E402
from scene import fingerprint  # noqa: E402

QUICK = ("--radius", "0.1", "--samples", "64", "--buffer", "256", "--backend", "software")
SETTINGS = job.Settings(("mean_curvature",), bridge.Options(radius=0.1, samples=64, buffer_size=256), "software")


@pytest.fixture
def cylinder_blend(tmp_path):
    """The cylinder that an armature bends, as a file."""
    animated.bent_cylinder()
    path = tmp_path / "cylinder.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    return path


def contents(folder):
    """The bytes of every frame by its name; other files do not count."""
    return {path.name: path.read_bytes() for path in cache.frames_in(folder).values()}


def bake(target, folder, wanted, **request):
    """Bakes frames in this process; gives those that had to be made."""
    scene = bpy.context.scene
    given = {"settings": SETTINGS, **request}
    with (
        frames.FrameBaker(scene, target, frames.FrameRequest(folder=folder, **given)) as baker,
        frames.frame_kept(scene),
    ):
        return [baker.run(task).frame for task in map(baker.prepare, wanted) if task is not None]


def values(folder, frame, name="mean_curvature"):
    """One frame's values."""
    return cache.read_frame(cache.frame_path(folder, frame)).values[name]


# ---- Frames


def test_frame_has_the_bits_of_a_bake_of_its_own(tmp_path):
    target = animated.bent_cylinder()
    assert bake(target, tmp_path, (1, 10, 20)) == [1, 10, 20]
    rest = mesh_io.read_object(target, corner_normals=False)
    with bridge.Context("software") as context, context.mesh(rest) as mesh:
        fixed = at_fixed_radii(SETTINGS, mesh.report())
    for frame in (1, 10, 20):
        bpy.context.scene.frame_set(frame)
        alone = job.run(source_meshes.read(target, "deformed").arrays, fixed).values["mean_curvature"]
        assert values(tmp_path, frame).tobytes() == alone.tobytes()
    assert values(tmp_path, 1).tobytes() != values(tmp_path, 20).tobytes()


def test_swelling_sphere_has_the_curvature_of_its_radius_and_the_change(tmp_path):
    target = animated.swelling_sphere()
    bake(target, tmp_path, (1, 6, 11), relative=True)
    for frame, radius in ((1, 2.0), (6, 3.0), (11, 4.0)):
        assert np.median(values(tmp_path, frame)) == pytest.approx(1 / radius, rel=0.02)
        change = values(tmp_path, frame, "mean_curvature_change")
        assert np.median(change) == pytest.approx(1 / radius - 1 / 2, abs=0.01)
    assert (values(tmp_path, 1, "mean_curvature_change") == 0).all()
    shown = cache.locked_ranges({tmp_path: ""})
    assert shown["mean_curvature"].maximum == pytest.approx(0.5, rel=0.02)
    assert shown["mean_curvature_change"].minimum == pytest.approx(-0.25, rel=0.05)


# ---- One method for all frames

AUTO = replace(SETTINGS, backend="auto")


def test_auto_goes_on_by_the_method_that_was_chosen_first(tmp_path, monkeypatch):
    target = animated.bent_cylinder(rings=6, sides=8)
    assert bake(target, tmp_path / "auto", (1,), settings=AUTO) == [1]
    bake(target, tmp_path / "cpu", (1, 2), settings=replace(SETTINGS, backend="cpu"))
    assert values(tmp_path / "auto", 1).tobytes() == values(tmp_path / "cpu", 1).tobytes()

    def with_card(stream):
        return "gpu" if stream.settings.backend == "auto" else stream.settings.backend

    monkeypatch.setattr(frame_baking.Stream, "backend", property(with_card))  # as an earlier version with a card
    assert bake(target, tmp_path / "auto", (1, 2), settings=AUTO) == [2]
    assert contents(tmp_path / "auto") == contents(tmp_path / "cpu")


def test_auto_unwraps_no_mesh_without_a_uv_map(tmp_path, monkeypatch):
    target = animated.bent_cylinder(rings=6, sides=8)
    while target.data.uv_layers:
        target.data.uv_layers.remove(target.data.uv_layers[0])
    monkeypatch.setattr(unwrap, "lay_out", lambda *_: pytest.fail("it was unwrapped"))
    assert bake(target, tmp_path / "new", (1, 2), settings=AUTO) == [1, 2]


def test_radius_is_that_of_the_rest_pose_in_every_frame(tmp_path):
    target = animated.swelling_sphere(steps=5)
    bake(target, tmp_path, (1, 11))
    radii = [cache.read_frame(cache.frame_path(tmp_path, frame)).info["radius"]["mean_curvature"] for frame in (1, 11)]
    assert radii[0] == radii[1] > 0


def test_frames_that_are_there_are_kept_and_damaged_or_changed_ones_made_again(tmp_path):
    target = animated.swelling_sphere(steps=5)
    bake(target, tmp_path, range(1, 6))
    before = contents(tmp_path)
    assert bake(target, tmp_path, range(1, 6)) == []
    path = cache.frame_path(tmp_path, 3)
    path.write_bytes(path.read_bytes()[:-1])
    cache.frame_path(tmp_path, 5).unlink()
    assert bake(target, tmp_path, range(1, 6)) == [3, 5]
    assert contents(tmp_path) == before
    other = job.Settings(("curvedness",), SETTINGS.options, "software")
    assert bake(target, tmp_path, (1, 2), settings=other) == [1, 2]
    assert bake(target, tmp_path, range(1, 6)) == [1, 2]
    target.data.shape_keys.key_blocks["Large"].data[0].co.x += 1  # another animation of the same mesh
    assert bake(target, tmp_path, range(1, 6)) == [2, 3, 4, 5]  # at frame 1 the key has no weight yet
    assert bake(target, tmp_path, (2,), force=True) == [2]


def test_parts_of_two_machines_merge_by_copying(tmp_path):
    target = animated.bent_cylinder(rings=6, sides=8)
    bake(target, tmp_path / "whole", range(1, 7))
    bake(target, tmp_path / "one", (5, 6, 4))
    bake(target, tmp_path / "other", (2, 1, 3))
    for path in (tmp_path / "other").iterdir():
        path.rename(tmp_path / "one" / path.name)
    assert contents(tmp_path / "one") == contents(tmp_path / "whole")
    assert cache.locked_ranges({tmp_path / "one": ""}) == cache.locked_ranges({tmp_path / "whole": ""})


def test_baking_frames_leaves_the_scene_as_it_is(tmp_path):
    target = animated.bent_cylinder()
    target.modifiers.new("Subdivision", "SUBSURF")
    bpy.context.scene.frame_set(7, subframe=0.25)
    before = fingerprint(target)
    bake(target, tmp_path, (1, 20))
    assert fingerprint(target) == before
    assert (bpy.context.scene.frame_current, bpy.context.scene.frame_subframe) == (7, 0.25)
    assert target.modifiers["Subdivision"].show_viewport


def test_evaluated_frames_go_to_the_original_vertices(tmp_path):
    target = animated.bent_cylinder(rings=6, sides=8)
    target.modifiers.new("Subdivision", "SUBSURF").levels = 1
    bake(target, tmp_path, (1, 20), source="evaluated")
    found = cache.read_frame(cache.frame_path(tmp_path, 20))
    assert found.vertex_count == len(target.data.vertices)
    assert found.info["vertices"] == "original"
    with pytest.raises(bridge.ParadescError, match="rest pose"):
        bake(target, tmp_path, (1,), source="evaluated", relative=True)


def test_frames_whose_vertices_are_lost_hold_those_of_the_evaluated_mesh(tmp_path):
    target = animated.swelling_sphere(steps=5)
    target.modifiers.new("Remesh", "REMESH").voxel_size = 0.5
    scene = bpy.context.scene
    request = frames.FrameRequest(SETTINGS, tmp_path, "evaluated")
    with frames.FrameBaker(scene, target, request) as baker, frames.frame_kept(scene):
        for frame in (1, 11):
            baker.run(baker.prepare(frame))
        assert len([note for note in baker.notes if "not played" in note]) == 1
    first, last = map(cache.read_frame, cache.frames_in(tmp_path).values())
    assert first.info["vertices"] == last.info["vertices"] == "evaluated"
    assert first.vertex_count < last.vertex_count  # voxels stay as large


def test_error_says_at_which_frame_and_the_frames_before_stay(tmp_path):
    target = animated.swelling_sphere(steps=5)
    target.data.shape_keys.key_blocks["Large"].data[4].co.x = float("nan")
    with pytest.raises(bridge.ParadescError, match=r"Frame 2: .*vertex 4"):
        bake(target, tmp_path, (1, 2, 3))
    assert list(cache.frames_in(tmp_path)) == [1]  # at which the key has no weight
    assert bpy.context.scene.frame_current == 1


@pytest.mark.parametrize(
    ("text", "expected"), [("1:5", [1, 2, 3, 4, 5]), ("-2:2:2", [-2, 0, 2]), ("7", [7]), (" 3:3 ", [3])]
)
def test_ranges_of_frames(text, expected):
    assert list(cache.parse_frames(text)) == expected


@pytest.mark.parametrize("text", ["", "a:b", "5:1", "1:5:0", "1:2:3:4", "1.5:2", "1:99999999", "-:3"])
def test_what_is_no_range_of_frames_is_refused(text):
    with pytest.raises(ValueError, match=r"[a-z]+ .*[.]"):
        cache.parse_frames(text)


def test_fox_runs(tmp_path):
    from paradesc_blender.scene import scene_io

    scene_io.open_scene(real_mesh("fox.glb"))
    target = scene_io.choose_object(prefer_active=False)
    run = bpy.data.actions["Run"] if "Run" in bpy.data.actions else next(a for a in bpy.data.actions if "Run" in a.name)
    skeleton = target.find_armature()
    skeleton.animation_data.action = run
    if getattr(run, "slots", None):
        skeleton.animation_data.action_slot = run.slots[0]
    first, last = map(int, run.frame_range)
    bake(target, tmp_path, (first, (first + last) // 2), relative=True)
    early, late = (values(tmp_path, frame) for frame in (first, (first + last) // 2))
    assert np.isfinite(early).mean() > 0.95
    changed = np.abs(early - late) > 0.01 * np.nanstd(early)
    assert changed.mean() > 0.1  # legs bend,
    assert np.nanmedian(np.abs(early - late)) < np.nanstd(early)  # and it stays a fox


# ---- The command line


def test_command_bakes_frames_and_reports(paradesc, cylinder_blend, tmp_path):
    words = ("animate", cylinder_blend, *QUICK, "--frames", "1:20:19", "--relative-to-rest", "--json", "report.json")
    output = accepted(paradesc(*words))
    folder = tmp_path / "paradesc_cache" / "cylinder"
    assert "2 frames made, 0 kept" in output
    assert list(cache.frames_in(folder)) == [1, 20]
    report = json.loads((tmp_path / "report.json").read_text())
    (row,) = report["objects"]
    assert (row["made"], row["kept"], report["source"]) == ([1, 20], [], "deformed")
    assert set(report["ranges"]) == {"mean_curvature", "mean_curvature_change"}
    assert all(row["seconds_per_frame"][stage] >= 0 for stage in ("depsgraph", "bake", "evaluate", "write"))
    before = contents(folder)
    again = paradesc(*words, "--frames", "1:20:1", "--range=-3:3")
    assert "18 frames made, 2 kept" in accepted(again)
    assert {name: before[name] for name in before} == {name: contents(folder)[name] for name in before}
    report = json.loads((tmp_path / "report.json").read_text())
    assert report["ranges"]["mean_curvature"] == [-3, 3]


def start(*words, cwd):
    """The command line, running."""
    return subprocess.Popen(
        [*command_line(), *map(str, words)], cwd=cwd, env=environment(), stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL, stdin=subprocess.DEVNULL,
    )  # fmt: skip


@pytest.mark.slow
def test_run_that_is_killed_and_started_again_gives_the_same_files(paradesc, cylinder_blend, tmp_path):
    least = int(os.environ.get("PARADESC_KILLED_FRAMES", "10"))
    for count in (least, 8 * least, 64 * least):  # a busy machine may kill it when a few frames are made already
        words = ("animate", cylinder_blend, *QUICK, "--frames", f"1:{count}")
        process = start(*words, "--cache", "killed", cwd=tmp_path)
        folder = tmp_path / "killed" / "cylinder"
        before = len(cache.frames_in(folder))
        while len(cache.frames_in(folder)) <= before and process.poll() is None:
            time.sleep(0.005)
        process.send_signal(signal.SIGKILL)
        process.wait()
        some = contents(folder)
        if len(some) < count:
            break
    assert 0 < len(some) < count
    output = accepted(paradesc(*words, "--cache", "killed"))
    assert f"{count - len(some)} frames made, {len(some)} kept" in output
    accepted(paradesc(*words, "--cache", "undisturbed"))
    undisturbed = contents(tmp_path / "undisturbed" / "cylinder")
    assert len(undisturbed) == count
    assert contents(folder) == undisturbed


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--frames", "5:1"), "before the first"),
        (("--range", "5"), "is not a range"),
        (("--range=3:-3",), "must end above"),
        (("--frames", "1", "--cache", "file"), "cannot be made"),
        (("--source", "rest"), "source"),
        (("--frames", "1", "--shape-key", "active"), "leave --shape-key out"),
        (("--frames", "1", "--object", "skeleton"), "not a mesh"),
    ],
    ids=str,
)
def test_command_refuses_in_one_sentence(cylinder_blend, tmp_path, monkeypatch, capsys, words, said):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "file").write_text("")
    assert cli.main(["animate", str(cylinder_blend), *QUICK, *words]) != 0
    sentence = capsys.readouterr().err.strip()
    assert sentence.startswith("paradesc: ")
    assert said in sentence
    assert "\n" not in sentence


def test_command_notes_once_what_has_no_effect_on_the_processor(run, cylinder_blend, tmp_path):
    words = ("--radius", "0.1", "--samples", "64", "--frames", "1:3", "--cache", tmp_path / "frames")
    ended = run("animate", cylinder_blend, *words, "--seed", "3", "--buffer", "256", "--backend", "cpu")
    assert ended.code == 0, ended.error
    assert ended.output.count("The buffer size and the seed are ignored on the processor") == 1
    assert "3 frames made" in ended.output


def test_a_file_that_was_saved_in_edit_mode_has_the_frames_of_its_animation(run, tmp_path):
    target = animated.swelling_sphere(steps=4)
    target.active_shape_key_index = 1
    for mode in ("OBJECT", "EDIT"):
        bpy.ops.object.mode_set(mode=mode)
        bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / f"{mode}.blend"))
    for mode in ("OBJECT", "EDIT"):
        ended = run("animate", tmp_path / f"{mode}.blend", *QUICK, "--frames", "1:11:10", "--cache", tmp_path / mode)
        assert ended.code == 0, ended.error
        assert bpy.context.object.mode == mode
    for frame, radius in ((1, 2), (11, 4)):
        whole, edited = (values(tmp_path / mode / "sphere", frame) for mode in ("OBJECT", "EDIT"))
        assert whole.tobytes() == edited.tobytes()
        assert edited.mean() == pytest.approx(1 / radius, rel=0.05)  # the sphere is coarse


def test_bake_measures_the_source_that_is_asked_for(paradesc, cylinder_blend):
    bpy.context.scene.frame_set(20)
    bpy.ops.wm.save_as_mainfile(filepath=str(cylinder_blend))
    accepted(paradesc("bake", cylinder_blend, *QUICK, "--source", "deformed", "-o", "out.npz"))
    with np.load(cylinder_blend.with_name("out.npz")) as file:
        assert file["vertices"][:, 2].max() < 3.2  # bent by 90 degrees at 2


def test_scene_settings_say_what_is_measured(cylinder_blend, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    package.register()
    bpy.context.scene.frame_set(20)
    group = bpy.context.scene.paradesc_animation
    group.source, group.relative_to_rest = "deformed", True
    bpy.ops.wm.save_as_mainfile(filepath=str(cylinder_blend))
    package.unregister()
    for words, bent in (((), True), (("--source", "original"), False)):
        assert cli.main(["bake", str(cylinder_blend), "--scene-settings", *QUICK, *words, "-o", "out.npz"]) == 0
        with np.load("out.npz") as file:
            assert (file["vertices"][:, 2].max() < 3.2) == bent
    words = ("--frames", "20", "--cache", "frames")
    assert cli.main(["animate", str(cylinder_blend), "--scene-settings", *QUICK, *words]) == 0
    (frame,) = (tmp_path / "frames" / "cylinder").iterdir()
    assert any(name.endswith("_change") for name in cache.read_frame(frame).values)


@pytest.mark.parametrize(
    ("source", "frame_source", "measured"),
    [("original", None, "deformed"), ("auto", None, "evaluated"), ("evaluated", "deformed", "deformed")],
)
def test_scene_settings_give_frames_the_source_that_the_panel_gives_them(
    cylinder_blend, monkeypatch, source, frame_source, measured
):
    monkeypatch.chdir(cylinder_blend.parent)
    package.register()
    group = bpy.context.scene.paradesc_animation
    group.source = source
    if frame_source:
        group.frame_source = frame_source
    bpy.ops.wm.save_as_mainfile(filepath=str(cylinder_blend))
    package.unregister()
    asked = []
    baker = frames.FrameBaker
    monkeypatch.setattr(frames, "FrameBaker", lambda *words: (asked.append(words[-1].source), baker(*words))[1])
    assert cli.main(["animate", str(cylinder_blend), "--scene-settings", *QUICK, "--frames", "1"]) == 0
    assert asked == [measured]


# ---- The operator


@pytest.fixture
def registered():
    package.register()
    yield
    package.unregister()


@pytest.fixture
def scene_to_bake(registered, tmp_path):
    """The cylinder, and settings for a quick bake of three of its frames."""
    target = animated.bent_cylinder(rings=6, sides=8)
    scene = bpy.context.scene
    settings, animation = scene.paradesc, scene.paradesc_animation
    settings.radius_percent, settings.samples, settings.buffer_size = 10.0, 64, 256
    settings.backend = "software"
    animation.use_scene_range = False
    animation.frame_start, animation.frame_end, animation.frame_step = 1, 20, 9
    animation.cache_folder = str(tmp_path)
    return target


def test_frames_need_no_output_of_a_single_bake(scene_to_bake):
    bpy.context.scene.paradesc.write_attributes = False
    assert bpy.ops.paradesc.bake_frames.poll()
    scene_to_bake.select_set(False)
    bpy.context.view_layer.objects.active = None
    assert not bpy.ops.paradesc.bake_frames.poll()


def test_operator_bakes_frames_and_comes_back(scene_to_bake, tmp_path):
    bpy.context.scene.frame_set(4)
    before = fingerprint(scene_to_bake)
    assert bpy.ops.paradesc.bake_frames("INVOKE_DEFAULT") == {"FINISHED"}
    assert list(cache.frames_in(tmp_path / "cylinder")) == [1, 10, 19]
    assert bpy.context.scene.frame_current == 4
    assert fingerprint(scene_to_bake) == before


def test_operator_refuses_in_one_sentence_and_comes_back(scene_to_bake, tmp_path):
    animation = bpy.context.scene.paradesc_animation
    animation.cache_folder = "//cache"
    with pytest.raises(RuntimeError, match=r"Save the [.]blend first"):
        bpy.ops.paradesc.bake_frames()
    animation.cache_folder, animation.frame_end = str(tmp_path), 0
    with pytest.raises(RuntimeError, match="before the first"):
        bpy.ops.paradesc.bake_frames()
    bpy.ops.object.mode_set(mode="EDIT")
    with pytest.raises(RuntimeError, match="poll"):
        bpy.ops.paradesc.bake_frames()
    bpy.ops.object.mode_set(mode="OBJECT")


def test_single_bake_measures_the_pose(scene_to_bake):
    scene = bpy.context.scene
    scene.frame_set(20)
    found = {}
    for source in ("original", "deformed"):
        scene.paradesc_animation.source = source
        assert bpy.ops.paradesc.bake() == {"FINISHED"}
        attribute = scene_to_bake.data.attributes["mean_curvature"]
        found[source] = mesh_io.read_array(attribute.data, "value", np.float32)
    assert np.abs(found["original"] - found["deformed"]).max() > 0.3
