"""paradesc compare: compares a device's results with the reference's, as a table of errors."""

import argparse

from ..core import compare
from . import options
from .common import Parser, Progress, UsageError, print_notes
from .sources import source_of

COLUMNS = (
    ("mean_percent_ae", "mean %"),
    ("median_percent_ae", "median %"),
    ("p99_percent_ae", "p99 %"),
    ("max_percent_ae", "max %"),
    ("seam_mean_percent_ae", "near seams %"),
    ("coverage_mean", "coverage"),
    ("undefined", "undefined"),
)


HELP = "compare a device's results with those of the reference"


def add_options(parser: Parser) -> None:
    """The command's options."""
    options.add_input(parser)
    add = parser.add_argument
    add("--object", metavar="NAME", help="the mesh object (default: a .blend's active one, else the largest)")
    options.add_computation_options(parser)
    add("--fail-over-error", type=float, metavar="PERCENT",
        help="end with code 5 if a descriptor's mean error is larger")  # fmt: skip


def run(arguments: argparse.Namespace) -> dict[str, object]:
    """Computes on a device and on the reference, and prints the table of errors; returns the report."""
    if arguments.backend == "reference":
        raise UsageError("The reference is what compare compares with; choose another backend.")
    options.check(arguments)
    source = source_of(arguments)
    print_notes(source.open())
    target = source.one(arguments.object)
    settings = options.opened_settings(arguments)
    arguments.material_maps = False  # also if the scene has them
    read = source.read(target, settings)
    notes = [*read.sentences, *options.notes_of_preset(arguments)]
    with Progress(arguments.progress) as progress:
        rows, device, reference = compare.compare(read.measured, settings, progress)
    print(f'object "{target.name}", radius {device.radius:.6g}, {settings.options.samples} samples')
    print(f"{device.backend}: {device.device}, {device.field_report['seconds_total']:.2f} s")
    print(f"reference: {reference.device}, {reference.field_report['seconds_total']:.2f} s")
    print_table(rows)
    spreads = [f"{note[0].upper()}{note[1:]}." for note in filter(None, map(compare.spread_note, rows))]
    warnings = [*device.warnings, *device.facet_notes()]
    print_notes([*notes, *spreads, *warnings])
    return {
        "object": target.name,
        "settings": settings.as_dict(),
        "backend": device.backend,
        "device": device.device,
        "fallback": "",  # for readers of earlier versions
        "notes": notes,
        "warnings": warnings,
        "rows": rows,
        "failed_checks": failed_checks(rows, arguments.fail_over_error),
    }


def failed_checks(rows: list[dict[str, object]], largest: float | None) -> list[str]:
    """A sentence for each descriptor whose mean error exceeds the allowed one, or is missing."""
    if largest is None:
        return []
    return [
        f"The mean error of {row['descriptor']} is {row['mean_percent_ae']:.4g} %, above the {largest:g} % allowed"
        + "".join(f" ({note})" for note in filter(None, [compare.spread_note(row)]))
        + "."
        for row in rows
        if not row["mean_percent_ae"] <= largest
    ]


def print_table(rows: list[dict[str, object]]) -> None:
    """Prints one line for each descriptor."""
    print(f"{'descriptor':26}" + "".join(f"{title:>14}" for _, title in COLUMNS))
    for row in rows:
        cells = "".join(
            f"{row[name]:>14}" if isinstance(row[name], int) else f"{row[name]:>14.4f}" for name, _ in COLUMNS
        )
        print(f"{row['descriptor']:26}{cells}")
