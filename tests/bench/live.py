"""Measures frames per second of live mode, by stage, on a mesh that an armature bends, in Blender without a window.

PYTHONPATH=addon python tests/bench/live.py --samples 16 32 64 --buffers 256 512 --json live.json
"""

import argparse
import json
import platform
import sys
import time
from dataclasses import asdict, dataclass, replace
from pathlib import Path

import bpy
import numpy as np

import paradesc_blender
from paradesc.core import job
from paradesc_blender.animation import sessions
from paradesc_blender.scene import mesh_io

NAME = "mean_curvature"
LENGTH, RADIUS, BUMP = 8.0, 1.0, 0.06
FRAMES = 8


@dataclass
class Row:
    """The cost of one setting, as the least of all frames in milliseconds, and its error in percent of the range."""

    samples: int
    buffer_size: int
    vertices: int
    radius_in_texels: float
    frames_per_second: float
    cpu: float  # of all threads, which other programs do not change
    depsgraph: float  # both evaluations, without anything of ours
    read: float
    compute: float  # of this the native library's stages:
    native_prepare: float
    native_bake: float
    native_evaluate: float
    write: float
    mean_error: float
    error_99: float


def bumpy_cylinder(rings: int, sides: int) -> bpy.types.Object:
    """Makes an open cylinder along z with bumps, as one chart whose seam runs along it."""
    z, turn = np.meshgrid(np.arange(rings) / (rings - 1), np.arange(sides) / sides, indexing="ij")
    angle = 2 * np.pi * turn
    radius = RADIUS + BUMP * np.sin(4 * angle) * np.sin(12 * np.pi * z)
    points = np.stack([radius * np.cos(angle), radius * np.sin(angle), LENGTH * (z - 0.5)], axis=-1).reshape(-1, 3)
    ring, side = np.meshgrid(np.arange(rings - 1), np.arange(sides), indexing="ij")
    corners = np.array([[0, 0], [0, 1], [1, 1], [1, 0]])
    at_ring, at_side = ring[..., None] + corners[:, 0], side[..., None] + corners[:, 1]
    mesh = bpy.data.meshes.new("cylinder")
    mesh.from_pydata(points.tolist(), [], (at_ring * sides + at_side % sides).reshape(-1, 4).tolist())
    uvs = np.stack([at_side / sides, at_ring / (rings - 1)], axis=-1) * 0.98 + 0.01
    mesh.uv_layers.new(name="UVMap").data.foreach_set("uv", uvs.astype(np.float32).ravel())
    mesh.polygons.foreach_set("use_smooth", np.ones(len(mesh.polygons), bool))
    mesh.update()
    made = bpy.data.objects.new("cylinder", mesh)
    bpy.context.collection.objects.link(made)
    return made


def bend(target: bpy.types.Object) -> None:
    """Adds two bones with smooth weights, of which the upper one turns from the first frame to the last."""
    armature = bpy.data.objects.new("bones", bpy.data.armatures.new("bones"))
    bpy.context.collection.objects.link(armature)
    bpy.context.view_layer.objects.active = armature
    bpy.ops.object.mode_set(mode="EDIT")
    for name, start, end in (("lower", -LENGTH / 2, 0), ("upper", 0, LENGTH / 2)):
        bone = armature.data.edit_bones.new(name)
        bone.head, bone.tail = (0, 0, start), (0, 0, end)
    bpy.ops.object.mode_set(mode="OBJECT")
    for name, sign in (("lower", -1), ("upper", 1)):
        group = target.vertex_groups.new(name=name)
        for vertex in target.data.vertices:
            group.add([vertex.index], float(np.clip(0.5 + sign * vertex.co.z / 3, 0, 1)), "REPLACE")
    target.modifiers.new("bones", "ARMATURE").object = armature
    bone = armature.pose.bones["upper"]
    bone.rotation_mode = "XYZ"
    for frame, angle in ((1, 0.0), (FRAMES, 0.8)):
        bone.rotation_euler = (angle, 0, 0)
        bone.keyframe_insert("rotation_euler", frame=frame)


def frame_seconds(frame: int) -> float:
    """How long a change to this frame takes."""
    start = time.perf_counter()
    bpy.context.scene.frame_set(frame)
    return time.perf_counter() - start


