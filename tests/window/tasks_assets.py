"""The seven assets: imported, and clicked once with no setting touched; then the sizes of the radius on one of them."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

import bpy
import person
from assets import ASSETS
from scenes import as_found, clicked, imported, shading

import clicks

if TYPE_CHECKING:
    from drive import Run

REAL = [asset for asset in ASSETS.values() if asset.file]


def one_click(run: "Run", asset: object) -> Iterator[None]:
    """Imports an asset and clicks once; measures both masks, and judges the one that is seen."""
    as_found()
    imported(asset.file)
    shading().light, shading().color_type = "STUDIO", "MATERIAL"
    words = yield from clicked()
    file = yield from run.picture(asset.name)
    for shown in clicks.found(words.startswith("bake_image")):
        found = shown.measured(asset.hard)
        text = f"{asset.name}, {words}, {shown.mask}{', seen' if shown.seen else ''}: radius {shown.percent:.2f} %, white {found.white:.2f}, "
        text += f"{found.bright:.1%} above 0.5, {found.dark:.1%} below 0.05, flat {found.on_flat}; {', '.join(found.faults()) or 'usable'}"
        run.saw("A3" if asset.hard else "A2", text, not found.faults() if shown.seen else None, file)


def sizes(run: "Run") -> Iterator[None]:
    """Fine, Medium, Broad on the beast."""
    as_found()
    imported("beast.obj")
    place = yield from person.find("paradesc.radius_fit")
    if place is None:
        run.saw("A2", "no Fine, Medium, Broad on the panel", False)
        return
    there = person.region("UI")
    radii = []
    for size, share in (("fine", 0.15), ("broad", 0.8)):
        yield from person.click(there.x + share * (there.width - 24), place[1])
        yield from person.drawn(2)
        chosen = bpy.context.scene.paradesc.radius_fit
        yield from clicked()
        file = yield from run.picture(f"beast_{size}")
        radii.append(bpy.context.scene.paradesc.radius_percent)
        run.saw("A2", f"beast, click on {size}: {chosen}, {radii[-1]:.2f} %", chosen == size, file)
    run.saw("A2", "broad is larger than fine", radii[1] > radii[0])


def steps(run: "Run") -> Iterator[None]:
    """One after another."""
    yield from person.alone()
    yield from person.open_tab()
    for asset in REAL:
        if asset.missing:
            run.saw("A2", asset.missing)
        else:
            yield from run.tried("A2", one_click(run, asset))
    if not ASSETS["beast"].missing:
        yield from run.tried("A2", sizes(run))
