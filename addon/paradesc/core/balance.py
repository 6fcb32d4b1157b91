"""Finds the radius at which noise and what a radius blurs balance, from mean curvatures at several. Never imports bpy.

The model: H(r) = H0 + b r² + noise. A ball blurs with r² (Pottmann, Wallner, Huang and Yang 2009, "Integral invariants
for robust geometry processing"), the estimator "extrapolated" with r⁴, and the descriptor standard_error says how noise
falls with r if that of vertices is independent. The change of H from r to about 2 r holds both: its mean square over the
mesh says how large they are. Steps of voxels belong together over several edges, so noise may fall more slowly, by a
power of r.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from ..bridge import InputError, MeshArrays
from . import advice, fitting

# The word for a radius that is found so; that of settings, too (job.Settings.radius_fit).
AUTO = "auto"
MEAN, ERROR = "mean_curvature", "standard_error"
# The radii that are looked at, as shares of the diagonal. None is below the mean edge, where values show facets.
LEAST, LARGEST = 0.005, 0.16
# A radius is compared with the first that is larger by this: near ones see the same noise.
APART = 1.8
# Bounds of what the model lets noise be: so many times the variance of independent vertices, times r to these powers.
MOST_NOISE, POWERS = 9.0, np.arange(0, 2.25, 0.25)
# A term has to explain the changes better by this, in squares of their relative errors.
COST_OF_POWER, COST_OF_BIAS = 0.01, 0.02
ENOUGH_CHANGES = 3
# Only radii from so many mean edges on tell how noise falls: below, it is that of single normals.
TELLING = APART
# The radius of least error takes the squared bias times this: changes of what bends within a radius are less than r² has it.
CAUTION = 2.0
# The power of r with which the blur of an estimator grows.
BLUR = {"shape-operator": 2, "extrapolated": 4}
# The radii that are looked at in any case end at so many times the least; later ones are, if the best is not so far below.
FIRST, BEYOND = 4.0, 1.9
# Extrapolated values are taken if their expected error is less than this share of the others'.
GAIN = 0.8
# Rounds of averages over the neighbors of vertices that smooth their own bias; noise and bias count half by the mesh's.
ROUNDS = 8

UNKNOWN = (
    "The noise is not known here, so it cannot choose the radius: this takes fitted normals on the processor and no "
    "displacement image; give the radius as a number."
)

# The types of job.py, which is built on this.
Settings, Results = TypeVar("Settings"), TypeVar("Results")
Array = NDArray[np.float64]


@dataclass(frozen=True, repr=False)
class Profile:
    """Mean curvatures at several radii, their errors, and the radii at which these are least.

    Lengths are in the unit of the vertices, and curvatures are one over that. There are k radii and n vertices, in the
    order that was asked for. Values are NaN where a curvature or its error does not exist.

    Attributes
    ----------
    radii : (k,)
        The radii, in ascending order.
    values : (k, n)
        The mean curvatures.
    standard_error : (k, n)
        The error by noise: that of independent vertices, scaled to the noise that the mesh shows.
    bias : (k, n)
        The error by blur, b r² or b r⁴: values minus bias and noise are H0. It is noisy, and 0 where none shows.
    best : (n,)
        The radius at which the expected error of each vertex, by noise and blur together, is least.
    radius : float
        The radius at which the expected error of the whole mesh is least.
    expected : float
        The root mean square of the expected error at that radius.

    Examples
    --------
    >>> import numpy as np
    >>> import paradesc
    >>> u, v = np.meshgrid(np.linspace(-1, 1, 21), np.linspace(-1, 1, 21))
    >>> vertices = np.stack([u, v, -0.2 * u * u], axis=2).reshape(-1, 3)
    >>> faces = np.arange(420).reshape(20, 21)[:, :20].reshape(-1, 1) + [0, 1, 22, 21]
    >>> profile = paradesc.profile(vertices, faces, radii=(0.2, 0.3, 0.4), radius_unit="absolute")
    >>> profile.values.shape
    (3, 441)
    >>> profile.radius  # the smallest, since there is no noise
    0.2
    >>> profile.at([220]).values.round(2).tolist()
    [[0.2], [0.2], [0.2]]
    """

    radii: Array
    values: Array
    standard_error: Array
    bias: Array
    best: Array
    radius: float
    expected: float

    def __repr__(self) -> str:
        span = f"{len(self.radii)} radii from {self.radii[0]:.4g} to {self.radii[-1]:.4g}"
        least = f"expected error {self.expected:.3g}, the least, at the radius {self.radius:.4g}"
        return f"{len(self.best):,} vertices, {span}: {least}"

    def at(self, vertices: Sequence[int] | NDArray[np.integer]) -> "Profile":
        """The profile of some vertices alone; its radius stays that of the whole mesh.

        Parameters
        ----------
        vertices : (j,) array_like of int
            The vertices, counted from 0.

        Returns
        -------
        Profile
            A profile with arrays (k, j) and (j,).

        Raises
        ------
        IndexError
            There is no such vertex.
        """
        own = {name: getattr(self, name)[:, vertices] for name in ("values", "standard_error", "bias")}
        return replace(self, best=self.best[vertices], **own)


def usual_radii(arrays: MeshArrays) -> list[float]:
    """Lengths from the mean edge on to 16 % of the diagonal, in steps of about the root of 2."""
    edge, diagonal = advice.edge_and_diagonal(arrays)
    largest = LARGEST * diagonal
    least = min(max(edge, LEAST * diagonal), largest / 2)
    return np.geomspace(least, largest, 1 + round(2 * np.log2(largest / least))).tolist()


def balanced(settings: Settings, arrays: MeshArrays, compute: Callable[[Settings], Results]) -> Settings:
    """The settings with the radius at which noise and bias of this mesh balance, as a length.

    The shape operator is extrapolated if that leaves a smaller error.
    """
    settings = in_lengths(settings)
    radii, estimator = usual_radii(arrays), settings.options.estimator
    found = as_far_as_needed(settings, arrays, radii, compute)
    if estimator == "shape-operator":
        options = replace(settings.options, estimator="extrapolated")
        other = as_far_as_needed(replace(settings, options=options), arrays, radii, compute)
        if other.expected < GAIN * found.expected:
            found, estimator = other, "extrapolated"
    radius = float(f"{found.radius:.3g}")
    options = replace(settings.options, radius=radius, estimator=estimator)
    return replace(settings, options=options, more_radii=(), radius_fit=fitting.FITTED)


def in_lengths(settings: Settings) -> Settings:
    """The settings for radii that are lengths."""
    return replace(settings, options=replace(settings.options, radius_unit="absolute"))


def profile(
    settings: Settings, arrays: MeshArrays, radii: Sequence[float] | None, compute: Callable[[Settings], Results]
) -> Profile:
    """The profile at radii that rise, or the usual ones; the settings say all else, and compute() gives the results."""
    if radii is None:
        settings, radii = in_lengths(settings), usual_radii(arrays)
    results = compute(sweep(settings, radii))
    lengths = [results.radius_of(name) for name in results.values]
    return of_rows(settings, arrays, lengths[::2], rows_of(results))


def as_far_as_needed(
    settings: Settings, arrays: MeshArrays, radii: Sequence[float], compute: Callable[[Settings], Results]
) -> Profile:
    """The profile at the first of these lengths, so many that the best radius lies well below the last.

    The largest radii take most of the time, as a ball has more triangles with the square of its radius.
    """
    count, rows = int(np.searchsorted(radii, FIRST * radii[0])) + 1, np.empty((0, 0))
    while True:
        more = rows_of(compute(sweep(settings, radii[len(rows) // 2 : count])))
        rows = np.concatenate([rows, more]) if len(rows) else more
        found = of_rows(settings, arrays, radii[:count], rows)
        if count >= len(radii) or BEYOND * found.radius <= radii[count - 1]:
            return found
        count += 1


def rows_of(results: Results) -> Array:
    """Mean curvatures and their errors at each radius, one after the other."""
    return np.stack(list(results.values.values())).astype(np.float64)


def of_rows(settings: Settings, arrays: MeshArrays, radii: Sequence[float], rows: Array) -> Profile:
    """The profile of rows at these lengths."""
    telling = TELLING * advice.edge_and_diagonal(arrays)[0]
    power = BLUR[blurring(settings.options.estimator)]
    return profile_of(radii, rows[::2], rows[1::2], arrays.triangle_vertices, telling, power)


def blurring(estimator: str) -> str:
    """The estimator that a profile is measured by: integrals have no standard error, and the shape operator's radius."""
    return estimator if estimator in BLUR else "shape-operator"


