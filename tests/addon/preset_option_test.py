"""The option --preset: files, names, what goes before what, and what is refused."""

import pytest

bpy = pytest.importorskip("bpy", reason="needs Blender")

from preset_files import SOUND, own_folder, written  # noqa: E402
from scene import add_sphere, saved_scene  # noqa: E402

QUICK = ("--buffer", "128", "--backend", "software", "--output", "out.ply", "--json", "report.json")


def test_a_preset_file_supplies_what_no_option_gives(run, report, sphere_obj, tmp_path):
    path = written(tmp_path, settings={**SOUND["settings"], "radius_percent": 8, "samples": 32, "more_radii": ""})
    ended = run("bake", sphere_obj, "--preset", path, *QUICK)
    assert ended.code == 0, ended.error
    found = report()
    settings = found["settings"]
    assert set(settings["descriptors"]) == {"cavity", "convexity"}
    assert (settings["radius"], settings["samples"], settings["texels"]) == (0.08, 32, 2048)
    assert settings["harris_k"] == 0.04
    shown = found["objects"][0]["descriptors"]["cavity"]
    assert (shown["shown_minimum"], shown["shown_maximum"], shown["color_map"]) == (-0.5, 0.75, "heat")
    assert found["notes"] == ['The preset "Studio Cavity" names image_format, which has no effect here.']
    words = ("--descriptors", "cavity", "--samples", "16", "--radius", "0.1", "--texels", "64", "--range=0:1")
    assert run("bake", sphere_obj, "--preset", path, *words, "--color-map", "grey", *QUICK).code == 0
    found = report()
    settings = found["settings"]
    assert (settings["descriptors"], settings["samples"], settings["radius"]) == (["cavity"], 16, 0.1)
    assert settings["texels"] == 64
    shown = found["objects"][0]["descriptors"]["cavity"]
    assert (shown["shown_minimum"], shown["shown_maximum"], shown["color_map"]) == (0.0, 1.0, "grey")


def test_a_preset_goes_before_the_settings_of_the_scene(registered, run, report, tmp_path):
    add_sphere(steps=6)
    scene = bpy.context.scene
    scene.paradesc.backend, scene.paradesc.seed, scene.paradesc.texels = "software", 5, 64
    scene.paradesc_looks.color_map = "grey"
    blend = saved_scene(tmp_path / "scene.blend")
    path = written(tmp_path, settings={"descriptors": ["cavity"], "samples": 32}, image=None)
    words = ("--scene-settings", "--preset", path, "--buffer", "128", "--output", "out.ply", "--json", "report.json")
    assert run("bake", blend, *words).code == 0
    settings = report()["settings"]
    assert (settings["backend"], settings["seed"], settings["samples"], settings["texels"]) == ("software", 0, 32, 64)
    assert report()["objects"][0]["descriptors"]["cavity"]["color_map"] == "heat"
    written(tmp_path, settings=None, image=None)
    assert run("bake", blend, *words).code == 0
    assert report()["settings"]["seed"] == 5


def test_a_preset_is_found_by_its_name_among_the_users_own(run, report, sphere_obj, monkeypatch, tmp_path):
    written(own_folder(monkeypatch, tmp_path), settings={"descriptors": ["cavity"], "samples": 24})
    assert run("bake", sphere_obj, "--preset", "studio cavity", *QUICK).code == 0
    assert report()["settings"]["samples"] == 24
    ended = run("bake", sphere_obj, "--preset", "nobody", *QUICK)
    assert ended.code == 2
    assert "edge_wear" in ended.error
    assert "Studio Cavity" in ended.error


def test_frames_take_a_preset_and_say_what_they_have_no_use_for(run, report, tmp_path):
    add_sphere(steps=4)
    blend = saved_scene(tmp_path / "scene.blend")
    path = written(
        tmp_path, settings={"descriptors": ["cavity"], "samples": 24, "buffer_size": 128}, colors={"span": "auto"}
    )
    words = ("--frames", "1:1", "--cache", "frames", "--backend", "software", "--json", "report.json")
    ended = run("animate", blend, "--preset", path, *words)
    assert ended.code == 0, ended.error
    assert report()["settings"]["samples"] == 24
    assert report()["notes"] == ['The preset "Studio Cavity" names image_format, span, which have no effect here.']


@pytest.mark.parametrize("command", ["bake", "animate", "compare"])
def test_a_faulty_preset_ends_with_the_code_of_inputs_and_one_sentence(run, sphere_obj, tmp_path, command):
    path = written(tmp_path, settings={"samples": 3})
    output = ("--output", "out.npz") if command == "bake" else ()
    ended = run(command, sphere_obj, "--preset", path, *output)
    assert (ended.code, ended.output) == (3, "")
    assert (
        ended.error
        == f'paradesc: The preset file "{path}" has 3 as "samples" in settings; give a whole number from 8 to 4096.\n'
    )
    path.write_text("{")
    assert run(command, "missing.obj", "--preset", path, *output).error.startswith(
        f'paradesc: The preset file "{path}" is'
    )
