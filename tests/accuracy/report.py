"""Measures the accuracy of the descriptors, and writes a page with tables and plots beside the paper's figures.

    .venv/bin/python tests/accuracy/report.py --output tests/accuracy/REPORT.md [--quick] [--sections closed,reference]

Every section writes a JSON file and its pictures beside the page, in results/ (results-quick/ with --quick). Sections
that are not asked for are taken from there, so one can be measured again alone. Plots need matplotlib; without it one
sentence says so, and the tables are still there.
"""

import argparse
import subprocess
import sys
import time
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
sys.path[:0] = [str(ROOT / "addon"), str(HERE)]

import bench  # noqa: E402
import page  # noqa: E402
import sections_engines  # noqa: E402
import sections_models  # noqa: E402
import sections_rough  # noqa: E402
import sections_settings  # noqa: E402
import sections_surfaces  # noqa: E402

from paradesc import bridge  # noqa: E402

# name: (function, title, part of the paper, seconds on two cores of a desktop processor with llvmpipe, quick)
SECTIONS = {
    **sections_surfaces.SECTIONS,
    **sections_rough.SECTIONS,
    **sections_models.SECTIONS,
    **sections_settings.SECTIONS,
    **sections_engines.SECTIONS,
}


def parse(words):
    names = ", ".join(f"{name} ({row[3]} s, quick {row[4]} s)" for name, row in SECTIONS.items())
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0], epilog=f"Sections: {names}.")
    parser.add_argument(
        "--output", type=Path, default=HERE / "REPORT.md", help="the page (default: tests/accuracy/REPORT.md)"
    )
    parser.add_argument("--quick", action="store_true", help="fewer surfaces, models and settings: some two minutes")
    parser.add_argument("--sections", default="", metavar="A,B", help="measure these only (default: all)")
    arguments = parser.parse_args(words)
    arguments.chosen = [name.strip() for name in arguments.sections.split(",") if name.strip()] or list(SECTIONS)
    unknown = [name for name in arguments.chosen if name not in SECTIONS]
    if unknown:
        parser.error(f"there is no section {', '.join(unknown)}; choose from {', '.join(SECTIONS)}")
    if not arguments.output.absolute().parent.is_dir():
        parser.error(f'there is no folder "{arguments.output.absolute().parent}"')
    return arguments


def command(arguments):
    """The command that measures one section again, wherever the page lies."""
    return " ".join(["python tests/accuracy/report.py", *["--quick"] * arguments.quick])


def commit():
    """The commit measured, or "" outside of a repository."""
    git = ["git", "-C", str(ROOT)]
    try:
        name = subprocess.run([*git, "rev-parse", "--short", "HEAD"], capture_output=True, text=True, check=True).stdout
        changed = subprocess.run(
            [*git, "status", "--porcelain", "native", "shaders", "addon"], capture_output=True, text=True
        )
    except (OSError, subprocess.CalledProcessError):
        return ""
    return name.strip() + (" with changes" if changed.stdout.strip() else "")


def measure(name, measured, folder, quick, stamp):
    """Runs one section and saves it; gives the seconds."""
    function, title, paper, *_ = SECTIONS[name]
    section = page.Section(name, title, paper, folder, stamp, quick=quick)
    start = time.monotonic()
    function(measured, section, quick)
    measured.forget()
    section.seconds = time.monotonic() - start
    section.save()
    return section.seconds


def write(output, folder, device):
    """Writes the page of all sections that were saved."""
    lines = ["# Accuracy", ""]
    lines += [
        "Errors are percentages of absolute error by the one definition of this project: 100 · mean |x − truth| over "
        "the range between the truth's 2.5th and 97.5th percentile (`addon/paradesc/core/compare.py`). *Closed form* "
        "is the smooth surface's exact value as r → 0; *reference* integrates over the triangles themselves. Radii are "
        "fractions of the bounding box's diagonal. Unless a section says otherwise: the engine on the CPU, 256 "
        "samples, fitted normals, evaluation at the vertices; `affine` and `paper` are ways of texture space, by the "
        "software device with buffers of 1024² texels. The paper does not define its %AE, and its reference is another "
        "one.",
        "",
        f"Last measured on {device}.",
        "",
    ]
    for name in SECTIONS:
        path = folder / f"{name}.json"
        if path.is_file():
            lines += page.markdown(page.load(path), folder.name)
        else:
            lines += [f"## {SECTIONS[name][1]}", "", f"Not measured yet: `--sections {name}`.", ""]
    output.write_text("\n".join(lines).rstrip() + "\n")


def main(words):
    arguments = parse(words)
    folder = arguments.output.absolute().parent / ("results-quick" if arguments.quick else "results")
    folder.mkdir(exist_ok=True)
    measured = bench.Bench()
    device = f"{measured.device} on {bench.cpu_model()}"
    stamp = f"{page.today()}, {device}, commit {commit() or 'unknown'}, {command(arguments)}"
    failed = []
    for name in arguments.chosen:
        sys.stderr.write(f"{name} … ")
        sys.stderr.flush()
        try:
            seconds = measure(name, measured, folder, arguments.quick, f"{stamp} --sections {name}")
            write(arguments.output, folder, device)
            sys.stderr.write(f"{seconds:.0f} s\n")
        except bridge.ParadescError as error:
            failed.append(name)
            measured.forget()
            sys.stderr.write(f"failed: {error.sentence}\n")
    sys.stderr.write(f"wrote {arguments.output}\n")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
