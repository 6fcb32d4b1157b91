"""Every viewport gets back what it showed before a bake."""

from types import SimpleNamespace

import pytest

pytest.importorskip("bpy", reason="needs Blender")

from paradesc.scene import viewports  # noqa: E402


class Screen(dict):
    """A screen with two 3D viewports between others."""

    def __init__(self):
        self.areas = [self.area("VIEW_3D", "MATERIAL"), self.area("CONSOLE"), self.area("VIEW_3D", "RANDOM")]
        self.areas.append(self.area("VIEW_3D", "VERTEX"))

    def area(self, kind, color_type=""):
        items = [SimpleNamespace(identifier=name) for name in ("MATERIAL", "RANDOM", "SINGLE", "VERTEX")]
        rna = SimpleNamespace(properties={"color_type": SimpleNamespace(enum_items=items)})
        shading = SimpleNamespace(type="SOLID", color_type=color_type, bl_rna=rna)
        return SimpleNamespace(type=kind, spaces=SimpleNamespace(active=SimpleNamespace(shading=shading)))

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


def test_a_viewport_that_was_set_since_stays_and_old_files_are_read():
    screen = Screen()
    for _, shading in viewports.shadings(screen):
        viewports.show_attributes(screen, shading)
    screen.areas[0].spaces.active.shading.color_type = "SINGLE"
    viewports.restore(screen)
    assert screen.shown() == ["SINGLE", "RANDOM", "VERTEX"]
    screen[viewports.FORMER] = "MATERIAL"
    viewports.restore(screen)
    assert screen.shown() == ["SINGLE", "RANDOM", "MATERIAL"]
