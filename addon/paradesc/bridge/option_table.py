"""The options of a computation, a row each, as plain data.

The C options (abi.py, options.py), the panel's settings and presets (core/members.py), the options of the command line
(commands/options.py) and what compute() checks (numpy_api/options.py) are made of these rows.
"""

from dataclasses import dataclass, field


@dataclass(frozen=True)
class Row:
    """One option."""

    place: int  # among the members of pdesc_options
    name: str
    panel: str  # analysis, neighborhood, quality, method (which is research as a whole) or output
    default: object  # of the library; its type is the option's
    what: str  # in sentences
    label: str  # in the panel
    about: str  # the tooltip
    help: str  # on the command line
    choices: tuple[tuple[str, str, str], ...] = ()  # name, label and tooltip of each, in C's order
    limits: dict[str, object] = field(default_factory=dict)  # and more for Blender's property
    words: dict[str, object] = field(default_factory=dict)  # for argparse
    flag: str = ""  # on the command line, if it is not the name
    usual: object = None  # the panel's default, if it is not the library's
    research: bool = False  # few people need it; those of the method anyway
    unsigned: bool = False  # in C

    @property
    def kind(self) -> str:
        """The kind of the panel's setting."""
        return "choice" if self.choices or isinstance(self.default, str) else type(self.default).__name__


COUNT = {"metavar": "N"}

