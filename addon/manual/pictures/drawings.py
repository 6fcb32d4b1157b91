"""Pictures that the command line draws, or numpy alone: descriptors, color maps."""

from pathlib import Path

import bpy
import lettering
import numpy as np
import picture
import studio
import subjects
from PIL import Image

from paradesc.bridge import descriptors as registry
from paradesc.core import color_maps
from paradesc.files import png

# Lines along a direction, in lengths of the monkey.
LINE_LENGTH, LINE_WIDTH, LINE_LIFT, LINE_DISTANCE = 0.07, 0.012, 0.006, 0.05
MASKS = {"cavity", "convexity"}  # shown in grey, as they are used
SURFACE, INK = (0.86, 0.86, 0.84), (0.10, 0.22, 0.50)


def draw_descriptors(folder: str) -> None:
    """One picture of each descriptor of the registry, with its legend."""
    for row in registry():
        if row.components > 1:
            image = lines_along(row.name)
        elif row.name == "harris":
            box = subjects.rounded_box()
            image = subjects.drawn(box, "--descriptors", row.name, "--radius", "0.08")
        elif row.name == "standard_error":
            image = subjects.drawn(noisy(subjects.monkey()), "--descriptors", row.name, "--radius", "0.04")
        else:
            words = ["--descriptors", row.name, "--radius", str(subjects.RADIUS_PERCENT / 100)]
            words += ["--color-map", "grey"] if row.name in MASKS else []
            image = subjects.drawn(subjects.monkey(), *words)
        png.write_png(Path(folder) / f"{row.name}.png", subjects.trimmed(image))


def noisy(made: bpy.types.Object, everywhere: bool = False) -> bpy.types.Object:
    """The object, its vertices moved at random by a tenth of a mean edge, or by nothing at its left and more to its right."""
    positions = np.array([vertex.co for vertex in made.data.vertices])
    ends = positions[np.array([edge.vertices[:] for edge in made.data.edges])]
    length = np.linalg.norm(ends[:, 0] - ends[:, 1], axis=1).mean()
    across = np.ones(len(positions)) if everywhere else (positions[:, 0] - positions[:, 0].min()) / np.ptp(positions[:, 0])
    moves = 0.1 * length * across[:, None] * np.random.default_rng(0).normal(size=positions.shape)
    made.data.vertices.foreach_set("co", (positions + moves).ravel())
    return made


def lines_along(name: str) -> np.ndarray:
    """The monkey with short lines along a direction, at vertices that lie apart."""
    bpy.context.scene.paradesc.radius_percent = subjects.RADIUS_PERCENT
    made = subjects.baked(subjects.monkey(), name)
    mesh, matrix = made.data, np.array(made.matrix_world)
    points = np.array([vertex.co for vertex in mesh.vertices]) @ matrix[:3, :3].T + matrix[:3, 3]
    normals = np.array([vertex.normal for vertex in mesh.vertices]) @ matrix[:3, :3].T
    mesh.calc_loop_triangles()
    triangles = np.array([list(triangle.vertices) for triangle in mesh.loop_triangles])
    along = np.array([item.vector for item in mesh.attributes[name].data]) @ matrix[:3, :3].T
    chosen = spread_out(points, along)
    middle, along, normal = points[chosen] + LINE_LIFT * normals[chosen], along[chosen], normals[chosen]
    reach, side = LINE_LENGTH / 2 * along, LINE_WIDTH / 2 * np.cross(normal, along)
    corners = np.stack([middle - reach - side, middle + reach - side, middle + reach + side, middle - reach + side])
    first = len(points) + 4 * np.arange(len(chosen))[:, None]
    quads = np.concatenate([first + np.array([0, 1, 2]), first + np.array([0, 2, 3])])
    every = np.concatenate([points, corners.transpose(1, 0, 2).reshape(-1, 3)])
    colors = np.concatenate([np.tile(SURFACE, (len(points), 1)), np.tile(INK, (4 * len(chosen), 1))])
    drawn = picture.Drawing(every, np.concatenate([triangles, quads]), picture.PANEL)
    return drawn.paint(colors)[::2, ::2]


def spread_out(points: np.ndarray, along: np.ndarray) -> np.ndarray:
    """Numbers of points that have a direction and lie apart, chosen one after the other in a fixed random order."""
    chosen: list[int] = []
    for index in np.random.default_rng(0).permutation(np.flatnonzero(np.isfinite(along).all(axis=1))):
        near = points[chosen] - points[index]
        if not chosen or (near**2).sum(axis=1).min() > LINE_DISTANCE**2:
            chosen.append(int(index))
    return np.array(chosen)


def draw_maps(path: str) -> None:
    """Every color map as a bar with its name."""
    width, height, left = 420, 18, 150
    image = np.full((len(color_maps.MAPS) * (height + 4), left + width, 3), 237, np.uint8)
    for index, row in enumerate(color_maps.MAPS.values()):
        top = index * (height + 4) + 2
        colors = np.round(255 * row.function(np.linspace(0, 1, width))).astype(np.uint8)
        image[top : top + height, left:] = colors
        lettering.draw_text(image, row.name, 6, top + 5, 1, (60, 60, 60))
    png.write_png(Path(path), image)


def draw_scans(path: str) -> None:
    """A sphere of voxels and a noisy monkey, colored by mean curvature at three radii."""
    rows = []
    for make, limit in ((sphere_of_voxels, 2.0), (lambda: noisy(subjects.monkey(), everywhere=True), 4.0)):
        words = ["--descriptors", "mean_curvature", f"--range={-limit:g}:{limit:g}"]
        shots = [subjects.drawn(make(), *words, "--radius", radius) for radius in ("0.02", "0.06", "0.12")]
        rows.append(np.concatenate(shots, axis=1))
    studio.save(Image.fromarray(np.concatenate(rows, axis=0)), path)


def sphere_of_voxels() -> bpy.types.Object:
    """The border of the voxels whose middles lie in a ball: steps, as a segmentation has them."""
    subjects.empty()
    bpy.ops.mesh.primitive_uv_sphere_add(segments=64, ring_count=32, radius=1.0)
    made = bpy.context.active_object
    steps = made.modifiers.new("voxels", "REMESH")
    steps.mode, steps.octree_depth, steps.scale = "BLOCKS", 5, 0.9
    bpy.ops.object.modifier_apply(modifier="voxels")
    made.name = "Voxels"
    return made


KINDS = {"descriptors": draw_descriptors, "maps": draw_maps, "scans": draw_scans}
