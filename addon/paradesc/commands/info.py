"""paradesc info: describes the meshes of a file, what is wrong with them, and which radius and buffer suit them."""

import argparse

from .. import bridge
from ..core import advice, uv_faults
from .common import Parser, print_notes
from .options import add_objects
from .sources import Subject, source_of

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


HELP = "describe the meshes of a file, and the radius and buffer that suit them"


def add_options(parser: Parser) -> None:
    """The command's options."""
    add_objects(parser)


def run(arguments: argparse.Namespace) -> dict[str, object]:
    """Prints every mesh object, or those that --object names; returns their descriptions."""
    source = source_of(arguments)
    notes = source.open()
    shown = [source.subject(target) for target in source.described()]
    notes += [note for subject in shown for note in subject.notes]
    objects = [described(subject) for subject in shown]
    for row in objects:
        print_object(row, unwraps=source.unwraps)
    if not objects:
        print("There is no mesh object.")
    print_notes(notes)
    return {"objects": objects, "notes": notes}


def described(subject: Subject) -> dict[str, object]:
    """The description of a mesh: facts, UV map, defects, and suggested settings; or why it cannot be read."""
    try:
        arrays = subject.read()
        with bridge.Context("reference") as context, context.mesh(arrays) as native:
            report = native.report()
            hint = advice.suggested(report, advice.texels_per_length(arrays))
            options = bridge.Options(buffer_size=int(hint["buffer"])) if hint else bridge.Options()
            # A software rasterizer uses main memory.
            memory = native.memory(["mean_curvature"], options, "software")
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
    share = f" ({row['mean_edge'] / diagonal:.3g} of it)" if diagonal else ""
    print(f"  diagonal {diagonal:.6g}, mean edge {row['mean_edge']:.6g}{share}")
    hint = row["suggested"]
    if hint:
        texels = f"{hint['radius_in_texels']:.1f} texels"
        least = f"{hint['smallest_radius_at_usual_buffer']:.3g}"
        print(f"  suggested: --radius {hint['radius']:g} --buffer {hint['buffer']} ({texels})")
        print(f"  four texels with --buffer {bridge.Options().buffer_size}: --radius {least}")
    memory = row["memory"]
    allowed = f"{memory['allowed'] / 1e6:,.0f} MB may be used"
    print(f"  memory for that on a software rasterizer: about {memory['total'] / 1e6:,.0f} MB, {allowed}")
