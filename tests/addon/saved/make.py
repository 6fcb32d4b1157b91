"""Saves a .blend, frames and a preset as one version of the add-on does, with their contents, for saved_test.py.

Usage: BLENDER_USER_SCRIPTS=FOLDER blender -b --factory-startup -P make.py -- ADDON VERSION OUT.zip

ADDON is the folder `addon` of a built tree of that version, and VERSION names that version. The oldest supported
Blender, 3.4, has to run it, because newer ones read what it saves. It uses only properties and operators, as people's
files and scripts do. If the method has changed since (addon/manual/values.md), OUT.npz beside OUT.zip has the values
that today's gives for the same files; saved_test.py compares what is computed again with them.
"""

import io
import json
import os
import sys
import tempfile
import zipfile
from pathlib import Path

import bpy
import numpy as np

SETTINGS = {
    "paradesc": {
        "descriptors": {"mean_curvature", "shape_index", "harris"},
        "radius_unit": "mean-edge", "radius_edges": 2.5, "radius_percent": 7.0, "radius_absolute": 0.375, "samples": 72,
        "adaptive": 0.125, "buffer_size": 320, "precision": "half", "normals": "max", "backend": "reference",
        "device_index": 0, "estimator": "integral", "variance_reduction": "none", "distance": "geodesic",
        "evaluate": "texel", "relocation": "affine", "pattern": "stratified", "ellipse": "directional",
        "geodesic": "chords", "max_jumps": 5, "seed": 11, "map_descriptor": "mean_curvature", "map_sigma": 1.5,
        "harris_k": 0.0625, "corner_threshold": 12.5, "image_format": ".png", "image_path": "//curves.png",
        "texels": 96, "buffers_path": "//buffers", "space": "object", "shape_key": "active",
    },
    "paradesc_looks": {
        "color_map": "heat", "span": "percentile", "percentile": 5.0, "symmetric": False, "minimum": -0.25,
        "maximum": 0.75, "use_neutral": True, "neutral": 0.125, "show_legend": False, "pack_red": "mean_curvature",
        "pack_name": "channels", "pack_kind": "BYTE_COLOR", "pack_domain": "CORNER",
    },
    "paradesc_animation": {
        "source": "deformed", "frame_source": "deformed", "use_scene_range": False, "frame_start": 1, "frame_end": 3,
        "frame_step": 1, "cache_folder": "//frames", "relative_to_rest": True, "overwrite": False,
    },
    "paradesc_live": {
        "samples": 24, "buffer_size": 128, "fast_seams": True, "full_render": False, "wait": True, "missing": "HOLD",
    },
}  # fmt: skip
# Settings that apply while values are computed, for the reference and for frames; the rest is as above.
COMPUTED = {"evaluate": "vertex", "relocation": "connected", "pattern": "golden-angle", "ellipse": "center"}
COMPUTED |= {
    "geodesic": "local",
    "distance": "euclidean",
    "precision": "full",
    "shape_key": "basis",
    "normals": "fitted",
}
# Steps along a side of one of the six faces of the sphere.
STEPS = 4


