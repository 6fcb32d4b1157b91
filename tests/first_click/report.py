"""Clicks once on every asset with no setting touched, and measures the mask beside Blender's own masks.

    PYTHONPATH=addon python tests/first_click/report.py [--assets beast,fandisk] [--no-peers] [--both] [--page]
        [--pictures FOLDER]

It runs in Blender's Python module, and ends with 1 if an artist could not use one of the masks. measures.py says what is measured, and
assets.py which mask suits which asset. --both measures the other mask, too, and the other vertices, too, where the panel offers
an image; neither is judged. --page writes REPORT.md. --pictures draws a sheet of each asset into a folder.
"""

import argparse
import sys
import time
from dataclasses import dataclass, replace
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parents[1] / "addon")]

import bpy  # noqa: E402
import clicks  # noqa: E402
import measures  # noqa: E402
import page  # noqa: E402
import peers  # noqa: E402
import sheets  # noqa: E402
from assets import ASSETS, Asset  # noqa: E402


@dataclass
class Row:
    """The result of one click on one asset, or of one of Blender's masks."""

    asset: str
    mask: str
    by: str  # the way of the click, or the name of a peer
    percent: float = 0.0  # the radius, of the diagonal
    found: measures.Measures | None = None
    seen: bool = False  # whether the viewport shows this one after the click
    suits: bool = False  # whether it is the one that an artist would look for
    refusal: str = ""

    @property
    def faults(self) -> list[str]:
        """The reasons why an artist could not use the result."""
        return [self.refusal] if self.found is None else self.found.faults()


def clicked(asset: Asset, to_image: bool) -> tuple[list[Row], list[clicks.Shown]]:
    """Clicks on a fresh asset and measures both masks, first the one that the viewport shows."""
    asset.add()
    way = "image" if to_image else "vertices"
    try:
        found = clicks.click(to_image)
    except clicks.Refused as refusal:
        return [Row(asset.name, asset.mask, way, seen=True, suits=True, refusal=str(refusal))], []
    found.sort(key=lambda shown: not shown.seen)
    return [
        Row(asset.name, shown.mask, way, shown.percent, shown.measured(asset.hard), shown.seen, shown.mask == asset.mask)
        for shown in found
    ], found


def beside(asset: Asset, mask: str, percent: float, views: dict | None) -> list[Row]:
    """Blender's own masks of the same asset, measured at the vertices; what is flat is so by the radius of the click.

    views: takes a picture of each.
    """
    rows = []
    for name, paint in peers.PEERS.items():
        target = asset.add()
        at_vertices = paint(target, mask)
        surface = clicks.surface_of(target.data)
        points = measures.at_corners(surface)
        faces = measures.flat_faces(surface, points, percent / 100 * surface.diagonal) if asset.hard else None
        values = points.mixed(at_vertices[surface.triangles][..., None])[:, 0]
        rows.append(Row(asset.name, mask, name, found=measures.measured(values, points, faces)))
        if views is not None:
            views[name] = sheets.of_tones(target, at_vertices)
    return rows


def measured(asset: Asset, both: bool, with_peers: bool, pictures: Path | None) -> list[Row]:
    """All rows of one asset, the judged click first; pictures: the folder for its sheet."""
    to_image = clicks.offers_image(asset.add())
    other = [replace(row, seen=False, suits=False) for row in clicked(asset, False)[0]] if both and to_image else []
    rows, found = clicked(asset, to_image)
    views = {f"{shown.mask} {shown.way} {shown.percent:.2g}%": sheets.of_mask(shown) for shown in found if pictures}
    if with_peers:
        rows += other + beside(asset, asset.mask, rows[0].percent, views if pictures else None)
    if pictures:
        sheets.written(pictures / f"{asset.name}.png", {name: views[name] for name in sorted(views)})
    return rows


def main(words: list[str]) -> int:
    """Measures what was asked for, row by row."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--assets", default=",".join(ASSETS), help="names with commas between them (default: all)")
    parser.add_argument("--no-peers", action="store_true", help="without Blender's own masks")
    parser.add_argument("--both", action="store_true", help="vertices, too, where the panel offers an image")
    parser.add_argument("--page", action="store_true", help="write REPORT.md beside this file")
    parser.add_argument("--pictures", type=Path, help="draw a sheet of each asset into this folder")
    asked = parser.parse_args(words)
    unknown = [name for name in asked.assets.split(",") if name not in ASSETS]
    if unknown:
        parser.error(f"there is no asset {', '.join(unknown)}; choose from {', '.join(ASSETS)}")
    rows, left_out = [], []
    if asked.pictures:
        asked.pictures.mkdir(parents=True, exist_ok=True)
    for asset in map(ASSETS.get, asked.assets.split(",")):
        if asset.missing:
            left_out.append(asset.missing)
            continue
        start = time.monotonic()
        found = measured(asset, asked.both, not asked.no_peers, asked.pictures)
        rows += found
        sys.stdout.write("".join(map(page.line, found)))
        sys.stdout.flush()
        sys.stderr.write(f"{asset.name}: {time.monotonic() - start:.1f} s\n")
    if asked.pictures:
        own = [row.asset for row in rows if row.seen and not ASSETS[row.asset].file]  # no picture of what others have made
        sheets.contact((HERE if asked.page else asked.pictures) / "contact.jpg", [asked.pictures / f"{name}.png" for name in own])
    sys.stdout.write("\n" + page.summary(rows, left_out))
    if asked.page:
        (HERE / "REPORT.md").write_text(page.page(rows, left_out))
    return int(any(row.faults for row in rows if row.seen))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
