"""The settings of the panel and of presets: names, descriptions, defaults and limits. Never imports bpy.

Blender's properties are made of these (settings/properties.py), and the rules of presets follow from them
(files/preset_rules.py). The descriptors to choose from come from the native registry.
"""

from dataclasses import dataclass

from .. import bridge
from . import devices
from .color_maps import AUTOMATIC, CLIPPED_PERCENT, MAPS
from .corners import THRESHOLD


@dataclass(frozen=True)
class Member:
    """One setting: its kind, and the options for Blender's property."""

    kind: str  # bool, int, float, text, choice or choices (any number of them)
    words: dict[str, object]

    @property
    def default(self) -> object:
        """The value that nobody has chosen; several choices as a sorted list."""
        value = self.words.get("default", "")
        return sorted(value) if self.kind == "choices" else value


def member(kind: str, **words: object) -> Member:
    """A setting of this kind; words: name, description, default, and further options of its kind."""
    return Member(kind, words)


def options(panel: str) -> dict[str, Member]:
    """The settings for the options of the computation that are in a panel."""
    found = {}
    for row in bridge.TABLE:
        words = {"name": row.label, "description": row.about, "default": row.usual or row.default, **row.limits}
        if row.panel == panel:
            found[row.name] = Member(row.kind, {**words, **({"items": list(row.choices)} if row.choices else {})})
    return found


FITS = [
    ("fine", "Fine", "The smallest detail of the mesh"),
    ("medium", "Medium", "The usual choice for masks: one and a half edges, or 0.5 % of a dense mesh"),
    ("broad", "Broad", "Large forms"),
    ("typed", "Typed", "The typed radius"),
]
SPACES = [
    ("object", "Object", "The mesh as it is stored, before the object's scale"),
    (
        "world",
        "World",
        "The mesh as it stands in the scene, with the scale of the object and its parents, even uneven or mirrored",
    ),
]
SHAPES = [
    ("basis", "Basis", "The basis of the shape keys"),
    ("active", "Active Key", "The active shape key at its full value"),
]
IMAGE_FORMATS = [
    (".exr", "OpenEXR", "32-bit floats: the values themselves, all descriptors in one file"),
    (".png", "PNG, 16 Bits", "Values from the smallest to the largest as 16-bit numbers, a file for each descriptor"),
]
OUTSIDE = [
    ("neutral", "Neutral", "The value of a flat surface, which is 0.5 for values with a sign"),
    ("transparent", "Transparent", "An alpha channel, which is 0 outside the surface"),
]
BACKENDS = [(name, devices.TITLES[name], devices.ABOUT[name]) for name in bridge.BACKENDS]
COLOR_MAPS = [
    (AUTOMATIC, "Automatic", "Grey for masks; blue, white, red for values with a sign; viridis for all others"),
    *((row.name, row.label, row.description) for row in MAPS.values()),
]
SPANS = [
    (
        "auto",
        "Automatic",
        "Masks end near their largest value; other descriptors take their own range, or else the 2.5th to the 97.5th "
        "percentile",
    ),
    ("percentile", "Percentiles", "All values except a percentage at either end"),
    ("fixed", "Fixed", "From minimum to maximum, the same on every mesh"),
]
# The first click bakes both masks: any mesh shows at least one of them, and worn materials need both.
DEFAULT_DESCRIPTORS = {"cavity", "convexity"}
HIGHEST_BIT = 30  # the highest bit of positive numbers that Blender keeps
NO_DESCRIPTOR = ("missing", "None", "The native library is missing", 1)


def descriptor_items() -> list[tuple[str, str, str, int]]:
    """Menu items (name, label, description, bit) of the native registry.

    Files keep the bits. Those of operators on maps count down from the highest, so that a new row in either table of
    the registry moves none.
    """
    if bridge.missing_sentence():
        return [NO_DESCRIPTOR]
    rising, falling = iter(range(HIGHEST_BIT + 1)), iter(range(HIGHEST_BIT, -1, -1))
    return [
        (row.name, row.label, with_unit(row), 1 << next(falling if row.map_degree else rising))
        for row in bridge.descriptors()
    ]


