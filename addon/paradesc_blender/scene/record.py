"""Stores a record of written values on a mesh, in a custom property for panels, recoloring and later bakes.

Bakes, live frames and recoloring all write it with write().
"""

from collections.abc import Iterable
from dataclasses import asdict

import bpy

from paradesc.core import legend, stored
from paradesc.core.color_maps import ValueRange
from paradesc.core.job import NUMBER, Results

# The custom property with settings, reports, the making of colors, and the names of our attributes.
PROPERTY = "paradesc"


def read(mesh: bpy.types.Mesh) -> dict[str, object]:
    """The record that write() left on this mesh, checked; empty if there is none."""
    return stored.checked(kept(mesh, PROPERTY))


def kept(block: bpy.types.ID, name: str) -> dict[str, object]:
    """The members of a custom property; empty if it is missing or is not a group."""
    content = block.get(name)
    return content.to_dict() if hasattr(content, "to_dict") else {}


def layout_of(mesh: bpy.types.Mesh) -> dict[str, str]:
    """The description of the layout that a bake left on this mesh; empty if there is none."""
    return read(mesh).get("layout", {})


def attributes_of(mesh: bpy.types.Mesh) -> list[str]:
    """The names of our attributes that still exist on this mesh."""
    return [name for name in read(mesh).get("attributes", []) if name in mesh.attributes]


def attribute_of(mesh: bpy.types.Mesh, name: str) -> str:
    """Our newest attribute for values of this name; it has a number appended if the name was taken."""
    found = [one for one in attributes_of(mesh) if name in (one, NUMBER.sub("", one))]
    return max(found, key=lambda one: (len(one), one), default=name)


def write(
    mesh: bpy.types.Mesh,
    facts: dict[str, object],
    shown: dict[str, ValueRange],
    drawn: dict[str, dict[str, object]],
    names: Iterable[str] = (),
    layout: dict[str, str] | None = None,
) -> None:
    """Adds facts of a computation, ranges and making of colors, names of attributes and a new layout to the record.

    Earlier entries stay unless they are replaced; attributes that no longer exist are dropped.
    """
    former = read(mesh)
    known = sorted({*former.get("attributes", []), *names})
    mesh[PROPERTY] = {
        **former,
        **facts,
        "layout": former.get("layout", {}) if layout is None else layout,
        "ranges": {**former.get("ranges", {}), **{name: [span.minimum, span.maximum] for name, span in shown.items()}},
        "drawn": {**former.get("drawn", {}), **drawn},
        "attributes": [name for name in known if name in mesh.attributes],
    }


def disown(mesh: bpy.types.Mesh, names: Iterable[str]) -> None:
    """Drops the names of attributes that are no longer ours."""
    known = read(mesh).get("attributes", [])
    if not set(known).isdisjoint(names):
        mesh[PROPERTY]["attributes"] = [name for name in known if name not in names]


def forget(mesh: bpy.types.Mesh, word: str) -> None:
    """Drops one fact of a computation."""
    if word in kept(mesh, PROPERTY):
        del mesh[PROPERTY][word]


def take_over(source: bpy.types.Mesh, mesh: bpy.types.Mesh) -> None:
    """Adds entries of another mesh's record about attributes that this mesh has too; its own entries win."""
    theirs, own = read(source), read(mesh)
    if theirs:
        names = sorted({*theirs["attributes"], *own.get("attributes", [])})
        both = {word: {**theirs[word], **own.get(word, {})} for word in ("ranges", "drawn")}
        kept = {**theirs, **own, **both, "layout": own.get("layout", {})}
        mesh[PROPERTY] = {**kept, "attributes": [name for name in names if name in mesh.attributes]}


# ---- What there is to say


def facts_of(results: Results) -> dict[str, object]:
    """The facts of a computation as plain numbers, strings and lists: settings, reports, device, warnings, notes."""
    return {
        "settings": {
            name: float(value) if isinstance(value, int) and abs(value) >= 2**31 else value  # Blender stores 32 bits
            for name, value in results.settings.as_dict().items()
        },
        "mesh_report": results.mesh_report,
        "field_report": results.field_report,
        "backend": results.backend,
        "device": results.device,
        "warnings": "\n".join(results.warnings),
        "notes": "\n".join(results.notes),
    }


def drawing(shown: ValueRange) -> dict[str, object]:
    """The making of colors, apart from their range."""
    return {
        "map": shown.map_name,
        "diverging": shown.diverging,
        **asdict(shown.levels),
        **({} if shown.neutral is None else {"neutral": shown.neutral}),
    }


def drawing_of(shown: ValueRange, results: Results, name: str) -> dict[str, object]:
    """The making of a descriptor's colors, with radius and unit, as legends and recoloring need it."""
    return {
        **drawing(shown),
        "radius": results.radius_of(name),
        "unit": legend.unit_of(name, results.settings.options.map_descriptor),
    }
