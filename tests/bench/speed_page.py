"""Turns the JSON files of run.py into tests/bench/REPORT.md, a plot of the peers, and the table in README.md."""

import json
from pathlib import Path

import figures
import numpy as np
import page
import peers
import sweeps
import timing

START, END = "<!-- speed: written by tests/bench/run.py --page -->", "<!-- end of speed -->"
QUICK, PLOT = "quick.json", "peers.png"


def write(results: Path, readme: Path | None) -> None:
    """Writes REPORT.md beside the folder of results, its plot, and README's part, from all results that are there."""
    quick = results / QUICK
    found = json.loads(quick.read_text()) if quick.is_file() else None
    lines = ["# Speed", "", *intro()]
    if found:
        drawn = plot(found, results / PLOT)
        lines += ratio_lines(found) + peer_lines(found, f"results/{PLOT}" if drawn else "") + stage_lines(found)
        if readme:
            fill(readme, readme_lines(found))
    else:
        lines += ["The ratios have not been measured yet: `--quick --page`.", ""]
    for name, sweep in sweeps.SWEEPS.items():
        path = results / f"{name}.json"
        if path.is_file():
            lines += page.markdown(page.load(path), results.name)
        else:
            lines += [f"## {sweep.title}", "", f"Not measured yet: `--sweep {name}`.", ""]
    (results.parent / "REPORT.md").write_text("\n".join(lines).rstrip() + "\n")


def intro() -> list[str]:
    """Says what the figures are."""
    return [
        "Written by `tests/bench/run.py`; [tests/README.md](../README.md#benchmarks) says how. Our times are "
        "whole frames, from positions in Python to results in Python, without what depends on topology and UV "
        "map alone; fitted normals are in them. The *baseline* is the paper's method in object space "
        "(`baseline.cpp`): Voronoi-weighted vertices within r, found by a flood over half-edges, on all "
        "cores; its set-up, normals and weights are not counted. It is timed at a random sample of the same "
        "mesh's vertices, as many as it can do in two seconds, and extrapolated. *Fewest*: the smallest buffers of "
        "256, 512 and 1024 texels, and then as few samples, as "
        f"keep the mean error against the reference at 400 random vertices to {timing.ALLOWED_ERROR:g} %. "
        "Errors are the one definition of this project (`addon/paradesc/core/compare.py`).",
        "",
    ]


def stamp_lines(found: dict) -> list[str]:
    """Says where and when this was measured."""
    words = [found[name] for name in ("date", "device")]
    words.append(f"{found['cpu']} × {found['cores']}")
    words.append(f"commit {found['commit']}, load before {found['load_before']}, `{found['command']}`")
    return [f"<sub>{', '.join(words)}</sub>", ""]


def ratio_lines(found: dict) -> list[str]:
    """Shows every key beside its target."""
    rows = []
    for name, figure in figures.FIGURES.items():
        value = found.get(name)
        wanted = f"{'≥' if figure.at_least else '≤'} {figure.target:g}"
        shown = "–" if value is None else page.shown(value)
        state = found["reasons"].get(name, "") if value is None else "yes" if figure.met(value) else "no"
        rows.append([f"`{name}`", figure.meaning, shown, wanted, state])
    lines = ["## Ratios", "", "| key | what | value | wanted | met |", "| --- | --- | ---: | ---: | --- |"]
    lines += ["| " + " | ".join(row) + " |" for row in rows]
    lines += ["", "Beside them:", "", "| key | value |", "| --- | ---: |"]
    lines += [f"| `{name}` | {page.shown(value)} |" for name, value in found["beside"].items()]
    return [*lines, "", *stamp_lines(found)]


def peer_rows(found: dict) -> list[tuple[str, float, float | None, float | None, str]]:
    """Label, seconds, error against the reference and against the closed form in percent, note; fastest first."""
    measured = found["measured"]
    bunny, closed = measured.get("bunny"), measured.get("errors_closed", {})
    rows = []
    for name, row in measured.get("peers", {}).items():
        note = "" if name in peers.SAME_RADIUS else row.get("note", "") or "another radius"
        rows.append((row["label"], row["seconds"], row.get("error"), row.get("error_closed"), row.get("note") or note))
    if bunny:
        for name in ("fewest", "at_256"):
            label = f"Paradesc, {bunny[name]['samples']} samples, whole frame"
            rows.append((label, bunny[name]["seconds"], bunny[name]["error"], closed.get(name), ""))
        base = bunny["baseline"]
        rows.append(("the paper's object-space method", base["seconds"], base.get("error"), closed.get("baseline"), ""))
    return sorted(rows, key=lambda row: row[1])


def percent(value: float | None) -> str:
    """An error as people read it."""
    if value is None or value != value:
        return "–"
    return "> 100" if value > 100 else page.shown(value)


def peer_table(found: dict) -> list[str]:
    """Shows time and error side by side."""
    lines = [
        "| mean curvature of stanford-bunny | ms | error % | error on a torus % | |",
        "| --- | ---: | ---: | ---: | --- |",
    ]
    for label, seconds, error, closed, note in peer_rows(found):
        bold = "**" if label.startswith("Paradesc") else ""
        lines.append(f"| {bold}{label}{bold} | {1e3 * seconds:.0f} | {percent(error)} | {percent(closed)} | {note} |")
    return lines


