"""Shared by tests of live mode: a sphere that changes its shape, its values, and those of a bake of the same shape."""

import dataclasses

import bpy
import numpy as np

from paradesc import bridge
from paradesc.core import job
from paradesc.files.frame_baking import at_fixed_radii
from paradesc_blender.animation import live
from paradesc_blender.scene import mesh_io
from scene import add_sphere, attribute_values

NAME = "mean_curvature"


def stretching_sphere():
    """A sphere that a shape key makes an ellipsoid, from frame 1 to frame 3."""
    settings = bpy.context.scene.paradesc
    settings.radius_percent, settings.samples, settings.buffer_size = 8.0, 64, 256
    settings.backend = "software"
    made = add_sphere()
    made.shape_key_add(name="Basis")
    key = made.shape_key_add(name="long")
    points = np.empty(3 * len(made.data.vertices), np.float32)
    made.data.vertices.foreach_get("co", points)
    key.data.foreach_set("co", (points.reshape(-1, 3) * np.float32([1, 1, 2])).ravel())
    for frame, value in ((1, 0.0), (3, 1.0)):
        key.value = value
        key.keyframe_insert("value", frame=frame)
    bpy.context.scene.frame_set(1)
    return made


def switch(target, mode="LIVE"):
    """Switches live mode and gives the sentence that results."""
    target.paradesc_live.mode = mode
    return target.paradesc_live.sentence


def values(target, name=NAME):
    """The values on the mesh."""
    return attribute_values(bpy.data.objects[target.name].data, name)


def baked_shape(target, settings):
    """Bakes the object's present shape and gives the values."""
    evaluated = target.evaluated_get(bpy.context.evaluated_depsgraph_get())
    arrays = mesh_io.read_object(target, corner_normals=False)
    return job.run(dataclasses.replace(arrays, positions=mesh_io.read_positions(evaluated.data)), settings)


def live_settings(target):
    """The settings that live mode computes with, in the window."""
    settings = live.settings_for(bpy.context.scene, rendering=False)
    with bridge.Context(settings.backend) as context:
        rest = context.mesh(mesh_io.read_object(target, corner_normals=False)).report()
    return at_fixed_radii(settings, rest)


def count_computations(monkeypatch):
    """A list that grows with every computation."""
    done = []
    compute = live.Session.compute
    monkeypatch.setattr(live.Session, "compute", lambda *words: (done.append(1), compute(*words))[1])
    return done
