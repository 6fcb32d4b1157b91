"""Files that follow the names of objects: whose they are, by a mark, and that no two objects share one."""

import unicodedata
from pathlib import Path

import pytest

bpy = pytest.importorskip("bpy", reason="needs Blender")

from paradesc.files import cache, file_names, marks  # noqa: E402
from paradesc_blender.scene import images  # noqa: E402
from paradesc_blender.settings import preset_folders  # noqa: E402
from scene import add_sphere  # noqa: E402
from writers import bake_image, file  # noqa: E402

pytestmark = pytest.mark.usefixtures("registered")


def test_a_file_saved_under_another_name_goes_on_with_its_textures(target, folder):
    bake_image(target)
    path = Path(bpy.data.filepath)
    bpy.ops.wm.save_as_mainfile(filepath=str(path.with_name("file_v2.blend")), check_existing=False)
    bake_image(target)
    assert [one.name for one in folder.glob("*.png")] == ["sphere_curvature.png"]


def test_the_sentence_says_which_texture_stays(target, folder, capfd):
    file("sphere_curvature.png")(target)
    bake_image(target)
    said = capfd.readouterr().out
    assert 'the texture is "sphere_2_curvature"' in said
    assert "sphere_2_curvature.png, 16 × 16" in said


def test_a_mark_says_whose_a_file_is_until_anything_in_it_changes(target, folder):
    bake_image(target)
    content = (folder / "sphere_curvature.png").read_bytes()
    assert marks.owner_of(content) == {"blend": "file.blend", "object": "sphere"}
    place = content.index(b"IDAT") + 20
    assert marks.owner_of(content[:place] + b"\0\1" + content[place + 2 :]) is None
    assert marks.owner_of(content + b"more") is None
    assert marks.owner_of(content[:-3]) is None
    again = marks.marked(content, {"blend": "b", "object": "Würfel"})
    assert marks.owner_of(again) == {"blend": "b", "object": "Würfel"}
    assert again.count(b"tEXtParadesc") == 1
    for odd in (b"", b"\x89PNG\r\n\x1a\n", b"\x89PNG\r\n\x1a\n" + b"\xff" * 40, b"GIF89a"):
        assert marks.owner_of(odd) is None


def test_names_that_some_file_system_takes_for_one_are_kept_apart():
    names = ["Wall_001", "wall_001", "Tür", unicodedata.normalize("NFD", "Tür"), "x" * 300, "x" * 301]
    found = file_names.distinct(names)
    assert len({unicodedata.normalize("NFC", name).casefold() for name in found}) == len(names)
    assert found[0] == "Wall_001"
    assert max(len(name.encode()) for name in found) < 200
    assert file_names.distinct(names) == found


def test_names_keep_letters_digits_and_marks_of_every_alphabet():
    for name in ("Würfel", "Été_2", "हिन्दी", "立方体", "куб", "κύβος", unicodedata.normalize("NFD", "Würfel")):
        assert file_names.plain(name) == name
    assert file_names.plain('a<b>:"/\\|?*.\t\x85©d') == "a_b" + 12 * "_" + "d"


def test_textures_are_named_with_letters_that_have_accents(target, folder):
    target.name = "Würfel"
    bake_image(target)
    bake_image(target)
    assert [path.name for path in folder.glob("*.png")] == ["Würfel_curvature.png"]


@pytest.mark.parametrize("packed", [False, True])
def test_textures_of_a_former_name_go_on_with_it(target, folder, monkeypatch, packed):
    if packed:
        bpy.ops.wm.read_homefile(use_empty=True)
        target = add_sphere()
    target.name = "Würfel"
    with monkeypatch.context() as before:
        before.setattr(file_names, "plain", bpy.path.clean_name)
        bake_image(target)
    bake_image(target)
    assert [path.name for path in folder.glob("*.png")] == ([] if packed else ["W_rfel_curvature.png"])
    (image,) = (image for image in bpy.data.images if image.get(images.OBJECT) == "Würfel")
    assert bpy.path.basename(image.filepath) == "W_rfel_curvature.png"


def test_a_linked_object_of_the_same_name_has_textures_of_its_own(target, folder):
    bpy.ops.wm.save_as_mainfile(filepath=str(folder / "library.blend"), copy=True, check_existing=False)
    with bpy.data.libraries.load(str(folder / "library.blend"), link=True) as (_, wanted):
        wanted.objects = ["sphere"]
    (linked,) = (item for item in bpy.data.objects if item.library is not None)
    bpy.context.collection.objects.link(linked)
    bake_image(target)
    bake_image(linked)
    bake_image(target)
    names = sorted(path.name for path in folder.glob("*.png"))
    assert names == ["sphere_2_curvature.png", "sphere_curvature.png"]


def test_frames_of_objects_that_differ_in_case_have_folders_apart(tmp_path):
    assert cache.object_folder(tmp_path, "Crate").name == "Crate"
    assert cache.object_folder(tmp_path, "crate", [tmp_path / "Crate"]).name.startswith("crate_")
    (tmp_path / "Crate").mkdir()
    assert cache.object_folder(tmp_path, "Crate").name == "Crate"
    assert cache.object_folder(tmp_path, "crate").name.startswith("crate_")
    for name in ("con", "AUX", "nul", "com1"):
        assert cache.object_folder(tmp_path, name).name.startswith(f"{name}_")


# ---- Presets


@pytest.fixture
def presets_folder(tmp_path, monkeypatch):
    monkeypatch.setattr(preset_folders, "own_folder", lambda create=False: tmp_path)
    return tmp_path


@pytest.mark.parametrize("other", ["Mine.json", "mine.JSON"])
def test_a_preset_is_saved_beside_files_that_are_none_of_that_name(other, presets_folder):
    (presets_folder / other).write_text("a list of things to do")
    assert bpy.ops.paradesc.add_preset(name="Mine") == {"FINISHED"}
    bpy.ops.paradesc.add_preset(name="mine")
    assert (presets_folder / other).read_text() == "a list of things to do"
    assert len(list(presets_folder.iterdir())) == 3
    bpy.ops.paradesc.add_preset(name="Mine")
    assert len(list(presets_folder.iterdir())) == 3
