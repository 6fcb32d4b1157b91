"""Blender's own masks of the same meshes: Dirty Vertex Colors and Pointiness, in the sense of cavity or of edge wear."""

import bpy
import numpy as np

# Half the width of the ramp around 0.5, which is flat, that an artist puts behind Pointiness.
RAMP = 0.05


def dirty(target: bpy.types.Object, mask: str) -> np.ndarray:
    """(vertex_count,) of Paint > Dirty Vertex Colors at its defaults; dark hollows are white in a cavity mask."""
    mesh = chosen(target)
    layer = mesh.color_attributes.new("Dirty", "BYTE_COLOR", "POINT")
    mesh.color_attributes.active_color = layer
    bpy.ops.paint.vertex_color_dirt()
    tones = first_channel(mesh, "Dirty")
    return 1 - tones if mask == "cavity" else tones


def pointiness(target: bpy.types.Object, mask: str) -> np.ndarray:
    """(vertex_count,) of Geometry > Pointiness, baked by Cycles, behind a ramp on the side of 0.5 that the mask shows."""
    mesh = chosen(target)
    layer = mesh.color_attributes.new("Pointiness", "FLOAT_COLOR", "POINT")
    mesh.color_attributes.active_color = layer
    material = bpy.data.materials.new("Pointiness")
    material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    geometry, light, output = (
        tree.nodes.new(f"ShaderNode{kind}") for kind in ("NewGeometry", "Emission", "OutputMaterial")
    )
    tree.links.new(geometry.outputs["Pointiness"], light.inputs["Color"])
    tree.links.new(light.outputs["Emission"], output.inputs["Surface"])
    mesh.materials.clear()
    mesh.materials.append(material)
    scene = bpy.context.scene
    scene.render.engine, scene.cycles.device, scene.cycles.samples = "CYCLES", "CPU", 1
    bpy.ops.object.bake(type="EMIT", target="VERTEX_COLORS")
    raw = first_channel(mesh, "Pointiness")
    return np.clip((0.5 - raw if mask == "cavity" else raw - 0.5) / RAMP, 0, 1)


def chosen(target: bpy.types.Object) -> bpy.types.Mesh:
    """The object's mesh, once nothing else is chosen."""
    for item in bpy.context.view_layer.objects:
        item.select_set(item == target)
    bpy.context.view_layer.objects.active = target
    return target.data


def first_channel(mesh: bpy.types.Mesh, name: str) -> np.ndarray:
    """(vertex_count,) linear values of a color attribute."""
    data = mesh.color_attributes[name].data
    colors = np.empty(4 * len(data), np.float32)
    data.foreach_get("color", colors)
    return colors.reshape(-1, 4)[:, 0].astype(np.float64)


PEERS = {"Dirty": dirty, "Pointiness": pointiness}
