"""Renders and exports of an animation have every frame's pose with the values of that pose, whatever moves the mesh.

The silhouettes are those of a render without live values, and the pictures those of meshes baked in that pose.
"""

import numpy as np
import pytest

bpy = pytest.importorskip("bpy", reason="needs Blender")

from deforming import CASES, FIRST, LAST  # noqa: E402
from render_test import look_at, make_triangles, render_baked, same, settings_of, show_attribute  # noqa: E402
from scene import add_sphere  # noqa: E402

SIZE = 64
STEP = 3
FRAMES = range(FIRST, LAST + 1, STEP)
# Their pictures show more than the vertices of one mesh, or what only renders show: silhouettes alone are compared.
MORE = {"array", "solidify", "modifier_that_appears", "subdivision_behind_a_modifier"}
MORE |= {"two_objects_of_one_mesh", "object_shrunk_onto_it"}
QUICK = {"bend", "driven_by_an_own_property"}
NAMES = [name if name in QUICK else pytest.param(name, marks=pytest.mark.slow) for name in CASES]

pytestmark = pytest.mark.usefixtures("registered")


def moving_scene(move):
    """An object that moves from the first frame to the last, from whose silhouette nothing hides."""
    scene = bpy.context.scene
    settings_of(scene)
    scene.paradesc.backend = "cpu"
    target = add_sphere(steps=6)
    make_triangles(target)
    show_attribute(target)
    look_at(scene, "CYCLES")
    scene.render.film_transparent, scene.render.image_settings.color_mode = True, "RGBA"
    scene.frame_start, scene.frame_end, scene.frame_step = FIRST, LAST, STEP
    move(target)
    return target


def rendered(folder, name):
    """(SIZE, SIZE, 4) pixels of each frame, begun at a frame that is none of them."""
    scene = bpy.context.scene
    scene.frame_set(FIRST + 1)
    scene.render.filepath = str(folder / name)
    bpy.ops.render.render(animation=True)
    found = []
    for frame in FRAMES:
        image = bpy.data.images.load(str(folder / f"{name}{frame:04}.png"))
        found.append(np.array(image.pixels[:], np.float32).reshape(SIZE, SIZE, 4))
        bpy.data.images.remove(image)
    return found


def switch_all(mode):
    """Switches values on for all meshes, or for the first of those that share one."""
    chosen = {item.data: item for item in reversed(bpy.data.objects) if item.type == "MESH"}.values()
    for target in chosen:
        target.paradesc_live.mode = mode
    bpy.context.view_layer.update()
    assert [target.paradesc_live.sentence for target in chosen] == [""] * len(chosen)


def bake_frames(folder):
    """Fills the cache of all meshes."""
    scene = bpy.context.scene
    scene.paradesc_animation.cache_folder = str(folder / "cache")
    for item in bpy.data.objects:
        item.select_set(item.type == "MESH")
    assert bpy.ops.paradesc.bake_frames() == {"FINISHED"}


def check_silhouettes(found, expected):
    """Returns whether the pictures show the same poses."""
    for frame, picture, wanted in zip(FRAMES, found, expected, strict=True):
        assert same(picture[..., 3:], wanted[..., 3:]), f"frame {frame} shows another pose"
    assert not same(expected[0][..., 3:], expected[-1][..., 3:]), "nothing moves"


def check_values(target, found, folder):
    """Returns whether each picture is that of a mesh that was baked in the pose of its frame."""
    target.paradesc_live.mode = "OFF"
    for frame, picture in zip(FRAMES, found, strict=True):
        bpy.context.scene.frame_set(frame)
        assert same(picture[..., :3], render_baked(target, folder / f"{frame}.png")), f"frame {frame} has other values"


