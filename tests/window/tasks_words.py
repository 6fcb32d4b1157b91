"""Every panel open: one way to an image, and no setting's name twice."""

from collections import Counter
from collections.abc import Iterator
from typing import TYPE_CHECKING

import bpy
import person
from scenes import as_found, clicked, monkey

if TYPE_CHECKING:
    from drive import Run

PAGES = 6  # more than the open panels fill
NOTCHES = 12  # of the mouse's wheel, which scroll less than a page


def named(path: str) -> str:
    """The name of the setting with this path."""
    owner, _, name = path.rpartition(".")
    return bpy.data.path_resolve(owner.removeprefix("bpy.data.")).bl_rna.properties[name.partition("[")[0]].name


def open_panels(run: "Run") -> Iterator[None]:
    """Reads all that a person finds by scrolling through the panels of a mesh that moves."""
    made = monkey(2)
    as_found()
    yield from clicked()
    made.shape_key_add(name="Basis")
    yield from person.drawn(3)
    found: dict[str, tuple[int, int]] = {}
    there = person.region("UI")
    for page in range(PAGES):
        file = yield from run.picture(f"open_{page}", "UI")
        seen = yield from person.buttons()
        run.saw("C4", f"page {page} of the open panels", None, file)
        if not seen.keys() - found.keys():
            break
        found |= seen
        for _ in range(NOTCHES):
            yield from person.click(there.x + there.width // 3, there.y + there.height // 2, "WHEELDOWNMOUSE")
    names = Counter(named(words) for words in found if not words.startswith("bpy.ops."))
    twice = sorted(name for name, count in names.items() if count > 1)
    run.saw("C4", f"{len(names)} names of settings in all open panels: {', '.join(names)}; more than once: {twice}", not twice)
    images = [words for words in found if "image" in words]
    run.saw("C4", f"what has to do with images: {', '.join(images)}", not any("write_image" in words for words in images))


def steps(run: "Run") -> Iterator[None]:
    """All of it."""
    yield from person.alone()
    person.screen.open_panels()  # before Blender draws them, since it keeps which are closed
    yield from person.open_tab()
    yield from run.tried("C4", open_panels(run))
