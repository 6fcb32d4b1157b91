"""Preset files: saved, shared, checked before use and never executed; the command line."""

import json
import os
import random
import time
from types import SimpleNamespace

import pytest

bpy = pytest.importorskip("bpy", reason="needs Blender")

from paradesc.bridge import ParadescError  # noqa: E402
from paradesc.core import members  # noqa: E402
from paradesc.files import preset_file, preset_rules  # noqa: E402
from paradesc_blender.settings import presets  # noqa: E402
from preset_files import SOUND, own_folder, written  # noqa: E402
from scene import measure_curvature  # noqa: E402

pytestmark = pytest.mark.usefixtures("registered")

# Changes of a sound file, and a part of the sentence about each.
FAULTS = {
    "paradesc_preset": [(None, "is missing"), (2, "update the add-on"), ("1", "where the version 1 belongs"),
                        (True, "where the version 1 belongs"), (0, "where the version 1 belongs")],
    "name": [(None, 'has no "name"'), (" ", 'has no "name"'), (7, "not a line of at most 60"), ("a\nb", "not a line of"),
             ("x" * 61, "not a line of"), ("\ud800", "not a line of")],
    "purpose": [(["a"], "not a line of at most 500")],
    "settings": [([], "that is not an object"), ({"samples": 3}, "from 8 to 4096"), ({"samples": 99.5}, "a whole number"),
                 ({"samples": True}, "a whole number"), ({"samples": None}, "a whole number from 8"),
                 ({"samples": {"a": [1]}}, "a whole number"), ({"descriptors": [["cavity"]]}, "a list of some of"),
                 ({"descriptors": []}, "a list of some of"), ({"descriptors": ["wobble"]}, "a list of some of"),
                 ({"descriptors": "cavity"}, "a list of some of"), ({"normals": "odd"}, "one of fitted, max, mesh"),
                 ({"normals": ["max"]}, "one of fitted"), ({"radius_percent": 200}, "from 0.01 to 100"),
                 ({"radius_percent": "2"}, "a number"), ({"radius_absolute": 1e39}, "a number from 1e-06"),
                 ({"more_radii": "wide"}, "is not a positive number"), ({"more_radii": 3}, "a line of at most"),
                 ({"backend": "gpu"}, "which is not a setting"), ({"image_path": "/x"}, "which is not a setting"),
                 ({"samples": 10**40}, "a whole number from 8 to 4096")],
    "colors": [({"percentile": 49.5}, "from 0 to 49"), ({"symmetric": 1}, "true or false"),
               ({"show_legend": True}, "which is not a setting"), ({"span": "fixed", "minimum": 2}, "not above 2")],
    "image": [({"texels": 8}, "from 16 to 8192"), ({"image_path": "//x.exr"}, "which is not a setting"),
              ({"write_image": True}, "which is not a setting")],
    "script": [("import os", "which is unknown")],
}  # fmt: skip
BYTES = {
    b"": "not JSON in line 1",
    b"{": "not JSON in line 1",
    b"[]": "is not a preset of Paradesc",
    b'{"paradesc_preset": 1, "name": "a"}': "sets nothing",
    b'{"paradesc_preset": 1, "name": "a", "name": "b"}': '"name" twice',
    b'{"paradesc_preset": 1, "name": "a", "colors": {"minimum": NaN}}': 'NaN as "minimum" in colors; give a number',
    b'{"paradesc_preset": 1, "name": "a", "colors": {"minimum": -Infinity}}': "give a number",
    b'{"paradesc_preset": 1, "name": "a", "colors": {"minimum": 1e999}}': "give a number",
    b"[" * 500_000: "nested too deeply",
    b'{"paradesc_preset": 1, "name": "\xff"}': "no JSON in UTF-8",
    json.dumps(SOUND).encode("utf-16"): "no JSON in UTF-8",
    b" " * 1_000_001: "larger than 1 MB",
    b"import os\nos.system('x')": "not JSON in line 1",
}


