"""Renders each asset on a beveled box, by Cycles, as its thumbnail in the Asset Browser."""

import tempfile
from math import radians
from pathlib import Path

import bmesh
import bpy
import numpy as np
from mathutils import Vector

import paradesc_blender
from paradesc_blender.show import recolor, wear

SIDE, SAMPLES, SHADES = 128, 128, 64  # few shades keep the file small
# The box, and its radius of a bake in percent of the diagonal.
WIDTH, PANEL, VOXEL, RADIUS = 2.0, 0.3, 0.014, 1.6
LIGHTS = (  # direction, power, size, color
    ((-1.0, -0.8, 1.1), 300.0, 1.6, (1.0, 0.96, 0.9)),
    ((1.2, -0.3, 0.3), 130.0, 3.0, (0.85, 0.92, 1.0)),
    ((0.3, 1.0, 0.8), 220.0, 1.5, (1.0, 1.0, 1.0)),
)


def add(blocks: list[bpy.types.ID]) -> None:
    """Gives every asset its thumbnail, and takes away what it was rendered with."""
    paradesc_blender.register()
    target = baked_box()
    set_scene()
    for block in blocks:
        if isinstance(block, bpy.types.Material):
            shown = block
        elif isinstance(block, bpy.types.ShaderNodeTree):
            shown = shading(block)
        else:
            shown = plain()
            modify(target, block)
        target.data.materials.clear()
        target.data.materials.append(shown)
        give(block, rendered())
        target.modifiers.clear()
    paradesc_blender.unregister()


def baked_box() -> bpy.types.Object:
    """A box with recessed panels and a bolt on each, with the masks of a bake."""
    bpy.ops.mesh.primitive_cube_add(size=WIDTH)
    box = bpy.context.object
    surface = bmesh.new()
    surface.from_mesh(box.data)
    bmesh.ops.inset_individual(surface, faces=surface.faces[:], thickness=PANEL)
    panels = [face for face in surface.faces if abs(max(face.calc_center_median(), key=abs)) > 0.99 and is_panel(face)]
    moved = bmesh.ops.extrude_discrete_faces(surface, faces=panels)["faces"]
    for face in moved:
        bmesh.ops.translate(surface, verts=face.verts, vec=-0.16 * face.normal)
    surface.to_mesh(box.data)
    surface.free()
    for kind, members in (
        ("BEVEL", {"width": 0.05, "segments": 4}),
        ("REMESH", {"mode": "VOXEL", "voxel_size": VOXEL}),
        ("SMOOTH", {"iterations": 4}),
    ):
        modifier = box.modifiers.new(kind, kind)
        for name, value in members.items():
            setattr(modifier, name, value)
    bpy.ops.object.convert(target="MESH")
    bpy.ops.object.shade_smooth()
    box.rotation_euler.z = radians(-22)
    settings = bpy.context.scene.paradesc
    settings.radius_percent = RADIUS
    for name in ("cavity", "convexity", "mean_curvature"):
        settings.descriptors = {name}
        bpy.ops.paradesc.bake()
    return box


def is_panel(face: bmesh.types.BMFace) -> bool:
    """Returns whether a face of the box with insets is one of the inner ones."""
    return len(face.verts) == 4 and all(sum(abs(c) > 0.99 for c in vertex.co) == 1 for vertex in face.verts)


def set_scene() -> None:
    """Puts camera and lights around the box, and nothing behind it."""
    scene = bpy.context.scene
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    scene.collection.objects.link(camera)
    scene.camera, camera.data.lens = camera, 85.0
    place(camera, (0.45, -1.0, 0.42), 8.6)
    for direction, power, size, color in LIGHTS:
        lamp = bpy.data.lights.new("lamp", "AREA")
        lamp.energy, lamp.size, lamp.color = power, size, color
        item = bpy.data.objects.new("lamp", lamp)
        scene.collection.objects.link(item)
        place(item, direction, 5.0)
    scene.world = bpy.data.worlds.new("grey")
    scene.world.use_nodes = True
    scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.14, 0.15, 0.165, 1.0)
    scene.render.engine, scene.cycles.device, scene.cycles.samples = "CYCLES", "CPU", SAMPLES
    scene.cycles.use_denoising, scene.cycles.seed = False, 0
    scene.render.resolution_x = scene.render.resolution_y = SIDE
    scene.render.film_transparent = True
    scene.view_settings.view_transform = "Standard"


def place(item: bpy.types.Object, direction: tuple[float, float, float], distance: float) -> None:
    """Puts something into a direction from the box, at which it looks."""
    item.location = distance * Vector(direction).normalized()
    item.rotation_euler = (-item.location).to_track_quat("-Z", "Y").to_euler()


def shading(group: bpy.types.NodeTree) -> bpy.types.Material:
    """A material that shows what a group of shader nodes gives first."""
    material = plain()
    tree = material.node_tree
    node = tree.nodes.new("ShaderNodeGroup")
    node.node_tree = group
    shader = next(one for one in tree.nodes if one.type == "BSDF_PRINCIPLED")
    if group.name == wear.GROUP:
        for name, descriptor in wear.MASKS.items():
            attribute = tree.nodes.new("ShaderNodeAttribute")
            attribute.attribute_name = f"{descriptor}_color"
            tree.links.new(attribute.outputs["Color"], node.inputs[name])
        node.inputs["Base Color"].default_value = (0.30, 0.33, 0.12, 1.0)
    if "Radius" in node.inputs:
        node.inputs["Radius"].default_value = 0.01 * RADIUS * WIDTH * 3**0.5
    output = "Both" if "Both" in node.outputs else "Color"
    tree.links.new(node.outputs[output], shader.inputs["Base Color"])
    return material


def plain() -> bpy.types.Material:
    """A material of light clay."""
    material = bpy.data.materials.new("plain")
    material.use_nodes = True
    shader = next(one for one in material.node_tree.nodes if one.type == "BSDF_PRINCIPLED")
    shader.inputs["Base Color"].default_value = (0.5, 0.42, 0.36, 1.0)
    shader.inputs["Roughness"].default_value = 0.7
    return material


def modify(target: bpy.types.Object, group: bpy.types.NodeTree) -> None:
    """Adds geometry nodes that do enough to be seen on a thumbnail."""
    modifier = target.modifiers.new("nodes", "NODES")
    modifier.node_group = group
    shown = recolor.stored_range(target.data, "cavity")
    shares = {"From Min": 0.3, "From Max": 0.8, "Above": 0.2}
    wanted = {name: share * shown.maximum for name, share in shares.items()}
    wanted |= {"Offset": 0.2, "Size": 0.03, "Density": 900.0}
    for socket in group.inputs:
        if socket.name in wanted:
            modifier[socket.identifier] = wanted[socket.name]


def rendered() -> np.ndarray:
    """(SIDE * SIDE * 4,) display colors of what the camera sees."""
    with tempfile.TemporaryDirectory() as folder:
        path = str(Path(folder) / "thumbnail.png")
        bpy.context.scene.render.filepath = path
        bpy.ops.render.render(write_still=True)
        image = bpy.data.images.load(path)
        pixels = np.array(image.pixels[:], np.float32)
        bpy.data.images.remove(image)
    return pixels


def give(block: bpy.types.ID, pixels: np.ndarray) -> None:
    """Makes a picture the thumbnail of an asset."""
    preview = block.preview_ensure()
    preview.image_size = (SIDE, SIDE)
    preview.image_pixels_float.foreach_set(np.round(pixels * (SHADES - 1)) / (SHADES - 1))