def map_items() -> list[tuple[str, str, str]]:
    """Menu items of the descriptors that can be an operator's map: descriptors of the surface with one component."""
    if bridge.missing_sentence():
        return [NO_DESCRIPTOR[:3]]
    rows = [row for row in bridge.descriptors() if row.components == 1 and row.map_degree == 0]
    return [(row.name, row.label, with_unit(row)) for row in rows]


def with_unit(row: bridge.Descriptor) -> str:
    """A descriptor's description, with its unit if it has one."""
    return row.description + (f" [{row.unit}]" if row.unit else "")


def descriptor_members() -> dict[str, Member]:
    """The settings for the choice of descriptors."""
    items, maps, found = descriptor_items(), map_items(), options("analysis")
    usual = next((item for item in maps if item[0] == bridge.Options.map_descriptor), maps[0])
    found["map_descriptor"].words.update(items=maps, default=usual[0])
    return {
        **found,
        "descriptors": member(
            "choices", name="Descriptors",
            description="Descriptors to compute; several cost little more than one",
            items=items,
            default=DEFAULT_DESCRIPTORS & {item[0] for item in items} or {items[0][0]},
        ),
        "corner_threshold": member(
            "float", name="Corners",
            description="The Harris response that makes a corner, in percent of the largest one of the mesh",
            default=100 * THRESHOLD, min=0.01, max=100.0, precision=1, subtype="PERCENTAGE",
        ),
    }  # fmt: skip


def neighborhood_members() -> dict[str, Member]:
    """The settings for the size of the neighborhood, and its space."""
    return {
        "radius_percent": member(
            "float", name="Radius",
            description="Radius of the neighborhood that is measured, in percent of the diagonal of the mesh's "
            "bounding box",
            default=2.0, min=0.01, soft_max=20.0, max=100.0, precision=2, subtype="PERCENTAGE",
        ),
        "radius_absolute": member(
            "float", name="Radius",
            description="Radius of the neighborhood that is measured, as a length in object space, or in world space "
            "if World is measured",
            default=0.1, min=1e-6, precision=4, unit="LENGTH",
        ),
        "radius_edges": member(
            "float", name="Radius",
            description="Radius of the neighborhood that is measured, in multiples of the mesh's mean edge length",
            default=4.0, min=0.01, soft_max=50.0, precision=2,
        ),
        **options("neighborhood"),
        "radius_fit": member(
            "choice", name="Radius from Mesh",
            description="Fit the radius to the mesh and the mask at each bake; a typed radius is kept",
            items=FITS, default="medium",
        ),
        "more_radii": member(
            "text", name="More Radii",
            description="Further radii in the same unit, separated by commas, computed at once; the name of every "
            "result then ends in _r and its radius",
        ),
        "space": member(
            "choice", name="Space", description="Measure in object or in world space", items=SPACES, default="object"
        ),
        "shape_key": member(
            "choice", name="Shape",
            description="Measured shape of a mesh with shape keys", items=SHAPES, default="basis"
        ),
    }  # fmt: skip


def quality_members() -> dict[str, Member]:
    """The settings for accuracy, source and device."""
    return {
        **options("quality"),
        "material_maps": member(
            "bool", name="Material Maps",
            description="Measure the surface as the material's Displacement and Normal Map nodes change it",
            default=False,
        ),
        "backend": member("choice", name="Backend", description="Kind of device that computes", items=BACKENDS, default="auto"),
        "device_index": member(
            "int", name="Device",
            description="Number of the device among those of the backend, from 0; -1 takes the first that works",
            default=-1, min=-1,
        ),
    }  # fmt: skip


def method_members() -> dict[str, Member]:
    """The settings for the method, which researchers compare; the defaults are the most exact."""
    return options("method")


