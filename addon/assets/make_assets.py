"""Makes addon/paradesc_blender/assets/paradesc.blend: the node groups and materials that the add-on appends, as assets.

Usage: blender -b --factory-startup -P addon/assets/make_assets.py [-- FILE]

The oldest Blender that the add-on supports, 3.4, makes it, because newer ones read its files. The native library has to
be built first, because thumbnails show baked masks. Two runs write the same bytes, except for addresses in memory.
"""

import sys
from pathlib import Path

import bpy

FOLDER = Path(__file__).resolve().parent
sys.path[:0] = [str(FOLDER), str(FOLDER.parent)]

import groups  # noqa: E402
import looks  # noqa: E402

OUTPUT = FOLDER.parent / "paradesc_blender" / "assets" / "paradesc.blend"
CATALOG = "6d8f0a52-3b0e-4c47-9a43-0f6a5d1c7e21"  # as blender_assets.cats.txt beside the file has it
MASKS = "Reads the masks Cavity and Edge Wear, which Paradesc bakes."
# The function that makes each asset, its description and its tags.
ASSETS = (
    (groups.wear, "Dirt in hollows and worn edges, broken up by noise, on any color.", ("wear", "dirt", "edges")),
    (groups.curvature, f"Convexity and concavity as shader inputs. {MASKS}", ("curvature", "convexity", "cavity")),
    (groups.cavity, "Dirt and worn edges of the raw values cavity and convexity.", ("cavity", "edges")),
    (groups.cavity_of_mean_curvature, "Dirt and worn edges of mean curvature.", ("cavity", "edges")),
    (groups.swell, "Moves vertices along their normals by a baked value.", ("displace",)),
    (groups.keep, "Keeps what lies above a baked value.", ("selection",)),
    (groups.mark, "Writes a boolean attribute, true above a baked value.", ("selection",)),
    (groups.scatter, "Puts small objects where a baked value is high.", ("scatter", "moss")),
    (looks.painted_metal, f"Paint that is gone from the edges down to steel. {MASKS}", ("metal", "paint", "wear")),
    (looks.old_stone, f"Pale worn edges, dark and mossy hollows. {MASKS}", ("stone", "moss", "wear")),
    (looks.dusty_plastic, f"Scuffed edges, dust in hollows and on top. {MASKS}", ("plastic", "dust", "wear")),
)


def build() -> list[bpy.types.ID]:
    """Makes every asset in an empty file, without thumbnails; gives them in a fixed order."""
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    return [as_asset(make(), about, tags) for make, about, tags in ASSETS]


def as_asset(block: bpy.types.ID, about: str, tags: tuple[str, ...]) -> bpy.types.ID:
    """Makes a group or material an asset of our catalog."""
    block.asset_mark()
    data = block.asset_data
    data.catalog_id, data.description, data.author = CATALOG, about, "Paradesc"
    for tag in tags:
        data.tags.new(tag)
    return block


def main() -> int:
    """Builds, adds thumbnails, and saves."""
    words = sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else []
    made = build()
    if "--without-thumbnails" not in words:
        import thumbnails

        thumbnails.add(made)
    output = Path(words[0]) if words and not words[0].startswith("-") else OUTPUT
    bpy.data.libraries.write(str(output.resolve()), set(made), fake_user=True, compress=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
