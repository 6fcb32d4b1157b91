"""Measures in Blender's Python module what Python adds to a bake, and the time of Dirty Vertex Colors, on one mesh.

python tests/bench/blender_times.py MESH.npz [BACKEND]     prints a line of JSON; run.py calls it

The overhead is everything except the native library's own calls, whose time is taken at the border to it.
"""

import json
import sys
import time
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "addon"))

import bpy  # noqa: E402

from paradesc import bridge  # noqa: E402
from paradesc.bridge import library  # noqa: E402
from paradesc.core import job  # noqa: E402
from paradesc_blender.scene import delivery, mesh_io  # noqa: E402

NAME = "mean_curvature"
REPEATS = 7


class Border:
    """Seconds within the library's functions, summed up."""

    def __init__(self) -> None:
        self.seconds = 0.0
        native = library.load_library()
        for name in [name for name in vars(native) if name.startswith("pdesc_")]:
            setattr(native, name, self.timed(getattr(native, name)))

    def timed(self, function: object) -> object:
        """The same function, whose time is added up."""

        def call(*arguments: object) -> object:
            start = time.perf_counter()
            try:
                return function(*arguments)
            finally:
                self.seconds += time.perf_counter() - start

        return call


def make_object(path: str) -> bpy.types.Object:
    """Makes an object with a UV map from a file of numpy arrays."""
    with np.load(path) as file:
        positions, vertices, uvs = file["positions"], file["corner_vertices"], file["corner_uvs"]
    mesh = bpy.data.meshes.new("Bench")
    count = len(vertices)
    mesh.vertices.add(len(positions))
    mesh.vertices.foreach_set("co", positions.ravel())
    mesh.loops.add(count)
    mesh.loops.foreach_set("vertex_index", vertices)
    mesh.polygons.add(count // 3)
    mesh.polygons.foreach_set("loop_start", np.arange(0, count, 3, dtype=np.int32))
    mesh.polygons.foreach_set("use_smooth", np.ones(count // 3, bool))
    mesh.update(calc_edges=True)
    mesh.uv_layers.new(name="UVMap").data.foreach_set("uv", uvs.ravel())
    made = bpy.data.objects.new("Bench", mesh)
    bpy.context.collection.objects.link(made)
    bpy.context.view_layer.objects.active = made
    made.select_set(True)
    return made


def overhead(target: bpy.types.Object, backend: str) -> dict[str, float]:
    """Seconds of the fastest of several bakes for reading the mesh, the bridge, and writing the values."""
    border = Border()
    settings = job.Settings((NAME,), bridge.Options(samples=8, buffer_size=256), backend)
    best: dict[str, float] = {}
    mesh = target.data
    with bridge.Context(backend) as context:
        for _ in range(REPEATS):
            start = time.perf_counter()
            arrays = mesh_io.read_object(target, corner_normals=False)
            read = time.perf_counter() - start
            native, start = border.seconds, time.perf_counter()
            with context.mesh(arrays) as made:
                results = job.run_on(made, arrays, settings)
            between = time.perf_counter() - start - (border.seconds - native)
            if NAME not in mesh.attributes:
                mesh.attributes.new(NAME, "FLOAT", "POINT")
            start = time.perf_counter()
            mesh.attributes[NAME].data.foreach_set("value", results.values[NAME])
            write = time.perf_counter() - start
            one = {"read_seconds": read, "bridge_seconds": between, "write_seconds": write}
            one["overhead_seconds"] = sum(one.values())
            if not best or one["overhead_seconds"] < best["overhead_seconds"]:
                best = one
    return best


def whole_bake(target: bpy.types.Object, backend: str) -> dict[str, float]:
    """Seconds for writing everything that a bake leaves in the mesh: values, colors, mask, summary."""
    settings = job.Settings((NAME,), bridge.Options(samples=8, buffer_size=256), backend)
    results = job.run(mesh_io.read_object(target, corner_normals=False), settings)
    taken = []
    for _ in range(3):
        start = time.perf_counter()
        delivery.deliver(target, results)
        taken.append(time.perf_counter() - start)
    return {"write_all_seconds": min(taken)}


def dirty(target: bpy.types.Object) -> float:
    """Seconds of Dirty Vertex Colors."""
    target.data.color_attributes.new("Dirt", "BYTE_COLOR", "CORNER")
    bpy.ops.object.mode_set(mode="VERTEX_PAINT")
    start = time.perf_counter()
    bpy.ops.paint.vertex_color_dirt()
    taken = time.perf_counter() - start
    bpy.ops.object.mode_set(mode="OBJECT")
    return taken


def main(path: str, backend: str = "auto") -> None:
    """Prints what was measured."""
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    target = make_object(path)
    found = {"dirty_seconds": dirty(target), **whole_bake(target, backend), **overhead(target, backend)}
    found |= {"vertices": len(target.data.vertices), "blender": bpy.app.version_string}
    sys.stdout.write("\n" + json.dumps(found) + "\n")


if __name__ == "__main__":
    main(*sys.argv[1:])
