"""Viewports show masks in flat light, and get back what they showed before a bake."""

from types import SimpleNamespace

import pytest

bpy = pytest.importorskip("bpy", reason="needs Blender")

from paradesc_blender.scene import node_groups, record, viewports  # noqa: E402
from scene import add_sphere  # noqa: E402


class Screen(dict):
    """A screen with two 3D viewports between others."""

    def __init__(self):
        self.areas = [self.area("VIEW_3D", "MATERIAL"), self.area("CONSOLE"), self.area("VIEW_3D", "RANDOM")]
        self.areas.append(self.area("VIEW_3D", "VERTEX"))

    def area(self, kind, color_type="", **more):
        items = [SimpleNamespace(identifier=name) for name in ("MATERIAL", "RANDOM", "SINGLE", "VERTEX")]
        lights = [SimpleNamespace(identifier=name) for name in ("STUDIO", "MATCAP", "FLAT")]
        switch = SimpleNamespace(type="BOOLEAN")
        properties = {
            "color_type": SimpleNamespace(type="ENUM", enum_items=items),
            "light": SimpleNamespace(type="ENUM", enum_items=lights),
            "show_cavity": switch,
            "show_shadows": switch,
        }
        values = {"light": "STUDIO", "show_cavity": False, "show_shadows": False, **more}
        shading = SimpleNamespace(
            type="SOLID", color_type=color_type, **values, bl_rna=SimpleNamespace(properties=properties)
        )
        return SimpleNamespace(type=kind, spaces=SimpleNamespace(active=SimpleNamespace(shading=shading)))

    def lights(self):
        return [area.spaces.active.shading.light for area in self.areas if area.type == "VIEW_3D"]

    def shown(self):
        return [area.spaces.active.shading.color_type for area in self.areas if area.type == "VIEW_3D"]


def test_every_viewport_gets_back_what_it_showed():
    screen = Screen()
    for _ in range(2):  # two bakes
        for _, shading in viewports.shadings(screen):
            viewports.show_attributes(screen, shading)
    assert screen.shown() == ["VERTEX"] * 3
    viewports.restore(screen)
    assert screen.shown() == ["MATERIAL", "RANDOM", "VERTEX"]


def test_a_viewport_that_was_set_since_stays():
    screen = Screen()
    for _, shading in viewports.shadings(screen):
        viewports.show_attributes(screen, shading)
    screen.areas[0].spaces.active.shading.color_type = "SINGLE"
    viewports.restore(screen)
    assert screen.shown() == ["SINGLE", "RANDOM", "VERTEX"]


def looks(shading):
    """The settings of a viewport that a bake changes."""
    return {name: getattr(shading, name) for name in viewports.PLAIN}


def test_masks_are_shown_in_flat_light_without_shadows_and_all_of_it_comes_back():
    screen = Screen()
    screen.areas[0] = screen.area("VIEW_3D", "MATERIAL", light="MATCAP", show_cavity=True, show_shadows=True)
    before = [looks(shading) for _, shading in viewports.shadings(screen)]
    for _, shading in viewports.shadings(screen):
        viewports.show_attributes(screen, shading)
        assert looks(shading) == viewports.PLAIN
    viewports.restore(screen)
    assert [looks(shading) for _, shading in viewports.shadings(screen)] == before


def test_a_light_that_was_chosen_since_stays():
    screen = Screen()
    shading = screen.areas[0].spaces.active.shading
    viewports.show_attributes(screen, shading)
    shading.light = "MATCAP"
    viewports.restore(screen)
    assert (shading.light, shading.color_type) == ("MATCAP", "MATERIAL")


def test_what_was_there_at_first_is_known_though_it_is_shown_again():
    screen = Screen()
    shading = screen.areas[0].spaces.active.shading
    viewports.show_attributes(screen, shading)
    shading.color_type = "SINGLE"  # somebody chooses another color, and the eye shows attributes again
    viewports.show_attributes(screen, shading)
    viewports.restore(screen)
    assert (shading.light, shading.color_type) == ("STUDIO", "SINGLE")


def test_who_sculpts_keeps_the_light_or_gets_it_back():
    screen = Screen()
    shading = screen.areas[0].spaces.active.shading
    viewports.show_attributes(screen, shading, viewports.LIT)
    assert (shading.light, shading.color_type) == ("STUDIO", "VERTEX")
    viewports.show_attributes(screen, shading)
    assert shading.light == "FLAT"
    viewports.show_attributes(screen, shading, viewports.LIT)
    assert shading.light == "STUDIO"
    viewports.restore(screen)
    assert (shading.light, shading.color_type) == ("STUDIO", "MATERIAL")


def test_a_viewport_that_was_split_off_gets_back_what_the_other_one_showed():
    screen = Screen()
    screen.areas[3] = screen.area("VIEW_3D", "VERTEX", light="FLAT")  # somebody's own
    for _, shading in viewports.shadings(screen):
        viewports.show_attributes(screen, shading)
    screen.areas.append(screen.area("VIEW_3D", "VERTEX", light="FLAT"))  # Blender adds it at the end, as a copy
    assert screen.lights() == ["FLAT"] * 4
    assert viewports.can_restore(SimpleNamespace(screen=screen))
    viewports.restore(screen)
    assert screen.shown() == ["MATERIAL", "RANDOM", "VERTEX", "MATERIAL"]
    assert screen.lights() == ["STUDIO", "STUDIO", "FLAT", "STUDIO"]
    assert not screen


