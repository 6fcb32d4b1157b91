"""Turns the report of a mesh into sentences about what in it spoils values, and what to do. Never imports bpy."""

# Faults in a smaller share of the triangles than this say nothing about the rest.
FEW = 0.01
# If a larger share of triangles than this has no area, the file was probably written or read wrong.
MANY_WITHOUT_AREA = 0.01
# A mesh has fallen apart if it has this many parts for each triangle: two triangles of a card are one part.
APART = 0.6
# A mesh with fewer triangles than this cannot fall apart.
LEAST = 8


def sentences(report: dict[str, float | int]) -> list[str]:
    """Sentences about defects in a bridge.Mesh.report() that limit values; none for a sound mesh, open or not."""
    flat, count = report["degenerate_triangles"], report["triangle_count"]
    used, found = count - flat - report["copied_triangles"], []
    if flat > MANY_WITHOUT_AREA * count:
        found.append(
            f"{flat:,} of {count:,} triangles have no area and are left out: check whether the file was written and "
            "read correctly, or dissolve them (Mesh > Clean Up > Degenerate Dissolve)."
        )
    if report["opposed_edges"]:
        found.append(
            f"{edges(report['opposed_edges'])} faces that are wound against each other, and the surface is taken "
            "apart there: give the faces one winding (in edit mode, with all selected, Mesh > Normals > Recalculate "
            "Outside)."
        )
    if report["inward_parts"]:
        found.append(wound_inwards(report))
    if used >= LEAST and report["parts"] >= APART * used:
        found.append(fallen_apart(report, used))
    elif report["nonmanifold_edges"] - report["opposed_edges"] > FEW * 1.5 * used:
        shared = report["nonmanifold_edges"] - report["opposed_edges"]
        found.append(
            f"{edges(shared)} more than two faces, and the surface is taken apart there: remove inner faces, "
            "which Select > All by Trait > Non Manifold finds in edit mode."
        )
    return found


def wound_inwards(report: dict[str, float | int]) -> str:
    """A sentence about closed parts whose faces have their back outside."""
    count = report["inward_parts"]
    some = f"{count:,} closed part is" if count == 1 else f"{count:,} closed parts are"
    which = "The closed mesh is" if report["parts"] == 1 else some
    return (
        f"{which} wound inwards, so convex places count as concave: turn the faces (in edit mode, with all "
        "selected, Mesh > Normals > Recalculate Outside)."
    )


def fallen_apart(report: dict[str, float | int], used: int) -> str:
    """A sentence about a mesh in which hardly any triangle has a neighbor."""
    counted = f"its {used:,} triangles are {report['parts']:,} parts"
    parts = f"The mesh falls apart: {counted}, and values are those of single faces"
    if report["boundary_edges"] > used:
        return (
            f"{parts}. Merge corners that lie beside each other (in edit mode, with all selected, Mesh > Merge > By "
            "Distance)."
        )
    return f"{parts}. Remove faces that lie within or upon others, and give the rest one winding."


def edges(count: int) -> str:
    """The beginning of a sentence about a number of edges."""
    return f"{count:,} edge has" if count == 1 else f"{count:,} edges have"
