"""The bridge without Blender: contexts, meshes, fields, and every error as one sentence."""

import dataclasses
import re
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from paradesc import bridge
from paradesc.bridge import ParadescError, abi, library, options
from shapes import ADDON, RADIUS, ROOT, as_arrays, cube_sphere

OPTIONS = bridge.Options(radius=0.04, samples=128, buffer_size=512)
DEVICE = "software"


def compute(arrays, names=("mean_curvature",), backend=DEVICE, options=OPTIONS):
    """Values by name."""
    with bridge.Context(backend) as context, context.mesh(arrays) as mesh, mesh.compute(names, options) as field:
        return {name: field.values(name) for name in names}


def refusal(action, *arguments, **named):
    """The error of an action, which has to be one sentence."""
    with pytest.raises(ParadescError) as caught:
        action(*arguments, **named)
    sentence = caught.value.sentence
    assert sentence == str(caught.value)
    assert sentence.strip()
    assert "\n" not in sentence.strip()
    return caught.value


def test_bridge_never_imports_blender():
    numpy_folder = str(Path(np.__file__).parents[1])
    code = f"import sys; sys.path[:0] = [{str(ADDON)!r}, {numpy_folder!r}]; sys.modules['bpy'] = None\n"
    code += "import paradesc.bridge, paradesc.files.results\n"
    code += "from paradesc.core import color_maps, compare, job\n"
    subprocess.run([sys.executable, "-c", code], check=True)


def test_registry_names_are_unique_and_described():
    rows = bridge.descriptors()
    names = [row.name for row in rows]
    assert len(set(names)) == len(names)
    assert {"mean_curvature", "gaussian_curvature", "shape_index", "local_bending_energy"} <= set(names)
    assert all(row.label and row.description for row in rows)


def test_units_follow_the_power_of_length():
    units = {row.name: row.unit for row in bridge.descriptors()}
    assert units["mean_curvature"] == "1/length"
    assert units["gaussian_curvature"] == "1/length^2"
    assert units["sphere_volume"] == "length^3"
    assert units["shape_index"] == ""


def test_defaults_are_those_of_the_library():
    native = library.new_struct(abi.ComputeOptions)
    ours = bridge.Options()
    made = options.native_options(ours)
    native.map_descriptor = native.map_descriptor or made.map_descriptor  # without one, the library takes its own
    for name, _ in abi.ComputeOptions._fields_:
        assert getattr(native, name) == getattr(made, name), name


@pytest.mark.parametrize("backend", ["software", "cpu", "reference"])
def test_sphere_has_mean_curvature_one_over_radius(sphere, backend):
    values = compute(sphere, backend=backend)["mean_curvature"]
    # A 14-step cube sphere is a polyhedron; its fitted normals carry the sphere's curvature to well within two percent.
    np.testing.assert_allclose(values, 1 / RADIUS, rtol=0.02)


@pytest.mark.parametrize("backend", [DEVICE, "cpu"])
def test_backends_agree_with_the_reference(sphere, backend):
    names = ("mean_curvature", "gaussian_curvature", "local_bending_energy", "sphere_volume_normalized")
    device, reference = compute(sphere, names, backend=backend), compute(sphere, names, backend="reference")
    for name in names:
        # Noise of 128 samples on a coarse sphere; on fine meshes the mean errors are an order below.
        assert np.abs(device[name] - reference[name]).mean() < 0.01 * np.abs(reference[name]).mean(), name


def test_directions_are_unit_tangents(sphere):
    values = compute(sphere, ("principal_direction_max", "principal_direction_min"))
    for array in values.values():
        assert array.shape == (len(sphere.positions), 3)
        np.testing.assert_allclose(np.linalg.norm(array, axis=1), 1.0, atol=1e-5)
    across = np.einsum("ij,ij->i", values["principal_direction_max"], values["principal_direction_min"])
    np.testing.assert_allclose(across, 0.0, atol=1e-5)


