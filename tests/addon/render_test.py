"""Live values in renders: two frames, pixel by pixel against meshes that were baked in those shapes.

The shape index is shown, whose colors always span -1 to 1.
"""

import os

import numpy as np
import pytest

from shapes import ADDON

bpy = pytest.importorskip("bpy", reason="needs Blender")
import bmesh  # noqa: E402

from deforming import skip_where_keyed_vertices_crash  # noqa: E402
from paradesc_blender.animation import live, sessions  # noqa: E402
from paradesc_blender.scene import record  # noqa: E402
from processes import run_blender  # noqa: E402
from scene import add_sphere  # noqa: E402

NAME = "shape_index"
SIZE = 64
RADIUS = 0.3
FRAMES = (1, 4)
EEVEE = "BLENDER_EEVEE" if bpy.app.version < (4, 2, 0) or bpy.app.version >= (5, 0, 0) else "BLENDER_EEVEE_NEXT"
# Live colors come from a table of 4096 steps.
ONE_STEP = 1 / 255 + 1e-6


pytestmark = pytest.mark.usefixtures("registered")


def settings_of(scene):
    """Settings that are small, give the same bits twice, and have a radius that no pose changes."""
    group = scene.paradesc
    group.descriptors = {NAME}
    group.radius_unit, group.radius_absolute = "absolute", RADIUS
    group.samples, group.buffer_size, group.backend = 64, 256, "software"


def show_attribute(target):
    """Adds a material that emits the attribute's color, whatever light there is."""
    material = bpy.data.materials.new("shown")
    material.use_nodes = True
    nodes, links = material.node_tree.nodes, material.node_tree.links
    nodes.clear()
    attribute, emission, output = (
        nodes.new(f"ShaderNode{kind}") for kind in ("Attribute", "Emission", "OutputMaterial")
    )
    attribute.attribute_name = f"{NAME}_color"
    links.new(attribute.outputs["Color"], emission.inputs["Color"])
    links.new(emission.outputs["Emission"], output.inputs["Surface"])
    target.data.materials.append(material)


def look_at(scene, engine):
    """Adds a camera in front of the sphere, and makes renders quick."""
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    camera.data.type, camera.data.ortho_scale = "ORTHO", 7.0
    camera.location, camera.rotation_euler = (10, 0, 0), (np.pi / 2, 0, np.pi / 2)
    scene.collection.objects.link(camera)
    scene.camera = camera
    render = scene.render
    render.engine, render.resolution_x, render.resolution_y = engine, SIZE, SIZE
    render.image_settings.file_format = "PNG"
    scene.view_settings.view_transform = "Standard"
    render.dither_intensity = 0.0
    scene.frame_start, scene.frame_end, scene.frame_step = FRAMES[0], FRAMES[1], FRAMES[1] - FRAMES[0]
    if engine == "CYCLES":
        scene.cycles.device, scene.cycles.samples, scene.cycles.use_denoising = "CPU", 4, False
        scene.cycles.seed = 3
    else:
        scene.eevee.taa_render_samples = 4


def make_triangles(target):
    """Cuts the quads, which Blender would cut in another way in another shape."""
    content = bmesh.new()
    content.from_mesh(target.data)
    bmesh.ops.triangulate(content, faces=content.faces)
    content.to_mesh(target.data)
    content.free()


def bend_by_armature(target):
    """Adds two bones, of which the upper one turns from the first frame to the last."""
    armature = bpy.data.objects.new("bones", bpy.data.armatures.new("bones"))
    bpy.context.collection.objects.link(armature)
    bpy.context.view_layer.objects.active = armature
    bpy.ops.object.mode_set(mode="EDIT")
    for name, start, end in (("lower", -2, 0), ("upper", 0, 2)):
        bone = armature.data.edit_bones.new(name)
        bone.head, bone.tail = (0, 0, start), (0, 0, end)
    bpy.ops.object.mode_set(mode="OBJECT")
    for name, sign in (("lower", -1), ("upper", 1)):
        group = target.vertex_groups.new(name=name)
        for vertex in target.data.vertices:
            group.add([vertex.index], float(np.clip(0.5 + sign * vertex.co.z, 0, 1)), "REPLACE")
    target.modifiers.new("bones", "ARMATURE").object = armature
    bone = armature.pose.bones["upper"]
    bone.rotation_mode = "XYZ"
    for frame, angle in zip(FRAMES, (0.0, 0.9), strict=True):
        bone.rotation_euler = (angle, 0, 0)
        bone.keyframe_insert("rotation_euler", frame=frame)