def test_a_viewport_that_was_split_off_is_known_at_the_next_bake_and_one_that_is_new_stays():
    screen = Screen()
    for _, shading in viewports.shadings(screen):
        viewports.show_attributes(screen, shading)
    screen.areas.append(screen.area("VIEW_3D", "VERTEX", light="FLAT"))
    screen.areas.append(screen.area("VIEW_3D", "SINGLE", light="MATCAP"))
    for _, shading in viewports.shadings(screen):
        viewports.show_attributes(screen, shading)
    viewports.restore(screen)
    assert screen.shown() == ["MATERIAL", "RANDOM", "VERTEX", "MATERIAL", "SINGLE"]
    assert screen.lights()[-2:] == ["STUDIO", "MATCAP"]


def worn():
    """A sphere with a material in which our wear is; the material and the node."""
    material = bpy.data.materials.new("worn")
    material.use_nodes = True
    add_sphere("ball").data.materials.append(material)
    node = material.node_tree.nodes.new("ShaderNodeGroup")
    node.node_tree = node_groups.new_group("ShaderNodeTree", "Paradesc Wear")
    return material, node


def test_undo_of_wear_makes_viewports_solid_again_though_the_bake_before_stays_shown(registered, monkeypatch):
    material, node = worn()
    mesh = bpy.context.object.data
    mesh.attributes.new("cavity_color", "FLOAT_COLOR", "POINT")
    record.write(mesh, {}, {}, {}, ["cavity_color"])
    mesh.color_attributes.active_color = mesh.color_attributes["cavity_color"]
    screen = Screen()
    screen.name = "Layout"
    types = [shading for _, shading in viewports.shadings(screen)]
    types[0].type = types[1].type = "MATERIAL"
    screen[viewports.SOLID_BEFORE], screen[viewports.KNOWN] = [0], [0, 2, 3]
    window = SimpleNamespace(view_layer=bpy.context.view_layer, screen=screen)
    manager = SimpleNamespace(windows=[window])
    monkeypatch.setattr(viewports, "bpy", SimpleNamespace(context=SimpleNamespace(window_manager=manager)))
    viewports.before_undo()
    viewports.on_undo()  # of something else
    assert [one.type for one in types] == ["MATERIAL", "MATERIAL", "SOLID"]
    viewports.before_undo()
    material.node_tree.nodes.remove(node)
    viewports.on_undo()
    assert [one.type for one in types] == ["SOLID", "MATERIAL", "SOLID"]  # the second one was not ours
    assert screen[viewports.UNWORN] == [0]
    assert viewports.SOLID_BEFORE not in screen


def test_undo_of_something_else_leaves_materials_that_are_shown(registered):
    material, node = worn()
    window = SimpleNamespace(view_layer=bpy.context.view_layer, screen={viewports.SOLID_BEFORE: [0]})
    assert viewports.shows_ours(window)
    material.node_tree.nodes.remove(node)
    assert not viewports.shows_ours(window)


def test_colors_in_another_scene_count_in_the_window_that_shows_it(registered):
    scene = bpy.data.scenes.new("other")
    target = add_sphere("ball")
    bpy.context.collection.objects.unlink(target)
    scene.collection.objects.link(target)
    scene.view_layers[0].update()
    target.data.attributes.new("cavity_color", "FLOAT_COLOR", "POINT")
    record.write(target.data, {}, {}, {}, ["cavity_color"])
    target.data.color_attributes.active_color = target.data.color_attributes["cavity_color"]
    assert viewports.shows_ours(SimpleNamespace(view_layer=scene.view_layers[0], screen={}))
    assert not viewports.shows_ours(SimpleNamespace(view_layer=bpy.context.view_layer, screen={}))


def test_every_viewport_that_showed_materials_for_a_moment_is_solid_again(monkeypatch):
    screen = Screen()
    shading = [shading for _, shading in viewports.shadings(screen)]
    shading[0].type = "RENDERED"
    monkeypatch.setattr(viewports, "bpy", SimpleNamespace(app=SimpleNamespace(background=False)))
    monkeypatch.setattr(viewports.preferences, "shows_results", lambda: True)
    monkeypatch.setattr(viewports.image_preview, "hide", lambda: None)
    viewports.reveal_materials(SimpleNamespace(screen=screen))
    shading[0].type = "SOLID"  # somebody opens another one, and wear is set anew
    viewports.reveal_materials(SimpleNamespace(screen=screen))
    screen.areas.append(screen.area("VIEW_3D", "MATERIAL"))  # split off from the first one
    screen.areas[-1].spaces.active.shading.type = "MATERIAL"
    viewports.restore(screen)
    assert [one.type for _, one in viewports.shadings(screen)] == ["SOLID"] * 4
