"""The question mark of the panel: opens the manual that lies beside the add-on, without a network."""

from pathlib import Path

import bpy

from ..settings import translation

# A package has web pages; a package without them and a source tree have the Markdown pages.
PACKAGE = Path(__file__).resolve().parents[1]
FIRST_PAGES = (
    PACKAGE / "manual" / "index.html",
    PACKAGE / "manual" / "README.md",
    PACKAGE.parent / "manual" / "README.md",
)


def first_page() -> Path | None:
    """The page to open, or None if the add-on was copied without its manual."""
    return next((path for path in FIRST_PAGES if path.is_file()), None)


class PARADESC_OT_manual(bpy.types.Operator):
    """Open the manual, which is part of the add-on and needs no network"""

    bl_idname = "paradesc.manual"
    bl_label = "Manual"
    bl_options = {"INTERNAL"}

    @classmethod
    def poll(cls, _context: bpy.types.Context) -> bool:
        """Says if there is no manual."""
        there = first_page() is not None
        if not there:
            cls.poll_message_set(translation.tooltip("This copy of the add-on has no manual; install a package"))
        return there

    def execute(self, _context: bpy.types.Context) -> set[str]:
        """Opens web pages in the browser, Markdown in the program that this system has for it."""
        page = first_page()
        if page.suffix == ".html":
            return bpy.ops.wm.url_open(url=page.as_uri())
        return bpy.ops.wm.path_open(filepath=str(page))


classes = (PARADESC_OT_manual,)
