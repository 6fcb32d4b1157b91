"""The notebooks and the gallery are what their code prints and draws, and the figures are right."""

import ast
import base64
import io
import json
import re
import sys
from importlib.util import find_spec

import numpy as np
import pytest

from conftest import blender_program
from shapes import ADDON

FOLDER = ADDON / "notebooks"
NAMES = ("scales", "shape_index", "sequence")
NEEDED = ("nbformat", "nbclient", "ipykernel", "pyvista", "matplotlib", "PIL")
OUTSIDE = re.compile(r"(?<![\w.:/~])/(?:home|root|tmp|usr|var|opt|work|mnt|Users)/|[A-Z]:\\\\")


def stored(name):
    """A notebook as it lies in the folder."""
    return json.loads((FOLDER / f"{name}.ipynb").read_text(encoding="utf-8"))


def code_cells(notebook):
    return [cell for cell in notebook["cells"] if cell["cell_type"] == "code"]


def text(lines):
    """A text of a notebook, which may be a list of lines."""
    return lines if isinstance(lines, str) else "".join(lines)


def printed(notebook):
    """The output of each cell with code."""
    return [
        "".join(text(output["text"]) for output in cell["outputs"] if output["output_type"] == "stream")
        for cell in code_cells(notebook)
    ]


def drawn(notebook):
    """The PNG files of all cells, in their order."""
    outputs = [output for cell in code_cells(notebook) for output in cell["outputs"] if "data" in output]
    return [base64.b64decode(text(output["data"]["image/png"])) for output in outputs]


def pixels(png):
    """(height, width, 3) float."""
    from PIL import Image

    with Image.open(io.BytesIO(png)) as image:
        return np.asarray(image.convert("RGB"), float)


def assert_alike(png, other):
    """Pictures that are not blank and differ in no more than what renderers do, such as how edges are smoothed."""
    found, expected = pixels(png), pixels(other)
    assert found.std() > 10
    assert found.shape == expected.shape
    assert np.abs(found - expected).mean() < 8


# ---- As they lie in the folder


@pytest.mark.parametrize("name", NAMES)
def test_a_notebook_has_its_outputs_and_is_small(name):
    notebook = stored(name)
    cells = code_cells(notebook)
    assert [cell["execution_count"] for cell in cells] == list(range(1, len(cells) + 1))
    outputs = [output for cell in cells for output in cell["outputs"]]
    assert {output["output_type"] for output in outputs} == {"stream", "display_data"}
    assert {output.get("name", "stdout") for output in outputs} == {"stdout"}
    assert all(cell["outputs"] or "show()" not in text(cell["source"]) for cell in cells)
    assert all(cell["metadata"] == {} for cell in notebook["cells"])
    assert set(notebook["metadata"]) == {"kernelspec", "language_info"}
    assert len(drawn(notebook)) >= 3
    assert (FOLDER / f"{name}.ipynb").stat().st_size < 600_000
    words = [text(cell["source"]) for cell in notebook["cells"]]
    assert not [found for word in (*words, *printed(notebook)) for found in OUTSIDE.findall(word)]


@pytest.mark.parametrize("name", NAMES)
def test_a_notebook_is_one_by_its_format(name):
    nbformat = pytest.importorskip("nbformat", reason="nbformat is not installed")
    nbformat.validate(nbformat.reads((FOLDER / f"{name}.ipynb").read_text(encoding="utf-8"), as_version=4))


def test_the_extra_brings_what_they_import():
    known = {"numpy", "paradesc", "pyvista", "matplotlib"} | sys.stdlib_module_names
    sources = [text(cell["source"]) for name in NAMES for cell in code_cells(stored(name))]
    sources += re.findall(r"^```python\n(.*?)^```", (FOLDER / "gallery.md").read_text(encoding="utf-8"), re.M | re.S)
    for source in sources:
        for node in ast.walk(ast.parse(source)):
            named = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
            named += [node.module] if isinstance(node, ast.ImportFrom) else []
            assert {name.split(".")[0] for name in named} <= known


def test_the_gallery_shows_what_is_drawn_and_nothing_else():
    page = (FOLDER / "gallery.md").read_text(encoding="utf-8")
    shown = re.findall(r"^```\n\n!\[.+?\]\(pictures/(\w+\.png)\)", page, re.M)
    assert shown == re.findall(r"\((?:\w+/)+(\w+\.png)\)", page)
    assert len(set(shown)) == len(shown) >= 8
    assert {path.name for path in (FOLDER / "pictures").iterdir()} == set(shown)
    assert len(re.findall(r"^```python", page, re.M)) == len(shown) + 1
    assert sum(path.stat().st_size for path in (FOLDER / "pictures").iterdir()) < 1_200_000


# ---- Run whole


@pytest.fixture(scope="module")
def make():
    """The command that makes them."""
    if missing := [name for name in NEEDED if find_spec(name) is None]:
        pytest.skip(f"{', '.join(missing)} not installed; blend_samples/setup.sh installs what notebooks need")
    if blender_program():
        pytest.skip("notebooks run in a Python of their own, not in Blender's")
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(str(FOLDER))
        import make
    return make


@pytest.fixture(scope="module")
def run(make):
    """Runs a notebook once."""
    done = {}

    def executed(name):
        if name not in done:
            done[name] = json.loads(json.dumps(make.executed(FOLDER / f"{name}.ipynb")))
        return done[name]

    return executed


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_a_notebook_prints_and_draws_what_is_stored(run, name):
    notebook, kept = run(name), stored(name)
    assert printed(notebook) == printed(kept)
    pictures, others = drawn(notebook), drawn(kept)
    assert len(pictures) == len(others)
    for picture, other in zip(pictures, others, strict=True):
        assert_alike(picture, other)