def test_chords_need_a_straight_way_in_the_uv_map(sphere):
    with pytest.raises(bridge.ParadescError, match="straight ways in the UV map"):
        compute(sphere, options=dataclasses.replace(OPTIONS, geodesic="chords"))


def test_affine_relocation_finds_the_sphere(sphere):
    for name in ("connected", "affine"):
        values = compute(sphere, options=dataclasses.replace(OPTIONS, relocation=name))["mean_curvature"]
        np.testing.assert_allclose(values, 1 / RADIUS, rtol=0.02)


def test_same_input_gives_the_same_bits(sphere):
    assert np.array_equal(compute(sphere)["mean_curvature"], compute(sphere)["mean_curvature"])


def test_descriptors_together_equal_descriptors_alone(sphere):
    together = compute(sphere, ("mean_curvature", "curvedness"))
    assert np.array_equal(together["curvedness"], compute(sphere, ("curvedness",))["curvedness"])


def test_reports_count_what_is_there(sphere):
    with bridge.Context(DEVICE) as context, context.mesh(sphere) as mesh:
        report = mesh.report()
        assert report["vertex_count"] == len(sphere.positions)
        assert report["triangle_count"] == len(sphere.triangle_corners)
        assert report["charts"] == 6
        assert report["boundary_edges"] == 0
        np.testing.assert_allclose(report["diagonal"], 2 * RADIUS * np.sqrt(3), rtol=0.02)
        with mesh.compute(("mean_curvature",), OPTIONS) as field:
            found = field.report()
    np.testing.assert_allclose(found["radius"], 0.04 * report["diagonal"], rtol=1e-5)
    assert found["undefined_vertices"] == 0
    assert 0.98 < found["coverage_mean"] <= 1.0


def test_coverage_and_mask_come_with_every_result(sphere):
    with (
        bridge.Context(DEVICE) as context,
        context.mesh(sphere) as mesh,
        mesh.compute(["curvedness"], OPTIONS) as field,
    ):
        coverage, mask = field.values("coverage"), field.mask()
    assert coverage.shape == mask.shape == (len(sphere.positions),)
    assert (coverage > 0.9).all()
    assert not mask.any()


def test_loose_vertex_is_undefined_and_the_others_are_not(sphere):
    arrays = dataclasses.replace(sphere, positions=np.vstack([sphere.positions, [[0, 0, 0]]]).astype(np.float32))
    values = compute(arrays)["mean_curvature"]
    assert np.isnan(values[-1])
    assert np.isfinite(values[:-1]).all()


def test_new_positions_scale_the_curvature(sphere):
    with bridge.Context(DEVICE) as context, context.mesh(sphere) as mesh:
        mesh.set_positions(3 * sphere.positions)
        with mesh.compute(["mean_curvature"], OPTIONS) as field:
            np.testing.assert_allclose(field.values("mean_curvature"), 1 / (3 * RADIUS), rtol=0.02)


def test_field_outlives_its_mesh_and_context(sphere):
    with bridge.Context(DEVICE) as context, context.mesh(sphere) as mesh:
        field = mesh.compute(["mean_curvature"], OPTIONS)
    assert np.isfinite(field.values("mean_curvature")).all()
    field.close()


@pytest.mark.parametrize("backend", ["cpu", "reference"])
def test_some_backends_need_no_uv_map(sphere, backend):
    arrays = dataclasses.replace(sphere, corner_uvs=None)
    values = compute(arrays, backend=backend)["mean_curvature"]
    np.testing.assert_allclose(values, 1 / RADIUS, rtol=0.02)


def test_device_without_uv_map_is_refused(sphere):
    arrays = dataclasses.replace(sphere, corner_uvs=None)
    assert "UV" in refusal(compute, arrays).sentence


