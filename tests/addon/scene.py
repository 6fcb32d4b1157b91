"""The parts that tests inside Blender share: an empty scene, its sphere, a fingerprint of everything in a mesh."""

import hashlib
import time

import bpy
import numpy as np

from shapes import cube_sphere


def empty_scene():
    """A scene without objects."""
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    measure_curvature()


def measure_curvature():
    """Lets the panel measure the mean curvature of base meshes, which has closed forms; new scenes bake masks."""
    if hasattr(bpy.types.Scene, "paradesc"):
        scene = bpy.context.scene
        scene.paradesc.descriptors, scene.paradesc_animation.source = {"mean_curvature"}, "original"


def add_sphere(name="sphere", steps=8, uv_map=True, smooth=True):
    """The sphere of six charts as Blender's active object."""
    points, quads, uvs = cube_sphere(steps)
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(points.tolist(), [], quads.tolist())
    if uv_map:
        mesh.uv_layers.new(name="UVMap").data.foreach_set("uv", uvs.astype(np.float32).ravel())
    mesh.polygons.foreach_set("use_smooth", np.full(len(quads), smooth))
    mesh.update()
    made = bpy.data.objects.new(name, mesh)
    bpy.context.collection.objects.link(made)
    bpy.context.view_layer.objects.active = made
    made.select_set(True)
    return made


def attribute_values(mesh, name):
    """(n,) or (n, 4) float32 values of an attribute."""
    attribute = mesh.attributes[name]
    member, width = ("color", 4) if attribute.data_type == "FLOAT_COLOR" else ("value", 1)
    values = np.empty(len(attribute.data) * width, np.float32)
    attribute.data.foreach_get(member, values)
    return values.reshape(-1, 4) if width == 4 else values


def fingerprint(target):
    """Everything about an object's mesh that a bake could change."""
    mesh = target.data
    positions = np.empty(3 * len(mesh.vertices), np.float32)
    mesh.vertices.foreach_get("co", positions)
    attributes = []
    for attribute in mesh.attributes:
        member = {"FLOAT": "value", "FLOAT_COLOR": "color", "INT": "value"}.get(attribute.data_type)
        content = b""
        if member:
            width = 4 if member == "color" else 1
            values = np.empty(len(attribute.data) * width, np.float32)
            attribute.data.foreach_get(member, values)
            content = values.tobytes()
        attributes.append((attribute.name, attribute.data_type, attribute.domain, hashlib.sha256(content).hexdigest()))
    active = mesh.color_attributes.active_color
    return (
        target.mode,
        positions.tobytes(),
        sorted(attributes),
        None if active is None else active.name,
        sorted(mesh.keys()),
        sorted(item.name for item in bpy.data.objects),
        sorted(item.name for item in bpy.data.meshes),
    )


def select(*targets):
    """Selects these objects, the last one as the active one."""
    for item in bpy.context.view_layer.objects:
        item.select_set(item in targets)
    bpy.context.view_layer.objects.active = targets[-1]


def subdivide():
    """Subdivides the whole mesh of the active object, as one does in edit mode."""
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="SELECT")
    bpy.ops.mesh.subdivide()
    bpy.ops.object.mode_set(mode="OBJECT")


def small_bake(backend="software"):
    """Settings that take a moment on small spheres."""
    settings = bpy.context.scene.paradesc
    settings.radius_percent, settings.samples, settings.buffer_size = 8.0, 64, 256
    settings.backend = backend
    return settings


def cancel_at(batch, fraction):
    """Begins a batch, and cancels it once its worker has done this share."""
    batch.step()
    while batch.worker.fraction < fraction and not batch.worker.done:
        time.sleep(0.001)
    batch.cancel()
    batch.close()
    assert batch.cancelled
    assert not batch.written


def saved_scene(path):
    """Saves the open scene; gives the path."""
    bpy.ops.wm.save_as_mainfile(filepath=str(path), check_existing=False)
    return path
