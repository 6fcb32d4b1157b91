"""The results of tests/drivers.py as tables of tests/DRIVERS.md: drivers, and registers of the slow programs."""

import platform
import re
from pathlib import Path

FIELDS = ("VGPRs", "SGPRs", "Spilled VGPRs", "Spilled SGPRs", "Scratch", "LDS", "Max Waves")
EVALUATE = "paper/evaluate/evaluate.comp.glsl"


def lines_of_file(path):
    """A text's own file and its words: variants that are on, and the descriptors that it stores."""
    text = path.read_text(encoding="utf-8")
    file = re.findall(r"^// 0: (.*)", text, re.MULTILINE)[-1]
    variants = set(re.findall(r"^#define (\w+) 1$", text, re.MULTILINE))
    variants |= {"HALF_FLOATS"} & set(re.findall(r"^#define (\w+)$", text, re.MULTILINE))
    stored = tuple(re.findall(r"(\w+)\(sums\.terms, sums\.center, neighborhood\)", text))
    group = next(iter(re.findall(r"^#define GROUP_SIZE (\d+)", text, re.MULTILINE)), "")
    return file, frozenset(variants), stored, group


def name_of(file, variants, stored):
    """The name of a program in the table, or nothing if it has no row there."""
    if file != EVALUATE:
        return ", ".join([file.removeprefix("paper/"), *("16 bits" for _ in {"HALF_FLOATS"} & variants)])
    if variants & {"INTEGRAL", "GEODESIC_BALL", "ADAPTIVE", "HALF_FLOATS", "CHORDS", "DIRECTIONAL"}:
        return ""
    if len(stored) > 1:
        what = "operators" if "laplacian" in stored else "all descriptors"
        what = "operators in windows" if "harris" in stored else what
    elif stored in (("mean_curvature",), ("gaussian_curvature",), ("sphere_volume",)):
        what = stored[0].replace("_", " ")
    else:
        return ""
    return f"{what}, {'paper' if 'PAPER' in variants else 'affine'}"


def registers_of(text, folder):
    """Rows by name of one compiler: the numbers that it printed for each program that has a row."""
    rows = {}
    for part in text.split("\nprogram ")[1:]:
        number = part.split("\n", 1)[0].strip()
        stats = re.findall(r"SGPRS: .*?Max Waves: \d+.*", part)
        stages = [path for path in Path(folder).glob(f"{number}.*") if path.suffix in (".comp", ".frag")]
        if not stages or not stats:
            continue
        file, variants, stored, group = lines_of_file(stages[0])
        name = name_of(file, variants, stored) if group in ("", "64") else ""
        if name:
            rows[name] = numbers_of(stats[-1])
    return rows


def numbers_of(line):
    """The numbers of one line of the driver's own counts, by FIELDS."""
    found = {name.lower(): int(value) for name, value in re.findall(r"([A-Z][A-Za-z ]*): (\d+)", line)}
    return [found.get(field.lower()) for field in FIELDS]


def cell(numbers):
    """VGPRs · SGPRs · waves, and what is spilled or lies in memory if anything does."""
    if not numbers:
        return "–"
    vector, scalar, spilled_vector, spilled_scalar, scratch, shared, waves = numbers
    bad = [
        f"**{count} {what}**"
        for count, what in (
            (spilled_vector, "VGPRs spilled"),
            (spilled_scalar, "SGPRs spilled"),
            (scratch, "bytes of scratch"),
            (shared, "bytes of LDS"),
        )
        if count
    ]
    return " · ".join([str(vector), str(scalar), str(waves), *bad])


def registers_table(registers):
    """registers: by driver, rows by name. Markdown."""
    names = sorted({name for rows in registers.values() for name in rows})
    lines = ["| VGPRs · SGPRs · waves | " + " | ".join(registers) + " |", "| --- |" + " --- |" * len(registers)]
    for name in names:
        lines.append(f"| {name} | " + " | ".join(cell(rows.get(name)) for rows in registers.values()) + " |")
    return "\n".join(lines)


def processor():
    """The name of this machine's processor."""
    found = re.findall(r"^model name\s*: (.*)", Path("/proc/cpuinfo").read_text(encoding="utf-8"), re.MULTILINE)
    return found[0] if found else platform.processor()


def drivers_table(outcomes):
    """Markdown: how each driver did, and why tests were skipped or failed."""
    lines = [
        "| driver | of | passed | failed | skipped | seconds | date |",
        "| --- | --- | ---: | ---: | ---: | ---: | --- |",
    ]
    for one in outcomes:
        counts = f"{one.passed} | {len(one.failed)} | {len(one.skipped)} | {one.seconds:.0f}"
        lines.append(f"| {one.title} | {one.unit} | {counts} | {one.date} |")
    lines.append("")
    for one in outcomes:
        for name, why in (one.skipped | one.failed).items():
            lines.append(f"- {one.title}: `{name}` {'failed' if name in one.failed else 'was skipped'}: {why}")
    return "\n".join(lines).rstrip()


def write(path, outcomes):
    """Writes the page's tables between its marks; what stands around them is kept."""
    page = path.read_text(encoding="utf-8")
    tables = {
        "drivers": f"{processor()}, seconds of the clock.\n\n{drivers_table(outcomes)}",
        "registers": registers_table({one.title: one.registers for one in outcomes if one.registers}),
    }
    for name, table in tables.items():
        before, rest = page.split(f"<!-- {name} -->\n")
        page = f"{before}<!-- {name} -->\n{table}\n<!-- end -->" + rest.split("<!-- end -->", 1)[1]
    path.write_text(page, encoding="utf-8")
