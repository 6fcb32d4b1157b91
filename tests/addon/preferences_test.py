"""The add-on's preferences: what holds for this machine, whatever scene is open."""

from types import SimpleNamespace

import pytest

bpy = pytest.importorskip("bpy", reason="needs Blender")

from paradesc_blender.scene import record  # noqa: E402
from paradesc_blender.settings import preferences as settings_preferences  # noqa: E402
from paradesc_blender.settings import properties, research  # noqa: E402
from scene import add_sphere, small_bake  # noqa: E402

pytestmark = pytest.mark.usefixtures("registered")


@pytest.fixture
def preferences():
    """The preferences of the add-on as if it were enabled."""
    addon = bpy.context.preferences.addons.new()
    addon.module = "paradesc_blender"
    yield addon.preferences
    bpy.context.preferences.addons.remove(addon)


def test_without_a_limit_the_library_takes_its_own(preferences):
    assert preferences.memory_limit == 0
    assert properties.job_settings(bpy.context.scene.paradesc).memory_limit == 0


def test_a_limit_refuses_the_bake_in_one_sentence_and_is_no_part_of_the_scene(preferences):
    target = add_sphere()
    small_bake()
    preferences.memory_limit = 0.001
    with pytest.raises(RuntimeError, match="memory limit"):
        bpy.ops.paradesc.bake()
    assert not record.attributes_of(target.data)
    preferences.memory_limit = 2.5
    settings = properties.job_settings(bpy.context.scene.paradesc)
    assert settings.memory_limit == 2_500_000_000
    assert "memory_limit" not in settings.as_dict()
    assert bpy.ops.paradesc.bake() == {"FINISHED"}


class Drawn:
    """A layout that notes texts and addresses."""

    def __init__(self):
        self.texts, self.addresses = [], []

    def row(self, **_options):
        return self

    split = column = row

    def prop(self, preferences, name):
        self.texts.append(preferences.bl_rna.properties[name].name)

    def label(self, text, **_options):
        self.texts.append(text)

    def operator(self, name, text="", **_options):
        self.texts.append(text)
        asked = SimpleNamespace(url="")
        if name == "wm.url_open":
            self.addresses.append(asked)
        return asked


def drawn(memory_limit=0.0):
    layout, cls = Drawn(), settings_preferences.PARADESC_AP_preferences
    cls.draw(SimpleNamespace(layout=layout, memory_limit=memory_limit, bl_rna=cls.bl_rna), None)
    return layout


def test_research_settings_are_hidden_until_the_preference_is_on(preferences):
    group = bpy.context.scene.paradesc
    assert research.is_hidden(group, "seed")
    assert not research.is_hidden(group, "samples")
    assert bpy.ops.paradesc.show_research() == {"FINISHED"}
    assert preferences.research_settings
    assert not research.is_hidden(group, "seed")


def test_a_frame_source_acts_as_soon_as_it_is_chosen():
    group = bpy.context.scene.paradesc_animation
    assert research.changed(bpy.context.scene) == []
    group.frame_source = "deformed"
    assert [name for _, name in research.changed(bpy.context.scene)] == ["frame_source"]
    assert bpy.ops.paradesc.reset_research() == {"FINISHED"}
    assert research.changed(bpy.context.scene) == []


def test_the_preferences_say_that_memory_is_automatic_and_where_to_read():
    shown = drawn()
    assert {"Show Results", "Research Settings", "Automatic", "Documentation"} <= set(shown.texts)
    assert "Automatic" not in drawn(memory_limit=2.0).texts


@pytest.mark.parametrize(
    ("address", "texts"),
    [
        ("https://codeberg.org/someone/paradesc/", ["Documentation", "Website", "Report a Bug"]),
        ("https://example.org/paradesc", ["Documentation", "Website"]),
        ("", ["Documentation"]),
    ],
)
def test_buttons_lead_to_the_addresses_of_the_manifest(monkeypatch, address, texts):
    monkeypatch.setattr(settings_preferences, "website", lambda: address)
    shown = drawn()
    assert [text for text in shown.texts if text in ("Documentation", "Website", "Report a Bug")] == texts
    assert [asked.url for asked in shown.addresses] == [address, f"{address}issues"][: len(texts) - 1]


def test_without_the_add_on_enabled_there_is_none():
    assert properties.job_settings(bpy.context.scene.paradesc).memory_limit == 0
