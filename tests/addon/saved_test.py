"""Files and scripts of an earlier version still open, show, play, go on and compute the same.

saved/make.py made saved/*.zip with the version that each names; what that version had is expected.
"""

import json
import zipfile
from pathlib import Path

import numpy as np
import pytest

bpy = pytest.importorskip("bpy", reason="needs Blender")

import paradesc_blender as package  # noqa: E402
from live_values import switch  # noqa: E402
from paradesc_blender.scene import record  # noqa: E402
from paradesc_blender.show import overlay, recolor  # noqa: E402
from paradesc_blender.ui import report_panel  # noqa: E402
from scene import select  # noqa: E402

ARCHIVES = sorted((Path(__file__).parent / "saved").glob("*.zip"))
GROUPS = ("paradesc", "paradesc_looks", "paradesc_animation", "paradesc_live")
# Frames are known by the bits of their positions. Blender 5.2 gives zeros another sign where shape keys move vertices.
SAME_ZEROS = bpy.app.version < (5, 2, 0)
DESCRIPTORS = ("mean_curvature", "shape_index", "harris")


@pytest.fixture(params=ARCHIVES, ids=lambda path: path.stem)
def archive(request):
    """The packed files that one version has saved."""
    return request.param


@pytest.fixture
def saved(archive, tmp_path):
    """The folder of the .blend, its frames and its preset."""
    with zipfile.ZipFile(archive) as packed:
        packed.extractall(tmp_path)
    return tmp_path


@pytest.fixture
def expected(saved):
    """The content of the file, except arrays."""
    return json.loads((saved / "expected.json").read_text())


@pytest.fixture
def arrays(saved):
    """Every attribute that was in the file, by object, frame and name."""
    with np.load(saved / "expected.npz") as found:
        return dict(found)


@pytest.fixture
def computed(arrays, archive):
    """The same, but what the method gives now where it has changed since (the manual's values.md says why)."""
    changed = archive.with_suffix(".npz")
    return {**arrays, **np.load(changed)} if changed.exists() else arrays


@pytest.fixture
def scene(registered, saved):
    """The file, opened with the add-on enabled."""
    bpy.ops.wm.open_mainfile(filepath=str(saved / "saved.blend"))
    return bpy.context.scene


def attributes(name, wanted):
    """Attributes of an object's mesh, flat, by name."""
    found = {}
    for attribute in wanted:
        data = bpy.data.objects[name].data.attributes[attribute].data
        member, width = {"FLOAT_COLOR": ("color", 4)}.get(
            bpy.data.objects[name].data.attributes[attribute].data_type, ("value", 1)
        )
        found[attribute] = np.empty(len(data) * width, np.float32)
        data.foreach_get(member, found[attribute])
    return found


def below(arrays, place):
    """The arrays of one place in the file."""
    return {name.removeprefix(place): values for name, values in arrays.items() if name.startswith(place)}


def same_bits(found, wanted):
    """Returns whether both have the same arrays, NaN included."""
    return found.keys() == wanted.keys() and all(found[name].tobytes() == wanted[name].tobytes() for name in wanted)


def assert_close(found, wanted):
    """Checks that values agree up to what another compiler or mathematical library rounds otherwise."""
    assert found.keys() == wanted.keys()
    for name, values in wanted.items():
        np.testing.assert_allclose(found[name], values, rtol=1e-5, atol=1e-6, err_msg=name)


def values_of(group, names):
    """Settings by name, sets as sorted lists."""
    found = {name: getattr(group, name) for name in names}
    return {name: sorted(value) if isinstance(value, set) else value for name, value in found.items()}


def choose(name):
    """Selects one object."""
    select(bpy.data.objects[name])


def test_there_is_a_file_of_an_earlier_version():
    assert ARCHIVES


