"""Which meshes have faces too large for vertex colors: walls and crates, and neither heads nor scanned parts."""

import numpy as np
import pytest

from conftest import real_mesh
from paradesc.core import large_faces
from shapes import cube_sphere

SQUARES = [(0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)]


def halves(quads):
    """(2 n, 3) triangles of (n, 4) quads."""
    quads = np.asarray(quads)
    return np.concatenate([quads[:, :3], quads[:, [0, 2, 3]]])


def box(sides=(1.0, 1.0, 1.0)):
    """A box as (8, 3) positions and (12, 3) triangles."""
    places = np.array([(x, y, z) for z in (-1, 1) for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))], np.float32)
    return places * np.float32(sides), halves(SQUARES)


def wave(steps, height):
    """A square of steps x steps quads, in waves of a height."""
    x, y = np.meshgrid(np.linspace(-1, 1, steps + 1), np.linspace(-1, 1, steps + 1))
    points = np.column_stack([x.ravel(), y.ravel(), height * np.sin(9 * x.ravel())]).astype(np.float32)
    corner = (np.arange(steps)[:, None] * (steps + 1) + np.arange(steps)).ravel()
    return points, halves(np.column_stack([corner, corner + 1, corner + steps + 2, corner + steps + 1]))


def test_all_of_a_box_lies_in_large_faces_between_edges():
    assert large_faces.share(*box()) == pytest.approx(1.0)  # the sum of areas in another order
    assert large_faces.are_too_large(*box((1, 5, 0.2)))


def test_faces_that_were_split_at_their_edges_are_joined_by_their_places():
    points, triangles = box()
    apart = points[triangles.ravel()], np.arange(triangles.size).reshape(-1, 3)
    assert large_faces.share(*apart) == pytest.approx(large_faces.share(points, triangles))


def test_a_finely_divided_surface_has_none_however_much_it_bends():
    points, quads, _ = cube_sphere(8)
    assert large_faces.share(points, halves(quads)) == 0.0
    assert large_faces.share(*wave(40, 0.3)) < 0.05


def test_a_plane_has_no_edges_to_show():
    assert large_faces.share(*wave(1, 0.0)) == 0.0


def test_what_has_no_area_has_no_share():
    points, triangles = box()
    assert large_faces.share(0 * points, triangles) == 0.0
    assert large_faces.share(points, triangles[:0]) == 0.0
    points[3] = np.nan
    assert large_faces.share(points, triangles) == 0.0


def test_edges_are_bent_from_ten_degrees_on():
    for degrees, count in ((8.0, 0), (12.0, 1)):
        angle = np.radians(degrees)
        points = np.array([(0, 0, 0), (0, 1, 0), (-1, 0, 0), (np.cos(angle), 0, np.sin(angle))])
        triangles = np.array([(0, 1, 2), (1, 0, 3)])
        assert len(large_faces.bent_edges(points, triangles)) == count


# ---- Objects


@pytest.fixture
def shown(registered):
    """Adds a primitive, and tells how its button asks."""
    bpy = pytest.importorskip("bpy", reason="needs Blender")
    from paradesc_blender.scene import large_faces as of_objects

    def answer(kind, modifier="", source="auto", **settings):
        getattr(bpy.ops.mesh, f"primitive_{kind}_add")()
        target = bpy.context.object
        if modifier:
            made = target.modifiers.new("made", modifier)
            for name, value in settings.items():
                setattr(made, name, value)
        bpy.context.view_layer.update()
        return of_objects.are_too_large(target, source)

    return answer


@pytest.mark.parametrize("width", [0.02, 0.1])
def test_a_beveled_cube_is_one_for_images(shown, width):
    assert shown("cube", "BEVEL", width=width, segments=3)


def test_subdivided_it_is_none_any_more_but_its_cage_is(shown):
    assert not shown("cube", "SUBSURF", levels=4)
    assert shown("cube", "SUBSURF", levels=4, source="original")