def test_cancelled_computation_leaves_the_mesh_usable(sphere):
    with bridge.Context(DEVICE) as context, context.mesh(sphere) as mesh:
        error = refusal(mesh.compute, ["mean_curvature"], OPTIONS, lambda stage, fraction: False)
        assert error.status == abi.STATUS_CANCELLED
        with mesh.compute(["mean_curvature"], OPTIONS) as field:
            assert np.isfinite(field.values("mean_curvature")).all()


def test_progress_rises_from_stage_to_stage(sphere):
    seen = []
    with bridge.Context(DEVICE) as context, context.mesh(sphere) as mesh:
        mesh.compute(
            ["mean_curvature"], OPTIONS, lambda stage, fraction: seen.append((stage, fraction)) or True
        ).close()
    fractions = [fraction for _, fraction in seen]
    assert fractions
    assert fractions == sorted(fractions)
    assert 0 <= fractions[0] <= fractions[-1] <= 1
    assert all(stage for stage, _ in seen)


def test_exception_in_progress_reaches_the_caller(sphere):
    def interrupt(stage, fraction):
        raise KeyboardInterrupt

    with bridge.Context(DEVICE) as context, context.mesh(sphere) as mesh, pytest.raises(KeyboardInterrupt):
        mesh.compute(["mean_curvature"], OPTIONS, interrupt)


@pytest.mark.parametrize(
    "change",
    [
        {"radius": 0.0},
        {"radius": -1.0},
        {"radius": float("nan")},
        {"radius": 1.5},
        {"samples": 0},
        {"samples": 2**40},
        {"buffer_size": 1},
        {"normals": "none"},
        {"radius_unit": "miles"},
        {"relocation": "rocket"},
        {"max_jumps": -1},
        {"seed": -1},
    ],
    ids=str,
)
def test_bad_option_is_one_sentence(sphere, change):
    error = refusal(compute, sphere, options=dataclasses.replace(OPTIONS, **change))
    assert error.status == abi.STATUS_INVALID_ARGUMENT


def test_unknown_descriptor_is_named(sphere):
    error = refusal(compute, sphere, ("pointiness",))
    assert error.status == abi.STATUS_INVALID_ARGUMENT
    assert "pointiness" in error.sentence


def test_value_that_was_not_asked_for_is_refused(sphere):
    with (
        bridge.Context(DEVICE) as context,
        context.mesh(sphere) as mesh,
        mesh.compute(["curvedness"], OPTIONS) as field,
    ):
        refusal(field.values, "mean_curvature")


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_position_that_is_not_finite_is_named(sphere, value):
    positions = sphere.positions.copy()
    positions[17, 1] = value
    error = refusal(compute, dataclasses.replace(sphere, positions=positions))
    assert error.status == abi.STATUS_INVALID_ARGUMENT
    assert "17" in error.sentence


@pytest.mark.parametrize("member", ["corner_vertices", "triangle_corners"])
@pytest.mark.parametrize("index", [-1, 10**6])
def test_index_out_of_range_is_named(sphere, member, index):
    array = getattr(sphere, member).copy()
    array.reshape(-1)[5] = index
    error = refusal(compute, dataclasses.replace(sphere, **{member: array}))
    assert error.status == abi.STATUS_INVALID_ARGUMENT
    assert str(index) in error.sentence.replace(",", "")


def test_mesh_without_triangles_is_refused(sphere):
    arrays = dataclasses.replace(sphere, triangle_corners=np.zeros((0, 3), np.int32))
    assert refusal(compute, arrays).status == abi.STATUS_INVALID_ARGUMENT


@pytest.mark.parametrize(
    ("member", "array"),
    [
        ("positions", np.zeros((5, 2))),
        ("corner_uvs", np.zeros((3, 2))),
        ("triangle_smooth", np.ones(1)),
        ("corner_vertices", np.zeros((4, 2))),
    ],
)
def test_array_of_wrong_shape_never_reaches_c(sphere, member, array):
    error = refusal(compute, dataclasses.replace(sphere, **{member: array}))
    assert member in error.sentence


def test_backend_and_device_that_do_not_exist_are_refused():
    refusal(bridge.Context, "vulkan")
    refusal(bridge.Context, DEVICE, 1000)


