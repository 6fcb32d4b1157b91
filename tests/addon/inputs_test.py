"""The command line reads every kind of file, and info tells about it: welding, defects, suggestions."""

import json

import numpy as np
import pytest

from shapes import RADIUS, cube_sphere

bpy = pytest.importorskip("bpy", reason="needs Blender")

from paradesc.commands import common  # noqa: E402
from paradesc_blender.scene import scene_io  # noqa: E402
from scene import add_sphere, empty_scene, saved_scene  # noqa: E402

QUICK = ("--radius", "0.08", "--samples", "32", "--buffer", "128", "--backend", "software")


def export(suffix, path):
    """Writes the open scene in another format, by the exporter that this Blender has."""
    names = {".stl": ("wm.stl_export", "export_mesh.stl"), ".fbx": ("export_scene.fbx",)}.get(
        suffix, ("wm.usd_export",)
    )
    name = next(name for name in reversed(names) if scene_io.operator_of(name))
    category, _, member = name.partition(".")
    getattr(getattr(bpy.ops, category), member)(filepath=str(path))


def write_gltf(path, points, quads, uvs):
    """Writes the sphere as .gltf and .bin by hand: Blender's glTF exporter makes its Python module crash at exit."""
    corners = quads.reshape(-1)
    positions = points[corners][:, [0, 2, 1]] * (1, 1, -1)  # y is up
    first = 4 * np.arange(len(quads))[:, None]
    triangles = np.concatenate([first + np.array([0, 1, 2]), first + np.array([0, 2, 3])])
    texcoords = uvs.reshape(-1, 2) * (1, -1) + (0, 1)
    arrays = [("VEC3", 5126, "<f4", positions), ("VEC2", 5126, "<f4", texcoords), ("SCALAR", 5125, "<u4", triangles)]
    views, accessors, content = [], [], b""
    for number, (kind, component, layout, array) in enumerate(arrays):
        piece = np.ascontiguousarray(array, layout).tobytes()
        count = triangles.size if kind == "SCALAR" else len(array)
        views.append({"buffer": 0, "byteOffset": len(content), "byteLength": len(piece)})
        accessors.append({"bufferView": number, "componentType": component, "count": count, "type": kind})
        content += piece
    accessors[0].update(min=positions.min(axis=0).tolist(), max=positions.max(axis=0).tolist())
    primitive = {"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "indices": 2}
    path.with_suffix(".bin").write_bytes(content)
    scene = {
        "asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}], "scene": 0, "nodes": [{"mesh": 0, "name": "sphere"}],
        "meshes": [{"primitives": [primitive]}], "accessors": accessors, "bufferViews": views,
        "buffers": [{"uri": path.with_suffix(".bin").name, "byteLength": len(content)}],
    }  # fmt: skip
    path.write_text(json.dumps(scene))


@pytest.mark.parametrize("suffix", [".stl", ".fbx", ".gltf", ".usd", ".usda", ".usdc", ".usdz"])
def test_every_input_gives_the_curvature_of_the_sphere(run, report, tmp_path, monkeypatch, suffix):
    empty_scene()
    add_sphere(steps=10)
    path = tmp_path / f"sphere{suffix}"
    if suffix.startswith(".usd") and not scene_io.operator_of("wm.usd_import"):
        path.write_text("#usda 1.0")
        ended = run("bake", path, *QUICK, "--output", "out.npz")
        assert ended.code == common.EXIT_INPUT
        assert f"importer of {suffix}" in ended.error
        return
    if suffix == ".gltf":
        write_gltf(path, *cube_sphere(10))
    else:
        export(suffix, path)
    monkeypatch.chdir(tmp_path)  # Blender's exporter of .usdz leaves another one
    ended = run("bake", path, *QUICK, "--output", "out.npz", "--json", "report.json")
    assert ended.code == 0, ended.error
    with np.load(tmp_path / "out.npz") as arrays:
        size = np.linalg.norm(arrays["vertices"], axis=1).mean()
        np.testing.assert_allclose(arrays["mean_curvature"] * size, 1.0, rtol=0.06)  # 32 samples on a coarse sphere
        np.testing.assert_allclose(
            size * np.abs(np.linalg.det(arrays["matrix_world"][:3, :3])) ** (1 / 3), RADIUS, rtol=1e-3
        )
        if suffix == ".stl":
            assert len(arrays["vertices"]) == len(cube_sphere(10)[0])
    if suffix == ".stl":
        assert "1,200 were welded into 602 vertices" in report()["notes"][0]
        assert "note: An STL file holds loose triangles" in ended.output


def test_stl_of_few_digits_is_welded_into_a_closed_surface(run, report, tmp_path):
    points, quads, _ = cube_sphere(6)
    noise = np.random.default_rng(3).uniform(-1e-6, 1e-6, (len(quads), 2, 3, 3))
    lines = ["solid sphere"]
    for number, quad in enumerate(quads):
        for side, corners in enumerate((quad[[0, 1, 2]], quad[[0, 2, 3]])):
            lines += ["facet normal 0 0 0", "outer loop"]
            lines += ["vertex {:.8f} {:.8f} {:.8f}".format(*row) for row in points[corners] + noise[number, side]]
            lines += ["endloop", "endfacet"]
    (tmp_path / "rough.stl").write_text("\n".join([*lines, "endsolid sphere", ""]))
    assert run("info", "rough.stl", "--json", "report.json").code == 0
    (row,) = report()["objects"]
    assert row["vertices"] == len(points)
    assert row["boundary_edges"] == 0


@pytest.mark.parametrize(
    ("suffix", "words"),
    [
        (".stl", '"junk.stl" cannot be read: '),
        (".fbx", 'Blender cannot read "junk.fbx": '),
        (".gltf", '"junk.gltf" cannot be read: '),
    ],
)
def test_broken_file_of_every_kind_is_one_sentence(run, tmp_path, suffix, words):
    (tmp_path / f"junk{suffix}").write_text("junk")
    ended = run("bake", f"junk{suffix}", *QUICK, "--output", "out.npz")
    assert ended.code == common.EXIT_INPUT
    sentence = ended.error.splitlines()[-1]  # this process's own streams also show what Python add-ons print
    assert sentence.startswith(f"paradesc: {words}")
    assert "Location" not in sentence
    assert not (tmp_path / "out.npz").exists()


def test_info_foresees_the_texels_of_a_bake(run, report, sphere_obj):
    assert run("info", sphere_obj, "--json", "report.json").code == 0
    (row,) = report()["objects"]
    assert row["uv_map"] == {"name": "UVMap", "fault": "", "charts": 6, "seam_edges": 168}
    assert not any(row["defects"].values())
    hint = row["suggested"]
    assert hint["radius_in_texels"] >= 4
    memory = row["memory"]
    assert 44 * hint["buffer"] ** 2 < memory["device"] < memory["total"] < memory["allowed"]
    words = ("--radius", hint["radius"], "--buffer", hint["buffer"], "--samples", "16", "--backend", "software")
    assert run("bake", sphere_obj, *words, "--json", "bake.json").code == 0
    found = report("bake.json")["objects"][0]["field_report"]["radius_in_texels"]
    np.testing.assert_allclose(found, hint["radius_in_texels"], rtol=0.1)  # a median over triangles, not over vertices


def test_info_tells_what_is_wrong_with_each_object(run, tmp_path, three_objects):
    bpy.ops.wm.open_mainfile(filepath=str(three_objects))
    first = bpy.data.objects["first"]
    first.data.uv_layers[0].data.foreach_set("uv", np.zeros(2 * len(first.data.loops), np.float32))
    first.modifiers.new("s", "SUBSURF")
    saved_scene(three_objects)
    ended = run("info", three_objects)
    assert ended.code == 0
    assert 'object "bare": The mesh "bare" has no faces' in ended.output
    assert "has a UV map without area; it is unwrapped for a bake" in ended.output
    assert ended.output.count("object ") == 5
    assert run("info", three_objects, "--object", "twin").output.count("object ") == 1
