"""Original, deformed and evaluated meshes: what is measured, where results go, and that the scene stays as it is."""

import ast

import numpy as np
import pytest

bpy = pytest.importorskip("bpy", reason="needs Blender")

import animated  # noqa: E402
from paradesc import bridge  # noqa: E402
from paradesc.bridge import abi  # noqa: E402
from paradesc.core import job, source_kinds  # noqa: E402
from paradesc.files.reading import on_original  # noqa: E402
from paradesc_blender.scene import delivery, mesh_io, scene_io, source_meshes  # noqa: E402
from paradesc_blender.scene.node_groups import add_socket  # noqa: E402
from scene import add_sphere, attribute_values, empty_scene, fingerprint, saved_scene, select, small_bake  # noqa: E402
from shapes import ADDON  # noqa: E402

QUICK = job.Settings(("mean_curvature",), bridge.Options(radius=0.1, samples=64, buffer_size=256), "software")


def with_modifiers(*modifiers, steps=5):
    """A sphere of radius 2 with these modifiers, each a type and its settings."""
    empty_scene()
    target = add_sphere(steps=steps)
    for kind, settings in modifiers:
        modifier = target.modifiers.new(kind, kind)
        for name, value in settings.items():
            setattr(modifier, name, value)
    bpy.context.view_layer.update()
    return target


def scene_state(target):
    """The mesh, and all that a source could change besides."""
    shown = [(item.name, item.show_viewport, item.show_render) for item in target.modifiers]
    evaluated = target.evaluated_get(bpy.context.evaluated_depsgraph_get())
    return (*fingerprint(target), shown, target.data.attributes.active_index, len(evaluated.data.vertices))


BEND = ("SIMPLE_DEFORM", {"deform_method": "BEND", "angle": 1.0})
SUBSURF = ("SUBSURF", {"levels": 1})


def test_without_modifiers_all_sources_are_the_same():
    target = with_modifiers()
    first, *others = (source_meshes.read(target, source).arrays for source in source_kinds.NAMES)
    assert all(np.array_equal(first.positions, arrays.positions) for arrays in others)
    assert all(np.array_equal(first.triangle_corners, arrays.triangle_corners) for arrays in others)


def test_deformed_follows_the_armature_and_original_does_not():
    target = animated.bent_cylinder()
    bpy.context.scene.frame_set(20)
    original, deformed = (source_meshes.read(target, source).arrays for source in ("original", "deformed"))
    assert original.positions[:, 2].max() == pytest.approx(4)
    assert deformed.positions[:, 2].max() < 3.2  # bent by 90 degrees at 2
    lower = original.positions[:, 2] <= 1.5
    np.testing.assert_allclose(deformed.positions[lower], original.positions[lower], atol=1e-5)
    assert deformed.corner_uvs is not None


def test_deformed_follows_a_shape_key():
    target = animated.swelling_sphere(steps=4)
    bpy.context.scene.frame_set(6)
    lengths = np.linalg.norm(source_meshes.read(target, "deformed").arrays.positions, axis=1)
    np.testing.assert_allclose(lengths, 3, rtol=1e-4)


@pytest.mark.parametrize("source", source_kinds.NAMES)
@pytest.mark.parametrize("modifiers", [(), (BEND,), (BEND, SUBSURF), (("REMESH", {"voxel_size": 0.5}), BEND)], ids=len)
def test_reading_changes_nothing(source, modifiers):
    target = with_modifiers(*modifiers)
    before = scene_state(target)
    source_meshes.read(target, source)
    assert scene_state(target) == before


def test_deformed_leaves_generating_modifiers_out_and_says_so():
    bent = source_meshes.read(with_modifiers(BEND), "deformed")
    more = source_meshes.read(with_modifiers(BEND, SUBSURF), "deformed")
    assert np.array_equal(more.arrays.positions, bent.arrays.positions)
    assert bent.notes == []
    assert '"SUBSURF"' in more.notes[0]


def test_modifiers_hidden_before_stay_hidden():
    target = with_modifiers(BEND, SUBSURF)
    target.modifiers["SUBSURF"].show_viewport = False
    assert source_meshes.read(target, "deformed").notes == []
    assert not target.modifiers["SUBSURF"].show_viewport


