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


def member(kind: str, **words: object) -> Member:
    """A setting of this kind; words: name, description, default, and further options of its kind."""
    return Member(kind, words)


RADIUS_UNITS = [
    ("diagonal", "% of Diagonal", "Percent of the diagonal of the mesh's bounding box"),
    ("absolute", "Length", "A length of the mesh before the object's scale, or of the scene where World is measured"),
    ("mean-edge", "× Mean Edge", "Multiples of the mean edge length"),
]
FITS = [
    ("fine", "Fine", "The smallest detail that the mesh has"),
    ("medium", "Medium", "What suits most masks: one and a half edges, or 0.5 % of a dense mesh"),
    ("broad", "Broad", "Large forms"),
    ("typed", "Typed", "The radius as it was typed"),
]
SPACES = [
    ("object", "Object", "The mesh as it is stored, before the object's scale"),
    (
        "world",
        "World",
        "The mesh as it stands in the scene: scaled, also unevenly or mirrored, by the object and parents",
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
    ("neutral", "Neutral", "The value of a flat surface: 0.5 of values with a sign"),
    ("transparent", "Transparent", "An alpha channel that is 0 there"),
]
NORMALS = [
    ("fitted", "Fitted", "Fit the surface around each vertex; best wherever the surface is smooth"),
    ("max", "Max's Weights", "Average the faces around each vertex by Max's weights"),
    ("mesh", "Of the Mesh", "Take the object's own normals, custom ones included"),
]
CREASES = [
    ("auto", "Automatic", "Edges marked sharp, and edges that bend far more than what lies beside them"),
    ("marked", "Marked Sharp", "Only edges that are marked sharp"),
    ("none", "None", "Round every edge as if the surface were smooth"),
]
RELOCATIONS = [
    ("connected", "Connected", "Take what is connected to the vertex; exact over any seams"),
    ("affine", "Affine", "Carry every sample over seams by itself, by the map of the seam edge"),
    ("paper", "Paper", "Sample again on every chart that samples fell on, as the paper does"),
]
ESTIMATORS = [
    ("shape-operator", "Fitted", "Curvatures of the surface fitted to the neighborhood; exact at every radius"),
    ("integral", "Integral", "The paper's: mean curvature from volume, Gaussian from geodesic area; for large radii"),
    ("extrapolated", "Extrapolated", "As fitted, without most of what the radius flattens; for large radii, and noise"),
]
VARIANCE_REDUCTIONS = [
    ("shape", "Fitted", "Integrate only what the shape operator does not explain: far less noise"),
    ("none", "None", "Plain sums over samples"),
]
GEODESICS = [
    ("local", "Local", "Distance along the surface by the normal curvature between two points"),
    ("chords", "Chords", "Sum of chords along the straight way in the UV map; not with connected neighborhoods"),
]
DISTANCES = [
    ("euclidean", "Straight", "Everything within the ball that is connected to the vertex"),
    ("geodesic", "Along the Surface", "Everything within the radius along the surface"),
]
PATTERNS = [
    ("golden-angle", "Golden Angle", "A spiral; the most even"),
    ("stratified", "Stratified", "One random place in each square of a grid, as the paper has it"),
]
ELLIPSES = [
    ("center", "At the Vertex", "Stretch the pattern by the distortion at the vertex"),
    ("directional", "By Direction", "Stretch the pattern by the largest distortion in each direction"),
]
EVALUATIONS = [
    ("vertex", "Vertices", "Evaluate at the vertices themselves"),
    ("texel", "Texels", "Evaluate at the texels of a map and look the vertices up in it, as the paper does"),
]
PRECISIONS = [
    ("full", "Full", "32-bit numbers"),
    ("half", "Half", "16-bit numbers: half the memory of the card"),
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
        "Masks up to nearly their largest value, others over the descriptor's own range where it has one, else from "
        "the 2.5th to the 97.5th percentile",
    ),
    ("percentile", "Percentiles", "All values but a percentage on either side"),
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


def default_of(items: list[tuple], wanted: str) -> str:
    """The wanted item if there is one, else the first."""
    return wanted if any(item[0] == wanted for item in items) else items[0][0]


def descriptor_members() -> dict[str, Member]:
    """The settings for the choice of descriptors."""
    items, maps = descriptor_items(), map_items()
    return {
        "descriptors": member(
            "choices", name="Descriptors",
            description="Descriptors to compute; several cost little more than one",
            items=items,
            default=DEFAULT_DESCRIPTORS & {item[0] for item in items} or {items[0][0]},
        ),
        "map_descriptor": member(
            "choice", name="Map Descriptor",
            description="The descriptor whose values over the surface the operators work on",
            items=maps,
            default=default_of(maps, bridge.Options.map_descriptor),
        ),
        "map_sigma": member(
            "float", name="Sigma",
            description="Standard deviation of the operators' Gaussian windows, in multiples of the radius",
            default=bridge.Options.map_sigma, min=0.1, soft_max=2.0, max=4.0, precision=2,
        ),
        "harris_k": member(
            "float", name="Harris k",
            description="The k of det A - k tr\u00b2 A, without unit; more suppresses edges, 0.04 to 0.06 are usual",
            default=bridge.Options.harris_k, min=0.0, max=0.249, precision=3, step=1,
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
            description="How far a vertex looks around, in percent of the diagonal of the mesh's bounding box",
            default=2.0, min=0.01, soft_max=20.0, max=100.0, precision=2, subtype="PERCENTAGE",
        ),
        "radius_absolute": member(
            "float", name="Radius",
            description="How far a vertex looks around, as a length: of the mesh before the object's scale, or of the "
            "scene where World is measured",
            default=0.1, min=1e-6, precision=4, unit="LENGTH",
        ),
        "radius_edges": member(
            "float", name="Radius",
            description="How far a vertex looks around, in multiples of the mesh's mean edge length",
            default=4.0, min=0.01, soft_max=50.0, precision=2,
        ),
        "radius_unit": member(
            "choice", name="Unit", description="What the radius is measured in", items=RADIUS_UNITS, default="diagonal"
        ),
        "radius_fit": member(
            "choice", name="Radius from Mesh",
            description="Each bake fits the radius to the mesh and the mask; typing a radius keeps that one",
            items=FITS, default="medium",
        ),
        "more_radii": member(
            "text", name="More Radii",
            description="Further radii in the same unit, separated by commas, computed at once; with any, every "
            "result's name ends in _r and its radius",
        ),
        "space": member(
            "choice", name="Space", description="Measure in object or in world space", items=SPACES, default="object"
        ),
        "shape_key": member(
            "choice", name="Shape",
            description="Which shape of a mesh with shape keys is measured", items=SHAPES, default="basis"
        ),
    }  # fmt: skip


def quality_members() -> dict[str, Member]:
    """The settings for accuracy, source and device."""
    return {
        "samples": member(
            "int", name="Samples",
            description="Surface samples around every vertex, at least; more are more exact and slower",
            default=256, min=8, soft_max=1024, max=4096,
        ),
        "adaptive": member(
            "float", name="Adaptive",
            description="Halve the samples where the error of the fit is below this angle; 0 is never",
            default=0.0, min=0.0, soft_max=0.2, precision=3, subtype="ANGLE",
        ),
        "buffer_size": member(
            "int", name="Resolution",
            description="Texels along a side of the buffers of a graphics card; the radius should span at least four. "
            "It is ignored on the processor",
            default=1024, min=64, max=8192, subtype="PIXEL",
        ),
        "precision": member(
            "choice", name="Precision", description="Size of numbers on the card", items=PRECISIONS, default="full"
        ),
        "normals": member(
            "choice", name="Normals", description="Where the vertex normals come from", items=NORMALS, default="fitted"
        ),
        "creases": member(
            "choice", name="Creases",
            description="Which edges count as hard", items=CREASES, default="auto"
        ),
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
    choices = (
        ("estimator", "Curvatures", "How curvatures are computed", ESTIMATORS),
        ("variance_reduction", "Control", "How the noise of integrals is reduced", VARIANCE_REDUCTIONS),
        ("distance", "Distance", "How the radius is measured", DISTANCES),
        ("evaluate", "Evaluate At", "Where descriptors are computed", EVALUATIONS),
        ("relocation", "Over Seams", "How neighborhoods go on over seams", RELOCATIONS),
        ("pattern", "Pattern", "Places of the samples", PATTERNS),
        ("ellipse", "Stretch", "How the pattern follows the distortion", ELLIPSES),
        ("geodesic", "Geodesic", "How distance along the surface is measured", GEODESICS),
    )
    members = {
        name: member("choice", name=label, description=description, items=items, default=items[0][0])
        for name, label, description, items in choices
    }
    members["max_jumps"] = member(
        "int", name="Max Jumps", description="Number of seams that one sample may cross", default=8, min=0, max=64
    )
    members["seed"] = member(
        "int", name="Seed",
        description="Random seed of the places of samples; the same settings give the same values",
        default=0, min=0,
    )  # fmt: skip
    return members


def output_members() -> dict[str, Member]:
    """The settings for outputs."""
    return {
        "write_attributes": member(
            "bool", name="Attributes",
            description="Leave values and colors on the mesh, as attributes of its vertices",
            default=True,
        ),
        "write_image": member(
            "bool", name="Image over UV Map",
            description="Write the values as an image in the mesh's UV map", default=False
        ),
        "image_format": member(
            "choice", name="Format", description="Kind of image file", items=IMAGE_FORMATS, default=".exr"
        ),
        "image_path": member(
            "text", name="Image",
            description="Where the image goes; the suffix follows the format, and of several meshes the name of each "
            "is added",
            default="//paradesc.exr", subtype="FILE_PATH",
        ),
        "texels": member(
            "int", name="Texels",
            description="Pixels along a side of textures, and of the map that Evaluate At: Texels computes",
            default=1024, min=16, max=8192, subtype="PIXEL",
        ),
        "image_outside": member(
            "choice", name="Outside",
            description="What textures show where there is no surface", items=OUTSIDE, default="neutral"
        ),
        "image_packed": member(
            "bool", name="Pack Channels",
            description="Bake one texture of three masks instead of the chosen ones: cavity in red, edge wear in green, "
            "openness in blue",
            default=False,
        ),
        "image_to_material": member(
            "bool", name="Add to Material",
            description="Put the textures into the object's active material as image nodes, ready to be connected",
            default=False,
        ),
        "cage": member(
            "float", name="Cage",
            description="How far from a low-poly mesh the detailed one is looked for, along the normals to both sides; "
            "0: a tenth of its diagonal",
            default=0.0, min=0.0, precision=4, subtype="DISTANCE",
        ),
        "write_buffers": member(
            "bool", name="Baked Buffers",
            description="Write positions, normals, charts, seams and distortion as pictures and raw values",
            default=False,
        ),
        "buffers_path": member(
            "text", name="Folder",
            description="Where the buffers go; of several meshes, the name of each is added",
            default="//paradesc_buffers", subtype="DIR_PATH",
        ),
    }  # fmt: skip


def color_members() -> dict[str, Member]:
    """The settings for colors."""
    return {
        "color_map": member(
            "choice", name="Color Map", description="The colors that values get", items=COLOR_MAPS, default=AUTOMATIC
        ),
        "span": member(
            "choice", name="Range", description="The values at the ends of the color map", items=SPANS, default="auto"
        ),
        "percentile": member(
            "float", name="Left Out",
            description="Share of the values left outside the range on either side",
            default=CLIPPED_PERCENT, min=0.0, max=49.0, precision=1, subtype="PERCENTAGE",
        ),
        "symmetric": member(
            "bool", name="Symmetric",
            description="Of values with a sign: the same range on both sides of the neutral value",
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
            "float", name="Contrast", description="Steepens the mask about its middle; no bake is needed",
            default=0.0, min=-1.0, max=1.0, precision=2, subtype="FACTOR",
        ),
        "brightness": member(
            "float", name="Brightness", description="Lifts or lowers the middle of the mask; black and white stay",
            default=0.0, min=-1.0, max=1.0, precision=2, subtype="FACTOR",
        ),
        "invert": member(
            "bool", name="Invert", description="Exchange black and white", default=False
        ),
        "same_scale": member(
            "bool", name="Same Scale",
            description="Meshes that are selected together share one range, so that equal shades are equal values",
            default=False,
        ),
        "use_neutral": member(
            "bool", name="Own Neutral Value",
            description="Choose the value in the middle of maps with two sides, instead of the descriptor's own",
            default=False,
        ),
        "neutral": member(
            "float", name="Neutral",
            description="The value in the middle of maps with two sides",
            default=0.0, precision=4,
        ),
    }  # fmt: skip


# Each of these becomes a sub-panel. The first four make a preset, without device and folders.
GROUPS = (descriptor_members, neighborhood_members, quality_members, method_members, output_members)