@pytest.fixture
def own(monkeypatch, tmp_path):
    """An empty folder in place of the user's own presets."""
    return own_folder(monkeypatch, tmp_path)


@pytest.fixture
def preferences():
    """The preferences of the add-on as if it were enabled."""
    addon = bpy.context.preferences.addons.new()
    addon.module = "paradesc_blender"
    yield addon.preferences
    bpy.context.preferences.addons.remove(addon)


def state():
    """Everything that a preset could set, and more."""
    scene = bpy.context.scene
    groups = (scene.paradesc, scene.paradesc_looks)
    return [
        (name, value if not isinstance(value := getattr(group, name), set) else sorted(value))
        for group in groups
        for name in group.bl_rna.properties.keys()  # noqa: SIM118
        if name != "rna_type"
    ]


def refused(path):
    """The sentence of a file that cannot be used; nothing is changed."""
    before = state()
    with pytest.raises(RuntimeError) as caught:
        bpy.ops.paradesc.load_preset(filepath=str(path))
    assert state() == before
    return str(caught.value).removeprefix("Error: ").strip()


def drawn():
    """The presets that the menu lists: text, and whether it can be chosen. Below them one saves and one removes."""
    lines = []

    class Layout:
        enabled = True

        def row(self):
            return Layout()

        def separator(self):
            lines.append("---")

        def operator(self, _operator, text, **_options):
            line = SimpleNamespace(text=text, layout=self)
            lines.append(line)
            return line

    presets.PARADESC_MT_presets.draw(SimpleNamespace(layout=Layout()), bpy.context)
    *listed, line, save, remove = [line if line == "---" else (line.text, line.layout.enabled) for line in lines]
    assert (line, *save) == ("---", "Save as Preset…", True)
    assert remove == ("Remove This Preset", bool(presets.chosen))
    return listed


# ---- Saved and applied


def test_own_presets_are_kept_applied_and_removed(own):
    scene = bpy.context.scene
    scene.paradesc.descriptors, scene.paradesc.radius_percent = {"curvedness", "cavity"}, 1.1
    scene.paradesc_looks.color_map, scene.paradesc_looks.neutral = "heat", 0.1
    scene.paradesc.texels, scene.paradesc.backend, scene.paradesc.image_path = 128, "reference", "//mine.exr"
    before = state()
    assert bpy.ops.paradesc.add_preset(name="Mine: über/alles", purpose="For all") == {"FINISHED"}
    (path,) = own.iterdir()
    assert path.name == "Mine_über_alles.json"
    content = json.loads(path.read_text())
    assert (content["name"], content["purpose"]) == ("Mine: über/alles", "For all")
    assert content["settings"]["descriptors"] == ["cavity", "curvedness"]
    assert (content["settings"]["radius_percent"], content["colors"]["neutral"]) == (1.1, 0.1)
    textures = {"image_outside": "neutral", "image_packed": False, "image_to_material": False}
    assert content["image"] == {"image_format": ".exr", "texels": 128, **textures}
    assert not {"backend", "image_path", "write_image"} & {*content["settings"], *content["colors"], *content["image"]}
    bpy.ops.paradesc.preset(name="corners")
    scene.paradesc.texels = 256
    assert bpy.ops.paradesc.load_preset(filepath=str(path)) == {"FINISHED"}
    assert state() == before
    assert presets.PARADESC_MT_presets.bl_label == "Mine: über/alles"
    assert bpy.ops.paradesc.add_preset(remove_active=True) == {"FINISHED"}
    assert not list(own.iterdir())
    assert presets.PARADESC_MT_presets.bl_label == "Presets"


def test_a_preset_of_the_same_name_is_replaced_and_one_called_alike_is_not(own):
    for name in ("a b", "a_b", "a b", "A B"):
        bpy.ops.paradesc.add_preset(name=name)
    assert sorted(path.name for path in own.iterdir()) == ["A_B_3.json", "a_b.json", "a_b_2.json"]
    bpy.ops.paradesc.add_preset(name="a_b", remove_name=True)
    assert sorted(path.name for path in own.iterdir()) == ["A_B_3.json", "a_b.json"]


