"""paradesc library: rows, what is kept, failures, and the same bits in one process, in many, by parts and by Dask."""

import hashlib
import json
import multiprocessing
import os
import signal
import subprocess
import sys
import threading
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

from conftest import blender_program
from libraries import (
    all_hash,
    dask_workers,
    hashes_of,
    make_library,
    process_environment,
    rows_of,
    waited_for,
)
from paradesc.commands import assets, spreading
from paradesc.commands.main import main
from paradesc.core.distributions import BINS, distribution
from shapes import cube_sphere, write_obj

QUICK = ("--radius", "0.2", "--samples", "16", "--backend", "cpu")


@pytest.fixture
def library(tmp_path):
    """A folder of seven assets."""
    return make_library(tmp_path / "library", 7)


def compute(library, output, *words, code=0):
    """Runs the command in this process; gives its report."""
    path = output.with_suffix(".report.json")
    words = words if "--workers" in words or "--dask" in words else ["--workers", "1", *words]
    assert main(["library", str(library), "-o", str(output), *QUICK, "--json", str(path), "--quiet", *words]) == code
    return json.loads(path.read_text())


def as_process(library, output, *words):
    """The words that run the command in a process of its own."""
    if blender_program():
        pytest.skip("runs in Python, not in Blender")
    return [sys.executable, "-m", "paradesc", "library", *map(str, (library, "-o", output)), *QUICK, *words]


# ---- Rows


def test_a_row_says_what_the_results_are(library, tmp_path):
    report = compute(library, tmp_path / "out", "--descriptors", "mean_curvature,principal_direction_max")
    rows = rows_of(tmp_path / "out")
    assert (report["assets"], report["made"], report["kept"], report["failed"]) == (7, 7, 0, [])
    assert sorted(rows) == sorted(path.relative_to(library).as_posix() for path in library.rglob("*.obj"))
    assert list(rows) == sorted(rows)
    for name, row in rows.items():
        assert row["status"] == "ok"
        assert row["content_hash"] == hashlib.sha256((library / name).read_bytes()).hexdigest()
        assert row["results"] == f"results/{name}.npz"
        (one,) = row["objects"]
        with np.load(tmp_path / "out" / row["results"]) as file:
            values = file["mean_curvature"].astype(np.float64)
            assert file["principal_direction_max"].shape == (len(values), 3)
            assert one["coverage"]["mean"] == pytest.approx(file["coverage"].mean())
        described = one["descriptors"]["mean_curvature"]
        assert described["mean"] == pytest.approx(values.mean())
        assert described["minimum"] == values.min()
        assert described["percentiles"]["50"] == pytest.approx(np.median(values))
        assert "histogram" not in one["descriptors"]["principal_direction_max"]
    assert hashes_of(tmp_path / "out")


def test_a_loose_vertex_does_not_hide_the_coverage_of_an_asset(tmp_path):
    one = tmp_path / "in" / "one.obj"
    one.parent.mkdir()
    one.write_text("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 9 9 9\nf 1 2 3\nf 1 3 4\n", encoding="utf-8")
    compute(one.parent, tmp_path / "out")
    (described,) = rows_of(tmp_path / "out")["one.obj"]["objects"]
    assert described["coverage"] == {"mean": 1.0, "minimum": 1.0}


def test_a_row_warns_of_a_radius_that_shows_facets(library, tmp_path):
    compute(library, tmp_path / "out", "--radius-unit", "mean-edge", "--radius", "0.9")
    for row in rows_of(tmp_path / "out").values():
        assert "The radius is only 0.9 of the mean edge" in row["warnings"][-1]
        assert row["notes"] == []


def test_histogram_counts_every_value_once():
    values = np.concatenate([np.random.default_rng(1).normal(size=5000), [np.nan, np.inf]]).astype(np.float32)
    found = distribution(values)
    bars = found["histogram"]
    assert len(bars["counts"]) == BINS
    assert sum(bars["counts"]) + bars["below"] + bars["above"] == 5000
    assert bars["below"] == bars["above"] == 50
    finite = values[:5000].astype(np.float64)
    wanted, _ = np.histogram(finite, BINS, (bars["minimum"], bars["maximum"]))
    assert np.abs(np.array(bars["counts"]) - wanted).sum() <= 2  # a value on an edge
    same = distribution(np.full(10, 3.0, np.float32))["histogram"]
    assert (same["counts"][0], sum(same["counts"]), same["minimum"]) == (10, 10, 3.0)
    assert distribution(np.full(3, np.nan, np.float32))["histogram"] is None


