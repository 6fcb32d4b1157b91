"""paradesc info: describes the meshes of a file, what is wrong with them, and which radius and buffer suit them."""

import argparse
from typing import TYPE_CHECKING

from .. import bridge
from ..core import advice
from .common import Parser, add_objects_options, add_output_options, check_outputs, open_input, print_notes
from .options import add_input

if TYPE_CHECKING:
    import bpy

# Counts of the mesh report that limit a bake, in words.
DEFECTS = {
    "degenerate_triangles": "triangles without area",
    "zero_uv_area_triangles": "triangles without area in the UV map",
    "flipped_triangles": "flipped triangles in the UV map",
    "nonmanifold_edges": "non-manifold edges",
    "nonmanifold_vertices": "non-manifold vertices",
    "loose_vertices": "loose vertices",
    "unlinked_edges": "edges without a partner over the seam",
}


def add_command(commands: "argparse._SubParsersAction[Parser]") -> None:
    """The command and its options."""
    info = commands.add_parser("info", help="show what a file's meshes are, and which radius and buffer suit them")
    add_input(info)
    add_objects_options(info)
    add_output_options(info)
    info.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> dict[str, object]:
    """Prints every mesh object, or those that --object names; gives them."""
    check_outputs([arguments.json] if arguments.json else [])
    _, notes = open_input(arguments)
    from ..scene import scene_io

    named = [scene_io.find_object(name) for name in dict.fromkeys(arguments.object)]
    shown = named or [item for item in scene_io.mesh_objects() if item not in scene_io.bone_shapes()]
    objects = [describe(item) for item in shown]
    for row in objects:
        print_object(row)
    if not objects:
        print("There is no mesh object.")
    print_notes(notes)
    return {"objects": objects, "notes": notes}


def describe(target: "bpy.types.Object") -> dict[str, object]:
    """Describes one object: facts, UV map, defects, and what suits it; or says why the mesh cannot be read."""
    from ..scene import mesh_io, record

    mesh = target.data
    row: dict[str, object] = {
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
    try:
        arrays = mesh_io.read_object(target, corner_normals=False, needs_uvs=False)
        with bridge.Context("reference") as context, context.mesh(arrays) as native:
            report = native.report()
            hint = advice.suggested(report, advice.texels_per_length(arrays))
            memory = expected_memory(native, hint)
    except bridge.ParadescError as error:
        return {**row, "obstacle": error.sentence, "vertices": len(mesh.vertices), "faces": len(mesh.polygons)}
    return {
        **row,
        "vertices": report["vertex_count"],
        "faces": len(mesh.polygons),
        "triangles": report["triangle_count"],
        "parts": report["parts"],
        "boundary_edges": report["boundary_edges"],
        "welded_vertices": report["welded_vertices"],
        "uv_map": uv_map(mesh, arrays, report),
        "defects": {name: report[name] for name in DEFECTS},
        "diagonal": report["diagonal"],
        "mean_edge": report["mean_edge"],
        "suggested": hint,
        "memory": memory,
    }


def expected_memory(native: bridge.Mesh, hint: dict[str, object] | None) -> dict[str, int]:
    """Bytes that a bake at the suggested settings would take on a software rasterizer, which uses the host's memory."""
    options = bridge.Options(buffer_size=int(hint["buffer"])) if hint else bridge.Options()
    return native.memory(["mean_curvature"], options, "software")


def uv_map(mesh: "bpy.types.Mesh", arrays: bridge.MeshArrays, report: dict[str, float]) -> dict[str, object]:
    """The active UV map: its name, what it is lacking, its charts and seams."""
    from ..scene import mesh_io, unwrap

    own = mesh_io.read_uvs(mesh)
    return {
        "name": None if own is None else mesh.uv_layers.active.name,
        "fault": unwrap.fault(own, arrays.triangle_corners),
        "charts": report["charts"],
        "seam_edges": report["seam_edges"],
    }


def print_object(row: dict[str, object]) -> None:
    """Prints an object in a few lines."""
    if row["obstacle"]:
        print(f'object "{row["object"]}": {row["obstacle"]}')
        return
    print(
        f'object "{row["object"]}": {row["vertices"]:,} vertices, {row["faces"]:,} faces, '
        f"{row['triangles']:,} triangles, parts: {row['parts']:,}, boundary edges: {row['boundary_edges']:,}"
    )
    found = row["uv_map"]
    state = f"The mesh {found['fault']}; it is unwrapped for a bake" if found["fault"] else "usable"
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
