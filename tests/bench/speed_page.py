"""Turns the JSON files of run.py and python_peers.py into tests/bench/REPORT.md, a plot of the peers, and the tables in
README.md and the manual."""

import json
from pathlib import Path

import figures
import page
import sweeps
import timing

START, END = "<!-- speed: written by tests/bench/run.py --page -->", "<!-- end of speed -->"
PYTHON_START = "<!-- packages: written by tests/bench/python_peers.py --page -->"
PYTHON_END = "<!-- end of packages -->"
QUICK, PLOT, PYTHON = "quick.json", "peers.png", "python_peers.json"
WAYS = ("fewest", "at_256", "one_core")  # in which frames of the bunny are timed beside other programs
# The same program as a Python package, which has errors on surfaces that are not smooth, by its label in README's table.
PACKAGE_OF = {
    "Paradesc, 256 samples": "paradesc",
    "VTK, mean curvature": "pyvista",
    "PyMeshLab, discrete": "pymeshlab_discrete",
    "PyMeshLab, scale-dependent quadric, the same radius": "pymeshlab_quadric",
    "libigl, 2 rings": "libigl2",
    "libigl, 5 rings": "libigl5",
    "MeshLab's APSS, scale 4": "pymeshlab_apss4",
    "MeshLab's APSS, scale 8": "pymeshlab_apss8",
    "trimesh, ball measure, the same radius": "trimesh",
}
BESIDE = {"paradesc_auto": "**Paradesc, radius chosen by itself**", "pymeshlab_apss16": "MeshLab's APSS, scale 16"}


def write(results: Path, root: Path | None) -> None:
    """Writes REPORT.md beside the folder of results, its plot, and the parts of README and manual below a root, from
    all results that are there."""
    found, packages = (stored(results / name) for name in (QUICK, PYTHON))
    lines = ["# Speed", "", *intro()]
    if found:
        drawn = plot(found, results / PLOT)
        lines += ratio_lines(found) + peer_lines(found, f"results/{PLOT}" if drawn else "") + stage_lines(found)
        if root:
            fill(root / "README.md", readme_lines(found, packages))
    else:
        lines += ["The ratios have not been measured yet: `--quick --page`.", ""]
    if packages:
        lines += python_lines(packages)
        if root:
            fill(root / "addon" / "manual" / "python.md", manual_lines(packages), PYTHON_START, PYTHON_END)
    for name, sweep in sweeps.SWEEPS.items():
        path = results / f"{name}.json"
        if path.is_file():
            lines += page.markdown(page.load(path), results.name)
        else:
            lines += [f"## {sweep.title}", "", f"Not measured yet: `--sweep {name}`.", ""]
    (results.parent / "REPORT.md").write_text("\n".join(lines).rstrip() + "\n")


def stored(path: Path) -> dict | None:
    """The content of a file of results, if it exists."""
    return json.loads(path.read_text()) if path.is_file() else None