def test_several_meshes_of_a_file_are_several_objects(library, tmp_path):
    points, quads, _ = cube_sphere(3)
    lines = []
    for name in ("sphere", "other"):
        first = 1 + len(points) * len(lines)
        lines.append(f"o {name}\n")
        lines[-1] += "".join("v {} {} {}\n".format(*point) for point in points)
        lines[-1] += "".join("f {} {} {} {}\n".format(*quad) for quad in quads + first)
    (library / "two.obj").write_text("".join(lines))
    compute(library, tmp_path / "out")
    row = rows_of(tmp_path / "out")["two.obj"]
    assert [one["object"] for one in row["objects"]] == ["sphere", "other"]
    with np.load(tmp_path / "out" / row["results"]) as file:
        np.testing.assert_array_equal(file["sphere/mean_curvature"], file["other/mean_curvature"])


# ---- What is kept


def stamps(output):
    """When each result was written."""
    return {path: path.stat().st_mtime_ns for path in (output / "results").rglob("*.*")}


def test_a_second_run_does_nothing_and_a_changed_file_is_computed_anew(library, tmp_path):
    output = tmp_path / "out"
    compute(library, output)
    before, listing = stamps(output), (output / "library.jsonl").read_bytes()
    path = library / "set_1" / "asset_0001.obj"
    os.utime(path)  # newer, but the same
    assert compute(library, output)["made"] == 0
    assert stamps(output) == before
    assert (output / "library.jsonl").read_bytes() == listing
    write_obj(path, *cube_sphere(2, radius=3.0))
    assert compute(library, output)["made"] == 1
    changed = {path.name for path, time in stamps(output).items() if before[path] != time}
    assert changed == {"asset_0001.obj.npz", "asset_0001.obj.json"}
    assert compute(library, output, "--samples", "8")["made"] == 7
    assert compute(library, output, "--samples", "8", "--force")["made"] == 7


def test_results_that_are_gone_or_cut_off_are_computed_again(library, tmp_path):
    output = tmp_path / "out"
    compute(library, output)
    before = hashes_of(output)
    results = sorted((output / "results").rglob("*.npz"))
    results[0].unlink()
    results[1].write_bytes(results[1].read_bytes()[:100])
    results[2].with_suffix(".json").write_text("{")
    assert compute(library, output)["made"] == 3
    assert hashes_of(output) == before


def test_a_folder_that_cannot_be_read_is_no_library_without_its_assets(library, tmp_path, capfd, monkeypatch):
    listed = os.scandir

    def refused(path):
        if str(path).endswith("set_1"):
            raise PermissionError(13, "Permission denied", str(path))
        return listed(path)

    monkeypatch.setattr(os, "scandir", refused)
    assert main(["library", str(library), "-o", str(tmp_path / "out"), *QUICK, "--workers", "1"]) == 3
    assert f'The folder "{library / "set_1"}" cannot be read: Permission denied.' in capfd.readouterr().err
    assert not (tmp_path / "out").exists()


def test_a_run_that_is_killed_between_arrays_and_row_leaves_no_row_of_former_arrays(library, tmp_path, monkeypatch):
    output, words = tmp_path / "out", ("--asset", "set_0/asset_0000.obj")
    compute(library, output)
    before = hashes_of(output)

    def killed(*_given):
        raise KeyboardInterrupt

    with monkeypatch.context() as patched:
        patched.setattr(assets, "write_row", killed)
        compute(library, output, *words, "--radius", "0.3", code=130)
    assert compute(library, output)["made"] == 1
    assert hashes_of(output) == before


def test_buffers_beside_a_gltf_belong_to_its_content(tmp_path):
    path = tmp_path / "a.gltf"
    path.write_text(json.dumps({"buffers": [{"uri": "a.bin"}, {"uri": "data:;base64,AA=="}]}))
    (tmp_path / "a.bin").write_bytes(b"one")
    first = assets.content_hash(path)
    (tmp_path / "a.bin").write_bytes(b"two")
    assert assets.content_hash(path) != first


