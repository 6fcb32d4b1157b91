"""The command line as a process: every output, every refusal."""

import json
import signal
import subprocess
import sys

import numpy as np
import pytest

from conftest import command_line, completed, environment, real_mesh
from shapes import ROOT, cube_sphere, write_obj

bpy = pytest.importorskip("bpy", reason="needs Blender")

from paradesc.core import color_maps  # noqa: E402
from scene import add_sphere, attribute_values, empty_scene  # noqa: E402

QUICK = ("--radius", "0.06", "--samples", "64", "--buffer", "256", "--backend", "software")
NAMES = ("mean_curvature", "shape_index")


def refused(process, *words):
    """Checks that there is one sentence on stderr, no traceback, and this exit code."""
    assert process.returncode != 0
    sentence = process.stderr.strip()
    assert sentence.startswith("paradesc: ")
    assert "\n" not in sentence
    assert "Traceback" not in process.stderr + process.stdout
    for word in words:
        assert word in sentence
    return sentence


def accepted(process):
    """Checks exit code 0, and that stderr has only what Blender itself says there."""
    assert process.returncode == 0, process.stderr
    assert process.stderr.strip() == ""
    return process.stdout


def loaded(path):
    """All arrays of a .npz file."""
    with np.load(path) as file:
        return {name: file[name] for name in file.files}


def read_ply(path):
    """The vertex properties of a binary PLY file, and its faces (n, 3)."""
    content = path.read_bytes()
    end = content.index(b"end_header\n") + len(b"end_header\n")
    kinds = {"float": "<f4", "uchar": "u1"}
    layout, counts = [], {}
    for words in (line.split() for line in content[:end].decode().splitlines()):
        if words[0] == "element":
            counts[words[1]] = int(words[2])
        elif words[0] == "property" and words[1] != "list":
            layout.append((words[2], kinds[words[1]]))
    vertices = np.frombuffer(content, np.dtype(layout), counts["vertex"], end)
    face = np.dtype([("count", "u1"), ("vertices", "<i4", (3,))])
    faces = np.frombuffer(content, face, counts["face"], end + vertices.nbytes)
    assert end + vertices.nbytes + faces.nbytes == len(content)
    return vertices, faces


def test_one_run_writes_every_kind_of_output_and_they_agree(paradesc, sphere_obj, tmp_path):
    outputs = [tmp_path / f"out{suffix}" for suffix in (".npz", ".ply", ".blend")]
    words = [word for path in outputs for word in ("--output", path)]
    output = accepted(
        paradesc("bake", sphere_obj, "--descriptors", ",".join(NAMES), *QUICK, *words, "--json", "report.json")
    )
    assert 'object "sphere"' in output
    arrays = loaded(outputs[0])
    assert list(arrays) == ["vertices", "matrix_world", *NAMES, "coverage", "paradesc_mask"]
    count = len(cube_sphere()[0])
    assert arrays["vertices"].shape == (count, 3)
    assert arrays["matrix_world"].shape == (4, 4)
    assert all(arrays[name].shape == (count,) for name in (*NAMES, "coverage"))
    np.testing.assert_allclose(arrays["vertices"], cube_sphere()[0], atol=1e-5)

    vertices, faces = read_ply(outputs[1])
    assert np.array_equal(np.stack([vertices[axis] for axis in "xyz"], axis=1), arrays["vertices"])
    assert all(np.array_equal(vertices[name], arrays[name], equal_nan=True) for name in (*NAMES, "coverage"))
    assert faces["vertices"].shape == (2 * len(cube_sphere()[1]), 3)

    bpy.ops.wm.open_mainfile(filepath=str(outputs[2]))
    target = bpy.data.objects["sphere"]
    for name in (*NAMES, "coverage"):
        assert np.array_equal(attribute_values(target.data, name), arrays[name], equal_nan=True)
    colors = attribute_values(target.data, "mean_curvature_color")
    assert colors.shape == (count, 4)
    written = np.stack([vertices[name] for name in ("red", "green", "blue")], axis=1)
    np.testing.assert_allclose(written, 255 * color_maps.linear_to_srgb(colors[:, :3]), atol=0.51)
    assert (written[:, 0] > written[:, 2].astype(int) + 50).all()  # the sphere is convex, which is red
    assert target.data.color_attributes.active_color.name == "mean_curvature_color"
    np.testing.assert_allclose(np.array(target.matrix_world), arrays["matrix_world"], atol=1e-6)

    report = json.loads((tmp_path / "report.json").read_text())
    (row,) = report["objects"]
    assert row["object"] == "sphere"
    assert report["settings"]["descriptors"] == list(NAMES)
    assert row["mesh_report"]["charts"] == 6
    assert row["field_report"]["undefined_vertices"] == int(np.isnan(arrays["shape_index"]).sum())
    assert report["device"]
    assert isinstance(report["warnings"], list)
    assert row["descriptors"]["mean_curvature"]["minimum"] == float(np.nanmin(arrays["mean_curvature"]))


