"""Prints what sharing out costs: a library in one process, in several, and by Dask, also with a worker that is killed.

Usage: bash tests/farms.sh [--assets 2000] [--keep FOLDER]
Ends with 1 if the arrays of any way differ, or an asset is lost or computed twice.
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile
import threading
import time
from contextlib import nullcontext
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent / "addon"))

from libraries import all_hash, dask_workers, make_library, process_environment, rows_of, waited_for
from paradesc.commands import assets

STEPS = (3, 4, 5, 6, 8)


def say(text: str) -> None:
    """Prints at once."""
    sys.stdout.write(text + "\n")
    sys.stdout.flush()


def run(library: Path, output: Path, words: list[str]) -> dict:
    """Runs the command as a process; gives its report."""
    report = output.with_suffix(".json")
    program = [sys.executable, "-m", "paradesc", "library", str(library), "-o", str(output), "--json", str(report)]
    started = time.monotonic()
    subprocess.run([*program, "--quiet", *words], env=process_environment(), check=True)
    return {**json.loads(report.read_text()), "wall": time.monotonic() - started}


def by_dask(library: Path, folder: Path, name: str, workers: int, killed: bool) -> dict:
    """Runs the command on so many workers, of which the first is killed once a third is done."""
    output = folder / name
    count = sum(1 for _ in library.rglob("*.obj"))
    with dask_workers(folder / f"dask_{name}", workers) as (file, processes):
        if killed:
            done = lambda: sum(1 for _ in output.rglob("*.npz")) > count // 3  # noqa: E731
            threading.Thread(target=lambda: (waited_for(done, 600), processes[0].kill())).start()
        return run(library, output, ["--dask", str(file)])


def line(name: str, cores: int, report: dict, output: Path) -> str:
    """One row of the table: overhead is what each asset took of the cores in use beside its computing."""
    rows = [row for row in rows_of(output).values() if row["status"] == "ok"]
    computing = sum(row["seconds"]["compute"] for row in rows)
    spent = report["seconds"]["run"] * cores
    computing = computing if report["made"] else 0.0
    each = [1000 * seconds / len(rows) for seconds in (computing, spent - computing)]
    shown = f"{report['wall']:.1f} | {each[0]:.1f} | {each[1]:.1f}"
    return f"| {name} | {len(rows)} | {report['made']} | {shown} | {all_hash(output)[:16]} |"


def main() -> int:
    """Prints the table; whether all ways agree."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--assets", type=int, default=2000)
    parser.add_argument("--keep", type=Path, help="use this folder and leave it there")
    arguments = parser.parse_args()
    with nullcontext(arguments.keep) if arguments.keep else tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        folder.mkdir(parents=True, exist_ok=True)
        library = make_library(folder / "library", arguments.assets, STEPS)
        cores = len(os.sched_getaffinity(0))
        say(f"{arguments.assets} assets, {cores} cores, load {os.getloadavg()[0]:.2f}")
        say("| run | assets | computed | s | computing, ms an asset | beside it, ms an asset | hash of all arrays |")
        say("| --- | ---: | ---: | ---: | ---: | ---: | --- |")
        ways = [("one process, one core", 1, ["--workers", "1", "--threads", "1"])]
        ways += [("one process, all cores", cores, ["--workers", "1"])]
        ways += [("processes, one a core", cores, ["--workers", str(cores)])]
        for title, used, words in ways:
            output = folder / title.replace(" ", "_").replace(",", "")
            say(line(title, used, run(library, output, words), output))
        say(line("the same again", cores, run(library, output, ways[-1][2]), output))
        for workers, killed in ((1, False), (2, False), (3, False), (3, True)):
            title = f"Dask, {workers} workers" + (", one killed" if killed else "")
            name = title.replace(" ", "_").replace(",", "")
            report = by_dask(library, folder, name, workers, killed)
            say(line(title, min(workers, cores), report, folder / name))
        outputs = [path.parent for path in folder.glob("*/library.jsonl")]
        hashes = {all_hash(path) for path in outputs}
        counts = {len(rows_of(path)) for path in outputs}
        names = {assets.RESULTS: {len(list(path.rglob("*.npz"))) for path in outputs}}
    same = len(hashes) == 1 and counts == {arguments.assets} and names == {assets.RESULTS: counts}
    say("all ways give the same arrays of every asset" if same else f"DIFFERENT: {hashes} {counts} {names}")
    return 0 if same else 1


if __name__ == "__main__":
    sys.exit(main())
