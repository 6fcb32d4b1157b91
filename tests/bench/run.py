"""Times the engine on the CPU against the baseline and other programs.

    .venv/bin/python tests/bench/run.py --quick --json FILE      # the ratios that are asked for, in some ten minutes
    .venv/bin/python tests/bench/run.py --quick --page           # and tests/bench/REPORT.md, its plot, README's table
    .venv/bin/python tests/bench/run.py --sweep detail --sweep charts --page
    .venv/bin/python tests/bench/run.py --quick --sweep models --json FILE     # with the ratios of this sweep

FILE has the CPU, the date, the commit and one key for each ratio (null with a reason if a part is missing),
and the parts themselves. A sweep takes minutes, and writes results/<sweep>.json; --page puts together all that are
there. Other programs on the machine make every figure worthless, so the file also has the load before the run.
"""

import argparse
import json
import os
import sys
import time
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
sys.path[:0] = [str(ROOT / "addon"), str(HERE.parent / "accuracy"), str(HERE)]

import bench as accuracy_bench  # noqa: E402
import figures  # noqa: E402
import page  # noqa: E402
import parts  # noqa: E402
import peer_parts  # noqa: E402
import report  # noqa: E402
import speed_page  # noqa: E402
import sweeps  # noqa: E402


def parse(words: list[str] | None) -> argparse.Namespace:
    """Parses the words of the command line."""
    lines = __doc__.splitlines()
    parser = argparse.ArgumentParser(
        description=lines[0], epilog="\n".join(lines[1:]), formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--quick", action="store_true", help="measure the ratios")
    names = ", ".join(f"{name} ({row.minutes} min)" for name, row in sweeps.SWEEPS.items())
    parser.add_argument("--sweep", action="append", default=[], choices=sweeps.SWEEPS, help=f"measure a sweep: {names}")
    parser.add_argument("--json", type=Path, help="where the ratios go")
    parser.add_argument(
        "--page",
        action="store_true",
        help="write REPORT.md, the plot, README's and the manual's table from all results",
    )
    parser.add_argument("--no-peers", action="store_true", help="leave other programs out")
    parser.add_argument(
        "--build", type=Path, default=ROOT / "build", help="folder of the native programs (default: build)"
    )
    parser.add_argument("--scale", type=float, default=1.0, help="of the meshes: to try the script; no figures")
    parser.add_argument("--results", type=Path, default=HERE / "results", help=argparse.SUPPRESS)
    arguments = parser.parse_args(words)
    if not (arguments.quick or arguments.sweep or arguments.page):
        parser.error("say what to do: --quick, --sweep or --page")
    if arguments.json and not arguments.quick:
        parser.error("--json is for --quick")
    return arguments


def about(run: parts.Run, command: str) -> dict[str, object]:
    """Says on which engine, where and when this was measured."""
    return {
        "device": run.bench.context.device,
        **where_and_when(command),
    }


def where_and_when(command: str) -> dict[str, object]:
    """Says by which command, when and on which processor something is measured, and what it had to do before."""
    return {
        "cpu": accuracy_bench.cpu_model(),
        "cores": os.cpu_count(),
        "load_before": round(os.getloadavg()[0], 2),
        "date": page.today(),
        "commit": report.commit(),
        "command": command,
    }


def quick(run: parts.Run, with_peers: bool) -> None:
    """Measures everything of which the ratios are made."""
    arrays = parts.bunny(run)
    parts.detail(run, 100_000, "detail_100k")
    parts.detail(run, 1_000_000, "detail_1m")
    parts.detail(run, 2_000_000, "detail_2m")
    parts.radius(run)
    parts.together(run)
    parts.memory(run)
    parts.first_bake(run)
    parts.blender(run, arrays)
    if with_peers:
        peer_parts.others(run, arrays)
    if "models" not in run.measured:
        run.reasons["models"] = "--sweep models measures it."


def content(run: parts.Run, stamp: dict[str, object]) -> dict[str, object]:
    """The content of the JSON file."""
    values, why = figures.figures(run.measured, run.reasons)
    return {
        **stamp,
        "load_after": round(os.getloadavg()[0], 2),
        **values,
        "reasons": why | {name: text for name, text in run.reasons.items() if name not in figures.FIGURES},
        "beside": figures.beside(run.measured),
        "part_seconds": {name: round(seconds, 1) for name, seconds in run.seconds.items()},
        "part_cpu_seconds": {name: round(seconds, 1) for name, seconds in run.cpu_seconds.items()},
        "measured": run.measured,
    }


def show(found: dict[str, object]) -> None:
    """Prints the ratios beside their targets."""
    for name, figure in figures.FIGURES.items():
        value = found[name]
        wanted = f"{'≥' if figure.at_least else '≤'} {figure.target:g}"
        state = "–" if value is None else "met" if figure.met(value) else "missed"
        shown = found["reasons"].get(name, "") if value is None else f"{value:g}"
        sys.stdout.write(f"{name:30} {shown:>10}   {wanted:8} {state}\n")
    for name, value in found["beside"].items():
        sys.stdout.write(f"{name:40} {value:g}\n")


def write_pages(results: Path) -> None:
    """Writes REPORT.md, and the tables of README.md and the manual if the results are those that are kept."""
    speed_page.write(results, ROOT if results == HERE / "results" else None)


def main(words: list[str] | None = None) -> int:
    """Measures what is asked for."""
    arguments = parse(words)
    start = time.monotonic()
    results = arguments.results
    results.mkdir(exist_ok=True)
    command = "python tests/bench/run.py " + " ".join(sys.argv[1:] if words is None else words)
    if arguments.quick or arguments.sweep:
        with parts.open_run(arguments) as run:
            stamp = about(run, command.strip())
            for name in arguments.sweep:
                sweeps.measure(name, run, stamp, results)
            if arguments.quick:
                quick(run, not arguments.no_peers)
                found = content(run, stamp)
                text = json.dumps(found, indent=1, ensure_ascii=False) + "\n"
                kept = results / speed_page.QUICK
                for path in {arguments.json or kept, *([kept] if arguments.page else [])}:
                    path.write_text(text)
                show(found)
    if arguments.page:
        write_pages(results)
    parts.say(f"{time.monotonic() - start:.0f} s in all\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