@pytest.mark.parametrize("mode", ["LIVE", "CACHE"])
@pytest.mark.parametrize("name", NAMES)
def test_an_animation_shows_each_frames_pose_and_its_values(name, mode, tmp_path):
    target = moving_scene(CASES[name])
    expected = rendered(tmp_path, "off")
    if mode == "CACHE":
        bake_frames(tmp_path)
    switch_all(mode)
    found = rendered(tmp_path, "shown")
    check_silhouettes(found, expected)
    if name not in MORE:
        check_values(target, found, tmp_path)


@pytest.mark.parametrize("name", ["subdivision_behind_a_modifier", "array", "solidify"])
def test_what_modifiers_make_keeps_its_pose_while_values_are_carried_to_it(name, tmp_path):
    target = moving_scene(CASES[name])
    bpy.context.scene.paradesc_animation.source = "auto"
    expected = rendered(tmp_path, "off")
    switch_all("LIVE")
    found = rendered(tmp_path, "shown")
    assert target.paradesc_live.sentence == ""
    check_silhouettes(found, expected)
    shown = [picture[..., :3][picture[..., 3] > 0.99] for picture in found]
    assert all(np.ptp(colors) > 0.05 for colors in shown), "a frame has no values"


def blurred(scene):
    scene.render.use_motion_blur = True


def kept_between_frames(scene):
    scene.render.use_persistent_data = True


def in_workbench(scene):
    scene.render.engine = "BLENDER_WORKBENCH"


@pytest.mark.slow
@pytest.mark.parametrize("mode", ["LIVE", "CACHE"])
@pytest.mark.parametrize("render", [blurred, kept_between_frames, in_workbench])
def test_however_it_is_rendered_an_animation_shows_each_frames_pose(render, mode, tmp_path):
    moving_scene(CASES["moving_object_with_a_modifier"])
    render(bpy.context.scene)
    expected = rendered(tmp_path, "off")
    if mode == "CACHE":
        bake_frames(tmp_path)
    switch_all(mode)
    check_silhouettes(rendered(tmp_path, "shown"), expected)


# ---- Exporters, and what somebody has changed without a key


def exported_positions(path, evaluation):
    """(frame_count, 3 * vertex_count) positions in a file of the animation, as Blender reads them again."""
    scene = bpy.context.scene
    scene.frame_set(FIRST + 1)
    if path.suffix == ".abc":
        bpy.ops.wm.alembic_export(filepath=str(path), as_background_job=False, evaluation_mode=evaluation)
    else:
        bpy.ops.wm.usd_export(filepath=str(path), export_animation=True, evaluation_mode=evaluation)
    before, found = set(bpy.data.objects), []
    (bpy.ops.wm.alembic_import if path.suffix == ".abc" else bpy.ops.wm.usd_import)(filepath=str(path))
    made = set(bpy.data.objects) - before
    read = next(item for item in made if item.type == "MESH")
    for frame in FRAMES:
        scene.frame_set(frame)
        evaluated = read.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
        found.append(np.empty(3 * len(evaluated.vertices), np.float32))
        evaluated.vertices.foreach_get("co", found[-1])
    for item in made:
        bpy.data.objects.remove(item)
    return np.array(found)


@pytest.mark.parametrize("evaluation", ["RENDER", "VIEWPORT"])
@pytest.mark.parametrize("kind", ["abc", "usdc"])
def test_exported_animations_have_each_frames_pose(kind, evaluation, tmp_path):
    library = {"abc": "alembic", "usdc": "usd"}[kind]
    if not getattr(bpy.app.build_options, library):
        pytest.skip(f"this Blender is built without {library}")
    target = moving_scene(CASES["bend"])
    bpy.context.scene.frame_step = 1
    expected = exported_positions(tmp_path / f"off.{kind}", evaluation)
    target.paradesc_live.mode = "LIVE"
    found = exported_positions(tmp_path / f"live.{kind}", evaluation)
    assert np.abs(expected[0] - expected[-1]).max() > 0.5
    np.testing.assert_array_equal(found, expected)
