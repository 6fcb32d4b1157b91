"""The backend auto takes the processor, without unwrapping, and the software rasterizer where it must."""

from dataclasses import replace

import numpy as np
import pytest

from conftest import command_line, completed, environment
from paradesc import bridge
from paradesc.bridge import Options
from paradesc.core import compare, job, stream
from paradesc.files import exr, maps
from paradesc.files.results import Baked
from shapes import cube_sphere, write_obj

QUICK = {"radius": 0.08, "samples": 64}
# Each setting that takes texture space, and words by which a note names it.
NEEDS = {
    "relocation affine": {"relocation": "affine"},
    "relocation paper": {"relocation": "paper"},
    "half floats": {"precision": "half"},
    "adaptive sampling": {"adaptive": 0.05},
}


@pytest.fixture
def without_opengl():
    """The environment of a process that finds no driver."""
    return {
        **environment(),
        "__EGL_VENDOR_LIBRARY_FILENAMES": "/nonexistent",
        "__EGL_VENDOR_LIBRARY_DIRS": "/nonexistent",
    }


def settings(names=("mean_curvature",), backend="auto", **options):
    return job.Settings(names, Options(**QUICK, **options), backend)


def test_python_and_the_library_agree_on_what_takes_texture_space(sphere):
    asked = [{}, {"evaluate": "texel"}, {"pattern": "stratified"}, {"estimator": "integral"}, *NEEDS.values()]
    with bridge.Context() as context, context.mesh(sphere) as mesh:
        for maps_set in (False, True):
            mesh.set_displacement(np.zeros((1, 1), np.float32) if maps_set else None)
            for options in asked:
                for buffers in (False, True):
                    chosen = settings(**options)
                    assert mesh.backend(chosen.options, buffers) == job.backend_for(chosen, buffers), options
    assert job.backend_for(settings(backend="gpu", adaptive=0.05)) == "gpu"


def test_a_bake_has_the_bits_of_the_processor(sphere):
    found, expected = job.run(sphere, settings()), job.run(sphere, settings(backend="cpu"))
    assert found.backend == expected.backend == "cpu"
    assert found.values["mean_curvature"].tobytes() == expected.values["mean_curvature"].tobytes()
    assert (found.warnings, found.device) == ([], expected.device)


@pytest.mark.parametrize("words", NEEDS)
def test_what_takes_texture_space_goes_to_the_software_rasterizer_with_a_note(sphere, words):
    found = job.run(sphere, settings(buffer_size=256, **NEEDS[words]))
    assert found.backend == "software"
    assert words in found.warnings[0]
    assert found.device in found.warnings[0]
    expected = job.run(sphere, settings(backend="software", buffer_size=256, **NEEDS[words]))
    assert found.values["mean_curvature"].tobytes() == expected.values["mean_curvature"].tobytes()


def test_buffers_are_baked_where_they_are_asked_for(sphere):
    found = job.run(sphere, settings(buffer_size=64), with_buffers=True)
    assert found.backend == "software"
    assert found.buffers["position"].shape == (64, 64, 3)
    assert "baked buffers" in found.warnings[0]


def test_cpu_by_name_refuses_texture_space_and_names_who_has_it(sphere):
    for words, options in NEEDS.items():
        with pytest.raises(bridge.ParadescError, match=f"{words}.*cpu.*software"):
            job.run(sphere, settings(backend="cpu", **options))


def test_numbers_without_effect_are_noted_once_and_are_no_warning(sphere):
    found = job.run(sphere, replace(settings(buffer_size=512, seed=3), more_radii=(0.1,)))
    assert (found.backend, found.warnings) == ("cpu", [])
    (note,) = found.unused_notes()
    assert "buffer size and the seed are ignored" in note
    assert job.run(sphere, settings()).unused_notes() == []
    assert job.run(sphere, settings(backend="software", buffer_size=256)).unused_notes() == []


def test_texels_of_the_processor_are_those_of_the_software_rasterizer(sphere, tmp_path):
    options = {"evaluate": "texel", "texels": 128, "buffer_size": 512}
    names = ("mean_curvature", "principal_direction_max")
    found = job.run(sphere, settings(names, **options))
    expected = job.run(sphere, settings(names, backend="software", **options))
    assert (found.backend, expected.backend) == ("cpu", "software")
    assert found.layout.tobytes() == expected.layout.tobytes()
    for name in (*names, "coverage"):
        ours, theirs = found.maps[name], expected.maps[name]
        assert ours.shape == theirs.shape
        assert np.array_equal(np.isnan(ours), np.isnan(theirs)), name
    there = np.isfinite(found.maps["mean_curvature"])
    difference = (found.maps["mean_curvature"] - expected.maps["mean_curvature"])[there]
    assert np.abs(difference).mean() < 0.02 * 0.5, "two backends, each within one percent of 1/R"
    path = tmp_path / "image.exr"
    exr.write_exr(path, maps.channels_of(Baked("sphere", found, sphere, np.eye(4))))
    assert path.stat().st_size > 128 * 128 * 4