def output_members() -> dict[str, Member]:
    """The settings for outputs."""
    return {
        **options("output"),
        "image_outside": member(
            "choice", name="Outside",
            description="Content of textures outside the surface", items=OUTSIDE, default="neutral"
        ),
        "image_packed": member(
            "bool", name="Pack Channels",
            description="Bake one texture of three masks instead of the chosen ones: cavity in red, edge wear in green, "
            "openness in blue",
            default=False,
        ),
        "image_to_material": member(
            "bool", name="Add to Material",
            description="Add the textures to the object's active material as image nodes, ready to be connected",
            default=False,
        ),
        "cage": member(
            "float", name="Cage",
            description="Distance from a low-poly mesh within which the detailed one is searched, along the normals "
            "to both sides; 0 is a tenth of its diagonal",
            default=0.0, min=0.0, precision=4, subtype="DISTANCE",
        ),
        **kept_members(),
    }  # fmt: skip


def kept_members() -> dict[str, Member]:
    """Settings of earlier versions, which files and scripts may set. None has an effect."""
    hidden = {"description": "Has no effect; Bake to Image and the command line write files", "options": {"HIDDEN"}}
    return {
        "write_attributes": member("bool", name="Attributes", default=True, **hidden),
        "write_image": member("bool", name="Image over UV Map", default=False, **hidden),
        "image_format": member("choice", name="Format", items=IMAGE_FORMATS, default=".exr", **hidden),
        "image_path": member("text", name="Image", default="//paradesc.exr", subtype="FILE_PATH", **hidden),
        "write_buffers": member("bool", name="Baked Buffers", default=False, **hidden),
        "buffers_path": member("text", name="Folder", default="//paradesc_buffers", subtype="DIR_PATH", **hidden),
    }


def color_members() -> dict[str, Member]:
    """The settings for colors."""
    return {
        "color_map": member(
            "choice", name="Color Map", description="Colors for the values", items=COLOR_MAPS, default=AUTOMATIC
        ),
        "span": member(
            "choice", name="Range", description="The values at the ends of the color map", items=SPANS, default="auto"
        ),
        "percentile": member(
            "float", name="Left Out",
            description="Percentage of the values that is left outside the range at either end",
            default=CLIPPED_PERCENT, min=0.0, max=49.0, precision=1, subtype="PERCENTAGE",
        ),
        "symmetric": member(
            "bool", name="Symmetric",
            description="For values with a sign, use the same range on both sides of the neutral value",
            default=True,
        ),
        "minimum": member(
            "float", name="Minimum",
            description="The value at the lower end, in the descriptor's unit",
            default=-1.0, precision=4,
        ),
        "maximum": member(
            "float", name="Maximum",
            description="The value at the upper end, in the descriptor's unit",
            default=1.0, precision=4,
        ),
        "contrast": member(
            "float", name="Contrast", description="Steepen the mask about its middle; no bake is needed",
            default=0.0, min=-1.0, max=1.0, precision=2, subtype="FACTOR",
        ),
        "brightness": member(
            "float", name="Brightness", description="Raise or lower the middle of the mask; black and white stay",
            default=0.0, min=-1.0, max=1.0, precision=2, subtype="FACTOR",
        ),
        "invert": member(
            "bool", name="Invert", description="Swap black and white", default=False
        ),
        "same_scale": member(
            "bool", name="Same Scale",
            description="Meshes that are selected together share one range, so that equal shades are equal values",
            default=False,
        ),
        "use_neutral": member(
            "bool", name="Own Neutral Value",
            description="Choose the value in the middle of diverging color maps, in place of the descriptor's own",
            default=False,
        ),
        "neutral": member(
            "float", name="Neutral",
            description="The value in the middle of diverging color maps",
            default=0.0, precision=4,
        ),
    }  # fmt: skip


# Each of these becomes a sub-panel. The first four make a preset, without device and folders.
GROUPS = (descriptor_members, neighborhood_members, quality_members, method_members, output_members)
