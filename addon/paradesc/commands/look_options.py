"""The command line's options about colors, and what they mean. Never imports bpy."""

import argparse
import math
from dataclasses import replace

from .. import bridge
from ..core.color_maps import AUTOMATIC, MAPS, Look


def add_look_options(parser: argparse.ArgumentParser) -> None:
    """Adds the options for the color map and range of .blend, .ply and .png outputs."""
    group = parser.add_argument_group("colors")
    add = group.add_argument
    add("--color-map", choices=(AUTOMATIC, *MAPS), help="color map (default: by the descriptor's sign)")
    bounds = group.add_mutually_exclusive_group()
    bounds.add_argument("--range", action="append", type=fixed_range, default=[], metavar="[NAME=]A:B",
        help="values at the ends of the color map, as in --range=-1:1, or of one descriptor; repeatable")  # fmt: skip
    bounds.add_argument("--percentile", type=percentile, metavar="P",
        help="leave P percent of the values outside the range at either end (default: 2.5)")  # fmt: skip
    add("--neutral", type=finite, metavar="X", help="the value in the middle of diverging color maps")
    add("--asymmetric", action="store_true", help=(
        "for values with a sign, take a range of its own by percentiles on each side"
    ))


def look_of(arguments: argparse.Namespace, otherwise: Look | None = None) -> Look:
    """The look that these options ask for. otherwise: the look that supplies the missing options."""
    look = otherwise or Look()
    if arguments.range or arguments.percentile is not None:
        look = replace(look, percentile=arguments.percentile, ranges=dict(arguments.range))
    given = {"color_map": arguments.color_map, "neutral": arguments.neutral}
    look = replace(look, **{name: value for name, value in given.items() if value is not None})
    return replace(look, symmetric=False) if arguments.asymmetric else look


def fixed_range(text: str) -> tuple[str, tuple[float, float]]:
    """Parses "curvedness=0:3" or "-1:1" into a descriptor's name ("" for all) and two numbers."""
    name, _, bounds = text.rpartition("=")
    try:
        low, high = map(finite, bounds.split(":"))
    except ValueError:
        raise argparse.ArgumentTypeError(f'"{text}" is not a range; write two numbers, as in 0:2 or =-1:1') from None
    if not high > low:
        raise argparse.ArgumentTypeError(f'the range "{text}" must end above its beginning')
    name = name.strip()
    known = [row.name for row in bridge.descriptors()]
    if name and name not in known:
        raise argparse.ArgumentTypeError(f'there is no descriptor "{name}"; choose from {", ".join(known)}')
    return name, (low, high)


def finite(text: str) -> float:
    """Parses a number that is neither infinite nor NaN."""
    value = float(text)
    if not math.isfinite(value):
        raise ValueError(text)
    return value


def percentile(text: str) -> float:
    """Parses a percentage below 50, which can be left out on both sides."""
    value = float(text)
    if not 0 <= value < 50:
        raise argparse.ArgumentTypeError(f"{text} is not a share of one end; give one from 0 to below 50")
    return value