# ---- Failures


def test_failures_are_rows_and_nothing_else_is_lost(library, tmp_path, capfd):
    (library / "empty.obj").write_text("")
    (library / "noise.ply").write_bytes(b"\x00\xff" * 50)
    report = compute(library, tmp_path / "out", code=5)
    said = capfd.readouterr().err
    assert said.startswith('paradesc: 2 of 9 assets could not be computed, "')
    assert said.count("\n") == 1
    rows = rows_of(tmp_path / "out")
    assert {name: row["exit_code"] for name, row in rows.items() if row["exit_code"]} == {
        "empty.obj": 3,
        "noise.ply": 3,
    }
    assert "it is empty" in rows["empty.obj"]["error"]
    assert {row["file"] for row in report["failed"]} == {"empty.obj", "noise.ply"}
    again = compute(library, tmp_path / "out", code=5)
    assert (again["made"], again["kept"]) == (0, 9)
    assert compute(library, tmp_path / "out", "--allow-failures")["made"] == 0


def test_an_asset_that_fails_has_no_results_of_an_earlier_run(library, tmp_path):
    output = tmp_path / "out"
    compute(library, output)
    (library / "set_1" / "asset_0001.obj").write_text("")
    compute(library, output, code=5)
    assert not (output / "results" / "set_1" / "asset_0001.obj.npz").exists()
    assert len(list((output / "results").rglob("*.npz"))) == 6
    assert rows_of(output)["set_1/asset_0001.obj"]["status"] == "failed"


def test_one_asset_is_counted_in_the_singular(library, tmp_path, capsys):
    words = ["library", str(library), "-o", str(tmp_path / "out"), "--asset", "set_1/asset_0001.obj", *QUICK]
    assert main([*words, "--workers", "1", "--radius", "0.001"]) == 0
    said = capsys.readouterr().out
    assert "1 asset: 1 computed, 0 kept, 0 of them failed\n" in said
    assert "note: Warnings are in the rows of 1 asset.\n" in said


def test_a_failure_of_the_machine_is_tried_again_and_never_allowed(library, tmp_path, monkeypatch):
    def fails(*_):
        raise MemoryError("no memory")

    with monkeypatch.context() as patch:
        patch.setattr(assets, "bake", fails)
        report = compute(library, tmp_path / "out", "--allow-failures", code=5)
    assert {row["error"] for row in report["failed"]} == {"Unexpected MemoryError: no memory"}
    assert compute(library, tmp_path / "out")["made"] == 7


@pytest.mark.parametrize(
    ("words", "code", "said"),
    [
        (["--part", "3/2"], 2, "is not a part"),
        (["--part", "1/2", "--asset", "set_0/asset_0000.obj"], 2, "not both"),
        (["--asset", "missing.obj"], 3, "There is no file"),
        (["--workers", "0"], 2, "at least 1"),
        (["--scene-settings"], 2, "no scene"),
        (["--descriptors", "wobbliness"], 2, "wobbliness"),
        pytest.param(["--dask", "tcp://127.0.0.1:1"], 4, "no Dask scheduler", marks=pytest.mark.slow),
    ],
)
def test_what_makes_no_sense_is_refused_in_one_sentence(library, tmp_path, capfd, monkeypatch, words, code, said):
    monkeypatch.setattr(spreading, "CONNECTING", 0.5)
    if "--dask" in words:
        pytest.importorskip("distributed", reason="Dask is not installed")
    else:
        words = ["--workers", "1", *words] if "--workers" not in words else words
    assert main(["library", str(library), "-o", str(tmp_path / "out"), *words]) == code
    found = [line for line in capfd.readouterr().err.splitlines() if line.startswith("paradesc: ")]
    assert len(found) == 1
    assert said in found[0]


# ---- The same bits however it is split


def test_parts_and_single_assets_make_what_one_run_makes(library, tmp_path):
    compute(library, tmp_path / "whole")
    output = tmp_path / "parts"
    done = [compute(library, output, "--part", f"{part}/3")["made"] for part in (1, 2, 3)]
    assert sum(done) == 7
    assert max(done) < 7
    assert not (output / "library.jsonl").exists()
    assert compute(library, output)["made"] == 0
    assert hashes_of(output) == hashes_of(tmp_path / "whole")
    one = compute(library, tmp_path / "one", "--asset", "set_2/asset_0002.obj", "--threads", "1")
    assert one["made"] == 1
    assert len(list((tmp_path / "one").rglob("*.npz"))) == 1