@pytest.mark.parametrize(
    ("kind", "large"),
    [("cube", True), ("cylinder", True), ("cone", True), ("monkey", False), ("uv_sphere", False), ("torus", False)],
)
def test_primitives_are_told_apart(shown, kind, large):
    assert shown(kind) == large


@pytest.mark.parametrize(
    ("name", "large"), [("barracks", True), ("fandisk", False), ("human", False), ("pirate", False)]
)
def test_real_meshes_are_told_apart(registered, name, large):
    bpy = pytest.importorskip("bpy", reason="needs Blender")
    bpy.ops.wm.obj_import(filepath=str(real_mesh(f"{name}.obj")))
    from paradesc_blender.scene import large_faces as of_objects

    assert of_objects.every([item for item in bpy.data.objects if item.type == "MESH"], "auto") == large


def test_of_no_object_nothing_is_said(registered):
    from paradesc_blender.scene import large_faces as of_objects

    assert not of_objects.every([], "auto")


# ---- Panel and menus


def drawn(cls):
    from panel_test import drawn_by

    return drawn_by(cls)


@pytest.mark.parametrize("kind", ["cube", "torus"])
def test_the_main_button_is_the_one_that_shows_a_mask_and_the_other_stays(shown, kind):
    from paradesc_blender.ui import panel

    large = shown(kind)
    found, buttons = drawn(panel.PARADESC_PT_bake), ["Bake Descriptors", "Bake to Image"]
    assert [text for text in found["operator"] if text in buttons] == (buttons[::-1] if large else buttons)
    assert ("Faces are too large" in " ".join(found["label"])) == large


def test_menus_bake_to_images_then(shown):
    from paradesc_blender.ui import menus

    shown("torus")
    assert drawn(menus.PARADESC_MT_bake)["operator"][0] == "Bake Cavity"
    shown("cube")
    import bpy

    from scene import select

    select(bpy.data.objects["Cube"])
    assert drawn(menus.PARADESC_MT_bake)["operator"][0] == "Bake Cavity to Image"


def test_a_mask_that_a_menu_asks_for_is_the_one_in_the_image(shown):
    import bpy

    shown("cube")
    bpy.context.scene.paradesc.texels = 64
    assert bpy.ops.paradesc.bake_image(mask="openness") == {"FINISHED"}
    assert [image.name for image in bpy.data.images if image.source == "FILE"] == ["Cube_openness"]


def test_flat_faces_of_a_cube_are_black_away_from_its_edges_in_the_image(shown):
    """Twice the radius from an edge nothing of another face is seen: 0 to the bit of a 16-bit pixel."""
    import bpy

    from paradesc_blender.scene import image_results, unwrap

    shown("cube")
    bpy.context.scene.paradesc.texels = 1024
    bpy.ops.paradesc.bake_image(mask="edge_wear")
    target = bpy.context.object
    radius = bpy.context.scene.paradesc.radius_percent / 100 * 12**0.5  # of the diagonal of a cube of side 2
    image = image_results.found(target).images[0]
    pixels = np.array(image.pixels[:], np.float32).reshape(1024, 1024, 4)[:, :, 0]
    uvs = unwrap.read_uvs(target.data.uv_layers.active).reshape(6, 4, 2)
    assert radius < 0.2
    for corners in uvs:
        low, high = corners.min(axis=0), corners.max(axis=0)
        inside = (high - low) * radius  # a face has side 2 and its inner part lies 2 radii from its border
        (left, bottom), (right, top) = np.ceil(1024 * (low + inside)), np.floor(1024 * (high - inside))
        face = pixels[int(bottom) : int(top), int(left) : int(right)]
        assert face.size > 1000
        assert not face.any()
        border = pixels[int(512 * (low[1] + high[1])), int(1024 * low[0]) + 1]  # about a fifth of the radius away
        assert border > 0.5
