"""Small animated scenes: an armature that bends a cylinder, a shape key on a sphere."""

from math import cos, pi, radians, sin

import bpy
import numpy as np

from scene import add_sphere, empty_scene


def bent_cylinder(rings=12, sides=16, name="cylinder"):
    """An open cylinder along z over two bones, the upper of which bends by 90 degrees from frame 1 to frame 20."""
    empty_scene()
    mesh = bpy.data.meshes.new(name)
    angles = [2 * pi * k / sides for k in range(sides)]
    places = [(0.5 * cos(a), 0.5 * sin(a), 4 * ring / rings) for ring in range(rings + 1) for a in angles]
    quads = [
        (r * sides + k, r * sides + (k + 1) % sides, (r + 1) * sides + (k + 1) % sides, (r + 1) * sides + k)
        for r in range(rings)
        for k in range(sides)
    ]
    mesh.from_pydata(places, [], quads)
    corners = [((k + u) / sides, (r + v) / rings) for r in range(rings) for k in range(sides) for u, v in UNIT]
    mesh.uv_layers.new(name="UVMap").data.foreach_set("uv", np.array(corners, np.float32).ravel())
    mesh.polygons.foreach_set("use_smooth", np.full(len(quads), True))
    mesh.update()
    target = bpy.data.objects.new(name, mesh)
    bpy.context.collection.objects.link(target)
    skeleton = add_bones()
    for group, upper in (("lower", False), ("upper", True)):
        weights = target.vertex_groups.new(name=group)
        for vertex, place in enumerate(places):
            share = min(1.0, max(0.0, place[2] - 1.5))
            weights.add([vertex], share if upper else 1 - share, "REPLACE")
    target.modifiers.new("Armature", "ARMATURE").object = skeleton
    bpy.context.view_layer.objects.active = target
    target.select_set(True)
    bpy.context.scene.frame_set(1)
    return target


UNIT = ((0, 0), (1, 0), (1, 1), (0, 1))


def add_bones():
    """Two bones in a row along z, the upper one turned from frame 1 to 20."""
    data = bpy.data.armatures.new("skeleton")
    skeleton = bpy.data.objects.new("skeleton", data)
    bpy.context.collection.objects.link(skeleton)
    bpy.context.view_layer.objects.active = skeleton
    bpy.ops.object.mode_set(mode="EDIT")
    lower, upper = data.edit_bones.new("lower"), data.edit_bones.new("upper")
    lower.head, lower.tail = (0, 0, 0), (0, 0, 2)
    upper.head, upper.tail = (0, 0, 2), (0, 0, 4)
    upper.parent = lower
    bpy.ops.object.mode_set(mode="OBJECT")
    bone = skeleton.pose.bones["upper"]
    bone.rotation_mode = "XYZ"
    for frame, angle in ((1, 0), (20, radians(90))):
        bone.rotation_euler = (angle, 0, 0)
        bone.keyframe_insert("rotation_euler", frame=frame)
    return skeleton


def swelling_sphere(steps=8):
    """A sphere of radius 2 that a shape key makes one of radius 4 from frame 1 to frame 11."""
    empty_scene()
    target = add_sphere(steps=steps)
    target.shape_key_add(name="Basis")
    key = target.shape_key_add(name="Large")
    for place, vertex in zip(key.data, target.data.vertices, strict=True):
        place.co = 2 * vertex.co
    for frame, value in ((1, 0.0), (11, 1.0)):
        key.value = value
        key.keyframe_insert("value", frame=frame)
    for curve in curves_of(target.data.shape_keys):
        for point in curve.keyframe_points:
            point.interpolation = "LINEAR"
    bpy.context.scene.frame_set(1)
    return target


def curves_of(owner):
    """The curves of an owner's action, in layers or as they were before Blender 5."""
    action = owner.animation_data.action
    if hasattr(action, "fcurves"):
        return list(action.fcurves)
    return [
        curve for layer in action.layers for strip in layer.strips for bag in strip.channelbags for curve in bag.fcurves
    ]