@pytest.mark.slow
def test_the_gallery_is_what_its_code_draws(make, tmp_path):
    make.draw_gallery(tmp_path)
    kept = {path.name: path.read_bytes() for path in (FOLDER / "pictures").iterdir()}
    assert {path.name for path in tmp_path.iterdir()} == set(kept)
    for name, other in kept.items():
        assert_alike((tmp_path / name).read_bytes(), other)


# ---- Figures


def numbers(lines):
    return [float(word) for word in re.findall(r"(?<![\w.])-?\d+(?:\.\d+)?(?![\w.])", lines)]


@pytest.mark.slow
def test_scales_sees_ripples_or_the_torus_and_no_meshing(run):
    said = "".join(printed(run("scales")))
    outer, inner = 1.4, 0.6  # distances from the axis
    expected = [0.2 / (0.8 * inner), 1.8 / (0.8 * outer), -1 / (0.4 * inner), 1 / (0.4 * outer)]
    assert numbers(re.search("plain torus: (.*)", said)[1]) == pytest.approx(expected, abs=5e-4)
    away = [float(value) for value in re.findall(r"([\d.]+) from the plain torus", said)]
    assert away == sorted(away, reverse=True)
    # A ripple bends by 0.004 (36²/ring² + 14²/0.4²)/2 at its top, 3.8 to 9.7; its mean square is a quarter of that
    assert 3.8 / 2 - 0.5 < away[0] < 9.7 / 2
    assert away[-1] < 0.04
    rows = re.findall(r"(0\.05|0\.1|0\.2|VTK) +([\d.]+) +([\d.]+)$", said, re.M)
    errors = {}
    for radius, *found in rows:
        errors.setdefault(radius, []).append([float(value) for value in found])
    assert {radius: len(found) for radius, found in errors.items()} == {"0.05": 3, "0.1": 3, "0.2": 3, "VTK": 3}
    assert np.max(errors["0.1"], axis=0)[0] < 0.5
    assert np.ptp(errors["0.2"], axis=0) == pytest.approx([0, 0], abs=0.5)  # percent, whatever the mesh
    assert np.min(errors["VTK"]) > 5
    assert 0.25 < numbers(re.search("least area found: (.*)%", said)[1])[0] / 100 <= 0.5
    assert [float(value) for value in re.findall(r"error of H [\w ]+: ([\d.]+) %", said)] == pytest.approx(
        [0, 0], abs=1.5
    )
    assert "nan, mask 1" in said


@pytest.mark.slow
def test_shape_index_has_all_classes_and_the_theorem_of_gauss_and_bonnet(run):
    said = "".join(printed(run("shape_index")))
    assert "closed: True" in said
    assert float(re.search(r"integral of K: ([\d.]+) of 4π", said)[1]) == pytest.approx(1, abs=0.02)  # radius, facets
    shares = [float(share) for share in re.findall(r"S = +-?[\d.]+ +([\d.]+) %", said)]
    assert len(shares) == 9
    assert min(shares) > 0.5
    assert sum(shares) == pytest.approx(100, abs=0.5)  # of figures that are rounded
    segments = re.findall(r"^[a-z ]+? +(\d+)  largest ([\d.]+)$", said, re.M)
    assert len(segments) == 9
    assert sum(int(count) for count, _ in segments) == int(re.search(r"(\d+) segments", said)[1])
    assert all(float(area) >= np.pi * 0.06**2 for _, area in segments)
    least, most, error = numbers(re.search("S from (.*)", said)[1])
    assert (least, most) == pytest.approx(2 / np.pi * np.arctan([0.2, 1.8]), abs=5e-4)
    assert error < 0.005
    assert all(float(angle) < 0.5 for angle in re.findall(r"([\d.]+)°", said))


def bending_energy(t):
    """The energy of the notebook's rod without its ends, minus that of a straight rod: a sum over its surface."""
    s, around = np.meshgrid((np.arange(1500) + 0.5) / 750, 2 * np.pi * np.arange(64) / 64, indexing="ij")
    toward = 4 * min(4 * t, 1) * np.sin(2 * np.pi * (s / 1.6 - t)) * np.cos(around)
    squared = (1 / 0.12**2 + (toward / (1 - 0.12 * toward)) ** 2) / 2
    area = 0.12 * (1 - 0.12 * toward) * (2 * np.pi / 64) / 750
    return (squared * area).sum() - np.pi * 2 / 0.12


@pytest.mark.slow
def test_sequence_has_the_bits_of_one_mesh_and_the_energy_of_a_bent_rod(run):
    said = "".join(printed(run("sequence")))
    assert re.findall(r"the same bits: (\w+)", said) == ["True", "True"]
    straight = 4 * np.pi + np.pi * 2 / 0.12  # two half balls, and a tube
    assert numbers(re.search("straight rod: (.*)", said)[1]) == pytest.approx([straight] * 2, rel=0.01)
    rows = np.array([numbers(line) for line in re.findall(r"^ +\d+ +[\d.]+ +[\d.]+$", said, re.M)])
    assert rows[:, 0].tolist() == [0, 4, 8, 16, 24]
    expected = np.array([bending_energy(frame / 24) for frame in rows[:, 0]])
    assert rows[:, 2] == pytest.approx(expected, abs=2e-3)
    assert rows[1:, 1] == pytest.approx(expected[1:], rel=0.08)  # of a radius that is a fifth of the rod's
    assert float(re.search(r"mean error at these places: ([\d.]+)", said)[1]) < 0.05