def add_sphere(name: str, place: float) -> bpy.types.Object:
    """Adds a cube blown up to a sphere, each side a chart. Coordinates have few bits, so Blenders agree."""
    places = np.linspace(-1, 1, STEPS + 1)
    points, uvs, quads = [], [], []
    for side in range(6):
        axis, sign = side // 2, 1 - 2 * (side % 2)
        for v in places:
            for u in places:
                cube = np.roll([sign, u, sign * v], axis)
                points.append(np.round(cube / np.linalg.norm(cube) * 1024) / 1024)
                uvs.append(((side % 3 + 0.1 + 0.4 * (u + 1)) / 3, (side // 3 + 0.1 + 0.4 * (v + 1)) / 2))
        first = side * (STEPS + 1) ** 2
        for row in range(STEPS):
            for column in range(STEPS):
                corner = first + row * (STEPS + 1) + column
                quads.append((corner, corner + 1, corner + STEPS + 2, corner + STEPS + 1))
    welded, number = np.unique(np.array(points), axis=0, return_inverse=True)
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(welded.tolist(), [], [[int(number.ravel()[corner]) for corner in quad] for quad in quads])
    layer = mesh.uv_layers.new(name="UVMap")
    layer.data.foreach_set("uv", np.array([uvs[corner] for quad in quads for corner in quad], np.float32).ravel())
    mesh.polygons.foreach_set("use_smooth", np.arange(len(quads)) > 0)  # one is flat, because every Blender stores that
    mesh.update()
    made = bpy.data.objects.new(name, mesh)
    made.location.x = place
    bpy.context.collection.objects.link(made)
    return made


def stretch(target: bpy.types.Object) -> None:
    """Makes it an ellipsoid from frame 1 to frame 3."""
    target.shape_key_add(name="Basis")
    key = target.shape_key_add(name="long")
    points = np.empty(3 * len(target.data.vertices), np.float32)
    target.data.vertices.foreach_get("co", points)
    key.data.foreach_set("co", (points.reshape(-1, 3) * np.float32([1, 1, 2])).ravel())
    for frame, value in ((1, 0.0), (3, 1.0)):
        key.value = value
        key.keyframe_insert("value", frame=frame)
    for curve in target.data.shape_keys.animation_data.action.fcurves:
        for point in curve.keyframe_points:
            point.interpolation = "LINEAR"


def choose(target: bpy.types.Object) -> None:
    """Selects one object."""
    for item in bpy.context.view_layer.objects:
        item.select_set(item == target)
    bpy.context.view_layer.objects.active = target


def apply(settings: dict) -> None:
    """Sets the members of the scene's groups."""
    for name, members in settings.items():
        for member, value in members.items():
            setattr(getattr(bpy.context.scene, name), member, value)


def plain(value: object) -> object:
    """A property's value as JSON has it."""
    if isinstance(value, set):
        return sorted(value)
    if isinstance(value, (bool, int, str)):
        return value
    return float(value)


def group_values(group: bpy.types.PropertyGroup) -> dict[str, object]:
    """Everything that a group of settings holds, except collections."""
    known = [item.identifier for item in group.bl_rna.properties if item.type not in ("COLLECTION", "POINTER")]
    return {name: plain(getattr(group, name)) for name in known if name != "rna_type"}


def names() -> dict[str, object]:
    """Properties of every group and of every operator, with the identifiers of choices."""

    def members(kind: object) -> dict[str, object]:
        return {
            item.identifier: [choice.identifier for choice in getattr(item, "enum_items_static", ())]
            for item in kind.bl_rna.properties
            if item.identifier != "rna_type"
        }

    scene, target = bpy.context.scene, bpy.data.objects["live"]
    groups = {f"Scene.{name}": members(getattr(scene, name)) for name in SETTINGS}
    groups["Object.paradesc_live"] = members(target.paradesc_live)
    operators = {name: members(getattr(bpy.ops.paradesc, name).get_rna_type()) for name in dir(bpy.ops.paradesc)}
    panels = sorted(name for name in dir(bpy.types) if name.startswith(("PARADESC_PT_", "PARADESC_MT_")))
    return {"groups": groups, "operators": operators, "panels": panels}


def attributes(target: bpy.types.Object) -> dict[str, np.ndarray]:
    """Every attribute that the add-on has left on a mesh."""
    found = {}
    for name in target.data["paradesc"]["attributes"]:
        data = target.data.attributes[name].data
        width = {"FLOAT": 1, "FLOAT_VECTOR": 3, "FLOAT_COLOR": 4}[target.data.attributes[name].data_type]
        values = np.empty(len(data) * width, np.float32)
        data.foreach_get({1: "value", 3: "vector", 4: "color"}[width], values)
        found[name] = values
    return found


def make_scene(blend: Path) -> tuple[dict[str, object], dict[str, np.ndarray]]:
    """Makes and saves everything; gives what saved_test.py has to expect."""
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    bpy.ops.wm.save_as_mainfile(filepath=str(blend))  # frames lie beside it
    baked, live, played = (add_sphere(name, 4.0 * place) for place, name in enumerate(("baked", "live", "played")))
    arrays: dict[str, np.ndarray] = {}
    apply(SETTINGS)
    apply({"paradesc": COMPUTED, "paradesc_animation": {"source": "original"}})
    choose(baked)
    assert bpy.ops.paradesc.bake() == {"FINISHED"}
    arrays.update({f"baked/{name}": values for name, values in attributes(baked).items()})
    for target in (live, played):
        stretch(target)
    bpy.context.scene.frame_set(1)
    choose(played)
    apply({"paradesc": {"descriptors": {"mean_curvature"}}})
    assert bpy.ops.paradesc.bake_frames() == {"FINISHED"}
    played.paradesc_live.mode, live.paradesc_live.mode = "CACHE", "LIVE"
    for frame in (1, 2, 3):
        bpy.context.scene.frame_set(frame)
        for target in (live, played):
            assert not target.paradesc_live.sentence, target.paradesc_live.sentence
            arrays.update({f"{target.name}/{frame}/{name}": values for name, values in attributes(target).items()})
    choose(baked)
    bpy.ops.paradesc.add_preset(name="Saved")
    scene = bpy.context.scene
    expected = {
        "preset": group_values(scene.paradesc),
        "names": names(),
        "records": {item.name: item.data["paradesc"].to_dict() for item in (baked, live, played)},
        "ranges": {item.name: [item.minimum, item.maximum] for item in scene.paradesc_live.ranges},
    }
    expected["settings"] = {name: group_values(getattr(scene, name)) for name in SETTINGS}
    bpy.ops.wm.save_as_mainfile(filepath=str(blend), compress=True)
    return expected, arrays


def main(addon: str, version: str, out: str) -> None:
    """Makes the scene, and packs everything."""
    sys.path.insert(0, addon)
    import paradesc_blender

    with tempfile.TemporaryDirectory() as work:
        folder, blend = Path(work), Path(work) / "saved.blend"
        paradesc_blender.register()
        expected, arrays = make_scene(blend)
        expected.update(version=version, blender=bpy.app.version_string)
        packed = io.BytesIO()
        np.savez_compressed(packed, **arrays)
        kept = Path(os.environ["BLENDER_USER_SCRIPTS"]) / "presets" / "paradesc"
        with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED, compresslevel=9) as archive:
            for path in (blend, *sorted(folder.rglob("*.pdframe")), *sorted(folder.rglob("*.json"))):
                archive.write(path, path.relative_to(folder))
            archive.write(kept / "Saved.json", "Saved.json")
            archive.writestr("expected.json", json.dumps(expected, indent=1, sort_keys=True))
            archive.writestr("expected.npz", packed.getvalue())
        paradesc_blender.unregister()
    sys.stdout.write(f"{Path(out).stat().st_size:,} bytes\n")


main(*sys.argv[sys.argv.index("--") + 1 :])