@pytest.mark.parametrize(
    ("name", "stem"),
    [("../../etc/passwd", "etc_passwd"), ("CON", "CON_"), ("com1", "com1_"), ("...", "preset"), ("ü" * 60, "ü" * 50)],
)
def test_names_become_names_of_files_that_are_safe_everywhere(name, stem):
    assert preset_file.file_stem(name) == stem


def test_what_cannot_be_saved_or_removed_is_one_sentence(own, tmp_path):
    with pytest.raises(RuntimeError, match="Give the preset a name"):
        bpy.ops.paradesc.add_preset(name="  ")
    with pytest.raises(RuntimeError, match="Choose a preset of your own"):
        bpy.ops.paradesc.add_preset(remove_active=True)
    with pytest.raises(RuntimeError, match='no preset "other" of your own'):
        bpy.ops.paradesc.add_preset(name="other", remove_name=True)
    bpy.context.scene.paradesc.more_radii = "wide"
    with pytest.raises(RuntimeError, match="More Radii is not a positive number"):
        bpy.ops.paradesc.add_preset(name="mine")
    shared = written(tmp_path)
    bpy.ops.paradesc.load_preset(filepath=str(shared))
    with pytest.raises(RuntimeError, match="not one of your presets"):
        bpy.ops.paradesc.add_preset(remove_active=True)
    assert shared.is_file()
    assert not list(own.iterdir())


def test_what_a_file_does_not_name_gets_its_default_and_sections_that_are_missing_stay(tmp_path):
    scene = bpy.context.scene
    scene.paradesc.seed, scene.paradesc_looks.percentile, scene.paradesc.texels = 7, 9.0, 64
    bpy.ops.paradesc.load_preset(filepath=str(written(tmp_path, colors=None, image=None)))
    assert (scene.paradesc.seed, scene.paradesc.samples, scene.paradesc.texels) == (0, 99, 64)
    assert scene.paradesc_looks.percentile == 9.0
    scene.paradesc.seed = 7
    bpy.ops.paradesc.load_preset(filepath=str(written(tmp_path, settings=None)))
    assert (scene.paradesc.seed, scene.paradesc.texels, scene.paradesc.image_format) == (7, 2048, ".png")
    assert (scene.paradesc_looks.percentile, scene.paradesc_looks.color_map) == (2.5, "heat")


def test_our_own_presets_say_colors_and_images_too(monkeypatch):
    scene = bpy.context.scene
    preset = preset_file.Content("Mask", "A mask", {"samples": 32}, {"color_map": "grey"}, {"texels": 1024})
    monkeypatch.setitem(presets.PRESETS, "cavity", preset)
    scene.paradesc_looks.color_map, scene.paradesc_looks.percentile = "heat", 9.0
    bpy.ops.paradesc.preset(name="cavity")
    assert (scene.paradesc.samples, scene.paradesc.texels) == (32, 1024)
    assert (scene.paradesc_looks.color_map, scene.paradesc_looks.percentile) == ("grey", 2.5)


def test_all_of_our_own_presets_are_sound(tmp_path):
    for name, preset in presets.PRESETS.items():
        path = tmp_path / f"{name}.json"
        preset_file.write(path, preset)
        assert preset_rules.sound(path) == preset


# ---- Refused


@pytest.mark.parametrize(
    ("key", "value", "words"), [(key, *case) for key, cases in FAULTS.items() for case in cases], ids=str
)
def test_what_is_wrong_is_one_sentence_and_changes_nothing(tmp_path, key, value, words):
    path = written(tmp_path, **{key: value})
    sentence = refused(path)
    assert words in sentence
    assert sentence.startswith(f'The preset file "{path}" ')
    assert sentence.endswith(".")


@pytest.mark.parametrize(("content", "words"), BYTES.items(), ids=range(len(BYTES)))
def test_files_that_are_no_presets_at_all_are_one_sentence(tmp_path, content, words):
    path = tmp_path / "preset.json"
    path.write_bytes(content)
    assert words in refused(path)