def sweep(settings: Settings, radii: Sequence[float]) -> Settings:
    """The settings that compute what a profile is made of, at these radii."""
    estimator = blurring(settings.options.estimator)
    options = replace(settings.options, radius=radii[0], estimator=estimator, evaluate="vertex")
    more = tuple(radii[1:])
    return replace(settings, descriptors=(MEAN, ERROR), options=options, more_radii=more, radius_fit="typed")


def profile_of(
    radii: Sequence[float],
    values: Array,
    errors: Array,
    triangles: NDArray[np.integer],
    telling: float = 0.0,
    blur: int = 2,
) -> Profile:
    """The profile of (k, n) mean curvatures and standard errors at k lengths that rise.

    triangles: (m, 3) vertices. telling: the model is fitted to radii from this on, if they are enough. blur: the power of
    the radius that bias grows with.
    """
    r = np.asarray(radii, float)
    known = np.isfinite(values).all(axis=0) & np.isfinite(errors).all(axis=0)
    if not known.any():
        raise InputError(UNKNOWN)
    first, second = changes_between(r, telling)
    share = 1 / (r[second] ** blur - r[first] ** blur)
    slopes = (values[second] - values[first]) * share[:, None]  # b, and noise
    squares = errors**2
    mean = squares[:, known].mean(axis=1)
    power, noise, bias = explained(r, (slopes[:, known] ** 2).mean(axis=1), mean, first, second, blur)
    growth = noise * (r / r[first[0]]) ** power
    squares, mean = squares * growth[:, None], mean * growth

    variances = (squares[first] + squares[second]) * share[:, None] ** 2
    weights = 1 / (variances + bias + np.finfo(float).tiny)
    weights /= weights.sum(axis=0)
    slope = (weights * slopes).sum(axis=0)
    own = slope**2 - (weights**2 * variances).sum(axis=0)  # less what noise puts into it, on average
    own = np.maximum(averaged(np.where(known, own, 0.0), known, triangles), 0) if bias else np.zeros(len(own))
    expected = (squares + mean[:, None]) / 2 + CAUTION * (own + bias) / 2 * r[:, None] ** (2 * blur)
    best = np.where(known, r[np.where(known, expected, 0.0).argmin(axis=0)], np.nan)
    of_mesh = mean + CAUTION * bias * r ** (2 * blur)
    blurred = slope * r[:, None] ** blur if bias else np.where(known, 0.0, np.nan) * r[:, None]
    return Profile(
        r, values, np.sqrt(squares), blurred, best, float(r[of_mesh.argmin()]), float(np.sqrt(of_mesh.min()))
    )


