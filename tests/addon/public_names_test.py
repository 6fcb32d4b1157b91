"""The public part of the Python package: names, documentation whose examples run, warnings, and PyVista's accessor."""

import doctest
import inspect
import re
import warnings
from functools import partial

import numpy as np
import pytest

import paradesc
from paradesc import api
from python_api_test import torus
from shapes import ADDON, ROOT

PUBLIC = {name: getattr(paradesc, name) for name in paradesc.__all__}
METHODS = {
    f"{kind.__name__}.{name}": method
    for kind in (paradesc.Mesh, paradesc.Result, paradesc.Profile, paradesc.Descriptor)
    for name, method in vars(kind).items()
    if inspect.isfunction(method) and not name.startswith("_")
}


@pytest.fixture(scope="module")
def mesh():
    return torus(48, 24)[:2]


def test_the_package_shows_what_it_offers_and_nothing_of_blender():
    assert [name for name in dir(paradesc) if not name.startswith("__")] == sorted(paradesc.__all__)


@pytest.mark.parametrize("name", sorted(PUBLIC) + sorted(METHODS))
def test_everything_public_is_documented(name):
    found = PUBLIC.get(name) or METHODS[name]
    text = inspect.getdoc(found)
    assert text.splitlines()[0].endswith(".")
    if not inspect.isfunction(found):
        return
    signature = inspect.signature(found)
    section = re.search(r"Parameters\n-+\n(.*?)\n\n(?:Returns|Raises)\n", text, re.DOTALL)
    described = re.findall(r"^(\S.*?)(?: : .*)?$", section.group(1), re.M) if section else []
    described = set(re.findall(r"\w+", " ".join(described)))
    assert set(signature.parameters) - {"self"} == described
    assert ("\nReturns\n-------\n" in text) == (signature.return_annotation is not None)


@pytest.mark.filterwarnings("error")  # an example shows how it is done well
@pytest.mark.parametrize("name", sorted(PUBLIC))
def test_everything_public_has_an_example_that_gives_what_it_shows(name):
    assert re.search(r"Examples\n-+\n", inspect.getdoc(PUBLIC[name]))
    (test,) = doctest.DocTestFinder(recurse=False).find(PUBLIC[name], name, globs={})
    assert not doctest.DocTestRunner().run(test).failed


def test_what_limits_values_is_a_warning_at_the_line_that_computes(mesh):
    with pytest.warns(paradesc.ParadescWarning, match="mean edge") as told:
        result = paradesc.compute(*mesh, radius=1e-3)
    assert [str(one.message) for one in told] == result.warnings
    assert {one.filename for one in told} == {__file__}
    with paradesc.Mesh(*mesh) as kept, pytest.warns(paradesc.ParadescWarning) as told:
        kept.compute(radius=1e-3)
    assert told[0].filename == __file__
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        paradesc.compute(*mesh, radius=0.1)


def test_an_unknown_keyword_is_a_type_error_that_names_the_nearest(mesh):
    def refused(call, **more):
        with pytest.raises(TypeError) as caught:
            call(**more)
        assert not isinstance(caught.value, ValueError)
        return str(caught.value)

    compute = partial(paradesc.compute, *mesh)
    sentence = "compute() got an unexpected keyword argument 'sampels'; the nearest is 'samples'."
    assert refused(compute, sampels=3) == sentence
    assert refused(compute, uv=None).endswith("'uvs'.")
    assert refused(compute, harris=1).endswith("'harris_k'.")
    assert refused(partial(paradesc.profile, *mesh), radius=0.1).endswith("'radius'; the nearest is 'radii'.")
    with paradesc.Mesh(*mesh) as kept:
        assert refused(kept.compute, sampels=3) == f"Mesh.{sentence}"
        assert "argument 'backend'" in refused(kept.compute, backend="cpu")  # of the mesh, which has it already


@pytest.mark.parametrize("kind", [np.float64, np.float32])
def test_values_are_float32_whatever_was_given_and_the_documentation_says_so(mesh, kind):
    points, faces = mesh
    assert paradesc.compute(points.astype(kind), faces, radius=0.1)["mean_curvature"].dtype == np.float32
    for text in (paradesc.compute.__doc__, (ADDON / "manual" / "python.md").read_text(encoding="utf-8")):
        assert "float32, also for float64 vertices: the library takes positions" in text