def test_whoever_holds_the_evaluated_scene_finds_the_whole_stack_again():
    target = with_modifiers(SUBSURF)
    depsgraph = bpy.context.evaluated_depsgraph_get()
    assert len(target.evaluated_get(depsgraph).data.vertices) == 602
    source_meshes.read(target, "deformed")
    assert len(target.evaluated_get(depsgraph).data.vertices) == 602  # though nobody asked for an update


def test_modifiers_are_shown_again_after_an_error(monkeypatch):
    target = with_modifiers(BEND, SUBSURF)
    before = scene_state(target)

    def fail(*_):
        raise MemoryError

    monkeypatch.setattr(mesh_io, "read_positions", fail)
    for source in ("deformed", "evaluated"):
        with pytest.raises(MemoryError):
            source_meshes.read(target, source)
    monkeypatch.undo()
    assert scene_state(target) == before


@pytest.mark.parametrize(
    ("kind", "settings", "made"),
    [("SUBSURF", {"levels": 1}, 602), ("MIRROR", {"use_mirror_merge": False}, 304), ("SOLIDIFY", {}, 304),
     ("ARRAY", {"count": 3}, 456), ("TRIANGULATE", {}, 152)],
)  # fmt: skip
def test_original_vertices_are_found_among_the_evaluated_ones(kind, settings, made):
    target = with_modifiers((kind, settings))
    reading = source_meshes.read(target, "evaluated")
    assert len(reading.arrays.positions) == made
    assert reading.own
    assert len(set(reading.vertices.tolist())) == 152
    own = mesh_io.read_positions(target.data)
    found = reading.arrays.positions[reading.vertices]
    nearest = np.linalg.norm(own[:, None] - found[None], axis=2).argmin(axis=1)  # subdivision draws them inwards
    assert np.array_equal(nearest, np.arange(152))
    assert reading.notes == [f"Measured with its modifiers: {made} vertices."]


@pytest.mark.parametrize(("kind", "settings"), [("REMESH", {"voxel_size": 0.4}), ("DECIMATE", {"ratio": 0.5})])
def test_where_vertices_are_lost_the_reading_says_so(kind, settings):
    target = with_modifiers((kind, settings))
    before = fingerprint(target)
    reading = source_meshes.read(target, "evaluated")
    assert (reading.own, reading.vertices) == (False, None)
    assert reading.notes == [f"Measured with its modifiers: {len(reading.arrays.positions)} vertices."]
    assert fingerprint(target) == before


def test_subdivided_results_on_the_original_are_those_of_its_vertices():
    target = with_modifiers(("SUBSURF", {"levels": 1}), steps=12)
    reading = source_meshes.read(target, "evaluated")
    results = job.run(reading.arrays, QUICK)
    delivery.deliver(target, results, reading)
    values = attribute_values(target.data, "mean_curvature")
    assert np.array_equal(values, results.values["mean_curvature"][reading.vertices])
    radius = np.linalg.norm(reading.arrays.positions[reading.vertices], axis=1).mean()
    assert np.median(values) == pytest.approx(1 / radius, rel=0.03)  # of the smooth surface, not of the cage


def test_corners_come_along_to_the_original():
    target = with_modifiers(("SUBSURF", {"levels": 1}))
    reading = source_meshes.read(target, "evaluated")
    settings = job.Settings(("harris",), QUICK.options, "software")
    found = on_original(job.run(reading.arrays, settings), reading.vertices)
    assert len(found.corners.painted) == 152
    assert all(found.corners.painted[vertex] == 1 for vertex in found.corners.vertices)


def test_masks_and_seams_come_along_to_the_original_where_vertices_are_reordered():
    target = animated.bent_cylinder(rings=8, sides=12)
    target.modifiers.remove(target.modifiers["Armature"])
    own = source_meshes.read(target, "original")
    shuffled = target.modifiers.new("Build", "BUILD")
    shuffled.use_random_order, shuffled.frame_start, shuffled.frame_duration = True, -100, 1
    bpy.context.view_layer.update()
    reading = source_meshes.read(target, "evaluated")
    assert reading.own
    assert sorted(reading.vertices) == list(range(len(own.arrays.positions)))
    assert (reading.vertices != np.arange(len(reading.vertices))).mean() > 0.9
    settings = job.Settings(("mean_curvature",), bridge.Options(0.1, samples=64, buffer_size=256), "software")
    expected, results = job.run(own.arrays, settings), job.run(reading.arrays, settings)
    found = on_original(results, reading.vertices)
    near_rim = np.isin(own.arrays.positions[:, 2].round(6), (0, 4))
    assert np.array_equal(expected.mask & abi.MASK_BOUNDARY != 0, near_rim)
    assert np.array_equal(found.mask, expected.mask)
    assert not np.array_equal(results.mask, expected.mask)
    assert np.array_equal(found.near_seam, expected.near_seam)
    assert 0 < found.near_seam.sum() < len(found.near_seam)
    assert np.array_equal(found.coverage, results.coverage[reading.vertices])
    assert found.values.keys() == results.values.keys() == {"mean_curvature"}
    expected_values = results.values["mean_curvature"][reading.vertices]
    assert np.array_equal(found.values["mean_curvature"], expected_values, equal_nan=True)


