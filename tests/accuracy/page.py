"""Turns what a section of the report measured into a JSON file, pictures beside it, and its part of the page."""

import json
import math
import textwrap
import time
from dataclasses import asdict, dataclass, field
from pathlib import Path

from paradesc.files.png import write_png

try:
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot
except ImportError:
    pyplot = None

NO_MATPLOTLIB = (
    "matplotlib is not installed, so there are no plots; the numbers are in the tables (pip install matplotlib)."
)


@dataclass
class Table:
    """A table with its cells as they are shown."""

    caption: str
    head: list[str]
    rows: list[list[str]]


@dataclass
class Section:
    """One section of the report; numbers stay in JSON as the text that is shown."""

    name: str
    title: str
    paper: str  # the part of the paper that it compares with
    folder: Path
    stamp: str = ""  # date, device, command
    seconds: float = 0.0
    quick: bool = False
    items: list[dict] = field(default_factory=list)  # in the order in which they are shown
    missing: list[str] = field(default_factory=list)

    def say(self, text):
        """Adds a paragraph."""
        self.items.append({"kind": "text", "text": text})

    def lacks(self, sentence):
        """Adds a sentence about what could not be measured, once."""
        if sentence not in self.missing:
            self.missing.append(sentence)

    def table(self, caption, head, rows):
        """Adds a table; numbers have four significant digits."""
        self.items.append(
            {"kind": "table", **asdict(Table(caption, list(head), [[shown(x) for x in row] for row in rows]))}
        )

    def plot(self, name, caption, draw, columns=1, height=4.0):
        """Adds a plot: draw(axes...) paints with matplotlib; without it one sentence says so."""
        if pyplot is None:
            self.lacks(NO_MATPLOTLIB)
            return
        figure, axes = pyplot.subplots(1, columns, figsize=(6.4 * columns, height), constrained_layout=True)
        draw(*(axes if columns > 1 else [axes]))
        figure.get_layout_engine().set(rect=(0, 0.07, 1, 0.93))
        figure.text(0.01, 0.01, "\n".join(textwrap.wrap(self.stamp, 115 * columns)), fontsize=5.5, color="0.4")
        path = self.folder / f"{self.name}_{name}.png"
        figure.savefig(path, dpi=100)
        pyplot.close(figure)
        self.items.append({"kind": "image", "file": path.name, "text": caption})

    def picture(self, name, caption, image):
        """Adds an (h, w, 3) uint8 image."""
        path = self.folder / f"{self.name}_{name}.png"
        write_png(path, image)
        self.items.append({"kind": "image", "file": path.name, "text": caption})

    def save(self):
        content = asdict(self)
        del content["folder"]
        (self.folder / f"{self.name}.json").write_text(json.dumps(content, indent=1, ensure_ascii=False) + "\n")


def load(path):
    """Reads a section that was saved."""
    return Section(**json.loads(path.read_text()), folder=path.parent)


def shown(value):
    """A cell's text."""
    if isinstance(value, str):
        return value
    if value is None or (isinstance(value, float) and math.isnan(value)):
        return "–"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, int):
        return f"{value:,}".replace(",", " ") if value >= 10000 else str(value)
    value = float(value)
    if value == 0 or 1e-3 <= abs(value) < 1e5:
        digits = 3 if abs(value) < 10 else 2 if abs(value) < 100 else 1
        return f"{value:.{digits}f}" if abs(value) >= 0.1 or value == 0 else f"{value:.4f}"
    return f"{value:.1e}"


def markdown(section, images):
    """The lines of a section; images: the folder of its pictures as the page names it."""
    lines = [f"## {section.title}", ""]
    if section.paper:
        lines += [f"*In the paper: {section.paper}*", ""]
    for item in section.items:
        if item["kind"] == "text":
            lines += [item["text"], ""]
        elif item["kind"] == "image":
            lines += [f"![{item['text']}]({images}/{item['file']})", "", f"*{item['text']}*", ""]
        else:
            lines += [*table_lines(item), ""]
    lines += [f"- Not measured: {sentence}" for sentence in section.missing] + [""] * bool(section.missing)
    quick = ", quick" if section.quick else ""
    lines += [f"<sub>{section.stamp}; {section.seconds:.0f} s{quick}</sub>", ""]
    return lines


def table_lines(item):
    """A caption and the table; nothing if there are no rows."""
    if not item["rows"]:
        return []
    head = "| " + " | ".join(item["head"]) + " |"
    rule = "|" + "|".join(" --- " if is_text(column) else " ---: " for column in zip(*item["rows"], strict=True)) + "|"
    return [item["caption"], "", head, rule, *["| " + " | ".join(row) + " |" for row in item["rows"]]]


def is_text(cells):
    """Returns whether a column holds words; numbers are set flush right."""
    return any(cell[:1].isalpha() or "," in cell for cell in cells)


def today():
    return time.strftime("%Y-%m-%d")