def test_radii_are_an_axis(mesh):
    result = paradesc.compute(*mesh, ["curvedness", "principal_direction_max"], radius=(0.05, 0.1))
    assert np.array_equal(result.over_radii("curvedness"), [result["curvedness_r0.05"], result["curvedness_r0.1"]])
    assert result.over_radii("principal_direction_max").shape == (2, len(mesh[0]), 3)
    assert result["curvedness", 0.1] is result["curvedness_r0.1"]
    assert ("curvedness", 0.1) in result
    with pytest.raises(KeyError, match="was not computed"):
        result["curvedness", 0.2]
    with pytest.raises(KeyError, match=re.escape("give a radius too, result['curvedness', 0.05]")):
        result["curvedness"]
    radii = np.array([0.05, 0.1]) / 3  # more digits than names have
    third = paradesc.compute(*mesh, "curvedness", radii, domain="faces")
    assert np.array_equal(third["curvedness", radii[1]], third["curvedness_r0.0333333"])
    one = paradesc.compute(*mesh, "curvedness", radius=0.1)
    assert one["curvedness", 0.1] is one["curvedness"]
    assert np.array_equal(one.over_radii("curvedness")[0], one["curvedness"])
    with pytest.raises(KeyError, match="curved"):
        result.over_radii("curved")


def test_the_radius_is_shown_as_a_length_and_as_a_share(mesh):
    diagonal = np.linalg.norm(np.ptp(mesh[0], axis=0))
    shown = repr(paradesc.compute(*mesh, radius=0.1))
    assert f"radius {0.1 * diagonal:.4g} = 10 % of the diagonal {diagonal:.4g}," in shown


def test_the_first_examples_give_the_radius_as_a_length():
    pages = [ADDON / "manual" / "python.md", ADDON / "PACKAGE.md"]
    for text in (api.__doc__, *(page.read_text(encoding="utf-8") for page in pages)):
        first = re.search(r"paradesc\.compute\(.*\)", text).group()
        assert 'radius=0.08, radius_unit="absolute")' in first


def test_bits_of_the_mask_have_names():
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [5, 5, 5]])
    mask = paradesc.compute(points, [[0, 1, 2]], radius=0.1).mask
    assert paradesc.Mask(int(mask[3])) == paradesc.Mask.NO_FACE
    assert paradesc.Mask.BOUNDARY in paradesc.Mask(int(mask[0]))
    assert (mask & paradesc.Mask.BOUNDARY != 0).tolist() == [True, True, True, False]
    assert set(re.findall(r"^([A-Z_]+)$", inspect.getdoc(paradesc.Mask), re.M)) == set(paradesc.Mask.__members__)


def test_the_metadata_is_complete():
    tomllib = pytest.importorskip("tomllib", reason="Python 3.10 has none")
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert project["entry-points"]["pyvista.accessors"] == {"paradesc": "paradesc.pyvista_accessor"}
    wanted = "description readme license license-files authors requires-python keywords classifiers"
    assert all(project[name] for name in wanted.split())


def test_pyvista_has_an_accessor(mesh):
    pyvista = pytest.importorskip("pyvista", "0.48")
    from paradesc import pyvista_accessor  # of the entry point, which sources have not

    assert pyvista_accessor.ParadescAccessor
    surface = pyvista.PolyData.from_regular_faces(*mesh)
    with pytest.warns(paradesc.ParadescWarning) as told:
        surface.paradesc.curvature(radius=1e-3)
    assert {one.filename for one in told} == {__file__}
    measured = surface.paradesc.curvature(radius=0.1)
    assert np.array_equal(measured["mean_curvature"], paradesc.compute(*mesh, radius=0.1)["mean_curvature"])
    assert "mean_curvature" not in surface.point_data
    faces = surface.paradesc.compute("curvedness", 0.1, domain="faces")
    assert len(faces.cell_data["curvedness"]) == surface.n_cells
    assert faces.active_scalars_name == "curvedness"
    found = doctest.DocTestFinder().find(pyvista_accessor.ParadescAccessor, "accessor", globs={})
    runner = doctest.DocTestRunner()
    assert not [one for one in (runner.run(test) for test in found) if one.failed]
