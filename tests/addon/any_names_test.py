"""Commands take names of any alphabet and length: output never fails for a console's alphabet, nor a run for a name."""

import json
import os
import subprocess
import sys
import unicodedata
from pathlib import Path

import numpy as np
import pytest

from paradesc import cli
from shapes import ADDON, cube_sphere, write_obj

NAME = "é猫😀.obj"
LONG = "x" * 300
BAKE = ("bake", "--reader", "files")
PROGRAM = (sys.executable, "-m", "paradesc")
# The modules of this Python, which Blender's own has not.
ALONE = {**os.environ, "PYTHONPATH": os.pathsep.join(map(str, (ADDON, Path(np.__file__).parents[1])))}


def run(folder, encoding, *words):
    """A command as a process whose streams have this alphabet."""
    variables = {**ALONE, "PYTHONIOENCODING": encoding, "PYTHONUTF8": "0"}
    return subprocess.run([*PROGRAM, *words], env=variables, cwd=folder, capture_output=True, timeout=120, check=False)


@pytest.mark.parametrize("encoding", ["cp1252", "ascii", "utf-8"])
def test_output_never_fails_for_the_alphabet_of_a_console(tmp_path, encoding):
    write_obj(tmp_path / NAME, *cube_sphere(4))
    read = ("--reader", "files")
    commands = [
        ("bake", NAME, "-o", "猫.ply", "-o", "猫.npz", *read),
        ("info", NAME, *read),
        ("info", NAME, "--json", "-", *read),
        ("compare", NAME, "--backend", "cpu", "--radius", "0.2", *read),
        ("animate", "é猫😀#.obj", "--cache", "c"),
        ("library", ".", "-o", "猫", "--workers", "1"),
        ("tasks", "library", ".", "-o", "猫"),
        ("tasks", "library", ".", "-o", "猫", "--list", "tasks.json"),
        ("bake", "没.obj", "-o", "o.npz", *read),
    ]
    for words in commands:
        done = run(tmp_path, encoding, *words)
        refused = {"没.obj": 3, "é猫😀#.obj": 3}.get(words[1], 0)
        assert done.returncode == refused, done.stderr
        assert b"Unexpected" not in done.stderr
        text = done.stdout.decode(encoding)
        if words[-2:] == ("--json", "-") or "-" in words:
            assert json.loads(text)["input"] == NAME
        if words[0] == "tasks" and "--list" not in words:
            assert json.loads(text.splitlines()[0])["name"] == NAME
    assert len(np.load(tmp_path / "猫.npz")["mean_curvature"]) == 98


@pytest.mark.skipif(os.name == "nt", reason="the shell of other systems closes the streams")
@pytest.mark.parametrize("closed", [">&-", "2>&-", ">&- 2>&-"])
def test_a_process_without_standard_streams_computes(tmp_path, closed):
    write_obj(tmp_path / "a.obj", *cube_sphere(4))
    program = [*PROGRAM, *BAKE, "-o", "a.npz"]
    for name, code in (("a.obj", 0), ("b.obj", 3)):
        words = ["sh", "-c", f'"$@" {closed}', "sh", *program, name]
        assert subprocess.run(words, cwd=tmp_path, env=ALONE, timeout=120, check=False).returncode == code
    assert (tmp_path / "a.npz").is_file()


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="this system has no full device")
def test_a_report_that_cannot_be_printed_is_one_sentence(tmp_path):
    words = [*PROGRAM, "list", "--json", "-"]
    with Path("/dev/full").open("wb") as full:
        done = subprocess.run(words, stdout=full, stderr=subprocess.PIPE, env=ALONE, timeout=120, check=False)
    assert done.returncode != 0
    assert b"Traceback" not in done.stderr


@pytest.mark.skipif(os.name == "nt" or sys.platform == "darwin", reason="names are bytes on Linux alone")
def test_a_name_that_is_no_text_is_written_in_reports(tmp_path):
    name = os.fsdecode(b"\xff.obj")
    write_obj(tmp_path / name, *cube_sphere(4))
    done = run(tmp_path, "utf-8", "bake", name, "-o", "o.npz", "--json", "r.json", "--reader", "files")
    assert (done.returncode, done.stderr) == (0, b"")
    assert json.loads((tmp_path / "r.json").read_text())["input"] == name
    done = run(tmp_path, "utf-8", "library", ".", "-o", "out", "--workers", "1")
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize(
    ("words", "code", "sentence"),
    [
        ((*BAKE, f"{LONG}.obj", "-o", "o.npz"), 3, "There is no file"),
        ((*BAKE, "a.obj", "-o", f"{LONG}.npz"), 2, "cannot be written: File name too long"),
        ((*BAKE, "a.obj", "--dump-buffers", LONG), 2, "cannot be written: File name too long"),
        ((*BAKE, "a.obj", "-o", "o.npz", "--json", f"{LONG}.json"), 2, "File name too long"),
        ((*BAKE, "a.obj", "-o", "o.npz", "--displacement", f"{LONG}.png"), 3, "There is no image"),
        ((*BAKE, "a.obj", "-o", "o.npz", "--preset", f"{LONG}.json"), 3, "is not there; choose another file"),
        ((*BAKE, "a.obj", "-o", "o.npz", "--from-file", f"{LONG}.obj"), 3, "There is no file"),
        (("animate", f"{LONG}.ply", "--cache", "c"), 3, ""),
        (("animate", f"{LONG}#.ply", "--cache", "c"), 3, "has a number in its name"),
        (("library", LONG, "-o", "out"), 3, "There is no folder"),
    ],
)  # fmt: skip
def test_a_name_that_is_too_long_is_one_sentence(tmp_path, monkeypatch, capsys, words, code, sentence):
    monkeypatch.chdir(tmp_path)
    write_obj(tmp_path / "a.obj", *cube_sphere(4))
    found = cli.main(list(words))
    said = capsys.readouterr().err
    assert "Unexpected" not in said
    assert sentence in said
    assert found == code, said


