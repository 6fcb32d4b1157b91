"""bake --map over several UDIM tiles: names of the files, ranges, packed channels, refusals, the report."""

import numpy as np
import pytest

bpy = pytest.importorskip("bpy", reason="needs Blender")

from maps_test import decode16, pixels_of  # noqa: E402

from scene import add_sphere, empty_scene, saved_scene  # noqa: E402
from shapes import cube_sphere, write_obj  # noqa: E402

WORDS = ("--radius", "0.08", "--samples", "32", "--backend", "cpu", "--texels", "48", "--json", "report.json")
SIX = (1001, 1002, 1003, 1011, 1012, 1013)
PACK = ("--pack", "cavity,convexity,ambient_openness")


def bent(steps=8):
    """An ellipsoid of six charts: positions, quads and UVs."""
    points, quads, uvs = cube_sphere(steps)
    return points * [1.0, 0.8, 1.3], quads, uvs


def written_obj(folder, scale=(3, 2), move=(0, 0)):
    """It as a file, with a chart in each of six tiles."""
    points, quads, uvs = bent()
    return write_obj(folder / "six.obj", points, quads, uvs * np.array(scale) + np.array(move))


@pytest.fixture
def six(tmp_path):
    return written_obj(tmp_path)


def images_in(folder):
    return sorted(path.name for path in folder.iterdir() if path.suffix in (".png", ".exr"))


def names_of(stem, suffix=".png", tiles=SIX):
    return [f"{stem}.{tile}{suffix}" for tile in tiles]


def test_every_tile_has_a_file_with_its_number(run, report, six, tmp_path):
    assert run("bake", six, *WORDS, "--map", "x.png", "--map", "y.<UDIM>.exr", "-o", "z.exr").code == 0
    assert images_in(tmp_path) == names_of("x") + names_of("y", ".exr") + names_of("z", ".exr")
    rows = report()["maps"]
    assert [row["tile"] for row in rows] == 3 * list(SIX)
    assert [row["path"] for row in rows] == names_of("x") + names_of("y", ".exr") + names_of("z", ".exr")
    assert set(report()["outputs"]) == {row["path"] for row in rows}


def test_the_values_of_all_tiles_have_one_range(run, report, six, tmp_path):
    assert run("bake", six, *WORDS, "--map", "x.png", "--map", "x.exr").code == 0
    rows = [row for row in report()["maps"] if row["path"].endswith(".png")]
    assert len({(row["minimum"], row["maximum"]) for row in rows}) == 1
    low, high = rows[0]["minimum"], rows[0]["maximum"]
    pixels = {tile: decode16((tmp_path / f"x.{tile}.png").read_bytes())[0][:, :, 0] for tile in SIX}
    assert min(image.min() for image in pixels.values()) == 0
    assert max(image.max() for image in pixels.values()) == 65535
    assert any(image.max() < 60000 for image in pixels.values())  # the ellipsoid's sides differ
    for tile, image in pixels.items():
        values = pixels_of(tmp_path / f"x.{tile}.exr")[::-1, :, 0]
        # Beside the gutter an EXR is 0, which lies below the range.
        np.testing.assert_allclose(
            image / 65535, np.clip((values - low) / (high - low), 0, 1), atol=1 / 65535, err_msg=str(tile)
        )


def test_each_texel_of_a_tile_is_measured_on_request(run, six, tmp_path):
    assert run("bake", six, *WORDS, "--evaluate", "texel", "--map", "each.exr").code == 0
    assert run("bake", six, *WORDS, "--map", "few.exr").code == 0
    for tile in SIX:
        each, few = (pixels_of(tmp_path / f"{stem}.{tile}.exr")[::-1, :, 0] for stem in ("each", "few"))
        assert np.isfinite(each).all()
        # Linear values over 16ths of a side of the ellipsoid against those of each texel.
        assert np.abs(each - few).mean() < 0.02
        assert not np.array_equal(each, few)


def test_names_of_descriptors_and_channels_come_before_the_tile(run, six, tmp_path):
    two = ("--descriptors", "cavity,convexity")
    assert run("bake", six, *WORDS, *two, "--map", "x.<UDIM>.png", "--png-range", "colors").code == 0
    assert images_in(tmp_path) == names_of("x_cavity") + names_of("x_convexity")
    assert run("bake", six, *WORDS, *PACK, "--map", "y_<UDIM>.png").code == 0
    packed = [f"y_masks_{tile}.png" for tile in SIX]
    assert images_in(tmp_path)[12:] == packed
    pixels, texts = decode16((tmp_path / packed[3]).read_bytes())
    assert pixels.shape == (48, 48, 3)
    assert texts == decode16((tmp_path / packed[0]).read_bytes())[1]