def stretch_by_key(target):
    """Adds a shape key that pulls the upper half up."""
    target.shape_key_add(name="Basis")
    key = target.shape_key_add(name="pulled")
    for item, vertex in zip(key.data, target.data.vertices, strict=True):
        item.co.z *= 1.0 + 0.8 * max(vertex.co.z, 0.0)
    for frame, value in zip(FRAMES, (0.0, 1.0), strict=True):
        key.value = value
        key.keyframe_insert("value", frame=frame)


def stretch_and_bend(target):
    """Both the shape key and a modifier with keys."""
    stretch_by_key(target)
    bend = target.modifiers.new("bend", "SIMPLE_DEFORM")
    bend.deform_method = "BEND"
    for frame, angle in zip(FRAMES, (0.0, 1.5), strict=True):
        bend.angle = angle
        bend.keyframe_insert("angle", frame=frame)


def animated_scene(engine, deform):
    """A live object whose shape differs between the two frames."""
    scene = bpy.context.scene
    settings_of(scene)
    target = add_sphere()
    make_triangles(target)
    show_attribute(target)
    deform(target)
    look_at(scene, engine)
    scene.frame_set(FRAMES[0])
    target.paradesc_live.mode = "LIVE"
    assert target.paradesc_live.sentence == ""
    return target


def pixels(path):
    """(SIZE, SIZE, 3) values between 0 and 1 of an image file."""
    image = bpy.data.images.load(str(path))
    found = np.array(image.pixels[:], np.float32).reshape(SIZE, SIZE, 4)[..., :3]
    bpy.data.images.remove(image)
    return found


def render_still(path):
    """One picture of the scene at its frame."""
    bpy.context.scene.render.filepath = str(path)
    bpy.ops.render.render(write_still=True)
    return pixels(path)


def render_baked(target, path):
    """Renders the same picture with a mesh that has the present shape and was baked by the operator."""
    depsgraph = bpy.context.evaluated_depsgraph_get()
    shape = bpy.data.meshes.new_from_object(target.evaluated_get(depsgraph))
    for name in record.attributes_of(target.data):
        shape.attributes.remove(shape.attributes[name])
    still = bpy.data.objects.new("still", shape)
    still.matrix_world = target.matrix_world
    bpy.context.collection.objects.link(still)
    bpy.ops.object.select_all(action="DESELECT")
    bpy.context.view_layer.objects.active = still
    still.select_set(True)
    target.hide_render = True
    assert bpy.ops.paradesc.bake() == {"FINISHED"}
    found = render_still(path)
    target.hide_render = False
    bpy.data.objects.remove(still)
    return found


def same(first, second):
    """Returns whether two pictures are equal, except single pixels on the outline."""
    return (np.abs(first - second).max(axis=2) > ONE_STEP).mean() < 0.002


def expected_frames(target, folder):
    """The pictures that the two frames have to give."""
    found = []
    for frame in FRAMES:
        bpy.context.scene.frame_set(frame)
        found.append(render_baked(target, folder / f"expected{frame}.png"))
    assert np.abs(found[0] - found[1]).max(axis=2).mean() > 0.02
    return found


def move_vertices(target):
    """Animated vertices of the mesh itself."""
    skip_where_keyed_vertices_crash()
    for item in target.data.vertices:
        place = item.co.copy()
        for frame, share in zip(FRAMES, (0.0, 0.4), strict=True):
            item.co = place * (1.0 + share * max(place.z, 0.0))
            item.keyframe_insert("co", frame=frame)


@pytest.mark.slow
@pytest.mark.parametrize("deform", [bend_by_armature, stretch_by_key, move_vertices])
def test_stills_and_animation_in_cycles_show_each_frames_values(deform, tmp_path):
    target = animated_scene("CYCLES", deform)
    expected = expected_frames(target, tmp_path)
    for frame, wanted in zip(FRAMES, expected, strict=True):
        bpy.context.scene.frame_set(frame)
        assert same(render_still(tmp_path / f"still{frame}.png"), wanted)
    check_animation(expected, tmp_path)


def check_animation(expected, folder):
    """Renders both frames in a row."""
    bpy.context.scene.render.filepath = str(folder / "animation")
    bpy.ops.render.render(animation=True)
    for frame, wanted in zip(FRAMES, expected, strict=True):
        assert same(pixels(folder / f"animation{frame:04}.png"), wanted)