TABLE = (
    Row(
        19, "map_descriptor", "analysis", "sphere_volume_normalized", "map descriptor", "Map Descriptor",
        "The descriptor whose values over the surface the operators work on",
        "descriptor that operators (harris, laplacian, ...) are applied to (default: sphere_volume_normalized)",
        words={"metavar": "A"},
    ),
    Row(
        20, "map_sigma", "analysis", 1.0, "sigma", "Sigma",
        "Standard deviation of the operators' Gaussian windows, in multiples of the radius",
        "standard deviation of the windows of harris and difference_of_gaussians, times the radius (default: 1)",
        limits={"min": 0.1, "soft_max": 2.0, "max": 4.0, "precision": 2}, words={"metavar": "S"}, research=True,
    ),
    Row(
        21, "harris_k", "analysis", 0.04, "Harris k", "Harris k",
        "The k of det A - k tr\u00b2 A, without unit; more suppresses edges, 0.04 to 0.06 are usual",
        "k of harris (default: 0.04)",
        limits={"min": 0.0, "max": 0.249, "precision": 3, "step": 1}, words={"metavar": "K"}, research=True,
    ),
    Row(
        1, "radius_unit", "neighborhood", "diagonal", "radius unit", "Unit", "Unit of the radius",
        "unit of the radius: diagonal of the bounding box (default), units of the mesh, or mean edge length",
        choices=(
            ("diagonal", "% of Diagonal", "Percent of the diagonal of the mesh's bounding box"),
            (
                "absolute",
                "Length",
                "A length in object space, or in world space if World is measured",
            ),
            ("mean-edge", "× Mean Edge", "Multiples of the mean edge length"),
        ),
    ),
    Row(
        2, "samples", "quality", 256, "number of samples", "Samples",
        "Least number of surface samples around every vertex; more are more exact and slower",
        "samples around a vertex (default: 256)",
        limits={"min": 8, "soft_max": 1024, "max": 4096}, words=COUNT,
    ),
    Row(
        18, "adaptive", "quality", 0.0, "threshold", "Adaptive",
        "Halve the samples where the error of the fit is below this angle; 0 is never",
        "halve the samples where the error of the fit is below this angle, in radians",
        limits={"min": 0.0, "soft_max": 0.2, "precision": 3, "subtype": "ANGLE"},
        words={"metavar": "THRESHOLD", "nargs": "?", "const": 0.05}, research=True,
    ),
    Row(
        17, "precision", "quality", "full", "precision", "Precision", "Number format on the graphics card",
        "numbers in the buffers (default: full)",
        choices=(
            ("full", "Full", "32-bit numbers"),
            ("half", "Half", "16-bit numbers, which take half the memory"),
        ),
        research=True,
    ),
    Row(
        4, "normals", "quality", "fitted", "kind of normals", "Normals", "Source of the vertex normals",
        "vertex normals (default: fitted)",
        choices=(
            ("fitted", "Fitted", "Fit the surface around each vertex; best wherever the surface is smooth"),
            ("max", "Max's Weights", "Average the faces around each vertex by Max's weights"),
            ("mesh", "Mesh Normals", "Use the object's own normals, including custom ones"),
        ),
        research=True,
    ),
    Row(
        23, "creases", "quality", "auto", "choice of creases", "Creases", "Edges that count as hard creases",
        "hard edges: marked and found by their angle (default), marked ones alone, or none",
        choices=(
            ("auto", "Automatic", "Edges marked sharp, and edges that bend far more than their surroundings"),
            ("marked", "Marked Sharp", "Only edges that are marked sharp"),
            ("none", "None", "Treat every edge as smooth"),
        ),
    ),
    Row(
        3, "buffer_size", "quality", 1024, "buffer size", "Resolution",
        "Texels along a side of the buffers of a graphics card; the radius should span at least four. "
        "It is ignored on the processor",
        "side of the buffers (default: 1024)",
        limits={"min": 64, "max": 8192, "subtype": "PIXEL"}, words=COUNT, flag="buffer",
    ),
    Row(
        9, "estimator", "method", "shape-operator", "estimator", "Curvatures", "Estimator of curvatures",
        "curvatures by the fitted shape operator (default), that extrapolated to radius 0, or the paper's integrals",
        choices=(
            ("shape-operator", "Fitted", "Curvatures of the surface fitted to the neighborhood; exact at every radius"),
            (
                "integral",
                "Integral",
                "Integrals of the paper: mean curvature from volume, Gaussian from geodesic area; for large radii",
            ),
            (
                "extrapolated",
                "Extrapolated",
                "Like Fitted, without most of the blur; for large radii and noise",
            ),
        ),
    ),
    Row(
        10, "variance_reduction", "method", "shape", "variance reduction", "Control",
        "Variance reduction for the integrals",
        "integrals with the shape operator as control variate (default), or plain sums",
        choices=(
            ("shape", "Fitted", "Integrate only the residual of the shape operator, with far less noise"),
            ("none", "None", "Plain sums over samples"),
        ),
    ),
    Row(
        12, "distance", "method", "euclidean", "distance", "Distance", "Metric of the radius",
        "measure the radius straight (default) or along the surface",
        choices=(
            ("euclidean", "Straight", "The surface within the ball that is connected to the vertex"),
            ("geodesic", "Along the Surface", "The surface within the radius along the surface"),
        ),
    ),
    Row(
        15, "evaluate", "method", "vertex", "place of evaluation", "Evaluate At",
        "Places where descriptors are computed",
        "evaluate at vertices (default), or at texels of a map in which vertices are looked up",
        choices=(
            ("vertex", "Vertices", "Evaluate at the vertices themselves"),
            ("texel", "Texels", "Evaluate at the texels of a map and look the vertices up in it, as the paper does"),
        ),
    ),
    Row(
        8, "relocation", "method", "connected", "relocation", "Over Seams",
        "Continuation of neighborhoods across seams",
        "neighborhoods across seams: the connected part (default), each sample by affine maps, or as in the paper",
        choices=(
            ("connected", "Connected", "The part that is connected to the vertex; in texture space the same as Affine"),
            ("affine", "Affine", "Carry every sample across seams by the map of the seam edge"),
            ("paper", "Paper", "Sample again on every chart that samples reach, as the paper does"),
        ),
    ),
    Row(
        5, "max_jumps", "method", 8, "number of jumps", "Max Jumps", "Number of seams that one sample may cross",
        "with affine and paper, seams that a sample may cross (default: 8)", limits={"min": 0, "max": 64}, words=COUNT,
    ),
    Row(
        13, "pattern", "method", "golden-angle", "pattern", "Pattern", "Places of the samples",
        "with affine and paper, places of the samples",
        choices=(
            ("golden-angle", "Golden Angle", "A spiral; the most even"),
            ("stratified", "Stratified", "One random place in each square of a grid, as in the paper"),
        ),
    ),
    Row(
        14, "ellipse", "method", "center", "ellipse", "Stretch", "Stretching of the pattern by the UV map's distortion",
        "with affine and paper, extent by the distortion at the center, or by the largest on the way",
        choices=(
            ("center", "At the Vertex", "Stretch the pattern by the distortion at the vertex"),
            ("directional", "By Direction", "Stretch the pattern by the largest distortion in each direction"),
        ),
    ),
    Row(
        11, "geodesic", "method", "local", "geodesic distance", "Geodesic",
        "Formula for the distance along the surface",
        "along the surface by a local formula (default), or by chords (affine, paper)",
        choices=(
            ("local", "Local", "Distance along the surface by the normal curvature between two points"),
            (
                "chords",
                "Chords",
                "Sum of chords along the straight line in the UV map; not for connected neighborhoods",
            ),
        ),
    ),
    Row(
        6, "seed", "method", 0, "seed", "Seed",
        "Random seed of the places of samples; the same settings give the same values",
        "random seed of the sampling pattern (default: 0)", limits={"min": 0}, words=COUNT, unsigned=True,
    ),
    Row(
        16, "texels", "output", 512, "number of texels", "Texels",
        "Pixels along a side of textures, and of the map that Evaluate At: Texels computes",
        "side of the map of texels (default: 512)",
        limits={"min": 16, "max": 8192, "subtype": "PIXEL"}, words=COUNT, usual=1024,
    ),
)  # fmt: skip
