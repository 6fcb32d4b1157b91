"""glTF and FBX with the mask, read back."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

import bpy
import numpy as np
import person
from scenes import as_found, clicked, empty, monkey

from paradesc_blender.scene import arrays

if TYPE_CHECKING:
    from drive import Run


def exported(run: "Run", kind: str) -> Iterator[None]:
    """Bakes a monkey, exports it, imports it again, and compares the colors."""
    made = monkey(2, applied=True)
    as_found()
    yield from clicked()
    before = arrays.attribute_values(made.data.attributes["cavity_color"])[:, 0]
    path = str(run.folder / f"monkey.{kind}")
    if kind == "glb":
        words = {"use_selection": True}
        if "export_vertex_color" in bpy.ops.export_scene.gltf.get_rna_type().properties:
            words["export_vertex_color"] = "ACTIVE"
        bpy.ops.export_scene.gltf(filepath=path, **words)
    else:
        bpy.ops.export_scene.fbx(filepath=path, use_selection=True, mesh_smooth_type="FACE")
    empty()
    (bpy.ops.import_scene.gltf if kind == "glb" else bpy.ops.import_scene.fbx)(filepath=path)
    yield from person.drawn(3)
    read = next(item for item in bpy.context.scene.objects if item.type == "MESH").data
    names = [item.name for item in read.color_attributes]
    layer = read.color_attributes[0] if names else None
    colors = np.zeros(4 * len(layer.data) if layer else 4, np.float32)
    if layer:
        layer.data.foreach_get("color", colors)
    after = colors.reshape(-1, 4)[:, 0]
    percent = (50, 90, 99)
    text = f"{kind}: color layers {names}; percentiles {percent} before {np.percentile(before, percent).round(2)}, after {np.percentile(after, percent).round(2)}"
    run.saw("export", text, bool(names) and bool(np.abs(np.percentile(before, 99) - np.percentile(after, 99)) < 0.1))


def steps(run: "Run") -> Iterator[None]:
    """Both."""
    yield from person.alone()
    yield from person.open_tab()
    for kind in ("glb", "fbx"):
        yield from run.tried("export", exported(run, kind))
