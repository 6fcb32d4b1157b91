"""Collects what the groups of tasks saw into one page by point: points.py FOLDER."""

import json
import sys
from pathlib import Path

# Words of Blender's console that are the add-on's fault.
NOISE = ("Traceback", "ERROR: Image", "pyrna_enum_to_py")
MARKS = {True: "yes", False: "**no**", None: "look"}


def order(point: str) -> tuple[str, int]:
    """A2 before A10."""
    return point[:1], int("".join(filter(str.isdigit, point)) or 0)


def main(folder: Path) -> None:
    """Writes points.md."""
    rows = [json.loads(line) for file in sorted(folder.glob("*.jsonl")) for line in file.read_text().splitlines()]
    for log in sorted(folder.glob("*.log")):
        noise = [line.strip() for line in log.read_text(errors="replace").splitlines() if any(words in line for words in NOISE)]
        text = f"the console of {log.stem} says: {noise[0]} ({len(noise)} such lines)" if noise else f"the console of {log.stem} is quiet"
        rows.append({"point": "C10", "text": text, "good": not noise, "picture": ""})
    lines = ["| point | what is now | as wanted | picture |", "|---|---|---|---|"]
    for row in sorted(rows, key=lambda row: order(row["point"])):
        lines.append(f"| {row['point']} | {row['text']} | {MARKS[row['good']]} | {row['picture']} |")
    (folder / "points.md").write_text("\n".join(lines) + "\n")
    wrong = [row for row in rows if row["good"] is False]
    sys.stdout.write(f"{len(rows)} findings, {len(wrong)} not as wanted, in {folder / 'points.md'}\n")
    for row in wrong:
        sys.stdout.write(f"  {row['point']}: {row['text']} ({row['picture']})\n")


main(Path(sys.argv[1]))
