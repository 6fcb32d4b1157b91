"""Estimates how long a computation takes, so that farms can share work out evenly. Never imports bpy.

Seconds are those of one core of an AMD EPYC with the backend cpu; other machines differ by a factor that is the same
for all tasks. The coefficients follow from tests/bench/REPORT.md of 2026-11-24 (its columns "all cores ms", meshes
detail_1m and together) and from rows of paradesc library; tests/farms.sh prints estimates beside measured seconds.
"""

from .. import bridge
from .job import Settings

# Seconds of a core per million triangles.
PREPROCESSING = 1.0  # adjacency, once a mesh
PREPARING = 0.24  # normals and order of the samples, once a frame
EVALUATING = 1.0  # one descriptor at one radius, however few the samples; the radius itself changes next to nothing
EVALUATING_SAMPLE = 0.0016  # for each sample more
READING = 3.0  # an .obj; others are faster
# The cost of each further descriptor, as a share of the first one's evaluation.
MORE_DESCRIPTORS = 0.15
OPERATORS = 1.7  # operators on a map: two passes over the surface
# Seconds.
STARTING = 0.4  # Python, numpy and the library
STARTING_BLENDER = 1.0  # with Blender's module and a small scene
KEPT = 0.001  # finding that a small asset is there already
ASSET = 0.006  # reading, describing and writing the smallest asset


def evaluation(settings: Settings) -> float:
    """Seconds of a core per million triangles that evaluating takes, once preprocessing is done."""
    rows = {row.name: row for row in bridge.descriptors()}
    operators = sum(rows[name].map_degree > 0 for name in settings.descriptors)
    others = len(settings.descriptors) - operators
    share = 1 + MORE_DESCRIPTORS * max(0, others - 1) + OPERATORS * operators
    one = EVALUATING + EVALUATING_SAMPLE * settings.options.samples
    return PREPARING + one * share * (1 + len(settings.more_radii))


def of_asset(triangles: int, settings: Settings) -> float:
    """Seconds of a core for one asset, without the start of a process."""
    return ASSET + triangles / 1e6 * (READING + PREPROCESSING + evaluation(settings))


def of_frames(triangles: int, frames: int, settings: Settings) -> float:
    """Seconds of a core for frames of one animation in one process, which Blender's own evaluation adds to."""
    return STARTING_BLENDER + triangles / 1e6 * (PREPROCESSING + frames * evaluation(settings))
