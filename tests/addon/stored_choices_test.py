"""A file keeps a choice as a number, so a later version has to read the numbers of an earlier one in the same way.

New choices go to the end, and into these tables once a version with them is out; nothing else in them changes.
"""

import pytest

bpy = pytest.importorskip("bpy", reason="needs Blender")

pytestmark = pytest.mark.usefixtures("registered")

# Descriptors of the surface have bits from the lowest on, operators on maps from the highest; either may get more.
SURFACE = [
    "mean_curvature", "gaussian_curvature", "principal_curvature_max", "principal_curvature_min", "shape_index",
    "curvedness", "local_bending_energy", "sphere_volume", "sphere_volume_normalized", "euclidean_area",
    "geodesic_area", "cavity", "convexity", "ambient_openness", "principal_direction_max", "principal_direction_min",
]  # fmt: skip
ON_MAPS = ["gradient_magnitude", "laplacian", "difference_of_gaussians", "harris"]
# All others have numbers from 0 on.
CHOICES = {
    "Scene.paradesc.map_descriptor": SURFACE[:14],
    "Scene.paradesc.radius_fit": ["fine", "medium", "broad", "typed"],
    "Scene.paradesc.radius_unit": ["diagonal", "absolute", "mean-edge"],
    "Scene.paradesc.space": ["object", "world"],
    "Scene.paradesc.shape_key": ["basis", "active"],
    "Scene.paradesc.precision": ["full", "half"],
    "Scene.paradesc.creases": ["auto", "marked", "none"],
    "Scene.paradesc.normals": ["fitted", "max", "mesh"],
    "Scene.paradesc.backend": ["auto", "gpu", "software", "reference"],
    "Scene.paradesc.estimator": ["shape-operator", "integral", "extrapolated"],
    "Scene.paradesc.variance_reduction": ["shape", "none"],
    "Scene.paradesc.distance": ["euclidean", "geodesic"],
    "Scene.paradesc.evaluate": ["vertex", "texel"],
    "Scene.paradesc.relocation": ["connected", "affine", "paper"],
    "Scene.paradesc.pattern": ["golden-angle", "stratified"],
    "Scene.paradesc.ellipse": ["center", "directional"],
    "Scene.paradesc.geodesic": ["local", "chords"],
    "Scene.paradesc.image_format": [".exr", ".png"],
    "Scene.paradesc.image_outside": ["neutral", "transparent"],
    "Scene.paradesc_animation.source": ["original", "deformed", "evaluated"],
    "Scene.paradesc_animation.frame_source": ["deformed", "evaluated", "source"],
    "Scene.paradesc_live.missing": ["HOLD", "COMPUTE"],
    "Scene.paradesc_looks.color_map": [
        "auto", "viridis", "heat", "blue-yellow", "grey", "blue-red", "purple-green", "blue-black-orange", "cavity",
    ],
    "Scene.paradesc_looks.span": ["auto", "percentile", "fixed"],
    "Scene.paradesc_looks.pack_kind": ["FLOAT_COLOR", "BYTE_COLOR"],
    "Scene.paradesc_looks.pack_domain": ["POINT", "CORNER"],
    "Object.paradesc_live.mode": ["OFF", "LIVE", "CACHE"],
}  # fmt: skip


def stored():
    """Name and number of each choice, by property, of all that a file keeps with a scene or an object."""
    return {
        f"{owner.__name__}.{pointer.identifier}.{item.identifier}": {
            one.identifier: one.value for one in item.enum_items
        }
        for owner in (bpy.types.Scene, bpy.types.Object)
        for pointer in owner.bl_rna.properties
        if pointer.identifier.startswith("paradesc")
        for item in pointer.fixed_type.properties
        if item.type == "ENUM"
    }


def test_choices_keep_their_numbers():
    found = stored()
    assert set(found) == {*CHOICES, "Scene.paradesc.descriptors"}
    for place, names in CHOICES.items():
        assert [found[place].get(name) for name in names] == list(range(len(names))), place


def test_descriptors_keep_their_bits():
    found = stored()["Scene.paradesc.descriptors"]
    assert [found.get(name) for name in SURFACE] == [1 << bit for bit in range(len(SURFACE))]
    assert [found.get(name) for name in ON_MAPS] == [1 << (30 - bit) for bit in range(len(ON_MAPS))]