def test_a_map_in_the_first_tile_keeps_its_name_unless_a_number_is_asked_for(run, report, tmp_path):
    path = written_obj(tmp_path, (1, 1))
    assert run("bake", path, *WORDS, "--map", "x.png", "--map", "y.<UDIM>.png").code == 0
    assert images_in(tmp_path) == ["x.png", "y.1001.png"]
    assert (tmp_path / "x.png").read_bytes() == (tmp_path / "y.1001.png").read_bytes()
    assert [row.get("tile") for row in report()["maps"]] == [None, 1001]


def test_a_map_across_borders_gets_a_note(run, report, tmp_path):
    path = written_obj(tmp_path, (1, 1), (0.45, 0))
    assert run("bake", path, *WORDS, "--map", "x.png").code == 0
    assert images_in(tmp_path) == names_of("x", tiles=(1001, 1002))
    assert any("cross the borders of UDIM tiles" in note for note in report()["objects"][0]["notes"])


def test_low_poly_tiles_take_the_values_of_detailed_objects(run, report, six, tmp_path):
    points, quads, _ = bent(20)
    fine = write_obj(tmp_path / "fine.obj", points, quads)
    assert run("bake", six, *WORDS, "--from-file", fine, "--map", "x.png", "--png-range", "colors").code == 0
    assert images_in(tmp_path) == names_of("x")
    found = report()["objects"][0]
    assert found["transfer"]["texels"] > 6 * 42**2
    assert sum("the cage distance" in note for note in found["notes"]) == 1


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("-o", "x.<UDIM>.ply"), "has no UDIM tiles"),
        (("-o", "x.<UDIM>.png"), "which --map writes"),
        (("--map", "<UDIM>/x.png"), "in the name of the file"),
        (("--map", "x.<UDIM>.<UDIM>.png"), "once is enough"),
    ],
    ids=str,
)
def test_a_number_where_there_are_no_tiles_is_refused(run, six, words, said):
    ended = run("bake", six, *WORDS, *words)
    assert ended.code == 2
    assert said in ended.error


def test_tiles_of_a_map_beside_all_tiles_are_refused_and_a_single_image_is_not(run, report, tmp_path):
    path = written_obj(tmp_path, move=(-2, 0))
    ended = run("bake", path, *WORDS, "--map", "x.<UDIM>.png")
    assert ended.code == 3
    assert '"x.<UDIM>.png" stands for the UDIM tiles of' in ended.error
    assert images_in(tmp_path) == []
    assert run("bake", path, *WORDS, "--map", "x.png").code == 0
    assert images_in(tmp_path) == ["x.png"]
    assert any("outside of the UDIM tiles" in line for line in report()["warnings"])


def test_tiles_of_a_mesh_without_a_map_are_refused(run, tmp_path):
    points, quads, _ = bent()
    ended = run("bake", write_obj(tmp_path / "bare.obj", points, quads), *WORDS, "--map", "x.<UDIM>.png")
    assert ended.code == 3
    assert "has no UV map; unwrap it" in ended.error


def test_objects_that_share_a_mesh_have_the_same_tiles(run, tmp_path):
    empty_scene()
    first = add_sphere("first", steps=6)
    uvs = np.empty(2 * len(first.data.loops), np.float32)
    first.data.uv_layers.active.data.foreach_get("uv", uvs)
    first.data.uv_layers.active.data.foreach_set("uv", (uvs.reshape(-1, 2) * np.float32([3, 2])).ravel())
    twin = first.copy()
    twin.name = "twin"
    bpy.context.collection.objects.link(twin)
    path = saved_scene(tmp_path / "scene.blend")
    words = ("--all", "--evaluate", "texel", "--map", "x.<UDIM>.png", "--png-range", "colors")
    assert run("bake", path, *WORDS, *words).code == 0
    assert images_in(tmp_path) == names_of("x_first") + names_of("x_twin")
    for one, other in zip(names_of("x_first"), names_of("x_twin"), strict=True):
        assert (tmp_path / one).read_bytes() == (tmp_path / other).read_bytes()
