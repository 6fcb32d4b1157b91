"""paradesc info: describes the meshes of a file, what is wrong with them, and which radius and buffer suit them."""

import argparse
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from .. import bridge
from ..core import advice, uv_faults
from ..files.mesh_files import FileMesh
from . import file_reading
from .common import Parser, add_objects_options, add_output_options, check_outputs, print_notes
from .opening import open_input
from .options import add_input

if TYPE_CHECKING:
    import bpy

# The name of the only UV map in a file whose format has no names for UV maps.
UV_NAME = "UVMap"
# Counts of the mesh report that limit a bake, with words for people.
DEFECTS = {
    "degenerate_triangles": "triangles without area",
    "copied_triangles": "triangles at the places of others",
    "zero_uv_area_triangles": "triangles without area in the UV map",
    "flipped_triangles": "flipped triangles in the UV map",
    "nonmanifold_edges": "non-manifold edges",
    "opposed_edges": "edges of faces wound against each other",
    "inward_parts": "closed parts wound inwards",
    "nonmanifold_vertices": "non-manifold vertices",
    "loose_vertices": "loose vertices",
    "unlinked_edges": "edges without a partner over the seam",
}


def add_command(commands: "argparse._SubParsersAction[Parser]") -> None:
    """The command and its options."""
    info = commands.add_parser("info", help="describe the meshes of a file, and the radius and buffer that suit them")
    add_input(info)
    add_objects_options(info)
    add_output_options(info)
    info.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> dict[str, object]:
    """Prints every mesh object, or those that --object names; returns their descriptions."""
    check_outputs([arguments.json] if arguments.json else [])
    if file_reading.reads_files(arguments):
        meshes = file_reading.open_files(arguments)
        shown = file_reading.chosen(meshes, arguments.object) if arguments.object else meshes
        objects = [described(subject_of_file(mesh)) for mesh in shown]
        notes = [note for mesh in shown for note in mesh.notes]
    else:
        _, notes = open_input(arguments)
        from ..scene import scene_io

        named = [scene_io.find_object(name) for name in dict.fromkeys(arguments.object)]
        shown = named or [item for item in scene_io.mesh_objects() if item not in scene_io.bone_shapes()]
        objects = [described(subject_of(item)) for item in shown]
    for row in objects:
        print_object(row, unwraps=not file_reading.reads_files(arguments))
    if not objects:
        print("There is no mesh object.")
    print_notes(notes)
    return {"objects": objects, "notes": notes}


@dataclass
class Subject:
    """A mesh to describe: facts that are always reported, and a function that reads the mesh."""

    facts: dict[str, object]
    vertices: int
    faces: int
    uv_name: str | None
    uvs: np.ndarray | None  # (corner_count, 2) float32 of the active UV map, even an unusable one
    read: Callable[[], bridge.MeshArrays]  # raises ParadescError if it cannot be read


def subject_of(target: "bpy.types.Object") -> Subject:
    """An object of the scene."""
    from ..scene import mesh_io, record

    mesh = target.data
    facts: dict[str, object] = {
        "object": target.name,
        "mesh": mesh.name,
        "renders": not target.hide_render,
        "linked": mesh.library is not None or mesh.override_library is not None,
        "scale": [round(float(size), 6) for size in target.matrix_world.to_scale()],
        "modifiers": [modifier.type for modifier in target.modifiers],
        "shape_keys": len(mesh.shape_keys.key_blocks) if mesh.shape_keys else 0,
        "uv_maps": [layer.name for layer in mesh.uv_layers],
        "baked": record.attributes_of(mesh),
        "obstacle": "",
    }
    uvs, active = mesh_io.read_uvs(mesh), mesh.uv_layers.active
    return Subject(
        facts, len(mesh.vertices), len(mesh.polygons), active.name if active else None, uvs,
        lambda: mesh_io.read_object(target, corner_normals=False, needs_uvs=False),
    )  # fmt: skip


