"""A mesh far from the origin has the values that it has there, as far as its file holds digits."""

import json

import numpy as np
import pytest

import paradesc
from mesh_kinds import ball, glb, off, ply, rows, stl
from paradesc import cli
from paradesc.bridge import MeshArrays, origin
from paradesc.core import job, spaces
from paradesc.files import cache, mesh_files
from shapes import cube_sphere, write_obj

MAP = np.array([500000.0, 5400000.0, 100.0])  # 10 m of surface in a zone of UTM
SIZE = 5.0
DIGITS = "{:.6f}"
# Digits of the text files below, and what 32-bit floats about the middle leave: both 1e-6 of the radius of the sphere.
SHARE = 1e-3


def surface(offset=MAP, steps=10):
    """A sphere with bumps at a place: positions, quads and UV coordinates."""
    points, quads, uvs = cube_sphere(steps, 1.0)
    return SIZE * points * (1 + 0.04 * np.cos(3 * points).prod(axis=1, keepdims=True)) + offset, quads, uvs


def write(path, offset=MAP, steps=10, kind="double"):
    """The surface as a file; kind: the numbers that a .ply has."""
    points, quads, uvs = surface(offset, steps)
    if path.suffix == ".obj":
        return write_obj(path, points, quads, uvs)
    mesh = points, np.concatenate([quads[:, :3], quads[:, [0, 2, 3]]])
    writers = {
        ".off": lambda: off(surface=mesh, number=DIGITS),
        ".stl": lambda: stl(surface=mesh, number=DIGITS),
        ".ply": lambda: ply("binary_little_endian", surface=mesh, kind=kind),
        ".glb": lambda: glb(*ball(surface=mesh)),
    }
    path.write_bytes(writers[path.suffix]())
    return path


def bake(folder, path, *words, radius=("--radius", "0.8", "--radius-unit", "absolute")):
    """Arrays and report of a bake without Blender."""
    out, report = folder / "out.npz", folder / "out.json"
    names = "mean_curvature,principal_direction_max"
    more = ["--descriptors", names, "--backend", "cpu", "--reader", "files", "--quiet"]
    assert cli.main(["bake", str(path), "-o", str(out), "--json", str(report), *more, *radius, *map(str, words)]) == 0
    with np.load(out) as arrays:
        return dict(arrays), json.loads(report.read_text())


def agree(found, expected):
    spread = np.ptp(expected["mean_curvature"])
    np.testing.assert_allclose(found["mean_curvature"], expected["mean_curvature"], atol=SHARE * spread)


@pytest.mark.parametrize("suffix", [".obj", ".off", ".stl", ".ply"])
@pytest.mark.parametrize("space", ["object", "world"])
def test_a_file_with_digits_enough_gives_the_same_values_anywhere(tmp_path, suffix, space):
    here, _ = bake(tmp_path, write(tmp_path / f"here{suffix}", np.zeros(3)), "--space", space)
    far, report = bake(tmp_path, write(tmp_path / f"far{suffix}"), "--space", space)
    agree(far, here)
    np.testing.assert_allclose(far["vertices"], here["vertices"] + MAP, atol=2e-6)  # of digits in the text
    assert np.ptp(here["mean_curvature"]) > 0.02
    assert not [note for note in report["objects"][0]["warnings"] if "from the origin" in note]


@pytest.mark.parametrize("suffix", [".ply", ".glb"])
def test_what_32_bit_floats_lose_far_away_is_said(tmp_path, suffix):
    _, report = bake(tmp_path, write(tmp_path / f"far{suffix}", kind="float"))
    (note,) = [note for note in report["objects"][0]["warnings"] if "from the origin" in note]
    assert (
        "5.4e+06 from the origin, where 32-bit floats are 0.5 apart: its vertices are rounded to 0.6 of the mean"
        in note
    )
    near = write(tmp_path / f"near{suffix}", np.array([30.0, 0, 0]), kind="float")
    assert not [note for note in bake(tmp_path, near)[1]["objects"][0]["warnings"] if "from the origin" in note]


