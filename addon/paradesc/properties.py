"""The settings kept in a scene; the descriptors to choose from come from the native registry."""

import bpy

from . import bridge
from .job import Settings

RADIUS_UNITS = [
    ("diagonal", "% of diagonal", "Percent of the diagonal of the mesh's bounding box"),
    ("absolute", "Units", "Units of the mesh's own coordinates, before the object's scale"),
    ("mean-edge", "× mean edge", "Multiples of the mean edge length"),
]
NORMALS = [
    ("fitted", "Fitted", "Fit the surface around each vertex; best wherever the surface is smooth"),
    ("max", "Max's weights", "Average the faces around each vertex by Max's weights"),
    ("mesh", "Of the mesh", "Take the object's own normals, custom ones included"),
]
RELOCATIONS = [
    ("connected", "Connected", "Take what is connected to the vertex in the buffers; exact over any seams"),
    ("affine", "Affine", "Carry every sample over seams by itself, by the map of the seam edge"),
    ("paper", "Paper", "Sample again on every chart that samples fell on, as the paper does"),
]
ESTIMATORS = [
    ("shape-operator", "Shape operator", "Curvatures of the surface fitted to the neighborhood; exact at every radius"),
    ("integral", "Integral", "The paper's: mean curvature from volume, Gaussian from geodesic area; for large radii"),
    ("extrapolated", "Extrapolated", "The integral, mean curvature extrapolated to r = 0; for radii above 12 edges"),
]
VARIANCE_REDUCTIONS = [
    ("shape", "Shape operator", "Integrate only what the shape operator does not explain: far less noise"),
    ("none", "None", "Plain sums over samples"),
]
GEODESICS = [
    ("local", "Local", "Distance along the surface by the normal curvature between two points"),
    ("chords", "Chords", "Sum of chords along the straight way in the UV map; not with connected neighborhoods"),
]
DISTANCES = [
    ("euclidean", "Straight", "Everything within the ball that is connected to the vertex"),
    ("geodesic", "Along the surface", "Everything within the radius along the surface"),
]
PATTERNS = [
    ("golden-angle", "Golden angle", "A spiral; the most even"),
    ("stratified", "Stratified", "One random place in each square of a grid, as the paper has it"),
]
ELLIPSES = [
    ("center", "At the vertex", "Stretch the pattern by the distortion at the vertex"),
    ("directional", "By direction", "Stretch the pattern by the largest distortion in each direction"),
]
EVALUATIONS = [
    ("vertex", "Vertices", "Evaluate at the vertices themselves"),
    ("texel", "Texels", "Evaluate at the texels of a map and look the vertices up in it, as the paper does"),
]
PRECISIONS = [
    ("full", "Full", "32-bit buffers"),
    ("half", "Half", "16-bit buffers: half the memory"),
]
BACKENDS = [
    ("auto", "Automatic", "A graphics card, else the software rasterizer, else the reference"),
    ("gpu", "Graphics card", "A hardware device with OpenGL 4.5"),
    ("software", "Software", "A software rasterizer on the CPU"),
    ("reference", "Reference", "Exact quadrature in object space on the CPU; slow, needs no UV map"),
]
DEFAULT_DESCRIPTOR = "mean_curvature"
NO_DESCRIPTOR = ("missing", "None", "The native library is missing", 1)


def descriptor_items() -> list[tuple[str, str, str, int]]:
    """Menu items (name, label, description, bit) of the native registry."""
    if bridge.missing_sentence():
        return [NO_DESCRIPTOR]
    return [
        (row.name, row.label, row.description + (f" [{row.unit}]" if row.unit else ""), 1 << index)
        for index, row in enumerate(bridge.descriptors())
    ]