def test_mixed_marks_are_no_vertices():
    marks = np.array([[0, 5, 9], [1, 7, 3], [2, 8, 4]], np.float32)
    mixed = (marks[0] + marks[2]) / 2  # has the index of the vertex between
    carried = np.array([mixed, marks[2], marks[0], marks[2], [np.nan, 0, 0], [9, 0, 0]], np.float32)
    assert source_meshes.matched(carried, marks).tolist() == [2, -1, 1]


def test_edit_mode_is_measured_as_edited():
    target = with_modifiers(BEND)
    bpy.ops.object.mode_set(mode="EDIT")
    reading = source_meshes.read(target, "deformed")
    bpy.ops.object.mode_set(mode="OBJECT")
    assert np.array_equal(reading.arrays.positions, mesh_io.read_positions(target.data))
    assert "as it is edited" in reading.notes[0]


def test_own_normals_are_those_of_the_deformed_mesh():
    target = with_modifiers(BEND)
    arrays = source_meshes.read(target, "deformed", corner_normals=True).arrays
    original = source_meshes.read(target, "original", corner_normals=True).arrays
    assert not np.allclose(arrays.corner_normals, original.corner_normals, atol=0.05)
    np.testing.assert_allclose(np.linalg.norm(arrays.corner_normals, axis=1), 1, atol=1e-3)


def test_object_that_blender_does_not_evaluate_is_refused_and_not_measured_without_its_modifiers():
    target = with_modifiers(BEND)
    target.hide_viewport = True
    for source in ("deformed", "evaluated"):
        with pytest.raises(bridge.ParadescError, match="disabled in viewports"):
            source_meshes.read(target, source)
    assert len(source_meshes.read(target, "original").arrays.positions) == 152
    target.hide_viewport = False
    target.hide_set(True)  # only out of sight
    straight = mesh_io.read_positions(target.data)
    assert not np.allclose(source_meshes.read(target, "deformed").arrays.positions, straight)


def test_a_taken_name_is_one_sentence():
    target = with_modifiers(SUBSURF)
    target.data.attributes.new(source_meshes.MARK, "INT", "POINT")
    with pytest.raises(bridge.ParadescError, match="rename"):
        source_meshes.read(target, "evaluated")


# ---- What shows or hides modifiers, and how often they are evaluated


def driven(target):
    curve = target.driver_add('modifiers["SUBSURF"].show_viewport')
    curve.driver.expression = "1"


def animated_switch(target):
    target.modifiers["SUBSURF"].keyframe_insert("show_viewport", frame=1)


@pytest.mark.parametrize("switch", [driven, animated_switch])
def test_deformed_leaves_out_what_a_driver_or_an_animation_shows(switch):
    target = with_modifiers(SUBSURF, BEND)
    switch(target)
    bpy.context.view_layer.update()
    before = scene_state(target)
    reading = source_meshes.read(target, "deformed")
    assert len(reading.arrays.positions) == 152
    assert "SUBSURF" in reading.notes[0]
    assert scene_state(target) == before
    curves = [*target.animation_data.drivers, *(source_meshes.showing(target.modifiers["SUBSURF"]))]
    assert curves
    assert not any(curve.mute for curve in curves)


def count_evaluations(monkeypatch):
    """Counts how often the modifiers of objects are evaluated to meshes."""
    counted = []
    evaluated = source_meshes.evaluated_mesh

    def counting(target):
        counted.append(target.name)
        return evaluated(target)

    monkeypatch.setattr(source_meshes, "evaluated_mesh", counting)
    return counted