def test_results_are_written_at_the_files_own_places(tmp_path):
    path = write(tmp_path / "far.ply")
    (mesh,) = mesh_files.read(path)
    for suffix in (".ply", ".vtp", ".vtk"):
        bake(tmp_path, path, "-o", tmp_path / f"again{suffix}")
    (again,) = mesh_files.read(tmp_path / "again.ply")
    assert np.array_equal(again.arrays.positions, mesh.arrays.positions)
    assert again.arrays.positions.dtype == np.float64
    assert mesh.arrays.positions.astype("<f8").tobytes() in (tmp_path / "again.vtp").read_bytes()
    assert mesh.arrays.positions.astype(">f8").tobytes() in (tmp_path / "again.vtk").read_bytes()
    text = path.read_bytes()
    assert text.split(b"end_header\n")[1][: 24 * len(mesh.arrays.positions)] == mesh.arrays.positions.tobytes()


def test_high_to_low_gives_the_same_values_anywhere(tmp_path):
    found = {}
    for name, offset in (("here", np.zeros(3)), ("far", MAP)):
        low = write(tmp_path / f"{name}_low.obj", offset, 6)
        high = write(tmp_path / f"{name}_high.ply", offset, 24)
        words = ["--from-file", high, "--map", tmp_path / f"{name}.exr", "--texels", "64", "--cage", "1"]
        found[name], _ = bake(tmp_path, low, *words)
    assert np.isfinite(found["here"]["mean_curvature"]).all()
    agree(found["far"], found["here"])
    directions = [found[name]["principal_direction_max"] for name in ("here", "far")]
    alike = np.abs((directions[0] * directions[1]).sum(axis=1))
    assert np.quantile(alike, 0.1) > 0.99  # at umbilics a direction may be any


def test_frames_have_the_same_values_anywhere(tmp_path):
    found = {}
    for name, offset in (("here", np.zeros(3)), ("far", MAP)):
        (tmp_path / name).mkdir()
        for frame in (1, 2):
            write(tmp_path / name / f"m_{frame}.ply", offset + 7.0 * frame)
        words = ["--radius", "0.1", "--backend", "cpu", "--relative-to-rest", "--quiet"]
        assert cli.main(["animate", str(tmp_path / name), "--cache", str(tmp_path / f"{name}_frames"), *words]) == 0
        frames = tmp_path / f"{name}_frames" / "m"
        found[name] = [cache.read_frame(cache.frame_path(frames, frame)).values for frame in (1, 2)]
    for far, here in zip(found["far"], found["here"], strict=True):
        agree(far, here)
        assert np.abs(far["mean_curvature_change"]).max() < SHARE * np.ptp(here["mean_curvature"])


def test_several_objects_in_one_file_are_right_far_away(tmp_path):
    for name, offset in (("here", np.zeros(3)), ("far", MAP)):
        path = write(tmp_path / f"{name}.obj", offset)
        lines = path.read_text().splitlines()
        moved, count = surface(offset + np.array([20, 0, 0]))[0], len(surface()[0])
        second = ["o second", *(f"v {line}" for line in rows(moved, DIGITS).splitlines())]
        second += ["f " + " ".join(str(vertex + count + 1) for vertex in quad) for quad in surface()[1]]
        path.write_text("\n".join([*lines, *second]) + "\n")
        bake(tmp_path, path, "--all", "-o", tmp_path / f"{name}.ply")
    (here,), (far,) = (mesh_files.read(tmp_path / f"{name}.ply") for name in ("here", "far"))
    np.testing.assert_allclose(far.arrays.positions - MAP, here.arrays.positions, atol=2e-6)


def test_the_arrays_of_python_and_corners_of_harris_are_right_far_away():
    points, quads, _ = surface(np.zeros(3))
    here = paradesc.compute(points, quads, ["mean_curvature", "harris"], 0.1, backend="cpu")
    far = paradesc.compute(points + MAP, quads, ["mean_curvature", "harris"], 0.1, backend="cpu")
    agree(far, here)
    assert not far.warnings
    rounded = paradesc.compute((points + MAP).astype(np.float32), quads, "mean_curvature", 0.1, backend="cpu")
    assert "32-bit floats are 0.5 apart" in rounded.warnings[0]
    with paradesc.Mesh(points, quads, backend="cpu") as mesh:
        mesh.positions = points + MAP
        agree(mesh.compute("mean_curvature", 0.1), here)