def make_settings() -> type:
    """The class of the settings, with the registry as it is now."""
    items = descriptor_items()
    default = DEFAULT_DESCRIPTOR if any(item[0] == DEFAULT_DESCRIPTOR for item in items) else items[0][0]
    annotations = {
        "descriptors": bpy.props.EnumProperty(
            name="Descriptors",
            description="What to compute; hold Shift to choose several, which costs little more than one",
            items=items,
            options={"ENUM_FLAG"},
            default={default},
        ),
        "radius_percent": bpy.props.FloatProperty(
            name="Radius", description="Support radius", default=2.0, min=0.01, soft_max=20.0, max=100.0, precision=2
        ),
        "radius_absolute": bpy.props.FloatProperty(
            name="Radius", description="Support radius", default=0.1, min=1e-6, precision=4, unit="LENGTH"
        ),
        "radius_edges": bpy.props.FloatProperty(
            name="Radius", description="Support radius", default=4.0, min=0.01, soft_max=50.0, precision=2
        ),
        "radius_unit": bpy.props.EnumProperty(
            name="Unit", description="What the radius is measured in", items=RADIUS_UNITS, default="diagonal"
        ),
        "samples": bpy.props.IntProperty(
            name="Samples", description="Surface samples around every vertex", default=256, min=8, max=4096
        ),
        "buffer_size": bpy.props.IntProperty(
            name="Buffer size", description="Texels along a side of the baked buffers", default=1024, min=64, max=8192
        ),
        "normals": bpy.props.EnumProperty(
            name="Normals", description="Where the vertex normals come from", items=NORMALS, default="fitted"
        ),
        "relocation": bpy.props.EnumProperty(
            name="Over seams", description="How neighborhoods go on over seams", items=RELOCATIONS, default="connected"
        ),
        "estimator": bpy.props.EnumProperty(
            name="Curvatures", description="How curvatures are computed", items=ESTIMATORS, default="shape-operator"
        ),
        "variance_reduction": bpy.props.EnumProperty(
            name="Control", description="What integrals are helped by", items=VARIANCE_REDUCTIONS, default="shape"
        ),
        "distance": bpy.props.EnumProperty(
            name="Distance", description="What the radius bounds", items=DISTANCES, default="euclidean"
        ),
        "geodesic": bpy.props.EnumProperty(
            name="Along surface",
            description="How distance along the surface is measured",
            items=GEODESICS,
            default="local",
        ),
        "pattern": bpy.props.EnumProperty(
            name="Pattern", description="Places of the samples", items=PATTERNS, default="golden-angle"
        ),
        "ellipse": bpy.props.EnumProperty(
            name="Stretch", description="How the pattern follows the distortion", items=ELLIPSES, default="center"
        ),
        "adaptive": bpy.props.FloatProperty(
            name="Adaptive",
            description="Take half of the samples where normals fit the shape operator to within this angle; 0: all",
            default=0.0,
            min=0.0,
            soft_max=0.2,
            precision=3,
            subtype="ANGLE",
        ),
        "evaluate": bpy.props.EnumProperty(
            name="Evaluate at", description="Where descriptors are computed", items=EVALUATIONS, default="vertex"
        ),
        "texels": bpy.props.IntProperty(
            name="Texels", description="Along a side of the map of texels", default=512, min=16, max=8192
        ),
        "precision": bpy.props.EnumProperty(
            name="Precision", description="Of the baked buffers", items=PRECISIONS, default="full"
        ),
        "max_jumps": bpy.props.IntProperty(
            name="Max jumps", description="Seams that one sample may cross", default=8, min=0, max=64
        ),
        "material_maps": bpy.props.BoolProperty(
            name="Material maps",
            description="Measure the surface as the material's Displacement and Normal Map nodes change it",
            default=False,
        ),
        "backend": bpy.props.EnumProperty(name="Backend", description="What computes", items=BACKENDS, default="auto"),
        "device_index": bpy.props.IntProperty(
            name="Device", description="Which device of the backend; -1 takes the first that works", default=-1, min=-1
        ),
    }
    body = {"__annotations__": annotations, "__doc__": "Paradesc's settings of one scene.", "__module__": __name__}
    return type("PARADESC_PG_settings", (bpy.types.PropertyGroup,), body)


def radius_member(group: bpy.types.PropertyGroup) -> str:
    """The name of the radius that the chosen unit uses."""
    return {"diagonal": "radius_percent", "absolute": "radius_absolute"}.get(group.radius_unit, "radius_edges")


def job_settings(group: bpy.types.PropertyGroup) -> Settings:
    """A scene's settings as the computation takes them, descriptors in the registry's order."""
    radius = getattr(group, radius_member(group))
    chosen = group.descriptors
    return Settings(
        descriptors=tuple(row.name for row in bridge.descriptors() if row.name in chosen),
        options=bridge.Options(
            radius=radius / 100 if group.radius_unit == "diagonal" else radius,
            samples=group.samples,
            buffer_size=group.buffer_size,
            max_jumps=group.max_jumps,
            texels=group.texels,
            adaptive=group.adaptive,
            **{name: getattr(group, name) for name in bridge.CHOICES},
        ),
        backend=group.backend,
        device_index=group.device_index,
    )


# The settings' class is made by register(), when the native library has been laid in place.
classes = ()


def register() -> None:
    """Gives every scene its settings."""
    settings = make_settings()
    bpy.utils.register_class(settings)
    bpy.types.Scene.paradesc = bpy.props.PointerProperty(type=settings)


def unregister() -> None:
    """Takes them away."""
    del bpy.types.Scene.paradesc
    bpy.utils.unregister_class(bpy.types.PropertyGroup.bl_rna_get_subclass_py("PARADESC_PG_settings"))
