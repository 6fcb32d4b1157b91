"""Turns the rows of the first click into lines for the console and into a page."""

import time
from pathlib import Path
from typing import TYPE_CHECKING

import measures

if TYPE_CHECKING:
    from report import Row

HERE = Path(__file__).resolve().parent
INTRODUCTION = f"""# The first click

Each asset is imported and clicked once with every setting at its default, on the button that the panel offers first: *Bake to Image* where
most of the area lies in faces too large for colors at vertices. The click makes both masks, of which the bold row has the one that the
viewport shows; a star marks the one that an artist would look for. The values are those shown, from black 0 to white 1, weighted by area.

| measure | what it is | wanted |
|---|---|---|
| white | the value at the 98th percentile of what is not black (above 1/255) | at least {measures.WHITE} |
| bright | share of the area above {measures.BRIGHT} | {measures.LEAST_BRIGHT:.0%} to {measures.MOST_BRIGHT:.0%} |
| dark | share of the area below {measures.DARK} | at most {measures.MOST_DARK:.0%} |
| flat | of hard surfaces: the brightest flat face; in brackets the share of the area that is flat | at most {measures.MOST_ON_FLAT} |

A flat face is what triangles joined by edges of less than {measures.COPLANAR:g} degree make, if none of them differs by more from their mean. Sides of a
round surface are none, since a mask has the curvature of the whole there: they go on over two edges, which bend the same way by less
than {measures.ROUND:g} degrees, into faces at least {measures.ALIKE:g} times as large. A flat face is as bright as the mean of its points that lie farther
than {measures.CLEAR} radii from every edge around it, at {measures.FEWEST} places at least.
Vertices are measured at the corners of triangles, images at 200,000 points of the surface.

*Dirty* is Blender's Dirty Vertex Colors at its defaults, inverted for cavities. *Pointiness* is that of the Geometry node, baked by
Cycles at the vertices, behind a ramp from 0.5 to 0.55 (to 0.45 for cavities), as tutorials set it. Their flat faces are found by the
radius of the click.
"""


def cells(row: "Row") -> list[str]:
    """The four measures, as they are written."""
    if row.found is None:
        return ["–"] * 4
    found = row.found
    flat = "–" if found.on_flat is None else f"{found.on_flat:.3f} ({found.flat:.1%})"
    return [f"{found.white:.2f}", f"{found.bright:.1%}", f"{found.dark:.1%}", flat]


def verdict(row: "Row") -> str:
    """The faults of a row, or that it is usable."""
    return ", ".join(row.faults) or "usable"


def line(row: "Row") -> str:
    """One line of the console; an arrow stands before what the viewport shows, a star before what suits the asset."""
    radius = f"{row.percent:.2f} %" if row.percent else ""
    return (
        f"{'>' if row.seen else ' '}{'*' if row.suits else ' '}{row.asset:11} {row.mask:10}{row.by:11}{radius:>8}"
        + "".join(f"{cell:>7}" for cell in cells(row)[:3])
        + f"  {cells(row)[3]:16} {verdict(row)}\n"
    )


def summary(rows: list["Row"], left_out: list[str]) -> str:
    """How many masks are usable, and what was left out."""
    lines = [f"{sentence}\n" for sentence in left_out]
    for what, chosen in (("shown", [row for row in rows if row.seen]), ("that suit", [row for row in rows if row.suits])):
        lines.append(f"Usable masks of those {what}: {sum(not row.faults for row in chosen)} of {len(chosen)}.\n")
    return "".join(lines)


def page(rows: list["Row"], left_out: list[str]) -> str:
    """The whole page."""
    head = "| asset | mask | by | radius | white | bright | dark | flat | |\n|---|---|---|---:|---:|---:|---:|---:|---|\n"
    body = ""
    for row in rows:
        first = [f"**{row.asset}**" if row.seen else "", f"{row.mask}{' *' if row.suits else ''}", row.by]
        radius = f"{row.percent:.2f} %" if row.percent else ""
        body += "| " + " | ".join([*first, radius, *cells(row), verdict(row)]) + " |\n"
    end = f"\nMeasured on {time.strftime('%Y-%m-%d')} by `tests/first_click/report.py --page`. {summary(rows, left_out)}"
    picture = "\n![The project's own assets, each with Dirty, Pointiness, Cavity and Edge Wear](contact.jpg)\n"
    return f"{INTRODUCTION}\n{head}{body}{picture if (HERE / 'contact.jpg').is_file() else ''}{end}"
