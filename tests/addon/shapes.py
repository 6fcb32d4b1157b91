"""A sphere of six charts, as numbers, as the library's arrays and as a file."""

import sys
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
ADDON = ROOT / "addon"
PACKAGES = (ADDON / "paradesc", ADDON / "paradesc_blender")  # of the wheel, and of Blender
if str(ADDON) not in sys.path:
    sys.path.insert(0, str(ADDON))

from paradesc import bridge  # noqa: E402

# A sphere whose radius is not 1, so that a forgotten length shows.
RADIUS = 2.0
STEPS = 14


def cube_sphere(steps=STEPS, radius=RADIUS):
    """Six square charts on a sphere, sharing their vertices: positions, quads (n, 4) and their UVs (n, 4, 2)."""
    side = np.linspace(-1.0, 1.0, steps + 1)
    u, v = np.meshgrid(side, side, indexing="ij")
    points, quads, uvs = [], [], []
    corner = np.array([[0, 0], [1, 0], [1, 1], [0, 1]])
    index = np.arange((steps + 1) ** 2).reshape(steps + 1, steps + 1)
    place = np.stack(np.meshgrid(np.arange(steps), np.arange(steps), indexing="ij"), axis=-1)
    cells = place[:, :, None, :] + corner
    for face in range(6):
        axis, sign = face // 2, 1.0 - 2.0 * (face % 2)
        block = np.empty((steps + 1, steps + 1, 3))
        block[..., axis] = sign
        block[..., (axis + 1) % 3] = u
        block[..., (axis + 2) % 3] = v * sign
        points.append(block.reshape(-1, 3))
        quads.append(index[cells[..., 0], cells[..., 1]].reshape(-1, 4) + face * index.size)
        cell = np.array([face % 3, face // 3])
        uvs.append((cells.reshape(-1, 4, 2) / steps * 0.9 + 0.05 + cell) / (3, 2))
    points = np.concatenate(points)
    _, first, shared = np.unique(np.round(points, 9), axis=0, return_index=True, return_inverse=True)
    points = points[first] / np.linalg.norm(points[first], axis=1, keepdims=True) * radius
    return points, shared.reshape(-1)[np.concatenate(quads)], np.concatenate(uvs)


def as_arrays(points, quads, uvs):
    """Quads as the two triangles each that the native library reads."""
    first = 4 * np.arange(len(quads))[:, None]
    triangles = np.concatenate([first + np.array([0, 1, 2]), first + np.array([0, 2, 3])])
    return bridge.MeshArrays(
        positions=points.astype(np.float32),
        corner_vertices=quads.reshape(-1).astype(np.int32),
        triangle_corners=triangles.astype(np.int32),
        corner_uvs=uvs.reshape(-1, 2).astype(np.float32),
    )


def write_obj(path, points, quads, uvs=None):
    """A Wavefront file of quads, with one texture vertex a corner."""
    lines = ["o sphere"] + ["v {:.7f} {:.7f} {:.7f}".format(*point) for point in points]
    if uvs is None:
        lines += ["f " + " ".join(str(vertex + 1) for vertex in quad) for quad in quads]
    else:
        lines += ["vt {:.7f} {:.7f}".format(*uv) for uv in uvs.reshape(-1, 2)]
        for number, quad in enumerate(quads):
            lines.append("f " + " ".join(f"{vertex + 1}/{4 * number + k + 1}" for k, vertex in enumerate(quad)))
    path.write_text("\n".join(lines) + "\n")
    return path