def test_sphere_is_right_through_the_command_line(paradesc, sphere_obj, tmp_path):
    accepted(paradesc("bake", sphere_obj, *QUICK, "--output", "out.npz"))
    # Radius 2; 64 samples on a coarse sphere.
    np.testing.assert_allclose(loaded(tmp_path / "out.npz")["mean_curvature"], 0.5, rtol=0.03)


@pytest.mark.slow
def test_same_command_gives_the_same_bytes(paradesc, sphere_obj, tmp_path):
    for name in ("a.npz", "b.npz"):
        accepted(paradesc("bake", sphere_obj, *QUICK, "--output", name))
    first, second = loaded(tmp_path / "a.npz"), loaded(tmp_path / "b.npz")
    assert all(np.array_equal(first[name], second[name]) for name in first)


@pytest.mark.slow
def test_seed_changes_the_samples(paradesc, sphere_obj, tmp_path):
    accepted(paradesc("bake", sphere_obj, *QUICK, "--output", "a.npz"))
    accepted(paradesc("bake", sphere_obj, *QUICK, "--seed", 7, "--output", "b.npz"))
    first, second = loaded(tmp_path / "a.npz"), loaded(tmp_path / "b.npz")
    assert not np.array_equal(first["mean_curvature"], second["mean_curvature"])


@pytest.mark.slow
def test_baked_ply_can_be_read_again(paradesc, sphere_obj, tmp_path):
    accepted(paradesc("bake", sphere_obj, *QUICK, "--output", "out.ply"))
    accepted(paradesc("bake", "out.ply", "--radius", "0.06", "--backend", "reference", "--output", "again.npz"))
    vertices, _ = read_ply(tmp_path / "out.ply")
    np.testing.assert_allclose(loaded(tmp_path / "again.npz")["vertices"][:, 0], vertices["x"], atol=1e-6)


@pytest.fixture
def two_spheres(tmp_path):
    """A scene whose active object is the smaller one of two."""
    empty_scene()
    add_sphere("large", steps=10)
    add_sphere("small", steps=6)
    path = tmp_path / "two.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path), check_existing=False)
    return path


def test_active_object_of_a_blend_is_taken_and_named(paradesc, two_spheres):
    output = accepted(paradesc("bake", two_spheres, *QUICK, "--output", "out.npz"))
    assert 'object "small"' in output


def test_object_can_be_named(paradesc, two_spheres, tmp_path):
    output = accepted(paradesc("bake", two_spheres, *QUICK, "--object", "large", "--output", "out.npz"))
    assert 'object "large"' in output
    assert len(loaded(tmp_path / "out.npz")["vertices"]) == len(cube_sphere(10)[0])


