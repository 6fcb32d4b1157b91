"""The manual's Markdown pages → web pages in a folder of the package, readable without a network.

Without the Python package markdown the pages go into the package as they are.
"""

import html
import re
import shutil
from importlib.util import find_spec
from pathlib import Path

ADDON = Path(__file__).resolve().parents[2] / "addon"
FIRST, CHANGES = "README", "CHANGELOG"
PICTURES = {".png", ".jpg", ".gif"}
STYLE = """
body { max-width: 60rem; margin: 2rem auto; padding: 0 1rem; font: 1rem/1.5 system-ui, sans-serif; }
body { color: #222; background: #fff; }
a { color: #0b5cad; }
img { max-width: 100%; }
table { border-collapse: collapse; margin: 1rem 0; }
th, td { border: 1px solid #ccc; padding: 0.25rem 0.6rem; text-align: left; vertical-align: top; }
code { background: #f2f2f2; padding: 0 0.2rem; border-radius: 3px; }
pre { background: #f2f2f2; padding: 0.8rem; overflow-x: auto; }
nav { border-bottom: 1px solid #ccc; padding-bottom: 0.5rem; }
@media (prefers-color-scheme: dark) {
  body { color: #ddd; background: #1d1f21; } a { color: #7ab7f5; }
  code, pre { background: #2a2d30; } th, td, nav { border-color: #444; }
}
"""


def sources(addon: Path) -> dict[str, Path]:
    """The pages by the names that they get, the first page first."""
    pages = [addon / "manual" / f"{FIRST}.md", *sorted((addon / "manual").glob("*.md")), addon / f"{CHANGES}.md"]
    return {page.stem: page for page in pages}


def write_manual(folder: Path, addon: Path = ADDON) -> None:
    """Fills a new folder with the pages and their pictures."""
    folder.mkdir(parents=True)
    pictures = addon / "manual" / "pictures"
    for path in (path for path in pictures.rglob("*") if path.suffix in PICTURES):
        target = folder / "pictures" / path.relative_to(pictures)
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(path, target)
    for name, page in sources(addon).items():
        text = page.read_text(encoding="utf-8")
        if find_spec("markdown") is None:
            flat = text.replace(f"(../{CHANGES}.md", f"({CHANGES}.md").replace("(manual/", "(")
            (folder / f"{name}.md").write_text(flat, encoding="utf-8")
        else:
            (folder / page_name(name)).write_text(web_page(text), encoding="utf-8")


def page_name(name: str) -> str:
    """The web page that a page becomes."""
    return "index.html" if name == FIRST else f"{name.lower()}.html"


def web_page(text: str) -> str:
    """A Markdown page as a whole web page, its links leading to web pages."""
    import markdown
    from markdown.extensions.toc import TocExtension

    extensions = ["tables", "fenced_code", "sane_lists", TocExtension(slugify=slug)]
    body = markdown.markdown(text, extensions=extensions)
    body = re.sub(r'(?<=href=")(?:[\w./]*/)?(\w+)\.md(?=[#"])', lambda found: page_name(found[1]), body)
    title = html.escape(re.search(r"^# (.+)$", text, re.M)[1])
    return (
        f'<!DOCTYPE html>\n<html lang="en">\n<head><meta charset="utf-8"><title>{title}</title>\n'
        f"<style>{STYLE}</style></head>\n<body>\n"
        f'<nav><a href="index.html">Manual</a></nav>\n{body}\n</body>\n</html>\n'
    )


def slug(title: str, separator: str) -> str:
    """A heading's anchor, the same as GitHub's."""
    return re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", separator)
