"""Folders of small assets, their rows, and Dask's scheduler and workers as processes."""

import hashlib
import json
import os
import subprocess
import sys
import time
from contextlib import contextmanager

import numpy as np

from shapes import ADDON, cube_sphere, write_obj


def make_library(folder, count, steps=(2, 3, 4)):
    """Ellipsoids of a few sizes in folders below this one; every one is another shape."""
    for index in range(count):
        points, quads, uvs = cube_sphere(steps[index % len(steps)])
        points = points * np.random.default_rng(index).uniform(0.5, 2.0, 3)
        path = folder / f"set_{index % 3}" / f"asset_{index:04}.obj"
        path.parent.mkdir(parents=True, exist_ok=True)
        write_obj(path, points, quads, uvs)
    return folder


def rows_of(output):
    """The rows of a library by file."""
    lines = (output / "library.jsonl").read_text(encoding="utf-8").splitlines()
    rows = [json.loads(line) for line in lines]
    found = {row["file"]: row for row in rows}
    assert len(found) == len(rows)
    return found


def hashes_of(output):
    """The hash of each asset's arrays, as the files are."""
    found = {}
    for name, row in rows_of(output).items():
        content = (output / row["results"]).read_bytes()
        assert hashlib.sha256(content).hexdigest() == row["results_hash"]
        found[name] = row["results_hash"]
    return found


def all_hash(output):
    """One hash of all assets' arrays."""
    return hashlib.sha256(json.dumps(sorted(hashes_of(output).items())).encode()).hexdigest()


def process_environment():
    """The environment in which other processes find the package."""
    return {**os.environ, "PYTHONPATH": str(ADDON)}


def started(words, log):
    """A process whose output goes to a file."""
    with log.open("w") as file:
        return subprocess.Popen(
            list(map(str, words)), env=process_environment(), stdin=subprocess.DEVNULL, stdout=file, stderr=file
        )


def waited_for(condition, seconds=60):
    """Waits until something is true."""
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end, "waited in vain"
        time.sleep(0.01)


@contextmanager
def dask_workers(folder, count):
    """A scheduler and workers of one thread each, which nobody starts again: the scheduler file and the processes."""
    folder.mkdir(parents=True, exist_ok=True)
    file = folder / "scheduler.json"
    program = [sys.executable, "-m"]
    ends = ["--scheduler-file", file, "--no-dashboard"]
    scheduler = [*program, "distributed.cli.dask_scheduler", "--port", "0", "--host", "127.0.0.1", *ends]
    processes = [started(scheduler, folder / "scheduler.log")]
    try:
        waited_for(file.is_file)
        worker = [*program, "distributed.cli.dask_worker", "--nthreads", "1", "--no-nanny", "--local-directory", folder]
        processes += [started([*worker, *ends], folder / f"worker_{index}.log") for index in range(count)]
        yield file, processes[1:]
    finally:
        for process in processes:
            process.kill()
            process.wait()