def changes_between(r: Array, telling: float = 0.0) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """The radii that are compared: each with the first that is far enough above; the ends if none is.

    Only radii from telling on are, if those are enough.
    """
    second = np.searchsorted(r, APART * r)
    first = np.flatnonzero(second < len(r))
    later = first[r[first] >= telling]
    first = later if len(later) >= ENOUGH_CHANGES else first
    return (first, second[first]) if len(first) else (np.array([0]), np.array([len(r) - 1]))


def explained(
    r: Array, slopes: Array, errors: Array, first: NDArray[np.intp], second: NDArray[np.intp], blur: int = 2
) -> tuple[float, float, float]:
    """The power of r and the factor that errors need, and b², which explain the mean squares of slopes best.

    errors: the mean squares of standard errors. Relative squares are least, as all radii tell of either as much.
    """
    by_noise = (errors[first] + errors[second]) / (r[second] ** blur - r[first] ** blur) ** 2
    slopes = np.maximum(slopes, np.finfo(float).tiny)
    if len(slopes) < ENOUGH_CHANGES:
        return 0.0, 1.0, float(np.maximum(slopes - by_noise, 0).mean())
    best = (np.inf, 0.0, 0.0, 0.0)
    even = slopes.min() / slopes  # whatever the unit of length is
    for power in POWERS:
        noisy = by_noise * (r[first] / r[first[0]]) ** power / slopes
        both = np.linalg.lstsq(np.stack([noisy, even], axis=1), np.ones(len(even)), rcond=None)[0][0]
        alone = noisy.sum() / max(float(noisy @ noisy), np.finfo(float).tiny)
        for factor in np.clip([0.0, alone, both], 0, MOST_NOISE):
            for bias in (0.0, max(float(even @ (1 - factor * noisy)) / float(even @ even), 0.0)):
                left = ((factor * noisy + bias * even - 1) ** 2).sum()
                cost = left + COST_OF_POWER * power + COST_OF_BIAS * (bias > 0)
                best = min(best, (float(cost), float(power), float(factor), bias))
    return best[1], best[2], best[3] * float(slopes.min())


def averaged(values: Array, known: NDArray[np.bool_], triangles: NDArray[np.integer]) -> Array:
    """Values at vertices, smoothed by some rounds of means over those that share triangles."""
    count = len(values)
    weights = known.astype(float)
    for _ in range(ROUNDS):
        values, weights = (of_neighbors(field, triangles, count) for field in (values, weights))
        values, weights = values / np.maximum(weights, np.finfo(float).tiny), (weights > 0).astype(float)
    return values


def of_neighbors(field: Array, triangles: NDArray[np.integer], count: int) -> Array:
    """The sum of a field over the triangles around each vertex."""
    sums = np.repeat(field[triangles].sum(axis=1), 3)
    return np.bincount(triangles.reshape(-1), weights=sums, minlength=count)