def test_a_name_that_just_fits_is_written(tmp_path):
    path = write_obj(tmp_path / "a.obj", *cube_sphere(4))
    out = tmp_path / ("猫" * 83 + ".npz")  # 253 bytes
    assert cli.main(["bake", str(path), "-o", str(out), "--quiet", "--reader", "files"]) == 0
    assert [item.name for item in tmp_path.iterdir() if item.name.startswith(".")] == []
    assert out.is_file()


def test_what_the_system_refuses_is_one_sentence(tmp_path, monkeypatch, capsys):
    path = write_obj(tmp_path / "a.obj", *cube_sphere(4))

    def fails(*_words):
        raise OSError(28, "No space left on device", "out.npz")

    monkeypatch.setattr("paradesc.commands.bake.bake_objects", fails)
    assert cli.main(["bake", str(path), "-o", str(tmp_path / "out.npz"), "--reader", "files"]) == 1
    assert capsys.readouterr().err == 'paradesc: "out.npz" cannot be used: No space left on device.\n'


@pytest.mark.skipif(os.name == "nt", reason="Windows has no limit for the size of a file")
@pytest.mark.parametrize("words", [("-o", "a.npz"), ("-o", "a.vtp"), ("--dump-buffers", "a", "--backend", "software")])
def test_a_disk_that_is_full_is_one_sentence(tmp_path, words):
    write_obj(tmp_path / "a.obj", *cube_sphere(8))
    limited = 'import resource, sys; resource.setrlimit(resource.RLIMIT_FSIZE, (4096, 4096)); sys.path[:0] = ["."]'
    script = f"{limited}\nfrom paradesc.cli import main\nsys.exit(main(sys.argv[1:]))"
    program = [sys.executable, "-c", script, *BAKE, "a.obj", *words]
    done = subprocess.run(program, cwd=tmp_path, env=ALONE, capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 1
    assert len(done.stderr.splitlines()) == 1, done.stderr
    assert "cannot be written: File too large." in done.stderr


# ---- UV maps that cannot be used


@pytest.mark.parametrize(
    ("line", "reason"),
    [("vt 0 0", "has a UV map without area"), ("vt nan 0", "has a UV map with coordinates that are not finite")],
)
def test_a_uv_map_that_cannot_be_used_is_told_from_none(tmp_path, capsys, line, reason):
    points, quads, _ = cube_sphere(4)
    path = write_obj(tmp_path / "a.obj", points, quads)
    text = path.read_text().replace("f ", f"{line}\nf ", 1)
    lines = [row if row[0] != "f" else row.replace(" ", "/1 ").replace("f/1", "f") + "/1" for row in text.splitlines()]
    path.write_text("\n".join(lines))
    words = ["bake", str(path), "--reader", "files", "--backend", "cpu"]
    assert cli.main([*words, "--map", str(tmp_path / "o.exr")]) == 3
    assert reason in capsys.readouterr().err
    assert cli.main([*words, "-o", str(tmp_path / "o.npz")]) == 0
    assert f'note: The mesh "sphere" {reason}, which was left out.' in capsys.readouterr().out


def test_an_object_is_found_by_its_name_however_accents_are_composed(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for form, other in (("NFC", "NFD"), ("NFD", "NFC")):
        name = unicodedata.normalize(form, "Würfel")
        path = tmp_path / "a.obj"
        write_obj(path, *cube_sphere(4))
        path.write_text(f"o {name}\n" + path.read_text().partition("\n")[2], encoding="utf-8")
        words = [*BAKE, "a.obj", "--object", unicodedata.normalize(other, name), "-o", f"{form}.npz"]
        assert cli.main(words) == 0
        assert "mean_curvature" in np.load(f"{form}.npz")