def test_frames_of_texels_with_charts_that_share_a_place_have_the_bits_of_bakes_of_their_own(sphere):
    stacked = replace(sphere, corner_uvs=(sphere.corner_uvs * (3, 2)).astype(np.float32) % 1.0)
    chosen = settings(evaluate="texel", texels=64)
    for arrays in (sphere, stacked):
        with stream.Stream(arrays, chosen) as opened:
            for factor in (1.0, 1.2):
                positions = (arrays.positions * (1, 1, factor)).astype(np.float32)
                alone = job.run(replace(arrays, positions=positions), chosen)
                found = opened.compute(positions)
                assert found.backend == "cpu"
                assert found.maps["mean_curvature"].tobytes() == alone.maps["mean_curvature"].tobytes()
            assert opened.made == (1 if arrays is sphere else 2)


def test_compare_measures_what_auto_takes(sphere):
    positions = (sphere.positions * (1 + 0.1 * np.sin(2 * sphere.positions[:, :1]))).astype(np.float32)
    (row,), device, reference = compare.compare(replace(sphere, positions=positions), settings())
    assert (device.backend, reference.backend) == ("cpu", "reference")
    assert row["mean_percent_ae"] < 1.0


# ---- In Blender


@pytest.fixture
def bare(tmp_path):
    """A sphere without a UV map as a file."""
    pytest.importorskip("bpy", reason="needs Blender")
    points, quads, _ = cube_sphere()
    return write_obj(tmp_path / "bare.obj", points, quads)


@pytest.fixture
def unwraps(monkeypatch):
    """Counts how often Blender unwraps."""
    pytest.importorskip("bpy", reason="needs Blender")
    from paradesc_blender.scene import unwrap

    made = []
    original = unwrap.unwrapped
    monkeypatch.setattr(unwrap, "unwrapped", lambda *words: made.append(words) or original(*words))
    return made


def test_nothing_is_unwrapped_where_the_processor_computes(bare, run, report, unwraps):
    words = ("--radius", "0.08", "--samples", "64", "--json", "report.json", "--output", "out.npz")
    assert run("bake", bare, *words).code == 0
    assert (report()["backend"], unwraps) == ("cpu", [])
    assert report()["warnings"] == []
    assert run("bake", bare, *words, "--precision", "half", "--buffer", "256").code == 0
    assert (report()["backend"], len(unwraps)) == ("software", 1)


def test_notes_say_on_the_command_line_what_has_no_effect(bare, run, report):
    words = ("--radius", "0.08", "--samples", "64", "--json", "report.json", "--fail-on-warnings")
    ended = run("bake", bare, *words, "--buffer", "256")
    assert ended.code == 0, "it is no warning"
    assert ended.output.count("ignored on the processor") == 1
    assert "The buffer size is ignored" in report()["objects"][0]["notes"][0]


def test_images_need_no_opengl(sphere_obj, tmp_path, without_opengl):
    words = ("--radius", "0.08", "--samples", "64", "--evaluate", "texel", "--texels", "64", "--output", "out.exr")
    done = completed([*command_line(), "bake", sphere_obj, *words], tmp_path, without_opengl)
    assert done.returncode == 0, done.stderr
    assert "cpu: CPU" in done.stdout
    assert (tmp_path / "out.exr").stat().st_size > 64 * 64


def test_what_takes_opengl_ends_with_one_sentence_where_there_is_none(sphere_obj, tmp_path, without_opengl):
    words = ("--radius", "0.08", "--precision", "half", "--output", "out.npz")
    done = completed([*command_line(), "bake", sphere_obj, *words], tmp_path, without_opengl)
    assert done.returncode != 0
    assert "half floats" in done.stderr
    assert "OpenGL" in done.stderr
    assert len(done.stderr.strip().splitlines()) == 1, done.stderr
    assert not (tmp_path / "out.npz").exists()


def test_live_values_of_a_mesh_without_a_uv_map_are_the_processors(unwraps, registered):
    import bpy

    from live_values import switch
    from paradesc_blender.animation import sessions
    from scene import add_sphere

    target = add_sphere(steps=12, uv_map=False)
    bpy.context.view_layer.objects.active = target
    group = bpy.context.scene.paradesc
    group.radius_percent, group.samples = 8.0, 64
    assert switch(target) == ""
    bpy.context.scene.frame_set(2)
    session = sessions.session_at(target)
    assert session is not None
    assert session.results.backend == "cpu"
    assert unwraps == []
    assert np.isfinite(session.results.values["mean_curvature"]).all()
