"""The odd mesh files of a review, where they stand beside the checkout: each has its values, or the right sentence."""

import numpy as np
import pytest

from paradesc.bridge import InputError
from paradesc.core import job
from paradesc.files import mesh_files
from shapes import ROOT

BUGS = ROOT.parent / "shared" / "reviews" / "bugs"
FILES = sorted(path for path in BUGS.glob("*/*") if path.suffix.lower() in mesh_files.SUFFIXES)
# The sentence of each file that is refused.
REFUSED = {
    "decimal_comma.obj": "line 1, .* is not a row of numbers; decimals take a point",
    "empty.obj": "it is empty",
    "f_zero_based.obj": 'line 643, "f 0 162 164", names vertex 0, and there are 642, counted from 1',
    "fo.obj": "has no faces",  # a word that was given up in 1995
    "html.obj": "it is a web page",
    "only_comment.obj": "has no faces",
    "only_points.obj": "has no faces",
    "upper.obj": "has no faces",
    "v_nan.obj": "Vertex 7 is at .nan, nan, nan.; positions have to be finite",
    "v_nan_unused.obj": "Vertex 642 is at .nan, nan, nan.; positions have to be finite",
    "ascii_comma.ply": "decimals take a point",
    "ascii_nan.ply": "Vertex 0 is at .nan, nan, nan.; positions have to be finite",
    "count_zero_faces.ply": "has no faces",
    "float_count.ply": 'its header has the line "element vertex 642.0"',
    "format_missing.ply": "its header does not say its format",
    "gz.ply": "compressed by gzip",
    "html.ply": "it is a web page",
    "truncated_vertices.ply": "ends too early",
    "xyz_upper.ply": "have no property x",
    "empty.stl": "it is empty",
    "header_only.stl": "has no faces",
    "stlb_80.stl": "has no faces",
    "4off.off": "4OFF has vertices in another space than three dimensions",
    "bad_index.off": "a face has vertex 642, counted from 0, and there are 642",
    "empty.off": "it is empty",
    "fewer_faces.off": "it promises 1280 faces, and ends after 1180",
    "more_lines.off": "more follows the 1180 faces that it promises",
    "empty.gltf": "has no faces",
    "html.gltf": "it is a web page",
    "lfs.glb": "it is a pointer of Git LFS",
    "missing_bin.gltf": 'its buffer "gone.bin" is not beside it',
    "nan_position.glb": "Vertex 5 is at .nan, nan, nan.; positions have to be finite",
    "only_points.glb": "has no faces",
    "req_EXT_meshopt_compression.glb": "EXT_meshopt_compression; export it without compression",
    "req_KHR_draco_mesh_compression.glb": "KHR_draco_mesh_compression; export it without compression",
    "req_KHR_gaussian_splatting.glb": "KHR_gaussian_splatting; export it without them, or let Blender read it",
    "truncated.glb": "14,984 of 15,384 bytes; it was cut off",
    "version1.glb": "it is glTF 1.0",
}


def prism(sides):
    """Area and volume of an upright prism of height one over the polygon in the unit circle."""
    base = sides / 2 * np.sin(2 * np.pi / sides)
    return 2 * base + 2 * sides * np.sin(np.pi / sides), base


# Area and volume of what is no sphere, a cap or a patch having the volume of the cone over it.
SHAPES = {
    **{f"prism{sides}.off": prism(sides) for sides in (3, 5, 6, 12)},
    "concave5.off": (2.5, 0), "concave5_rot.off": (2.5, 0),
    "concave_ngon.off": (14, 3),  # three unit cubes in an L
    "tri_hex.off": (1.5 * 3**0.5 + 0.75 * 3**0.5, 0.25 * 3**0.5),  # a hexagon, and two thirds of another one above it
    "only_fan.glb": (24 * np.sin(np.pi / 24), 16 * np.sin(np.pi / 24)),  # the unit disk at height two, of 48 sides
    "tube_with_fan_caps.glb": (6 * np.pi, 2 * np.pi),  # a closed cylinder of radius one and height two
    **dict.fromkeys(("strips.glb", "strip_restart.glb", "strip_degenerate_joined.glb", "strips_no_indices.glb"),
                    (4 * np.pi, 4 / 3 * np.pi)),  # its side alone
}  # fmt: skip
SPHERES = [path for path in FILES if path.name not in REFUSED and path.name not in SHAPES]
pytestmark = pytest.mark.skipif(not FILES, reason=f"the review's files are not at {BUGS}")


def area_and_volume(mesh):
    corners = mesh.arrays.positions.astype(float)[mesh.arrays.triangle_vertices]
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return np.linalg.norm(across, axis=1).sum() / 2, np.linalg.det(corners).sum() / 6


@pytest.mark.parametrize("path", [path for path in FILES if path.name in REFUSED], ids=lambda path: path.name)
def test_what_is_damaged_is_refused_with_the_right_sentence(path):
    with pytest.raises(InputError, match=REFUSED[path.name]):
        mesh_files.read(path)


@pytest.mark.parametrize("path", [path for path in FILES if path.name in SHAPES], ids=lambda path: path.name)
def test_shapes_have_the_area_and_the_volume_of_their_closed_forms(path):
    (mesh,) = mesh_files.read(path)
    # facets of 48 and 96 sides stand for what is round; six digits of the text for what is not
    assert area_and_volume(mesh) == pytest.approx(SHAPES[path.name], rel=4e-3, abs=1e-5)


@pytest.mark.parametrize("path", SPHERES, ids=lambda path: path.name)
def test_spheres_have_mean_curvature_one_over_radius(path):
    (mesh,) = mesh_files.read(path)
    radius = np.linalg.norm(mesh.arrays.positions - mesh.arrays.positions.mean(axis=0), axis=1).max()
    area, volume = area_and_volume(mesh)
    assert area == pytest.approx(4 * np.pi * radius**2, rel=0.02)  # what facets cut off
    assert volume == pytest.approx(4 / 3 * np.pi * radius**3, rel=0.04)  # and wound outwards
    settings = job.Settings(backend="cpu")
    settings.options.radius = 0.1
    found = job.run(mesh.arrays, settings).values["mean_curvature"] * radius
    assert np.nanmedian(np.abs(found - 1)) < 0.02  # spheres of 162 vertices
    assert np.nanmax(np.abs(found - 1)) < 0.06
    assert np.isnan(found).sum() <= 1  # a vertex that no face uses