def test_renders_take_full_quality_where_the_window_does_not(tmp_path):
    target = animated_scene("CYCLES", stretch_by_key)
    bpy.context.scene.frame_set(FRAMES[1])
    expected = render_baked(target, tmp_path / "expected.png")
    bpy.context.scene.paradesc_live.samples, bpy.context.scene.paradesc_live.buffer_size = 8, 64
    bpy.context.scene.frame_set(FRAMES[0])
    bpy.context.scene.frame_set(FRAMES[1])
    assert same(render_still(tmp_path / "full.png"), expected)
    bpy.context.scene.paradesc_live.full_render = False
    assert not same(render_still(tmp_path / "quick.png"), expected)


def test_motion_blur_asks_for_shapes_between_frames_not_for_values(tmp_path, monkeypatch):
    animated_scene("CYCLES", stretch_by_key)
    scene = bpy.context.scene
    scene.frame_set(FRAMES[1])
    scene.render.use_motion_blur, scene.render.motion_blur_shutter = True, 0.5
    asked, computed = [], []
    on_frame, compute = sessions.live_objects, live.Session.compute
    monkeypatch.setattr(sessions, "live_objects", lambda: (asked.append(scene.frame_current_final), on_frame())[1])
    monkeypatch.setattr(
        live.Session, "compute", lambda *words: (computed.append(scene.frame_current_final), compute(*words))[1]
    )
    scene.paradesc.samples = 128  # the render is not what the window has
    render_still(tmp_path / "blurred.png")
    assert any(frame != int(frame) for frame in asked)
    assert computed[0] == FRAMES[1]
    assert all(frame == FRAMES[1] for frame in computed)


@pytest.mark.skipif(
    not bpy.app.binary_path and not os.environ.get("PARADESC_LONG_TESTS"),
    reason="compiling EEVEE's shaders takes the Python module half a minute on a software rasterizer",
)
def test_animation_in_eevee_shows_each_frames_values(tmp_path):
    target = animated_scene(EEVEE, stretch_and_bend)
    check_animation(expected_frames(target, tmp_path), tmp_path)


# ---- Farms

ENABLE = """
import bpy
assert bpy.ops.preferences.addon_enable(module="paradesc_blender") == {"FINISHED"}
bpy.ops.wm.save_userpref()
"""
REGISTER = """
import sys
sys.path.insert(0, FOLDER)
import paradesc_blender
paradesc_blender.register()
"""


def enabled_by_preferences(folder):
    """Enables the add-on where users put it; no words are needed."""
    (folder / "scripts" / "addons").mkdir(parents=True)
    for name in ("paradesc", "paradesc_blender"):
        (folder / "scripts" / "addons" / name).symlink_to(ADDON / name)
    (folder / "enable.py").write_text(ENABLE)
    run_blender([bpy.app.binary_path, "-b", "--factory-startup", "-P", folder / "enable.py"], folder)
    return []


def enabled_by_script(folder):
    """The words that run a script after the file was read."""
    (folder / "register.py").write_text(REGISTER.replace("FOLDER", repr(str(ADDON))))
    return ["-P", folder / "register.py"]


@pytest.mark.skipif(not bpy.app.binary_path, reason="needs Blender's executable")
@pytest.mark.parametrize("enable", [enabled_by_preferences, enabled_by_script])
def test_a_farm_renders_each_frames_values(enable, tmp_path):
    target = animated_scene("CYCLES", stretch_and_bend)
    expected = expected_frames(target, tmp_path)
    bpy.context.scene.frame_set(FRAMES[1])
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "shot.blend"))
    words = enable(tmp_path)
    words = ["--factory-startup", tmp_path / "shot.blend", *words] if words else [tmp_path / "shot.blend"]
    run_blender([bpy.app.binary_path, "-b", *words, "-o", tmp_path / "farm####", "-a"], tmp_path)
    for frame, wanted in zip(FRAMES, expected, strict=True):
        assert same(pixels(tmp_path / f"farm{frame:04}.png"), wanted)


@pytest.mark.skipif(not bpy.app.binary_path, reason="needs Blender's executable")
def test_a_farm_is_told_what_goes_wrong(tmp_path):
    target = animated_scene("CYCLES", stretch_by_key)
    target.modifiers.new("fewer", "DECIMATE").ratio = 0.5
    target.modifiers["fewer"].show_viewport = False
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "shot.blend"))
    words = ["--factory-startup", tmp_path / "shot.blend", *enabled_by_script(tmp_path)]
    said = run_blender([bpy.app.binary_path, "-b", *words, "-o", tmp_path / "farm####", "-f", FRAMES[1]], tmp_path)
    assert "switched off" in said
    assert "take vertices away" in said
