"""Reports and corners never take the place of another file of their command."""

import io
import json
import os
import threading

import numpy as np
import pytest


@pytest.mark.parametrize("command", ["bake", "animate", "compare", "info"])
def test_report_never_takes_the_place_of_the_input(run, sphere_obj, command):
    before = sphere_obj.read_bytes()
    ended = run(command, sphere_obj, "--json", sphere_obj)
    assert (ended.code, sphere_obj.read_bytes()) == (2, before)
    assert "is the input" in ended.error


@pytest.mark.parametrize("option", ["--from-file", "--displacement", "--normal-map", "--preset", "--corners", "-o"])
def test_report_never_takes_the_place_of_another_file_of_the_command(run, sphere_obj, tmp_path, option):
    other = tmp_path / {"-o": "other.npz"}.get(option, "other.png")
    other.write_bytes(b"kept")
    ended = run("bake", sphere_obj, option, other, "-o", tmp_path / "out.npz", "--json", other)
    assert (ended.code, other.read_bytes()) == (2, b"kept")
    assert "is the input or an output; choose another file for the report." in ended.error


@pytest.mark.parametrize("words", [("animate", ".", "--cache", "cache"), ("library", ".", "--output", "out")])
def test_report_never_takes_the_place_of_a_mesh_of_a_folder(run, sphere_obj, words):
    before = sphere_obj.read_bytes()
    ended = run(*words, "--json", sphere_obj)
    assert (ended.code, sphere_obj.read_bytes()) == (2, before)
    assert "is a mesh; choose another file for the report." in ended.error


def test_corners_never_take_the_place_of_the_values(run, sphere_obj, tmp_path):
    ended = run("bake", sphere_obj, "--descriptors", "harris", "-o", "out.npz", "--corners", "out.npz")
    assert ended.code == 2
    assert "is an output already; choose another file for the corners." in ended.error
    assert not (tmp_path / "out.npz").exists()


def test_report_never_takes_the_place_of_the_listing_of_a_library(run, sphere_obj, tmp_path):
    assert run("library", ".", "--output", "out", "--workers", 1).code == 0
    listing = tmp_path / "out" / "library.jsonl"
    before = listing.read_bytes()
    ended = run("library", ".", "--output", "out", "--json", "out/../out/library.jsonl")
    assert (ended.code, listing.read_bytes()) == (2, before)
    assert "is the input or an output; choose another file for the report." in ended.error


@pytest.mark.parametrize(
    "words",
    [
        ("--list", "named", "library", ".", "--output", "out"),
        ("library", ".", "--output", "out", "--list", "named"),
        ("--bundle", ".", "library", ".", "--output", "out"),
        ("animate", "named", "--frames", "1:9", "--cache", "cache"),
    ],
)
def test_report_on_tasks_never_takes_the_place_of_another_file(run, sphere_obj, tmp_path, words):
    name = "parameter_values.yaml" if "--bundle" in words else "named"
    (tmp_path / name).write_bytes(b"kept")
    ended = run("tasks", "--json", name, *words)
    assert (ended.code, (tmp_path / name).read_bytes()) == (2, b"kept")
    assert "is the input or an output; choose another file for the report." in ended.error


def test_list_of_tasks_never_takes_the_place_of_the_scene(run, tmp_path):
    (tmp_path / "shot.blend").write_bytes(b"kept")
    ended = run("tasks", "--list", "shot.blend", "animate", "shot.blend", "--frames", "1:9", "--cache", "cache")
    assert (ended.code, (tmp_path / "shot.blend").read_bytes()) == (2, b"kept")
    assert "is the input or an output; choose another file for the list." in ended.error


def test_corners_never_take_the_place_of_the_preset(run, sphere_obj, tmp_path):
    path = tmp_path / "look.json"
    path.write_text('{"paradesc_preset": 1, "name": "Look", "settings": {"descriptors": ["harris"]}}')
    before = path.read_bytes()
    ended = run("bake", sphere_obj, "--preset", path, "-o", "out.npz", "--corners", path)
    assert (ended.code, path.read_bytes()) == (2, before)
    assert "is the input; add --force to write over it, or choose another name." in ended.error


def test_a_report_that_is_named_as_a_folder_is_refused(run, sphere_obj):
    for name in (".", "", ".."):
        ended = run("info", sphere_obj, "--json", name)
        assert (ended.code, "is a folder" in ended.error) == (2, True), ended.error


@pytest.mark.skipif(os.name == "nt", reason="Windows has no pipes with names in folders")
def test_outputs_go_into_pipes_that_are_there(run, sphere_obj, tmp_path):
    read = {}
    paths = [tmp_path / "report.json", tmp_path / "values.npz"]
    readers = [threading.Thread(target=lambda path=path: read.update({path: path.read_bytes()})) for path in paths]
    for path, reader in zip(paths, readers, strict=True):
        os.mkfifo(path)
        reader.start()
    assert run("bake", sphere_obj, "-o", paths[1], "--json", paths[0]).code == 0
    for path, reader in zip(paths, readers, strict=True):
        reader.join(60)
        assert path.is_fifo()
    assert json.loads(read[paths[0]])["status"] == "ok"
    assert "mean_curvature" in np.load(io.BytesIO(read[paths[1]]))


@pytest.mark.skipif(os.name == "nt", reason="links need rights on Windows")
def test_outputs_go_where_a_link_points(run, sphere_obj, tmp_path):
    (tmp_path / "store").mkdir()
    for name in ("there.npz", "new.npz"):
        (tmp_path / name).symlink_to(tmp_path / "store" / name)
    (tmp_path / "store" / "there.npz").write_bytes(b"before")
    assert run("bake", sphere_obj, "-o", "there.npz", "-o", "new.npz").code == 0
    for name in ("there.npz", "new.npz"):
        assert (tmp_path / name).is_symlink()
        assert "mean_curvature" in np.load(tmp_path / "store" / name)
    assert len(list(tmp_path.rglob("*.npz"))) == 4
