"""Checks what a bake left in a mesh's custom property: the file may be of another version, or edited.

Never imports bpy.
"""

import math

from . import color_maps

# The members of a report that the panel shows. A report without one of them counts as missing.
MESH_REPORT = (
    "vertex_count",
    "triangle_count",
    "charts",
    "seam_edges",
    "loose_vertices",
    "degenerate_triangles",
    "zero_uv_area_triangles",
    "flipped_triangles",
    "nonmanifold_edges",
    "nonmanifold_vertices",
)
FIELD_REPORT = ("radius", "coverage_mean", "undefined_vertices", "seconds_total", "radius_in_texels")
WORDS = ("backend", "device", "warnings", "notes")
# The members of a bake to images that the panel shows, besides the name and content of each image:
IMAGE_LISTS = ("names", "holds")
IMAGE_WORDS, IMAGE_NUMBERS = ("uv_map", "notes", "warnings"), ("size", "seconds", "cage")


def checked(content: object) -> dict[str, object]:
    """The valid part of a record that record.write() made; empty if it names no attributes."""
    names = content.get("attributes") if isinstance(content, dict) else None
    if not isinstance(names, list) or not all(isinstance(name, str) for name in names):
        return {}
    found = {**content, "ranges": ranges(content.get("ranges")), "drawn": drawn(content.get("drawn"))}
    found.update({word: value if isinstance(value := content.get(word), str) else "" for word in WORDS})
    found["layout"] = texts(content.get("layout"))
    found["settings"] = as_dict(content.get("settings"))
    made = image_bake(found.pop("image_bake", None))
    found.update({"image_bake": made} if made else {})
    reports = {"mesh_report": MESH_REPORT, "field_report": FIELD_REPORT}
    if not all(is_report(content.get(name), members) for name, members in reports.items()):
        for name in reports:
            found.pop(name, None)
    return found


def as_dict(value: object) -> dict[str, object]:
    """The value if it is a dictionary, else an empty one."""
    return value if isinstance(value, dict) else {}


def texts(value: object) -> dict[str, str]:
    """The entries of a dictionary that are texts."""
    return {name: text for name, text in as_dict(value).items() if isinstance(text, str)}


def is_number(value: object) -> bool:
    """True of a finite number."""
    return isinstance(value, (int, float)) and abs(value) <= 1e300 and math.isfinite(value)


def is_report(value: object, members: tuple[str, ...]) -> bool:
    """Whether this is a dictionary of numbers with these members."""
    if not isinstance(value, dict) or not all(name in value for name in members):
        return False
    return all(is_number(number) for number in value.values())


def image_bake(value: object) -> dict[str, object]:
    """The record of a bake to images; empty if any part of it is missing."""
    row = as_dict(value)
    lists = [row.get(name) for name in IMAGE_LISTS]
    sound = all(isinstance(one, list) and all(isinstance(text, str) for text in one) for one in lists)
    sound = sound and len(lists[0]) == len(lists[1])
    sound = sound and all(isinstance(row.get(name), str) for name in IMAGE_WORDS)
    sound = sound and all(is_number(row.get(name)) for name in IMAGE_NUMBERS)
    if not sound:
        return {}
    percent = row.get("percent")  # which the files of earlier versions lack, as they lack extremes
    more = {"percent": percent if is_number(percent) else 0.0, "drawn": drawn(row.get("drawn"))}
    return {**{name: row[name] for name in (*IMAGE_LISTS, *IMAGE_WORDS, *IMAGE_NUMBERS)}, **more}


def ranges(value: object) -> dict[str, list[float]]:
    """The valid ranges by name: a lower and a larger upper number."""
    found = {}
    for name, span in as_dict(value).items():
        if isinstance(span, (list, tuple)) and len(span) == 2 and all(map(is_number, span)) and span[0] < span[1]:
            found[name] = [float(span[0]), float(span[1])]
    return found


def drawn(value: object) -> dict[str, dict[str, object]]:
    """The valid parts of how colors were made, by name, in the form of drawing_of()."""
    sound = {
        "map": lambda given: isinstance(given, str) and given in (color_maps.AUTOMATIC, *color_maps.MAPS),
        "diverging": lambda given: isinstance(given, (bool, int)),
        "neutral": is_number,
        "radius": is_number,
        "unit": lambda given: isinstance(given, str),
        "automatic": lambda given: bool(ranges({"": given})),
        "contrast": is_number,
        "brightness": is_number,
        "invert": lambda given: isinstance(given, (bool, int)),
        "dark": is_number,
        "bright": is_number,
    }
    return {
        name: {word: row[word] for word, good in sound.items() if word in row and good(row[word])}
        for name, row in as_dict(value).items()
        if isinstance(row, dict)
    }
