"""Mean and Gaussian curvature of a torus by the installed package, beside the closed forms: run by the tests of wheels.

It ends with 1 if an error, of the largest value, is above 0.2 %, or if Blender or this folder's sources were used.
"""

import platform
import sys
import time
from pathlib import Path

import numpy as np

import paradesc

AROUND, ACROSS = 160, 80
RADIUS, TUBE = 1.0, 0.4
ALLOWED = 0.002


def torus():
    """Vertices (n, 3), triangles (2 n, 3), and the two curvatures of each vertex (n,)."""
    i, j = (index.ravel() for index in np.meshgrid(np.arange(AROUND), np.arange(ACROSS), indexing="ij"))
    turn, tilt = 2 * np.pi * i / AROUND, 2 * np.pi * j / ACROSS
    ring = RADIUS + TUBE * np.cos(tilt)
    vertices = np.stack([ring * np.cos(turn), ring * np.sin(turn), TUBE * np.sin(tilt)], axis=1)
    mean = (RADIUS + 2 * TUBE * np.cos(tilt)) / (2 * TUBE * ring)
    gaussian = np.cos(tilt) / (TUBE * ring)
    next_i, next_j = (i + 1) % AROUND, (j + 1) % ACROSS
    a, b, c, d = (x * ACROSS + y for x, y in ((i, j), (next_i, j), (next_i, next_j), (i, next_j)))
    return vertices, np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)]), (mean, gaussian)


def main():
    """Prints one line; gives the exit code."""
    start = time.perf_counter()
    vertices, faces, expected = torus()
    names = ("mean_curvature", "gaussian_curvature")
    result = paradesc.compute(vertices, faces, names, radius=0.01)
    pairs = zip(names, expected, strict=True)
    errors = [np.abs(result[name] - truth).max() / np.abs(truth).max() for name, truth in pairs]
    seconds = time.perf_counter() - start
    shown = ", ".join(f"{name} within {error:.3%}" for name, error in zip(names, errors, strict=True))
    where = f"{platform.system()} {platform.machine()}, Python {platform.python_version()}, numpy {np.__version__}"
    sys.stdout.write(f"torus: {shown}; {seconds:.2f} s; paradesc {paradesc.__version__}, {where}\n")
    installed = Path(paradesc.__file__).resolve().parents[1] != Path(__file__).resolve().parents[2] / "addon"
    return 0 if max(errors) < ALLOWED and installed and "bpy" not in sys.modules else 1


if __name__ == "__main__":
    sys.exit(main())
