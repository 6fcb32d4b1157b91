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
from dataclasses import dataclass
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

MASKS = ("cavity", "edge_wear")


@dataclass
class Row:
    """What came of one click on one asset, or of one of Blender's masks."""

    asset: str
    mask: str
    by: str  # the way of the click, or the name of a peer
    judged: bool
    percent: float = 0.0  # the radius, of the diagonal
    found: measures.Measures | None = None
    refusal: str = ""

    @property
    def faults(self) -> list[str]:
        """What an artist could not use."""
        return [self.refusal] if self.found is None else self.found.faults()


def clicked(asset: Asset, mask: str, to_image: bool, judged: bool) -> tuple[Row, clicks.Shown | None]:
    """Clicks on a fresh asset and measures."""
    asset.add()
    row = Row(asset.name, mask, "image" if to_image else "vertices", judged)
    try:
        shown = clicks.click(mask, to_image)
    except clicks.Refused as refusal:
        row.refusal = str(refusal)
        return row, None
    surface = clicks.surface_of(shown.target.data)
    row.percent = 100 * shown.radius / surface.diagonal
    flat = measures.flat_points(surface, shown.points, shown.radius) if asset.hard else None
    row.found = measures.measured(shown.values, shown.points, flat)
    return row, shown


def beside(asset: Asset, mask: str, percent: float) -> list[Row]:
    """Blender's own masks of the same asset, measured at the vertices; what is flat is so by the radius of the click."""
    rows = []
    for name, paint in peers.PEERS.items():
        target = asset.add()
        at_vertices = paint(target, mask)
        surface = clicks.surface_of(target.data)
        points = measures.at_corners(surface)
        flat = measures.flat_points(surface, points, percent / 100 * surface.diagonal) if asset.hard else None
        values = points.mixed(at_vertices[surface.triangles][..., None])[:, 0]
        rows.append(Row(asset.name, mask, name, False, found=measures.measured(values, points, flat)))
    return rows


def measured(asset: Asset, both: bool, with_peers: bool) -> list[Row]:
    """All rows of one asset, the judged click first."""
    to_image = clicks.offers_image(asset.add())
    ways = (True, False) if both and to_image else (to_image,)
    rows = [
        clicked(asset, mask, way, mask == asset.mask and way == to_image)[0]
        for mask in sorted(MASKS, key=asset.mask.__ne__)[: 1 + both]
        for way in ways
    ]
    return rows + (beside(asset, asset.mask, rows[0].percent) if with_peers else [])


def draw(asset: Asset, path: Path) -> None:
    """Draws the sheet of one asset."""
    views = {}
    for name, paint in peers.PEERS.items():
        target = asset.add()
        tones = paint(target, asset.mask)
        layer = target.data.color_attributes.new("tones", "FLOAT_COLOR", "POINT")
        layer.data.foreach_set("color", tones.repeat(4).astype("float32"))
        sheets.set_up(target)
        views[name] = sheets.drawn(target, "tones")
    for mask in MASKS:
        to_image = clicks.offers_image(asset.add())
        row, shown = clicked(asset, mask, to_image, False)
        if shown is None:
            continue
        sheets.set_up(shown.target)
        colors = "" if shown.image else shown.target.data.color_attributes.active_color.name
        views[f"{mask} {row.by} {row.percent:.2g}%"] = sheets.drawn(shown.target, colors, shown.image)
    sheets.written(path, views)


def main(words: list[str]) -> int:
    """Measures what was asked for, row by row."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--assets", default=",".join(ASSETS), help="names with commas between them (default: all)")
    parser.add_argument("--no-peers", action="store_true", help="without Blender's own masks")
    parser.add_argument("--both", action="store_true", help="the other mask and the other way, too")
    parser.add_argument("--page", action="store_true", help="write REPORT.md beside this file")
    parser.add_argument("--pictures", type=Path, help="draw a sheet of each asset into this folder")
    asked = parser.parse_args(words)
    unknown = [name for name in asked.assets.split(",") if name not in ASSETS]
    if unknown:
        parser.error(f"there is no asset {', '.join(unknown)}; choose from {', '.join(ASSETS)}")
    rows, left_out = [], []
    for asset in map(ASSETS.get, asked.assets.split(",")):
        if asset.missing:
            left_out.append(asset.missing)
            continue
        start = time.monotonic()
        rows += measured(asset, asked.both, not asked.no_peers)
        if asked.pictures:
            asked.pictures.mkdir(parents=True, exist_ok=True)
            draw(asset, asked.pictures / f"{asset.name}.png")
        sys.stderr.write(f"{asset.name}: {time.monotonic() - start:.1f} s\n")
    if asked.pictures:
        sheets.contact(asked.pictures / "contact.png", [asked.pictures / f"{row.asset}.png" for row in rows if row.judged])
    sys.stdout.write("".join(["\n", *map(page.line, rows), page.summary(rows, left_out)]))
    if asked.page:
        (HERE / "REPORT.md").write_text(page.page(rows, left_out))
    return int(any(row.faults for row in rows if row.judged))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
