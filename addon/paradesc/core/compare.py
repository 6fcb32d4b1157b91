"""Compares the results of a device with those of the reference: the one definition of error, in percent.

%AE = 100 |x - reference| / (P97.5(reference) - P2.5(reference)), over the vertices with a face. A value that is
undefined on both sides is left out; one that is undefined on one side only counts as 100.

If the reference has one value everywhere, its size stands in for that range. On surfaces whose values hardly differ,
such as a fine sphere, a small error is a large share of the range; the spread of a row tells. Never imports bpy.
"""

from dataclasses import dataclass, replace

import numpy as np

from .. import bridge
from ..bridge import Descriptor, abi
from . import job

# If the reference's range is a smaller share of its largest value, the surface counts as having one value everywhere.
CONSTANT_SHARE = 1e-3
# On a plane, rounding stays below this curvature times radius (to the unit's power).
PLANE_SHARE = 1e-4
UNDEFINED_ERROR = 100.0
# Values whose range is a smaller share of the largest one hardly differ.
SMALL_SPREAD = 0.05


@dataclass
class Errors:
    """Errors of one descriptor, in percent."""

    percent: np.ndarray  # (vertex_count,) NaN where left out
    spread: float = float("nan")  # the denominator as a share of the reference's largest value


def denominator(reference: np.ndarray, descriptor: Descriptor, radius: float) -> float:
    """The denominator of errors: the range of the (n,) defined reference values, or its substitute."""
    if reference.size == 0:
        return 1.0
    largest = float(np.abs(reference).max())
    power = descriptor.length_power
    if power < 0 and largest < (PLANE_SHARE / radius) ** -power:
        return (1.0 / radius) ** -power
    low, high = np.percentile(reference, [2.5, 97.5])
    if high - low < CONSTANT_SHARE * largest:
        return largest
    return float(high - low) if high > low else 1.0


def percent_errors(
    values: np.ndarray, reference: np.ndarray, with_face: np.ndarray, descriptor: Descriptor, radius: float
) -> Errors:
    """Error at each vertex; all arrays (vertex_count,), radius in units of the positions."""
    values, reference = values.astype(np.float64), reference.astype(np.float64)
    here, there = np.isfinite(values), np.isfinite(reference)
    counted = reference[there & with_face]
    scale = denominator(counted, descriptor, radius)
    largest = float(np.abs(counted).max()) if counted.size else 0.0
    percent = np.full(len(values), np.nan)
    both = here & there
    percent[both] = 100.0 * np.abs(values[both] - reference[both]) / scale
    percent[here != there] = UNDEFINED_ERROR
    percent[~with_face] = np.nan
    return Errors(percent, scale / largest if largest > 0 else float("nan"))


def angle_errors(values: np.ndarray, reference: job.Results, with_face: np.ndarray, name: str) -> Errors:
    """Angle in degrees between (n, 3) directions, whatever their sign.

    It is weighted by |k1 - k2| over its mean if the reference computed both: a sphere has no principal directions.
    """
    expected = reference.values[name]
    along = np.abs(np.einsum("ij,ij->i", values.astype(np.float64), expected.astype(np.float64)))
    angle = np.degrees(np.arccos(np.minimum(along, 1.0)))
    angle[np.isnan(values).any(axis=1) != np.isnan(expected).any(axis=1)] = UNDEFINED_ERROR
    angle[~with_face] = np.nan
    suffix = name[len(job.registry_name(name)) :]
    k1, k2 = (reference.values.get(f"principal_curvature_{end}{suffix}") for end in ("max", "min"))
    if k1 is not None and k2 is not None:
        weight = np.where(np.isfinite(angle), np.abs(k1 - k2), np.nan).astype(np.float64)
        mean = float(np.nanmean(weight)) if np.isfinite(weight).any() else 0.0
        angle *= weight / mean if mean > 0 else 1.0
    return Errors(angle)


def statistic(percent: np.ndarray, function: object, *arguments: float) -> float:
    """A statistic over the (n,) errors that count; NaN without any."""
    counted = percent[np.isfinite(percent)]
    return float(function(counted, *arguments)) if counted.size else float("nan")


def row(name: str, device: job.Results, reference: job.Results) -> dict[str, object]:
    """The errors of one descriptor on one mesh at one radius."""
    with_face = (reference.mask & abi.MASK_NO_FACE) == 0
    if device.values[name].ndim == 2:
        errors = angle_errors(device.values[name], reference, with_face, name)
    else:
        errors = percent_errors(
            device.values[name], reference.values[name], with_face, job.registry_row(name), device.radius_of(name)
        )
    percent = errors.percent
    near_seam = device.near_seam if device.near_seam is not None else np.zeros(len(percent), bool)
    undefined = np.isnan(device.values[name].reshape(len(percent), -1)).any(axis=1) & with_face
    return {
        "descriptor": name,
        "radius": device.asked_radius(name),
        "mean_percent_ae": statistic(percent, np.mean),
        "median_percent_ae": statistic(percent, np.median),
        "p99_percent_ae": statistic(percent, np.percentile, 99),
        "max_percent_ae": statistic(percent, np.max),
        "seam_mean_percent_ae": statistic(percent[near_seam], np.mean),
        "spread": errors.spread,
        "coverage_mean": device.report_of(name)["coverage_mean"],
        "undefined": int(undefined.sum()),
    }


def spread_note(row: dict[str, object]) -> str:
    """A note if the values of a row hardly differ, or ""."""
    if not row["spread"] < SMALL_SPREAD:
        return ""
    return f"the values of {row['descriptor']} differ by {100 * row['spread']:.2g} % only, which errors count against"


def compare(
    arrays: bridge.MeshArrays, settings: job.Settings, progress: bridge.ProgressFunction | None = None
) -> tuple[list[dict[str, object]], job.Results, job.Results]:
    """Rows of errors, one for each descriptor, and the two results that they compare."""
    device = job.run(arrays, settings, job.part_of(progress, 0, 2, "device, "))
    if device.backend == "reference":
        raise bridge.ParadescError(abi.STATUS_UNSUPPORTED, "There is no device to compare with the reference.")
    reference_settings = replace(device.settings, backend="reference", device_index=-1)
    reference = job.run(arrays, reference_settings, job.part_of(progress, 1, 2, "reference, "))
    rows = [row(name, device, reference) for name in device.values]
    return rows, device, reference