@pytest.mark.parametrize("placing", [True, False])
def test_modifiers_that_make_vertices_are_evaluated_once(placing, monkeypatch):
    target = with_modifiers(SUBSURF)
    counted = count_evaluations(monkeypatch)
    reading = source_meshes.read(target, "evaluated", placing=placing)
    assert counted == ["sphere"]
    assert (reading.vertices is not None, reading.own) == (placing, placing)
    assert source_meshes.MARK not in target.data.attributes


@pytest.mark.usefixtures("registered")
def test_an_image_of_a_linked_mesh_says_nothing_of_vertices_that_are_lost(tmp_path, capfd):
    with_modifiers(SUBSURF)
    path = saved_scene(tmp_path / "library.blend")
    empty_scene()
    with bpy.data.libraries.load(str(path), link=True) as (_, wanted):
        wanted.objects = ["sphere"]
    linked = bpy.data.objects["sphere"]
    bpy.context.collection.objects.link(linked)
    select(linked)
    settings = small_bake("cpu")
    settings.texels = 16
    bpy.context.scene.paradesc_animation.source = "evaluated"
    assert bpy.ops.paradesc.bake_image() == {"FINISHED"}
    assert "lose" not in capfd.readouterr().out


def test_sentences_about_sources_name_what_the_panel_and_the_command_line_have():
    labels = {name: label for name, label, _ in source_kinds.SOURCES}
    assert source_kinds.in_words("evaluated", "original") == "With Modifiers (evaluated) or Base Mesh (original)"
    folders = ("scene", "bake", "show", "animation", "settings", "ui")  # commands have words of their own
    for path in [path for folder in folders for path in (ADDON / "paradesc_blender" / folder).glob("*.py")]:
        for node in ast.walk(ast.parse(path.read_text())):
            text = node.value if isinstance(node, ast.Constant) and isinstance(node.value, str) else ""
            assert not any(f"the source {name}" in text for name in labels), f"{path}: {text}"
            assert "the backend cpu" not in text, f"{path}: {text}"


def test_modifiers_that_leave_no_faces_are_named():
    target = with_modifiers(("BUILD", {"frame_start": 9}))
    with pytest.raises(bridge.ParadescError, match=r'modifiers of "sphere" leave no faces; .* have to realize them'):
        source_meshes.read(target, "evaluated")


@pytest.mark.parametrize("source", ["evaluated", "original"])
def test_geometry_nodes_make_a_mesh_of_nothing(source):
    with_modifiers()
    target = bpy.data.objects.new("made", bpy.data.meshes.new("empty"))
    bpy.context.collection.objects.link(target)
    tree = bpy.data.node_groups.new("cube", "GeometryNodeTree")
    add_socket(tree, "Geometry", "geometry", output=True)
    nodes = [tree.nodes.new(kind) for kind in ("GeometryNodeMeshCube", "NodeGroupOutput")]
    tree.links.new(nodes[0].outputs[0], nodes[1].inputs[0])
    target.modifiers.new("cube", "NODES").node_group = tree
    bpy.context.view_layer.update()
    chosen, sentences = scene_io.all_objects(source)
    assert [item.name for item in chosen] == (["made", "sphere"] if source == "evaluated" else ["sphere"])
    assert ["has no faces" in sentence for sentence in sentences] == ([] if source == "evaluated" else [True])


def spoiled(target, value):
    uvs = target.data.uv_layers.active.data
    uvs.foreach_set("uv", np.full(2 * len(uvs), value, np.float32))


@pytest.mark.parametrize(("value", "words"), [(np.nan, "coordinates that are not finite"), (0.25, "without area")])
def test_a_uv_map_that_cannot_be_used_is_said_with_the_one_that_can(value, words):
    target = with_modifiers()
    spoiled(target, value)
    arrays = mesh_io.read_object(target, corner_normals=False, needs_uvs=False)
    assert arrays.corner_uvs is None
    assert arrays.uv_fault == f"has a UV map {'with ' if np.isnan(value) else ''}{words}"
    spoiled(target, 0.0)
    good = target.data.uv_layers.new(name="good")
    good.data.foreach_set("uv", np.random.default_rng(0).random(2 * len(good.data)).astype(np.float32))
    target.data.uv_layers.active_index = 0
    arrays = mesh_io.read_object(target, corner_normals=False, needs_uvs=False)
    assert arrays.uv_fault == 'has a UV map without area (its other "good" can be used: make it the active one)'
