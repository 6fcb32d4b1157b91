"""The code blocks of gallery.md → the pictures below them, for make.py: gallery.py FOLDER.

The first block makes what all others use. Each other one ends with show() and has its picture below it, so page and
pictures cannot differ.
"""

import re
import sys
from pathlib import Path

PAGE = Path(__file__).resolve().parent / "gallery.md"
BLOCK = re.compile(r"^```python\n(.*?)^```\n(?:\n!\[[^\]]*\]\(pictures/(\w+\.png)\))?", re.M | re.S)


def blocks(page: Path = PAGE) -> list[tuple[str, str]]:
    """Code and the name of its picture, "" for none."""
    return BLOCK.findall(page.read_text(encoding="utf-8"))


def draw(code: str, names: dict[str, object], path: Path) -> None:
    """Runs a block with the names of the first one, and writes the picture that it shows."""
    own = dict(names)
    exec(compile(code, path.stem, "exec"), own)
    if "plotter" in own:
        from PIL import Image

        Image.fromarray(own["plotter"].image).save(path)
    else:
        own["figure"].savefig(path, dpi=100)


def main(folder: Path) -> None:
    """All of them."""
    (first, _), *others = blocks()
    names: dict[str, object] = {}
    exec(compile(first, PAGE.name, "exec"), names)
    for code, picture in others:
        draw(code, names, folder / picture)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