def peer_lines(found: dict, image: str) -> list[str]:
    """Writes the section about peers."""
    lines = ["## Other programs", ""]
    lines += [
        "69 451 triangles, r = 2 % of the diagonal for those that take a radius. *Error*: against the reference on the"
        " same mesh at that radius, which is not what programs of another radius or of rings measure; *on a torus*:"
        " against the closed form on 12 000 vertices, which is what all of them mean. Not counted: imports, making the"
        " mesh.",
        "",
        *peer_table(found),
        "",
    ]
    lines += [
        f"- Not measured: {name}: {text}" for name, text in found["reasons"].items() if name not in figures.FIGURES
    ]
    if image:
        lines += ["", f"![Time and error of curvature by several programs]({image})"]
    return [*lines, "", *stamp_lines(found)]


def stage_lines(found: dict) -> list[str]:
    """Shows where the time goes."""
    rows = []
    for part, kinds in (
        ("detail_100k", ("fewest", "max_normals", "at_texels", "at_256")),
        ("detail_1m", ("fewest", "max_normals", "at_texels", "at_256")),
        ("detail_2m", ("fewest", "max_normals", "at_texels", "at_256")),
        ("radius", ("small", "large")),
        ("bunny", ("fewest", "max_normals", "at_texels", "at_256")),
        ("gather_one_chart", ("evaluate", "affine")),
        ("gather_many_charts", ("evaluate", "affine")),
        ("together", ("one", "eight")),
    ):
        for kind in kinds:
            row = found["measured"].get(part, {}).get(kind)
            if row:
                stages = [row[f"seconds_{stage}"] for stage in timing.STAGES]
                rest = row["seconds"] - stages[-1]
                times = [row["seconds"], row["cpu_seconds"], *stages[:-1], rest]
                error = percent(row.get("error"))
                settings = [str(row["samples"]), str(row["buffer_size"])]
                rows.append([part, kind, *settings, error, *(f"{1e3 * one:.1f}" for one in times)])
    head = [
        "mesh",
        "",
        "samples",
        "buffers",
        "error %",
        "frame ms",
        "all cores ms",
        "prepare",
        "bake",
        "evaluate",
        "upload, gather, read",
    ]
    lines = ["## Where a frame's time goes", "", "| " + " | ".join(head) + " |"]
    lines += ["|" + " --- |" * 2 + " ---: |" * (len(head) - 2)]
    return [*lines, *("| " + " | ".join(row) + " |" for row in rows), "", *stamp_lines(found)]


def plot(found: dict, path: Path) -> bool:
    """Plots time against error on the torus, where the truth is known; False without matplotlib."""
    every = [(label, 1e3 * seconds, closed) for label, seconds, _, closed, _ in peer_rows(found) if closed]
    rows = [row for row in every if row[2] < 100]  # a larger one means another unit, not an error
    if page.pyplot is None or len(rows) < 3:
        return False
    figure, axes = page.pyplot.subplots(figsize=(7.2, 4.0), constrained_layout=True)
    middle = float(np.sqrt(rows[0][1] * rows[-1][1]))
    for number, (label, milliseconds, error) in enumerate(rows):
        color = "tab:red" if label.startswith("Paradesc") else "0.4"
        right = milliseconds > middle
        place = (-6 if right else 6, 4 if number % 2 else -9)
        axes.loglog(milliseconds, error, "o", color=color)
        wanted = {"textcoords": "offset points", "fontsize": 7, "color": color, "ha": "right" if right else "left"}
        axes.annotate(label.removesuffix(", the same radius"), (milliseconds, error), place, **wanted)
    axes.set(xlabel="ms, mean curvature of the bunny's 34 834 vertices", ylabel="mean error on a torus, %")
    axes.margins(x=0.12, y=0.15)
    axes.grid(alpha=0.3)
    figure.savefig(path, dpi=110)
    page.pyplot.close(figure)
    return True


def readme_lines(found: dict) -> list[str]:
    """What README shows: time and error beside other programs, and how the lead grows with detail."""
    lines = [
        "Mean curvature of the Stanford bunny (69,451 triangles, radius 2 % of the diagonal) on two CPU cores, without"
        " a graphics card. Times are whole frames; the error is the mean against the closed form on a torus.",
        "",
        "| | ms | error % |",
        "| --- | ---: | ---: |",
    ]
    for label, seconds, _, closed, note in peer_rows(found):
        bold = "**" if label.startswith("Paradesc") else ""
        name = label.removesuffix(", whole frame") + (f" ({note})" if note.startswith("extrapolated") else "")
        lines.append(f"| {bold}{name}{bold} | {1e3 * seconds:.0f} | {percent(closed)} |")
    growth = [
        f"{page.shown(found[f'speedup_{name}'])} times at {triangles}"
        for name, triangles in (("100k", "100 K triangles"), ("1m", "1 M"), ("2m", "2 M"))
        if found.get(f"speedup_{name}") is not None
    ]
    lines.append("")
    if growth:
        lines += [
            "The lead over the paper's object-space method on all cores grows with the mesh (r = 4 %, error below"
            f" 0.5 %): {', '.join(growth)}. [All figures and targets](tests/bench/REPORT.md)",
            "",
        ]
    return [*lines, *stamp_lines(found)]


def fill(readme: Path, lines: list[str]) -> None:
    """Puts lines between README's markers, if they are there."""
    text = readme.read_text()
    if START in text and END in text:
        before, rest = text.split(START, 1)
        readme.write_text(before + START + "\n" + "\n".join(lines).rstrip() + "\n" + END + rest.split(END, 1)[1])
