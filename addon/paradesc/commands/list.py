"""paradesc list: the descriptors and the devices there are."""

import argparse

from .. import bridge
from .common import Parser


def add_command(commands: "argparse._SubParsersAction[Parser]") -> None:
    """The command and its options."""
    listing = commands.add_parser("list", help="show the descriptors and the devices there are")
    listing.set_defaults(run=run)


def run(_arguments: argparse.Namespace) -> None:
    """Prints the registry and the devices."""
    print("Descriptors")
    for row in bridge.descriptors():
        unit = f" [{row.unit}]" if row.unit else ""
        print(f"  {row.name:26}{row.description}{unit}")
    print("Devices")
    for row in bridge.devices():
        print(f"  {row['backend']:26}{row['device'] or 'none: ' + row['missing']}")
