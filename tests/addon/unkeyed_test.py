"""A value that was changed without a key is there again after a render or an export has evaluated animation."""

from types import SimpleNamespace

import pytest

bpy = pytest.importorskip("bpy", reason="needs Blender")

import deforming  # noqa: E402
from paradesc_blender.animation import painting  # noqa: E402
from scene import add_sphere  # noqa: E402

# The depsgraph of a render, which is not that of its view layer.
FOREIGN = SimpleNamespace(view_layer=SimpleNamespace(depsgraph=None))

pytestmark = pytest.mark.usefixtures("registered")


def number(target):
    deforming.bend(target)
    return lambda: target.modifiers["bend"], "angle", 1.25


def number_under_an_odd_name(target):
    target.modifiers.new('a.b["c"]', "SIMPLE_DEFORM")
    deforming.keyed(target.modifiers[0], "angle", 0.0, 2.5)
    return lambda: target.modifiers[0], "angle", 1.25


def number_of_a_strip(target):
    deforming.strip_of_the_nla(target)
    return lambda: target.modifiers["bend"], "angle", 1.25


def count(target):
    deforming.array(target)
    return lambda: target.modifiers["array"], "count", 7


def switch(target):
    deforming.modifier_that_appears(target)
    return lambda: target.modifiers["push"], "show_render", True


def choice(target):
    made = target.modifiers.new("deform", "SIMPLE_DEFORM")
    made.deform_method = "TWIST"
    made.keyframe_insert("deform_method", frame=deforming.FIRST)
    return lambda: made, "deform_method", "STRETCH"


def part_of_a_place(target):
    deforming.moving_object(target)
    return lambda: target.location, 2, 4.5


def part_of_a_vertex(target):
    deforming.moving_vertices(target)
    return lambda: target.data.vertices[3].co, 2, 4.5


def shape_key(target):
    deforming.shape_key(target)
    return lambda: target.data.shape_keys.key_blocks["pulled"], "value", 0.5


def own_property(target):
    deforming.driven_by_an_own_property(target)
    return lambda: target, '["push"]', 0.5


def own_property_under_an_odd_name(target):
    target['it"s.'] = 0.0
    target.keyframe_insert('["it\\"s."]', frame=deforming.FIRST)
    return lambda: target, '["it\\"s."]', 0.5


def part_of_an_own_property(target):
    target["three"] = [0.0, 1.0, 2.0]
    target.keyframe_insert('["three"]', frame=deforming.FIRST)
    return lambda: target["three"], 1, 0.5


def input_of_nodes(target):
    owner, name = deforming.nodes_with_a_keyframed_input(target)
    return lambda: owner, name, 0.5


CHANGES = [number, number_under_an_odd_name, number_of_a_strip, count, switch, choice, part_of_a_place]
CHANGES += [part_of_a_vertex, shape_key, own_property, own_property_under_an_odd_name, part_of_an_own_property]
CHANGES += [input_of_nodes]


def value_of(owner, name):
    """A property, a custom property, or a member of an array."""
    if isinstance(name, str):
        return owner.path_resolve(name) if name.startswith("[") else getattr(owner, name)
    return owner[name]


def change(owner, name, value):
    """Sets it, as somebody does by hand."""
    if isinstance(name, str) and not name.startswith("["):
        setattr(owner, name, value)
    else:
        owner[name if isinstance(name, int) else bpy.utils.unescape_identifier(name[2:-2])] = value


@pytest.mark.parametrize("changed", CHANGES)
def test_a_value_without_a_key_stays_until_another_frame(changed):
    scene, layer, target = bpy.context.scene, bpy.context.view_layer, add_sphere(steps=2)
    owner_of, name, value = changed(target)
    scene.frame_set(deforming.FIRST + 1)
    keyed = value_of(owner_of(), name)
    assert keyed != value
    change(owner_of(), name, value)
    layer.update()
    for _ in range(2):  # two renders
        painting.tag_written(target, FOREIGN)
        painting.tag_written(target, FOREIGN)  # of two frames each
        layer.update()
        assert value_of(owner_of(), name) == value
    painting.tag_written(target, FOREIGN)
    scene.frame_set(deforming.FIRST + 1)
    layer.update()
    assert value_of(owner_of(), name) == keyed