def test_every_name_that_scripts_use_is_still_there(scene, expected):
    names = expected["names"]
    for place, members in names["groups"].items():
        owner, group = place.split(".")
        found = getattr(scene if owner == "Scene" else bpy.data.objects["live"], group).bl_rna.properties
        assert_members(place, found, members)
    for operator, members in names["operators"].items():
        assert_members(operator, getattr(bpy.ops.paradesc, operator).get_rna_type().properties, members)
    gone = {"PARADESC_PT_output"}  # it drew the settings of kept_members(), which have no effect
    assert {name for name in names["panels"] if not hasattr(bpy.types, name)} == gone


def assert_members(place, found, members):
    """Checks that all of them are there, with all of their choices."""
    for name, choices in members.items():
        assert name in found, f"{place}.{name}"
        now = [item.identifier for item in found[name].enum_items_static] if choices else []
        assert set(choices) <= set(now), f"{place}.{name}"


def test_settings_are_those_that_were_saved(scene, expected):
    for name in GROUPS:
        wanted = expected["settings"][name]
        assert len(wanted) > 5
        assert values_of(getattr(scene, name), wanted) == wanted
    found = {item.name: [item.minimum, item.maximum] for item in scene.paradesc_live.ranges}
    assert found == expected["ranges"]
    assert found
    modes = [bpy.data.objects[name].paradesc_live.mode for name in ("baked", "live", "played")]
    assert modes == ["OFF", "LIVE", "CACHE"]


def test_settings_survive_a_session_without_the_addon(saved, expected):
    bpy.ops.wm.open_mainfile(filepath=str(saved / "saved.blend"))
    assert not hasattr(bpy.types.Scene, "paradesc")
    package.register()
    try:
        for name in GROUPS:
            wanted = expected["settings"][name]
            assert values_of(getattr(bpy.context.scene, name), wanted) == wanted
    finally:
        package.unregister()


def test_values_and_colors_are_those_that_were_saved(scene, arrays):
    for place, name in (("baked/", "baked"), ("live/3/", "live"), ("played/3/", "played")):
        wanted = below(arrays, place)
        assert "mean_curvature_color" in wanted
        assert same_bits(attributes(name, wanted), wanted), name


def test_what_the_mesh_records_is_read_as_it_was_meant(scene, expected):
    for name, wanted in expected["records"].items():
        found = record.read(bpy.data.objects[name].data)
        assert {key: found[key] for key in wanted} == wanted, name
    mesh = bpy.data.objects["baked"].data
    assert recolor.baked_names(mesh) == sorted(DESCRIPTORS)
    lines = report_panel.report_lines(record.read(mesh))
    assert any(line.startswith("Radius: ") for line in lines)
    title, shown = overlay.lines_of(mesh, "mean_curvature")
    assert title == "Mean Curvature (1/length)"
    assert [shown.minimum, shown.maximum] == expected["records"]["baked"]["ranges"]["mean_curvature"]
    assert shown.map_name == "heat"


def test_colors_can_be_made_again_from_the_values_that_are_there(scene, arrays):
    choose("baked")
    wanted = below(arrays, "baked/")
    assert bpy.ops.paradesc.recolor(every=True) == {"FINISHED"}
    assert_close(attributes("baked", wanted), wanted)
    scene.paradesc_looks.color_map = "grey"
    assert bpy.ops.paradesc.recolor() == {"FINISHED"}
    colors = attributes("baked", wanted)["mean_curvature_color"].reshape(-1, 4)
    assert np.ptp(colors[:, :3], axis=1).max() < 1e-3


def test_a_bake_with_the_saved_settings_gives_the_saved_values(scene, computed):
    choose("baked")
    scene.paradesc.descriptors, scene.paradesc_animation.source = set(DESCRIPTORS), "original"
    wanted = below(computed, "baked/")
    mesh = bpy.data.objects["baked"].data
    for name in wanted.keys() - {"paradesc_mask"}:  # which is written where it is, and where a value is missing
        mesh.attributes.remove(mesh.attributes[name])
    assert bpy.ops.paradesc.bake() == {"FINISHED"}
    assert_close(attributes("baked", wanted), wanted)


