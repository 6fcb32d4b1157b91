"""paradesc list: shows all descriptors and all devices."""

import argparse

from .. import bridge
from ..core import devices
from .common import Parser

HELP = "list the descriptors and the devices"


def add_options(_parser: Parser) -> None:
    """The command has no options of its own."""


def run(arguments: argparse.Namespace) -> dict[str, object]:
    """Prints the registry and the devices; returns both."""
    rows = [describe(row) for row in bridge.descriptors()]
    found = [
        {"backend": row.backend, "index": row.index, "device": row.name, "missing": row.missing}
        for row in devices.found()
    ]
    for row in found:
        row["index"] = None if row["index"] < 0 else row["index"]  # the only device of a backend needs none
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
    """Describes a descriptor for the report."""
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