def test_files_that_cannot_be_read_are_one_sentence(tmp_path):
    assert "is not there" in refused(tmp_path / "none.json")
    assert "is a folder" in refused(tmp_path)
    os.mkfifo(tmp_path / "pipe.json")
    assert "is not there" in refused(tmp_path / "pipe.json")
    assert "is not there" in refused(tmp_path / ("x" * 300 + ".json"))


def test_what_the_system_refuses_of_a_preset_is_one_sentence(own, monkeypatch):
    def fails(*_words, **_more):
        raise OSError(5, "Input/output error")

    path = written(own)
    monkeypatch.setattr(type(path), "open", fails)
    assert "cannot be read: Input/output error" in refused(path)


@pytest.mark.slow
def test_damaged_files_give_the_one_error_or_are_sound_and_never_anything_else(tmp_path):
    source, random_numbers = json.dumps(SOUND).encode(), random.Random(1)
    pieces = [b'"', b"{", b"}", b"[", b"]", b":", b",", b"NaN", b"1e999", b"-", b"null", b"\\ud800", b"\x00", b"\xff"]
    path, before, refusals = tmp_path / "damaged.json", state(), 0
    for _ in range(2000):
        content = bytearray(source)
        for _ in range(random_numbers.randint(1, 4)):
            place = random_numbers.randrange(len(content))
            end = place + random_numbers.choice((0, 1, 1, 8))
            content[place:end] = random_numbers.choice([*pieces, bytes([random_numbers.randrange(256)])])
        path.write_bytes(content)
        try:
            found = preset_rules.sound(path)
        except preset_file.PresetError as error:
            assert "\n" not in error.sentence  # noqa: PT017
            error.sentence.encode()
            refusals += 1
        else:
            presets.apply(bpy.context.scene, found)
            whole = preset_file.Content("all", settings={"radius_fit": "medium"}, colors={})
            presets.apply(bpy.context.scene, whole)
            for name in members.output_members():
                bpy.context.scene.paradesc.property_unset(name)
            measure_curvature()
        assert state() == before
    assert 1000 < refusals < 2000


# ---- Folders and the menu


def test_the_menu_lists_ours_then_the_users_then_those_of_the_shared_folder(own, preferences, tmp_path):
    shared = tmp_path / "studio"
    shared.mkdir()
    preferences.presets_folder = str(shared)
    written(own, "z.json", name="zebra")
    written(own, "b.json", name="Ape")
    written(shared)
    (shared / "broken.json").write_text("{")
    (shared / "notes.txt").write_text("no preset")
    ours = [(preset.name, True) for preset in presets.PRESETS.values()]
    listed = [*ours, "---", ("Ape", True), ("zebra", True), "---", ("broken.json", False), ("Studio Cavity", True)]
    assert drawn() == listed
    asked = SimpleNamespace(filepath=str(shared / "broken.json"))
    assert "is not JSON in line 1" in presets.PARADESC_OT_load_preset.description(bpy.context, asked)
    asked.filepath = str(shared / "preset.json")
    assert presets.PARADESC_OT_load_preset.description(bpy.context, asked) == SOUND["purpose"]


def test_an_open_menu_reads_no_file_twice_and_sees_what_has_changed(own, monkeypatch):
    read, path = [], written(own)
    whole = preset_rules.sound
    monkeypatch.setattr(preset_rules, "sound", lambda path: read.append(path) or whole(path))
    for _ in range(3):
        drawn()
    drawn()
    assert read == [path]
    path.write_text("{")
    os.utime(path, ns=(time.time_ns(), time.time_ns() + 10**9))
    assert drawn()[-1] == ("preset.json", False)


def test_folders_that_are_missing_or_closed_leave_the_menu_whole(own, preferences, tmp_path):
    preferences.presets_folder = str(tmp_path / "nowhere")
    own.rmdir()
    assert drawn() == [(preset.name, True) for preset in presets.PRESETS.values()]


def test_only_presets_raise_the_error_of_presets():
    assert issubclass(preset_file.PresetError, ParadescError)