def subject_of_file(mesh: FileMesh) -> Subject:
    """A mesh of a file, which has only its shape; formats with one UV map do not name it."""
    uvs = mesh.arrays.corner_uvs
    facts: dict[str, object] = {
        "object": mesh.name,
        "mesh": mesh.name,
        "renders": True,
        "linked": False,
        "scale": [round(float(size), 6) for size in np.linalg.norm(mesh.matrix_world[:3, :3], axis=0)],
        "modifiers": [],
        "shape_keys": 0,
        "uv_maps": [] if uvs is None else [UV_NAME],
        "baked": [],
        "obstacle": "",
    }
    arrays = mesh.arrays
    if uv_faults.fault(uvs, arrays.triangle_corners):
        arrays = replace(arrays, corner_uvs=None)
    name = None if uvs is None else UV_NAME
    return Subject(facts, len(arrays.positions), mesh.face_count, name, uvs, lambda: arrays)


def described(subject: Subject) -> dict[str, object]:
    """The description of a mesh: facts, UV map, defects, and suggested settings; or why it cannot be read."""
    try:
        arrays = subject.read()
        with bridge.Context("reference") as context, context.mesh(arrays) as native:
            report = native.report()
            hint = advice.suggested(report, advice.texels_per_length(arrays))
            memory = expected_memory(native, hint)
    except bridge.ParadescError as error:
        counts = {"vertices": subject.vertices, "faces": subject.faces}
        return {**subject.facts, "obstacle": error.sentence, **counts}
    return {
        **subject.facts,
        "vertices": report["vertex_count"],
        "faces": subject.faces,
        "triangles": report["triangle_count"],
        "parts": report["parts"],
        "boundary_edges": report["boundary_edges"],
        "welded_vertices": report["welded_vertices"],
        "uv_map": {
            "name": subject.uv_name,
            "fault": uv_faults.fault(subject.uvs, arrays.triangle_corners),
            "charts": report["charts"],
            "seam_edges": report["seam_edges"],
        },
        "defects": {name: report[name] for name in DEFECTS},
        "diagonal": report["diagonal"],
        "mean_edge": report["mean_edge"],
        "suggested": hint,
        "memory": memory,
    }


def expected_memory(native: bridge.Mesh, hint: dict[str, object] | None) -> dict[str, int]:
    """The bytes that a bake at the suggested settings would take on a software rasterizer, which uses main memory."""
    options = bridge.Options(buffer_size=int(hint["buffer"])) if hint else bridge.Options()
    return native.memory(["mean_curvature"], options, "software")


def print_object(row: dict[str, object], unwraps: bool) -> None:
    """Prints an object in a few lines."""
    if row["obstacle"]:
        print(f'object "{row["object"]}": {row["obstacle"]}')
        return
    print(
        f'object "{row["object"]}": {row["vertices"]:,} vertices, {row["faces"]:,} faces, '
        f"{row['triangles']:,} triangles, parts: {row['parts']:,}, boundary edges: {row['boundary_edges']:,}"
    )
    found = row["uv_map"]
    unwrapped = "it is unwrapped for a bake" if unwraps else "only Blender can unwrap it for images"
    state = f"The mesh {found['fault']}; {unwrapped}" if found["fault"] else "usable"
    name = f' "{found["name"]}"' if found["name"] else ""
    print(f"  UV map{name}: {state}, charts: {found['charts']:,}, seam edges: {found['seam_edges']:,}")
    defects = [f"{count:,} {DEFECTS[key]}" for key, count in row["defects"].items() if count]
    print(f"  defects: {', '.join(defects) or 'none'}")
    diagonal = row["diagonal"]
    print(f"  diagonal {diagonal:.6g}, mean edge {row['mean_edge']:.6g} ({row['mean_edge'] / diagonal:.3g} of it)")
    hint = row["suggested"]
    if hint:
        texels = f"{hint['radius_in_texels']:.1f} texels"
        least = f"{hint['smallest_radius_at_usual_buffer']:.3g}"
        print(f"  suggested: --radius {hint['radius']:g} --buffer {hint['buffer']} ({texels})")
        print(f"  four texels with --buffer {bridge.Options().buffer_size}: --radius {least}")
    memory = row["memory"]
    allowed = f"{memory['allowed'] / 1e6:,.0f} MB may be used"
    print(f"  memory for that on a software rasterizer: about {memory['total'] / 1e6:,.0f} MB, {allowed}")