def cpu_seconds(frame: int) -> float:
    """How much time of all cores a change to this frame takes."""
    start = time.process_time()
    bpy.context.scene.frame_set(frame)
    return time.process_time() - start


def reference_values(target: bpy.types.Object) -> np.ndarray:
    """(vertex_count,) values of the reference for the present shape."""
    settings = sessions.session_at(target).stream.settings
    arrays = mesh_io.read_object(target, corner_normals=False)
    evaluated = target.evaluated_get(bpy.context.evaluated_depsgraph_get())
    arrays = replace(arrays, positions=mesh_io.read_positions(evaluated.data))
    return job.run(arrays, replace(settings, backend="reference")).values[NAME]


def measure(target: bpy.types.Object, samples: int, buffer_size: int, expected: np.ndarray, rounds: int) -> Row:
    """Measures all frames several times; the least of each stage counts, because other programs can only add to it."""
    scene = bpy.context.scene
    scene.paradesc_live.samples, scene.paradesc_live.buffer_size = samples, buffer_size
    scene.frame_set(FRAMES)
    session = sessions.session_at(target)
    error = np.abs(session.results.values[NAME] - expected) / np.ptp(np.nanpercentile(expected, [2.5, 97.5]))
    times: dict[str, list[float]] = {}
    for frame in [*range(1, FRAMES + 1)] * rounds:
        total = frame_seconds(frame)
        report = session.results.field_report
        found = dict(session.seconds, total=total, depsgraph=total - sum(session.seconds.values()))
        found |= {f"native_{stage}": report[f"seconds_{stage}"] for stage in ("prepare", "bake", "evaluate")}
        for name, seconds in found.items():
            times.setdefault(name, []).append(1e3 * seconds)
    times["cpu"] = [1e3 * cpu_seconds(frame) for frame in range(1, FRAMES + 1)]
    least = {name: round(min(values), 2) for name, values in times.items()}
    return Row(
        samples=samples,
        buffer_size=session.results.settings.options.buffer_size,
        vertices=len(expected),
        radius_in_texels=round(session.results.field_report["radius_in_texels"], 1),
        frames_per_second=round(1e3 / least.pop("total"), 1),
        mean_error=round(100 * float(np.nanmean(error)), 3),
        error_99=round(100 * float(np.nanpercentile(error, 99)), 3),
        **least,
    )


def main() -> int:
    """Prints one row for each setting."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rings", type=int, default=250)
    parser.add_argument("--sides", type=int, default=140)
    parser.add_argument("--samples", type=int, nargs="+", default=[16, 32])
    parser.add_argument("--buffers", type=int, nargs="+", default=[512])
    parser.add_argument("--radius", type=float, default=2.0, help="percent of the diagonal")
    parser.add_argument("--backend", default="software")
    parser.add_argument("--rounds", type=int, default=2)
    parser.add_argument("--json", type=Path)
    words = parser.parse_args(sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else None)

    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    paradesc_blender.register()
    target = bumpy_cylinder(words.rings, words.sides)
    bend(target)
    settings = bpy.context.scene.paradesc
    settings.samples, settings.buffer_size, settings.radius_percent = 4096, 8192, words.radius
    settings.backend, settings.descriptors = words.backend, {NAME}
    bpy.context.scene.frame_set(FRAMES)
    bare = 1e3 * min(frame_seconds(frame) for frame in range(1, FRAMES + 1))
    bpy.context.scene.frame_set(FRAMES)
    target.paradesc_live.mode = "LIVE"
    expected = reference_values(target)
    sys.stdout.write(f"{len(expected)} vertices; a frame without live values takes {bare:.1f} ms\n")
    rows = [measure(target, s, b, expected, words.rounds) for b in words.buffers for s in words.samples]
    for row in rows:
        sys.stdout.write(
            "  ".join(f"{name} {value}" for name, value in asdict(row).items() if name != "vertices") + "\n"
        )
    if words.json:
        about = {"blender": bpy.app.version_string, "python": platform.python_version(), "bare_frame": round(bare, 2)}
        about["device"] = sessions.session_at(target).results.device
        words.json.write_text(json.dumps({**about, "rows": [asdict(row) for row in rows]}, indent=1) + "\n")
    paradesc_blender.unregister()
    return 0


if __name__ == "__main__":
    sys.exit(main())