def intro() -> list[str]:
    """Says what the figures are."""
    return [
        "Written by `tests/bench/run.py`; [tests/README.md](../README.md#benchmarks) says how. Our times are "
        "whole frames, from positions in Python to results in Python, without what depends on topology and UV "
        "map alone; fitted normals are in them. The *baseline* is the paper's method in object space "
        "(`baseline.cpp`): Voronoi-weighted vertices within r, found by a flood over half-edges, on all "
        "cores; its set-up, normals and weights are not counted. It is timed at a random sample of the same "
        "mesh's vertices, as many as it can do in two seconds, and extrapolated. *Fewest*: as few samples as "
        f"keep the mean error against the reference at 400 random vertices to {figures.ALLOWED_ERROR:g} %. "
        f"*Fine*: to {figures.FINE_ERROR:g} %. Frames are timed beside what they are "
        "compared with: the baseline before and after them, other programs in turns with them. "
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
    lines = ["## Ratios", "", "| key | what | value | wanted | met |", "| --- | --- | ---: | ---: | --- |"]
    lines += figure_rows(figures.FIGURES, found, found["reasons"])
    lines += ["", "Beside them:", "", "| key | value |", "| --- | ---: |"]
    lines += [f"| `{name}` | {page.shown(value)} |" for name, value in found["beside"].items()]
    return [*lines, "", *stamp_lines(found)]


def figure_rows(rows: dict[str, figures.Figure], values: dict, reasons: dict[str, str]) -> list[str]:
    """A line of the table for each figure: its value beside its target, or why it is missing."""
    lines = []
    for name, figure in rows.items():
        value = values.get(name)
        wanted = f"{'≥' if figure.at_least else '≤'} {figure.target:g}"
        shown = "–" if value is None else page.shown(value)
        state = reasons.get(name, "") if value is None else "yes" if figure.met(value) else "no"
        lines.append("| " + " | ".join([f"`{name}`", figure.meaning, shown, wanted, state]) + " |")
    return lines


def peer_rows(found: dict, ways: tuple = WAYS) -> list[tuple[str, float, float | None, float | None, str]]:
    """Label, seconds, error against the reference and against the closed form in percent, note; fastest first."""
    measured = found["measured"]
    bunny, closed = measured.get("bunny"), measured.get("errors_closed", {})
    rows = []
    for row in measured.get("peers", {}).values():
        note = row.get("note") or ("" if row.get("same_radius") else "another radius")
        rows.append((row["label"], row["seconds"], row.get("error"), row.get("error_closed"), note))
    if bunny:
        for way in (way for way in ways if way in bunny):
            label = f"Paradesc, {bunny[way]['samples']} samples" + ", one core" * (way == "one_core")
            error = closed.get("at_256" if way == "one_core" else way)
            rows.append((label, bunny[way]["seconds"], bunny[way]["error"], error, ""))
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
    detail = ("fewest", "fine", "max_normals", "at_256", "one_core")
    for part, kinds in (
        ("detail_100k", detail),
        ("detail_1m", detail),
        ("detail_2m", detail),
        ("radius", ("small", "large")),
        ("bunny", detail),
        ("together", ("one", "eight", "sixteen", "twenty")),
    ):
        measured = found["measured"].get(part, {})
        rows += [[part, kind, *stage_cells(measured[kind])] for kind in kinds if kind in measured]
    head = ["mesh", "", "samples", "error %", "frame ms", "all cores ms", "prepare", "evaluate", "upload, gather, read"]
    lines = ["## Where a frame's time goes", "", "| " + " | ".join(head) + " |"]
    lines += ["|" + " --- |" * 2 + " ---: |" * (len(head) - 2)]
    return [*lines, *("| " + " | ".join(row) + " |" for row in rows), "", *stamp_lines(found)]


def stage_cells(row: dict) -> list[str]:
    """One frame's samples, error and milliseconds by stage."""
    prepare, evaluate, total = (row[f"seconds_{stage}"] for stage in timing.STAGES)
    times = [row["seconds"], row["cpu_seconds"], prepare, evaluate, row["seconds"] - total]
    return [str(row["samples"]), percent(row.get("error")), *(f"{1e3 * one:.1f}" for one in times)]


def plot(found: dict, path: Path) -> bool:
    """Plots time against error on the torus, where the truth is known; False without matplotlib."""
    every = [(label, 1e3 * seconds, closed) for label, seconds, _, closed, _ in peer_rows(found) if closed]
    rows = [row for row in every if row[2] < 100]  # a larger one means another unit, not an error
    if page.pyplot is None or len(rows) < 3:
        return False
    figure, axes = page.pyplot.subplots(figsize=(9.0, 4.0), constrained_layout=True)
    for number, (label, milliseconds, error) in enumerate(rows, 1):
        color = "tab:red" if label.startswith("Paradesc") else "0.4"
        name = f"{number}  {label.removesuffix(', the same radius')}"
        axes.loglog(milliseconds, error, "o", color=color, label=name)
        place = (5, 4) if number % 2 else (-5, -10)
        axes.annotate(str(number), (milliseconds, error), place, textcoords="offset points", fontsize=7, color=color)
    figure.legend(loc="outside right center", fontsize=7, frameon=False, handlelength=1, labelcolor="linecolor")
    axes.set(xlabel="ms, mean curvature of the bunny's 34 834 vertices", ylabel="mean error on a torus, %")
    axes.margins(x=0.12, y=0.15)
    axes.grid(alpha=0.3)
    figure.savefig(path, dpi=110)
    page.pyplot.close(figure)
    return True


def rough_heads(packages: dict | None) -> list[str]:
    """The surfaces that are not smooth, on which any package was measured."""
    rows = packages["rows"].values() if packages else ()
    return list(dict.fromkeys(name for row in rows for name in row.get("rough", {})))


def rough_cells(row: dict, heads: list[str]) -> list[str]:
    """Errors of H there; a dash where there is none."""
    return [percent(row.get("rough", {}).get(name, {}).get("error_mean")) for name in heads]


def readme_lines(found: dict, packages: dict | None = None) -> list[str]:
    """The lines of README: each program once, time beside error, and the lead over the baseline on large meshes."""
    heads, rows = rough_heads(packages), packages["rows"] if packages else {}
    lines = [
        "Mean curvature of the Stanford bunny (69,451 triangles, radius 2 % of the diagonal) on two CPU cores, without"
        " a graphics card. Times are whole frames; the error is the mean against the closed form on a torus, clean and"
        " as scanners, segmentations and remeshers leave it.",
        "",
        f"| | {' | '.join(['ms', 'error %', *heads])} |",
        "| --- |" + " ---: |" * (2 + len(heads)),
    ]
    for label, seconds, _, closed, note in peer_rows(found, ("at_256",)):
        if closed and closed > 100:
            continue  # in another unit
        bold = "**" if label.startswith("Paradesc") else ""
        name = label + (f" ({note})" if note.startswith("extrapolated") else "")
        rough = rough_cells(rows.get(PACKAGE_OF.get(label, ""), {}), heads)
        lines.append(f"|{'|'.join([bold + name + bold, f'{1e3 * seconds:.0f}', percent(closed), *rough])}|")
    for row, label in [(rows[name], label) for name, label in BESIDE.items() if name in rows]:
        cells = [time_of(row, "bunny"), percent(row["torus"]["error_mean"]), *rough_cells(row, heads)]
        lines.append(f"|{'|'.join([label, *cells])}|")
    return [*lines, "", *growth_lines(found), *stamp_lines(found)]


def growth_lines(found: dict) -> list[str]:
    """How many times faster than the baseline a frame of the largest mesh is."""
    faster = found.get("speedup_2m")
    if not faster:
        return []
    return [
        f"On 2 M triangles, r = 4 %, a frame is {page.shown(faster)} times faster than the paper's object-space method"
        f" (error below {figures.FINE_ERROR:g} %). [All figures and targets](tests/bench/REPORT.md)",
        "",
    ]


def python_rows(found: dict) -> list[dict]:
    """Rows of Python packages, fastest on the last mesh first."""
    last = list(found["meshes"])[-1]
    return sorted(found["rows"].values(), key=lambda row: (row.get("untimed", False), row[last]["seconds"]))


def time_of(row: dict, mesh: str) -> str:
    """Milliseconds; a dash if the row was not measured in turns with the others."""
    return "–" if row.get("untimed") else f"{1e3 * row[mesh]['seconds']:.0f}"


def name_of(row: dict) -> str:
    """A package's label; ours is set in bold."""
    return f"**{row['label']}**" if row["label"].startswith("Paradesc") else row["label"]


def python_lines(found: dict) -> list[str]:
    """Writes the section about Python packages."""
    head = ["", "lines"]
    for mesh in found["meshes"]:
        head += [f"{mesh} ms", "cores", "H %", "K %"]
    lines = ["## Python packages", "", python_intro(found), "", "| " + " | ".join([*head, "size", "lacks"]) + " |"]
    lines.append("| --- |" + " ---: |" * (len(head) - 1) + " --- | --- |")
    for row in python_rows(found):
        cells = [name_of(row), str(row["lines"])]
        for mesh in found["meshes"]:
            one = row[mesh]
            cores = "–" if row.get("untimed") else f"{one['cpu_seconds'] / one['seconds']:.1f}"
            cells += [time_of(row, mesh), cores]
            cells += [percent(one["error_mean"]), percent(one["error_gaussian"])]
        lines.append("| " + " | ".join([*cells, row["size"], row["lacks"] or "–"]) + " |")
    lines += ["", f"Versions: {', '.join(f'{name} {version}' for name, version in found['versions'].items())}.", ""]
    lines += [f"- Not measured: {text}" for text in dict.fromkeys(found["reasons"].values())]
    return [*lines, *[""] * bool(found["reasons"]), *stamp_lines(found)]


def python_intro(found: dict) -> str:
    """Says what the job is and what its figures mean."""
    sizes = ", ".join(f"{name}: {size['triangles']:,} triangles" for name, size in found["meshes"].items())
    return (
        "The same job in each: mean and Gaussian curvature (H, K) at every vertex, as a Python user writes it "
        "(`python_jobs.py`), from arrays of vertices and faces to an array of each. *Lines* of code are counted in "
        "what is run; the import is one of them. Times are the fastest of three turns and include everything but the "
        "import, a package's own mesh too; each package uses the threads that it takes by itself (*cores*: seconds of "
        "all cores over seconds, which other programs on the machine make smaller). r = 2 % of the diagonal for those "
        f"that take a radius; {sizes}. *Errors* (mean, the better sign of H): on the torus, irregularly triangulated, "
        "against the closed form, which is what all of them mean; on the bunny against Paradesc's own reference at r, "
        "which is not what packages of another size measure. *Lacks*: what a user of the job has to add or to do "
        "without; directions are the principal ones. MeshLab's Quadric Fitting comes to libigl's 2 rings, and its PCA "
        "gives no curvature of any unit. Open3D has no curvature of meshes. CGAL has one at a radius, in C++ alone: it "
        "is in the table above."
    )


def manual_lines(found: dict) -> list[str]:
    """The lines of the manual: time on the last mesh, and errors on the first, which has a closed form."""
    first, *_, last = list(found["meshes"]) * 2
    rows = python_rows(found)
    heads = rough_heads(found)
    head = ["lines of code", f"{last}, ms", "H, error %", "K, error %", *heads, "measured over"]
    lines = ["", f"| | {' | '.join(head)} |"]
    lines.append("| --- |" + " ---: |" * (4 + len(heads)) + " --- |")
    for row in rows:
        rough = rough_cells(row, heads)
        errors = [percent(row[first][f"error_{name}"]) for name in ("mean", "gaussian")]
        cells = [name_of(row), str(row["lines"]), time_of(row, last), *errors, *rough, row["size"]]
        lines.append("| " + " | ".join(cells) + " |")
    used = ", ".join(f"{name} {version}" for name, version in found["versions"].items() if name != "paradesc")
    where = f"{found['cpu']}, {found['cores']} cores, {found['date']}, load before {found['load_before']}"
    return [*lines, "", f"Measured by `{found['command']}` ({where}) with {used}."]


def fill(page_file: Path, lines: list[str], start: str = START, end: str = END) -> None:
    """Puts lines between the markers of a page, if they are there."""
    text = page_file.read_text()
    if start in text and end in text:
        before, rest = text.split(start, 1)
        page_file.write_text(before + start + "\n" + "\n".join(lines).rstrip() + "\n" + end + rest.split(end, 1)[1])