@pytest.mark.parametrize("name", ["live", "played"])
def test_live_and_played_objects_follow_their_frames_as_before(scene, arrays, computed, name):
    for frame in (1, 2, 3):
        scene.frame_set(frame)
        assert bpy.data.objects[name].paradesc_live.sentence == ""
        wanted = below(arrays if name == "played" else computed, f"{name}/{frame}/")
        found = attributes(name, wanted)
        assert_close(found, wanted)
        if name == "played":
            assert found["mean_curvature"].tobytes() == wanted["mean_curvature"].tobytes()
    first, last = (below(arrays, f"{name}/{frame}/")["mean_curvature"] for frame in (1, 3))
    assert not np.allclose(first, last)


def stamps(folder):
    """When each frame's file was written."""
    return {path.name: path.stat().st_mtime_ns for path in folder.rglob("*.pdframe")}


@pytest.mark.skipif(package.__version__ != "0.1.0", reason="frames of another version are computed again")
@pytest.mark.skipif(not SAME_ZEROS, reason="the positions that were baked had other signs of zeros")
def test_frames_that_are_there_are_not_computed_again(scene, saved):
    before = stamps(saved)
    assert len(before) == 3
    choose("played")
    assert bpy.ops.paradesc.bake_frames() == {"FINISHED"}
    assert stamps(saved) == before
    scene.paradesc.samples = 80
    assert bpy.ops.paradesc.bake_frames() == {"FINISHED"}
    assert all(now != before[name] for name, now in stamps(saved).items())


def test_frames_are_baked_and_played_on_in_an_old_file(scene, saved, computed):
    scene.paradesc_animation.overwrite = True
    choose("live")
    assert bpy.ops.paradesc.bake_frames() == {"FINISHED"}
    assert switch(bpy.data.objects["live"], "CACHE") == ""
    scene.frame_set(2)
    wanted = {"mean_curvature": computed["live/2/mean_curvature"]}
    assert_close(attributes("live", wanted), wanted)


def test_a_preset_that_somebody_kept_sets_what_it_did(scene, saved, expected):
    bpy.ops.paradesc.preset(name="cavity")
    assert values_of(scene.paradesc, expected["preset"]) != expected["preset"]
    assert bpy.ops.paradesc.load_preset(filepath=str(saved / "Saved.json")) == {"FINISHED"}
    kept = {"backend", "device_index", "material_maps", "space", "shape_key", "cage"}
    kept |= {
        name for name in expected["preset"] if name.startswith(("write_", "image_", "buffers_")) or name == "texels"
    }
    wanted = {name: value for name, value in expected["preset"].items() if name not in kept}
    assert len(wanted) > 20
    assert values_of(scene.paradesc, wanted) == wanted


def test_a_farm_goes_on_with_the_scene_settings_of_an_old_file(saved, run, report, arrays):
    blend = saved / "saved.blend"
    words = (
        "--scene-settings",
        "--object",
        "played",
        "--frames",
        "1:4",
        "--cache",
        saved / "frames",
    )
    ended = run("animate", blend, *words, "--json", "report.json")
    assert ended.code == 0, ended.error
    (found,) = report()["objects"]
    changed = [4] if SAME_ZEROS else [2, 3, 4]
    assert found["made"] == (changed if package.__version__ == "0.1.0" else [1, 2, 3, 4])
    assert report()["relative_to_rest"]
    assert report()["settings"]["samples"] == 72


def test_the_command_line_bakes_an_old_file_by_its_settings(saved, paradesc, computed):
    names = ",".join(DESCRIPTORS)
    words = ("--scene-settings", "--object", "baked", "--source", "original", "--descriptors", names)
    done = paradesc("bake", saved / "saved.blend", *words, "--output", "out.npz")
    assert done.returncode == 0, done.stderr
    with np.load(saved / "out.npz") as found:
        assert_close(
            {name: found[name] for name in DESCRIPTORS}, {name: computed[f"baked/{name}"] for name in DESCRIPTORS}
        )
