"""The rows of the section on surfaces that are not smooth: bodies of known curvature with noise, stairs and folds."""

from dataclasses import dataclass

import numpy as np
import rough_surfaces as rough

# About so many vertices, so that there are 20 to 40 thousand triangles; stairs: the side of a voxel.
VERTICES = {"torus": 20000, "ellipsoid": 10000}
CELLS = {"sphere": 1 / 30, "torus": 0.04, "ellipsoid": 0.04}
UNEVEN = 0.2  # share of a cell by which vertices are moved along the surface where nothing else is said
SEEDS = 3


@dataclass(frozen=True)
class Row:
    """The changes that are made to a body."""

    body: str
    kind: str  # clean, noise, normal noise, stairs, folds, folds and noise
    noise: float = 0.0  # in mean edges
    moved: float = UNEVEN  # share of a cell

    @property
    def name(self):
        amounts = {"folds": f" {self.moved:g}", "folds and noise": f" {self.moved:g}, {self.noise:g}"}
        return f"{self.body}, {self.kind}" + amounts.get(self.kind, f" {self.noise:g}" if self.noise else "")

    @property
    def noisy(self):
        return self.noise > 0.02

    @property
    def seeds(self):
        return 1 if self.kind in ("clean", "stairs") else SEEDS

    def make(self, seed=0):
        """The mesh, and the truth at each vertex: that of the nearest point of the body before there was noise."""
        if self.kind == "stairs":
            points, faces = rough.staircase(self.body, CELLS[self.body])
        else:
            points, faces = rough.made(self.body, VERTICES[self.body], self.moved, seed)
        truth = rough.exact(self.body, points)
        normals = truth.pop("normals")
        if self.noise:
            ways = normals if self.kind == "normal noise" else None
            points = rough.noisy(points, faces, self.noise, seed, ways)
        return Case(self, points, faces, truth)


@dataclass
class Case:
    """A mesh and its exact curvatures."""

    row: Row
    points: np.ndarray  # (n, 3)
    faces: np.ndarray  # (m, 3)
    truth: dict[str, np.ndarray]  # (n,) by name

    @property
    def diagonal(self):
        return float(np.linalg.norm(np.ptp(self.points, axis=0)))

    @property
    def edge(self):
        return float(rough.mean_edge(self.points, self.faces))


ROWS = [
    row
    for body in VERTICES
    for row in (
        Row(body, "clean"),
        *(Row(body, "noise", amount) for amount in (0.02, 0.1, 0.3)),
        *(Row(body, "normal noise", amount) for amount in (0.1, 0.3)),
        *(Row(body, "folds", moved=moved) for moved in (0.3, 0.35, 0.4, 0.45)),
        Row(body, "folds and noise", 0.1, 0.4),
        Row(body, "stairs"),
    )
] + [Row("sphere", "stairs")]