def test_largest_object_of_an_imported_file_is_taken(paradesc, tmp_path):
    points, quads, uvs = cube_sphere(6)
    large = write_obj(tmp_path / "a.obj", *cube_sphere(8)).read_text().replace("o sphere", "o large")
    count, corners = len(cube_sphere(8)[0]), 4 * len(cube_sphere(8)[1])
    small = ["o small"] + ["v {:.7f} {:.7f} {:.7f}".format(*(point + 9)) for point in points]
    small += ["vt {:.7f} {:.7f}".format(*uv) for uv in uvs.reshape(-1, 2)]
    for number, quad in enumerate(quads):
        words = [f"{vertex + 1 + count}/{4 * number + k + 1 + corners}" for k, vertex in enumerate(quad)]
        small.append("f " + " ".join(words))
    (tmp_path / "both.obj").write_text(large + "\n".join(small) + "\n")
    output = accepted(paradesc("bake", "both.obj", *QUICK, "--output", "out.npz"))
    assert 'object "large"' in output


@pytest.mark.slow
def test_compare_prints_a_table_and_writes_its_rows(paradesc, tmp_path):
    names = ("mean_curvature", "curvedness")
    points, quads, uvs = cube_sphere(20)
    ellipsoid = write_obj(tmp_path / "ellipsoid.obj", points * (1.0, 0.8, 0.6), quads, uvs)
    output = accepted(paradesc("compare", ellipsoid, "--descriptors", ",".join(names), *QUICK, "--json", "rows.json"))
    assert all(name in output for name in names)
    rows = json.loads((tmp_path / "rows.json").read_text())["rows"]
    assert [row["descriptor"] for row in rows] == list(names)
    expected = {
        "descriptor", "radius", "spread", "mean_percent_ae", "median_percent_ae", "p99_percent_ae", "max_percent_ae",
        "seam_mean_percent_ae", "coverage_mean", "undefined",
    }  # fmt: skip
    for row in rows:
        assert set(row) == expected
        assert row["radius"] == 0.06
        assert row["mean_percent_ae"] < 2.0  # 64 samples in small buffers


def test_list_names_descriptors_and_devices(paradesc):
    output = accepted(paradesc("list"))
    for word in ("mean_curvature", "shape_index", "software", "reference"):
        assert word in output


def test_help_is_shown(paradesc):
    assert "--descriptors" in accepted(paradesc("bake", "--help"))


@pytest.mark.slow
@pytest.mark.parametrize(
    "words",
    [
        ["--radius", "0"],
        ["--radius", "-0.1"],
        ["--radius", "nan"],
        ["--radius", "1.5"],
        ["--radius", "wide"],
        ["--samples", "0"],
        ["--samples", "-5"],
        ["--samples", "99999999999"],
        ["--buffer", "3"],
        ["--max-jumps", "-1"],
        ["--seed", "-1"],
        ["--descriptors", "pointiness"],
        ["--descriptors", ","],
        ["--descriptors", "curvedness,curvedness"],
        ["--normals", "none"],
        ["--backend", "vulkan"],
        ["--device", "1000"],
        ["--object", "nobody"],
        ["--frobnicate"],
    ],
    ids=" ".join,
)
def test_bad_option_is_one_sentence_and_writes_nothing(paradesc, sphere_obj, tmp_path, words):
    refused(paradesc("bake", sphere_obj, *QUICK[4:], "--output", "out.npz", *words))
    assert not (tmp_path / "out.npz").exists()


def test_failure_leaves_the_blend_and_an_old_output_as_they_were(paradesc, two_spheres, tmp_path):
    before = two_spheres.read_bytes()
    (tmp_path / "out.npz").write_bytes(b"old")
    words = ["--output", two_spheres, "--output", "out.npz", "--radius", "0", "--backend", "software"]
    refused(paradesc("bake", two_spheres, *words))
    assert two_spheres.read_bytes() == before
    assert (tmp_path / "out.npz").read_bytes() == b"old"


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "content", "word"),
    [
        ("nothing.obj", None, "no file"),
        ("odd.xyz", "x", ".obj"),
        ("junk.blend", "junk", "junk.blend"),
        ("junk.glb", "junk", "junk.glb"),
        ("junk.ply", "junk", ""),
        ("junk.obj", "junk", "mesh"),
        ("points.obj", "o points\nv 0 0 0\nv 1 0 0\nv 0 1 0\n", "mesh"),
        ("lines.obj", "o lines\nv 0 0 0\nv 1 0 0\nl 1 2\n", "faces"),
        ("beyond.obj", "o beyond\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nf 1/1 2/1 9/1\n", ""),
    ],
)
def test_bad_file_is_one_sentence(paradesc, tmp_path, name, content, word):
    if content is not None:
        (tmp_path / name).write_text(content)
    refused(paradesc("bake", name, *QUICK, "--output", "out.npz"), word)
    assert not (tmp_path / "out.npz").exists()