@pytest.mark.slow
def test_a_process_that_is_killed_takes_no_asset_with_it(library, tmp_path):
    if blender_program():
        pytest.skip("runs in Python, not in Blender")
    compute(library, tmp_path / "whole")
    work = assets.Work(library, tmp_path / "out", *of_report(tmp_path / "whole.report.json"))
    names = sorted(rows_of(tmp_path / "whole"))
    killed = []

    def kill():
        children = multiprocessing.active_children()
        if not killed and children and (tmp_path / "out").exists():
            children[0].kill()
            killed.append(children[0])

    rows = {done.row["file"]: done.row for done in spreading.on_processes(work, names, 2, kill)}
    assert killed
    assert {name: row["results_hash"] for name, row in rows.items()} == hashes_of(tmp_path / "whole")


def of_report(path):
    """The settings and their key that a report has."""
    from paradesc import bridge
    from paradesc.core import job

    options = bridge.Options(radius=0.2, samples=16)
    settings = job.Settings(options=options, backend="cpu")
    key = json.loads(path.read_text())["settings_key"]
    assert key == assets.key_of(settings)
    return settings, key


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="only Linux lists the children of a process as a file")
def test_the_processes_of_a_run_that_is_killed_end_too(tmp_path):
    library = make_library(tmp_path / "library", 60, (6,))
    process = subprocess.Popen(as_process(library, tmp_path / "out", "--workers", "2"), env=process_environment())
    waited_for(lambda: len(list((tmp_path / "out").rglob("*.npz"))) >= 3)
    children = Path(f"/proc/{process.pid}/task/{process.pid}/children").read_text().split()
    assert len(children) >= 2
    process.kill()
    process.wait(60)
    waited_for(lambda: not any(Path(f"/proc/{child}").exists() for child in children))


@pytest.mark.slow
def test_a_run_that_is_stopped_goes_on_where_it_was(tmp_path):
    library = make_library(tmp_path / "library", 60, (6,))
    compute(library, tmp_path / "whole")
    output = tmp_path / "out"
    words = as_process(library, output, "--workers", "2")
    process = subprocess.Popen(words, env=process_environment(), stderr=subprocess.PIPE, text=True)
    waited_for(lambda: len(list(output.rglob("*.npz"))) >= 3)
    process.send_signal(signal.SIGTERM)
    assert process.communicate(timeout=60)[1] == "paradesc: Terminated.\n"
    assert process.returncode == 143
    left = compute(library, output)
    assert 0 < left["made"] < 60
    assert hashes_of(output) == hashes_of(tmp_path / "whole")


def test_a_window_loses_no_name():
    with ThreadPoolExecutor(2) as pool:
        found = list(spreading.windowed(lambda name: pool.submit(str, name), list(map(str, range(50))), 4, lambda: None))
    assert [name for name, _ in found] == [future.result() for _, future in found]
    assert sorted((name for name, _ in found), key=int) == list(map(str, range(50)))


@pytest.mark.slow
def test_dask_computes_the_same_bits_though_a_worker_is_killed(tmp_path, monkeypatch):
    pytest.importorskip("distributed", reason="Dask is not installed")
    if blender_program():
        pytest.skip("runs in Python, not in Blender")
    library = make_library(tmp_path / "library", 40, (10, 14))
    compute(library, tmp_path / "whole")
    output = tmp_path / "out"
    monkeypatch.setattr(spreading, "WINDOW", 12)
    there = []

    def kill(worker):
        waited_for(lambda: len(list(output.rglob("*.npz"))) >= 5)
        worker.kill()
        there.extend(output.rglob("*.npz"))

    with dask_workers(tmp_path / "dask", 2) as (file, workers):
        killer = threading.Thread(target=kill, args=workers[:1])
        killer.start()
        report = compute(library, output, "--dask", str(file))
        killer.join()
    assert 5 <= len(there) < 40
    assert (report["assets"], report["failed"]) == (40, [])
    assert len(rows_of(output)) == 40
    assert all_hash(output) == all_hash(tmp_path / "whole")
