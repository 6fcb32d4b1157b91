"""The question mark in the panel, which opens the manual that is part of the add-on, without a network."""

from pathlib import Path

import bpy

from ..settings import translation

# Packages contain web pages. A source tree, and a package without them, have Markdown pages.
PACKAGE = Path(__file__).resolve().parents[1]
FIRST_PAGES = (
    PACKAGE / "manual" / "index.html",
    PACKAGE / "manual" / "README.md",
    PACKAGE.parent / "manual" / "README.md",
)


def first_page() -> Path | None:
    """The page to open; None if the add-on was copied without its manual."""
    return next((path for path in FIRST_PAGES if path.is_file()), None)


class PARADESC_OT_manual(bpy.types.Operator):
    """Open the manual, which is part of the add-on and needs no network"""

    bl_idname = "paradesc.manual"
    bl_label = "Manual"
    bl_options = {"INTERNAL"}

    @classmethod
    def poll(cls, _context: bpy.types.Context) -> bool:
        """Works only if there is a manual; the button's tooltip says so."""
        missing = "This copy of the add-on has no manual; install a package"
        return translation.can_run(cls, "" if first_page() else missing)

    def execute(self, _context: bpy.types.Context) -> set[str]:
        """Opens web pages in the browser, and Markdown pages in the system's program for them."""
        page = first_page()
        if page.suffix == ".html":
            return bpy.ops.wm.url_open(url=page.as_uri())
        return bpy.ops.wm.path_open(filepath=str(page))


classes = (PARADESC_OT_manual,)