@pytest.mark.slow
def test_mesh_without_uv_map_is_unwrapped_and_said(paradesc, tmp_path):
    points, quads, _ = cube_sphere()
    write_obj(tmp_path / "bare.obj", points, quads, None)
    output = accepted(paradesc("bake", "bare.obj", *QUICK, "--output", "out.npz", "--output", "out.blend"))
    assert "note: The mesh has no UV map; Blender unwrapped a copy of it into" in output
    assert not [line for line in output.splitlines() if line.startswith(("Info", "Warning"))]
    np.testing.assert_allclose(loaded(tmp_path / "out.npz")["mean_curvature"], 0.5, rtol=0.05)
    again = accepted(paradesc("bake", tmp_path / "out.blend", *QUICK, "--output", "again.npz"))
    assert "that an earlier bake left in it" in again
    first, second = loaded(tmp_path / "out.npz"), loaded(tmp_path / "again.npz")
    assert np.array_equal(first["mean_curvature"], second["mean_curvature"])
    compared = accepted(paradesc("compare", "bare.obj", *QUICK))
    assert "Blender unwrapped a copy" in compared
    reference = accepted(paradesc("bake", "bare.obj", "--backend", "reference", "--output", "reference.npz"))
    assert "unwrapped" not in reference


def test_single_triangle_without_uv_map_is_baked(paradesc, tmp_path):
    (tmp_path / "bare.obj").write_text("o bare\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    accepted(paradesc("bake", "bare.obj", *QUICK, "--output", "out.npz"))
    np.testing.assert_allclose(loaded(tmp_path / "out.npz")["mean_curvature"], 0.0, atol=1e-5)


@pytest.mark.parametrize("output", ["out.gif", "out", "nowhere/out.npz"])
def test_bad_output_is_one_sentence(paradesc, sphere_obj, output):
    refused(paradesc("bake", sphere_obj, "--output", output))


def test_positions_that_are_not_finite_are_one_sentence(paradesc, tmp_path):
    empty_scene()
    add_sphere().data.vertices[3].co.x = float("nan")
    path = tmp_path / "nan.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path), check_existing=False)
    refused(paradesc("bake", path, *QUICK, "--output", "out.npz"), "3")


@pytest.mark.parametrize("words", [[], ["paint"], ["bake"], ["compare"]], ids=" ".join)
def test_incomplete_command_is_one_sentence(paradesc, words):
    if words == ["compare"] and bpy.app.binary_path:
        pytest.skip("Blender itself has an open file to compare on")
    refused(paradesc(*words))


def test_comparing_the_reference_with_itself_is_refused(paradesc, sphere_obj):
    refused(paradesc("compare", sphere_obj, "--backend", "reference"))


@pytest.mark.slow
@pytest.mark.parametrize(
    "name", ["degenerate_edge", "double_sided", "duplicate_edge", "zero_area_face", "zero_length_edge"]
)
def test_malformed_mesh_gives_results_for_its_sound_vertices(paradesc, tmp_path, name):
    path = real_mesh(f"malformed/{name}_planar_uv.obj")
    accepted(paradesc("bake", path, "--radius", "0.2", *QUICK[2:], "--output", "out.npz", "--json", "report.json"))
    arrays = loaded(tmp_path / "out.npz")
    (report,) = json.loads((tmp_path / "report.json").read_text())["objects"]
    found = report["mesh_report"]
    sound = found["triangle_count"] - found["degenerate_triangles"] - found["zero_uv_area_triangles"]
    assert np.isfinite(arrays["mean_curvature"]).any() == (sound > 0)
    assert report["field_report"]["undefined_vertices"] == int(np.isnan(arrays["mean_curvature"]).sum())


@pytest.mark.slow
def test_infinite_coordinates_that_blender_would_set_to_zero_are_refused(paradesc, tmp_path):
    path = real_mesh("malformed/infinite_coordinates.glb")
    process = paradesc("bake", path, *QUICK, "--output", "out.npz")
    refused(process, "infinite_coordinates.glb", "(-inf, -0.5, 0.5); positions have to be finite numbers")
    assert not (tmp_path / "out.npz").exists()


@pytest.mark.slow
def test_split_vertices_of_a_gltf_file_each_get_their_value(paradesc, tmp_path):
    accepted(
        paradesc(
            "bake", real_mesh("fox.glb"), "--radius", "0.05", *QUICK[2:], "--output", "out.npz", "--json", "r.json"
        )
    )
    arrays = loaded(tmp_path / "out.npz")
    (report,) = json.loads((tmp_path / "r.json").read_text())["objects"]
    assert report["mesh_report"]["welded_vertices"] > 1000
    _, place = np.unique(arrays["vertices"], axis=0, return_inverse=True)
    values, coverage = arrays["mean_curvature"], arrays["coverage"]
    assert np.isfinite(values).mean() > 0.95
    assert len(values) == len(coverage) == 1728
    first = np.full(place.max() + 1, np.nan)
    first[place] = values
    # Copies of a point are evaluated at the same place of the surface.
    spread = np.nanpercentile(values, 97.5) - np.nanpercentile(values, 2.5)
    assert np.nanmean(np.abs(values - first[place])) < 0.02 * spread


@pytest.mark.slow
@pytest.mark.parametrize("name", ["spot.obj", "bob.obj", "human.obj"])
def test_a_real_mesh_is_near_the_reference(paradesc, tmp_path, name):
    accepted(paradesc("compare", real_mesh(name), "--backend", "cpu", "--json", "rows.json"))
    (row,) = json.loads((tmp_path / "rows.json").read_text())["rows"]
    assert row["mean_percent_ae"] <= 0.1
    assert row["coverage_mean"] == 1.0


@pytest.mark.skipif(not bpy.app.binary_path, reason="needs Blender's own executable")
def test_blender_bakes_the_file_it_has_open(two_spheres, tmp_path):
    words = [
        "-b",
        two_spheres,
        "-P",
        ROOT / "addon" / "paradesc" / "cli.py",
        "--",
        "bake",
        *QUICK,
        "--output",
        "out.npz",
    ]
    assert 'object "small"' in accepted(completed([bpy.app.binary_path, *words], tmp_path))
    assert (tmp_path / "out.npz").is_file()


@pytest.mark.skipif(bool(bpy.app.binary_path), reason="needs the Python module of Blender")
def test_script_runs_without_the_package_on_the_path(sphere_obj, tmp_path):
    cli = ROOT / "addon" / "paradesc" / "cli.py"
    words = [sys.executable, cli, "--", "bake", sphere_obj, *QUICK, "--output", "out.npz"]
    accepted(completed(words, tmp_path))


@pytest.mark.slow
def test_interrupted_computation_is_one_sentence_and_writes_nothing(tmp_path):
    path = write_obj(tmp_path / "fine.obj", *cube_sphere(90))
    words = ["bake", path, "--radius", "0.3", "--samples", "4096", "--backend", "software", "--output", "out.npz"]
    with subprocess.Popen(
        [*command_line(), *map(str, words), "--progress", "lines"],
        cwd=tmp_path,
        env=environment(),
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
    ) as process:
        for line in process.stderr:
            if "evaluate" in line:
                break
        process.send_signal(signal.SIGINT)
        try:
            _, stderr = process.communicate(timeout=60)
        finally:
            process.kill()
    assert process.returncode == 130
    assert stderr.strip().endswith("paradesc: Interrupted.")
    assert "Traceback" not in stderr
    assert not (tmp_path / "out.npz").exists()
