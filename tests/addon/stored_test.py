"""The properties of a bake in a .blend are checked before use: edited ones, or those of another version, do no harm."""

import pytest

from paradesc.core import stored


def a_summary(**more):
    """A record as a bake leaves it."""
    return {
        "settings": {"space": "object"},
        "mesh_report": dict.fromkeys(stored.MESH_REPORT, 3),
        "field_report": dict.fromkeys(stored.FIELD_REPORT, 0.5),
        **dict.fromkeys(stored.WORDS, "words"),
        "ranges": {"mean_curvature": [-1.0, 1.0]},
        "drawn": {"mean_curvature": {"map": "heat", "diverging": True, "neutral": 0.0, "radius": 0.1, "unit": "1/m"}},
        "attributes": ["mean_curvature", "mean_curvature_color"],
        "layout": {"topology": "a", "content": "b"},
        **more,
    }


def test_what_a_bake_left_is_taken_as_it_is():
    assert stored.checked(a_summary()) == a_summary()


@pytest.mark.parametrize("content", [None, 3, "text", [], {}, {"attributes": 5}, {"attributes": ["a", 3]}])
def test_what_is_no_summary_is_empty(content):
    assert stored.checked(content) == {}


@pytest.mark.parametrize(
    "more",
    [
        {"mesh_report": {}},
        {"field_report": 7},
        {"field_report": {**dict.fromkeys(stored.FIELD_REPORT, 0.5), "radius": "wide"}},
        {"mesh_report": {**dict.fromkeys(stored.MESH_REPORT, 3), "charts": float("nan")}},
    ],
)
def test_a_report_that_lacks_something_is_no_report(more):
    found = stored.checked(a_summary(**more))
    assert "mesh_report" not in found
    assert "field_report" not in found
    assert found["attributes"] == a_summary()["attributes"]


@pytest.mark.parametrize(
    "span", [None, 3, [], [1], [1, 1], [2, 1], [0, "1"], [0, float("nan")], [0, 10**400], [0, 1, 2]]
)
def test_a_range_that_is_none_is_left_out(span):
    found = stored.checked(a_summary(ranges={"mean_curvature": span, "shape_index": [-1, 1]}))
    assert found["ranges"] == {"shape_index": [-1.0, 1.0]}


def test_of_a_drawing_only_what_is_sound_is_kept():
    row = {"map": "no such map", "diverging": 1, "neutral": "zero", "radius": float("inf"), "unit": 5, "more": 1}
    found = stored.checked(a_summary(drawn={"mean_curvature": row, "shape_index": 3}))
    assert found["drawn"] == {"mean_curvature": {"diverging": 1}}


def test_a_mesh_with_a_damaged_property_is_read_without_an_error():
    bpy = pytest.importorskip("bpy", reason="needs Blender")
    from paradesc import bridge
    from paradesc_blender.scene import record
    from paradesc_blender.show import channels, recolor

    mesh = bpy.data.meshes.new("damaged")
    mesh[record.PROPERTY] = a_summary(ranges={}, layout={"topology": 3})
    mesh[channels.OWN] = {"attributes": 5, "groups": ["a"]}
    assert record.layout_of(mesh) == {}
    assert channels.own_names(mesh, "attributes") == []
    assert channels.own_names(mesh, "groups") == ["a"]
    with pytest.raises(bridge.ParadescError, match="bake it again"):
        recolor.stored_range(mesh, "mean_curvature")
    bpy.data.meshes.remove(mesh)
