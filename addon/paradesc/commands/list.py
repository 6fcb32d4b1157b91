"""paradesc list: the descriptors and the devices there are."""

import argparse

from .. import bridge
from .common import Parser, add_output_options, check_outputs

BACKENDS = ("gpu", "software", "reference")
# More devices of one backend than a machine has.
MOST_DEVICES = 64
# What the library says of an index that is too large.
PAST_THE_LAST = "there are only"


def add_command(commands: "argparse._SubParsersAction[Parser]") -> None:
    """The command and its options."""
    listing = commands.add_parser("list", help="show the descriptors and the devices there are")
    add_output_options(listing)
    listing.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> dict[str, object]:
    """Prints the registry and the devices; gives them."""
    check_outputs([arguments.json] if arguments.json else [])
    rows = [describe(row) for row in bridge.descriptors()]
    found = devices()
    print("Descriptors")
    for row in rows:
        unit = f" [{row['unit']}]" if row["unit"] else ""
        print(f"  {row['name']:26}{row['description']}{unit}")
    print("Devices (--backend, --device)")
    for row in found:
        index = "" if row["index"] is None else row["index"]
        print(f"  {row['backend']:12}{index:<4}{row['device'] or 'none: ' + row['missing']}")
    return {"descriptors": rows, "devices": found}


def describe(row: bridge.Descriptor) -> dict[str, object]:
    """A descriptor for the report."""
    kind = "operator" if row.map_degree > 0 else "direction" if row.components == 3 else "scalar"
    return {
        "name": row.name,
        "label": row.label,
        "description": row.description,
        "kind": kind,
        "components": row.components,
        "unit": row.unit,
        "signed": row.is_signed,
        "neutral": row.neutral_value,
    }


def devices() -> list[dict[str, object]]:
    """Every device of every backend by its index; a backend without one has a row that says why."""
    return [row for backend in BACKENDS for row in devices_of(backend)]


def devices_of(backend: str) -> list[dict[str, object]]:
    """The devices of one backend; the reference has one, which needs no index."""
    first = row_of(backend, None)
    if first["missing"] or backend == "reference":
        return [first]
    rows: list[dict[str, object]] = []
    for index in range(MOST_DEVICES):
        row = row_of(backend, index)
        if PAST_THE_LAST in str(row["missing"]):
            break
        rows.append(row)
    return rows


def row_of(backend: str, index: int | None) -> dict[str, object]:
    """One device, or the sentence that says why there is none."""
    row: dict[str, object] = {"backend": backend, "index": index, "device": "", "missing": ""}
    try:
        with bridge.Context(backend, -1 if index is None else index) as context:
            row["device"] = context.device
    except bridge.ParadescError as error:
        row["missing"] = error.sentence
    return row
