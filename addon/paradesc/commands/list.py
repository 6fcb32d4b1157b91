"""paradesc list: shows all descriptors and all devices."""

import argparse

from .. import bridge
from ..core import devices
from .common import Parser, add_output_options, check_outputs


def add_command(commands: "argparse._SubParsersAction[Parser]") -> None:
    """The command and its options."""
    listing = commands.add_parser("list", help="list the descriptors and the devices")
    add_output_options(listing)
    listing.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> dict[str, object]:
    """Prints the registry and the devices; returns both."""
    check_outputs([arguments.json] if arguments.json else [])
    rows = [describe(row) for row in bridge.descriptors()]
    found = [describe_device(row) for row in devices.found()]
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


def describe_device(row: devices.Device) -> dict[str, object]:
    """Describes a device for the report; the only device of a backend needs no index."""
    index = None if row.index < 0 else row.index
    return {"backend": row.backend, "index": index, "device": row.name, "missing": row.missing}