def test_32_bit_floats_that_hold_all_digits_give_the_same_values():
    points, quads, _ = surface(np.zeros(3))
    points = np.round(points * 1024) / 1024  # so that nothing is lost at 4096
    triangles = np.concatenate([quads[:, :3], quads[:, [0, 2, 3]]]).astype(np.int32)
    corners = np.arange(triangles.size, dtype=np.int32).reshape(-1, 3)
    settings = job.Settings(backend="cpu")
    settings.options.radius = 0.15
    here, far = (
        job.run(MeshArrays((points + offset).astype(np.float32), triangles.reshape(-1), corners), settings)
        for offset in (np.zeros(3), np.array([4096.0, 0, -4096]))
    )
    assert not far.facet_notes()
    found, expected = far.values["mean_curvature"], here.values["mean_curvature"]
    np.testing.assert_allclose(found, expected, atol=1e-5 * np.ptp(expected))  # the middle is no whole number


def test_some_positions_tell_of_no_far_mesh_that_it_is_near():
    generator = np.random.default_rng(0)
    far = 0
    for count in (1, 2, 3, 65, 1000):
        for _ in range(200):
            points = generator.normal(size=(count, 3)) * generator.uniform(0.1, 1, 3) + generator.normal(size=3) * 3
            low, high = points.min(axis=0), points.max(axis=0)
            is_far = np.abs(low + high).max() > 2 * (high - low).max()
            far += is_far
            assert (origin.far_center(points) is not None) == is_far
    assert 100 < far < 900


@pytest.mark.parametrize("place", [0, 61, -1])
def test_one_vertex_without_a_face_at_the_origin_costs_no_digits(place):
    points, quads, _ = surface()
    values = {"radius": 0.8, "radius_unit": "absolute"}
    expected = paradesc.compute(surface(0)[0], quads, **values)["mean_curvature"]
    place %= len(points) + 1
    quads = quads + (quads >= place)
    found = paradesc.compute(np.insert(points, place, 0, axis=0), quads, **values)["mean_curvature"]
    np.testing.assert_allclose(np.delete(found, place), expected, atol=SHARE * np.ptp(expected))


def test_parts_too_far_apart_for_their_edges_are_told_of():
    points, quads, _ = surface(0)
    points, quads = np.concatenate([points, points + MAP]), np.concatenate([quads, quads + len(points)])
    with pytest.warns(paradesc.ParadescWarning, match="Compute the parts one by one"):
        paradesc.compute(points, quads, radius=0.8, radius_unit="absolute")


@pytest.mark.parametrize("place", [0.0, 1.0])
def test_a_mesh_that_is_one_point_has_no_values_wherever_it_is(place):
    with pytest.warns(paradesc.ParadescWarning):
        found = paradesc.compute([[place] * 3] * 3, [[0, 1, 2]], radius=0.5)
    assert np.isnan(found["mean_curvature"]).all()


def test_arrays_of_any_type_reach_the_library_near_the_origin():
    points, quads, _ = surface(np.array([1000.0, 0, 0]))
    triangles = np.concatenate([quads[:, :3], quads[:, [0, 2, 3]]]).astype(np.int32)
    corners = np.arange(triangles.size, dtype=np.int32).reshape(-1, 3)
    near = origin.near_origin(points)
    assert near.dtype == np.float32
    assert np.abs(near).max() < 2 * SIZE
    assert origin.near_origin(near) is near
    settings = job.Settings(backend="cpu")
    found = [
        job.run(MeshArrays(positions, triangles.reshape(-1), corners), settings).values["mean_curvature"]
        for positions in (points, near)
    ]
    assert np.array_equal(*found, equal_nan=True)
    arrays = MeshArrays(points, triangles.reshape(-1), corners)
    spaces.to_world(arrays, np.diag([2.0, 2, 2, 1]), "x")
    assert np.array_equal(arrays.positions, 2 * points)


def test_buffers_hold_the_meshs_own_positions(tmp_path):
    path = write(tmp_path / "far.obj")
    folder = str(tmp_path / "buffers")
    words = ["--backend", "software", "--dump-buffers", folder, "--buffer", "64", "--reader", "files"]
    assert cli.main(["bake", str(path), "--quiet", *words]) == 0
    with np.load(tmp_path / "buffers" / "buffers.npz") as buffers:
        there = buffers["position"][np.isfinite(buffers["position"]).all(axis=2)]
    assert np.abs(there - MAP).max() < 1.1 * SIZE