def test_missing_library_is_one_clear_sentence(tmp_path):
    error = refusal(library.open_library, tmp_path / "libparadesc.so")
    assert error.sentence.startswith("native library missing – ")


def test_broken_library_is_one_clear_sentence(tmp_path):
    path = tmp_path / "libparadesc.so"
    path.write_bytes(b"not a library")
    assert refusal(library.open_library, path).sentence.startswith("native library cannot be loaded – ")


def test_library_of_another_version_is_refused(tmp_path):
    functions = "".join(f"int {name}(void) {{ return 999; }}\n" for name in abi.FUNCTIONS)
    (tmp_path / "other.c").write_text(functions)
    path = tmp_path / "libother.so"
    subprocess.run(["cc", "-shared", "-fPIC", "-o", path, tmp_path / "other.c"], check=True)
    sentence = refusal(library.open_library, path).sentence
    assert "999" in sentence
    assert str(abi.ABI_VERSION) in sentence


def test_library_without_a_function_is_refused(tmp_path):
    (tmp_path / "old.c").write_text("int pdesc_abi_version(void) { return 1; }\n")
    path = tmp_path / "libold.so"
    subprocess.run(["cc", "-shared", "-fPIC", "-o", path, tmp_path / "old.c"], check=True)
    assert "does not fit" in refusal(library.open_library, path).sentence


def test_many_contexts_come_and_go():
    arrays = as_arrays(*cube_sphere(4))
    for _ in range(8):
        assert np.isfinite(compute(arrays, options=dataclasses.replace(OPTIONS, radius=0.2))["mean_curvature"]).all()


def test_what_takes_more_memory_than_allowed_is_refused_with_both_numbers(sphere):
    smooth = options.Options(creases="none")
    with bridge.Context("reference") as context, context.mesh(sphere) as mesh:
        needed = mesh.memory(["mean_curvature"], smooth)
    assert 0 < needed["mesh"] < needed["total"] <= needed["allowed"]
    with bridge.Context("reference", memory_limit=needed["total"] - 1) as context, context.mesh(sphere) as mesh:
        error = refusal(mesh.compute, ["mean_curvature"], smooth)
    assert error.status == abi.STATUS_OUT_OF_MEMORY
    assert "needs about" in error.sentence
    assert "may be used" in error.sentence
    with bridge.Context("reference", memory_limit=1000) as context:
        assert "A mesh of" in refusal(context.mesh, sphere).sentence


@pytest.mark.skipif(not shutil.which("nm"), reason="needs nm of binutils")
def test_library_asks_for_no_network_and_no_program():
    command = ["nm", "-D", "--undefined-only", library.library_path()]
    listed = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    names = {line.split()[-1].split("@")[0] for line in listed.splitlines()}
    assert "dlopen" in names, "else nm tells nothing"
    strange = {"socket", "connect", "getaddrinfo", "system", "popen", "fork", "vfork", "posix_spawn"}
    beginnings = ("exec", "gethost", "egl", "glX", "glGet")
    assert not {name for name in names if name in strange or name.startswith(beginnings)}


def test_library_reads_no_environment_and_looks_for_nothing_but_egl():
    sources = [path.read_text() for path in (ROOT / "native" / "src").rglob("*.[ch]*")]
    assert len(sources) > 50
    assert not [text for text in sources if "getenv" in text]
    assert sum(text.count("dlopen(") for text in sources) == 1
    found = re.findall(rb"lib(?:EGL|GL)[A-Za-z]*\.so[.0-9]*\0", library.library_path().read_bytes())
    assert set(found) == {b"libEGL.so.1\0"}


def test_library_is_loaded_from_the_folder_of_the_add_on_by_its_whole_path():
    path = library.library_path()
    assert path.is_absolute()
    assert path.parent.parent == Path(bridge.__file__).resolve().parent.parent
    assert Path(library.load_library()._name) == path
