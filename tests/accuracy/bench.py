"""Computes meshes and options with Paradesc and with its reference, and measures the errors."""

import platform
from dataclasses import asdict, dataclass, fields, replace
from pathlib import Path

import numpy as np

from paradesc import bridge
from paradesc.core import compare, job
from paradesc.core.job import registry_row

# These options say how to sample; the reference does not read them.
SAMPLING = {
    "samples", "buffer_size", "max_jumps", "seed", "relocation", "variance_reduction", "pattern", "ellipse", "adaptive",
    "evaluate", "texels", "precision",
}  # fmt: skip


class MissingError(Exception):
    """An option or a value of one that this build does not have."""


def has(name, value=None):
    """Returns whether this build has the option, and if it is a choice also the value."""
    if not hasattr(bridge.Options(), name):
        return False
    return value is None or name not in bridge.CHOICES or value in bridge.CHOICES[name][0]


def options(**wanted):
    """Options with these values; MissingError names the first that this build does not have."""
    for name, value in wanted.items():
        if not has(name, value):
            raise MissingError(f"{name} = {value}" if hasattr(bridge.Options(), name) else name)
    return bridge.Options(**wanted)


def registry():
    """Names of all descriptors that have one value for each vertex."""
    return [row.name for row in bridge.descriptors() if not row.name.startswith("principal_direction")]


def directions():
    """Names of the descriptors that are directions."""
    return [row.name for row in bridge.descriptors() if row.name.startswith("principal_direction")]


def cpu_model():
    """The processor's name."""
    path = Path("/proc/cpuinfo")
    lines = path.read_text().splitlines() if path.is_file() else []
    names = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.processor() or platform.machine()


@dataclass
class Stats:
    """Errors in percent as compare.py defines them, and the number of vertices that they cover."""

    mean: float
    median: float
    p99: float
    max: float
    count: int


def stats(percent):
    """Statistics of (n,) percentages; NaN is left out."""
    finite = percent[np.isfinite(percent)]
    if finite.size == 0:
        return Stats(np.nan, np.nan, np.nan, np.nan, 0)
    return Stats(finite.mean(), np.median(finite), np.percentile(finite, 99), finite.max(), finite.size)


def errors(name, values, truth, radius, subset=None):
    """Stats of values against truth, both (n,); subset: (n,) bool."""
    subset = np.ones(len(values), bool) if subset is None else subset
    return stats(compare.percent_errors(values, truth, subset, registry_row(name), radius).percent)


def angle(values, truth, weight, subset=None):
    """Mean angle in degrees between lines, (n, 3) each, weighted by (n,)."""
    length = np.linalg.norm(values, axis=1) * np.linalg.norm(truth, axis=1)
    with np.errstate(invalid="ignore", divide="ignore"):
        degrees = np.degrees(np.arccos(np.clip(np.abs((values * truth).sum(1)) / length, 0, 1)))
    counts = np.isfinite(degrees) & (np.ones(len(degrees), bool) if subset is None else subset)
    return float(np.average(degrees[counts], weights=weight[counts])) if counts.any() else np.nan


class Bench:
    """The engines, opened once."""

    def __init__(self):
        self.context = bridge.Context("auto")  # the CPU, and the software device for what texture space alone has
        self.oracle = bridge.Context("reference")
        self.meshes = {}
        self.kept = {}

    @property
    def device(self):
        return self.context.device

    def forget(self):
        """Frees all meshes and results between sections."""
        for mesh, _ in self.meshes.values():
            mesh.close()
        self.meshes.clear()
        self.kept.clear()

    def mesh(self, context, arrays):
        """The native mesh, made once."""
        key = (id(context), id(arrays))
        if key not in self.meshes:
            self.meshes[key] = (context.mesh(arrays), arrays)  # the arrays are kept, so that no others get their id
        return self.meshes[key][0]

    def run(self, arrays, names, chosen=None):
        """Our results."""
        return self.compute(self.context, arrays, tuple(names), chosen or bridge.Options())

    def reference(self, arrays, names, chosen=None):
        """The reference's results, computed once for the options that it reads."""
        chosen = chosen or bridge.Options()
        defaults = bridge.Options()
        read = {field.name: getattr(chosen, field.name) for field in fields(chosen) if field.name not in SAMPLING}
        key = (id(arrays), tuple(names), tuple(sorted(read.items())))
        if key not in self.kept:
            self.kept[key] = self.compute(self.oracle, arrays, tuple(names), replace(defaults, **read))
        return self.kept[key]

    def compute(self, context, arrays, names, chosen):
        mesh = self.mesh(context, arrays)
        with mesh.compute(names, chosen) as field:
            found = job.Results(
                settings=job.Settings(names, chosen, context.backend),
                values={name: field.values(name) for name in names},
                coverage=field.values("coverage"),
                mask=field.mask(),
                mesh_report=mesh.report(),
                field_report=field.report(),
                backend=context.backend,
                device=context.device,
                warnings=field.warnings(),
            )
            if context is not self.oracle:
                found.near_seam = mesh.near_seam(found.radius)
        return found

    def compare(self, arrays, names, chosen=None, against=None):
        """Rows of compare.py, one a descriptor, and our results; against: options of the reference."""
        found = self.run(arrays, names, chosen)
        truth = self.reference(arrays, names, against or chosen)
        return {name: compare.row(name, found, truth) for name in names}, found


def changed(chosen, default=None):
    """The options that are not the default, as text."""
    default = asdict(default or bridge.Options())
    return ", ".join(f"{name} {value}" for name, value in asdict(chosen).items() if value != default[name])
