"""Says in one line how far the results of two engines differ on samples that bake.sh baked twice.

Usage: python compare_engines.py FOLDER NAME...; the folder has NAME and NAME.texture_space, each as .npz and .json.
"""

import json
import sys
from pathlib import Path

import numpy as np

from paradesc.core import compare, job


def difference(folder: Path, name: str) -> float:
    """Mean difference over a sample's vertices and descriptors, in percent, with what auto chose as the reference."""
    means = []
    with np.load(folder / f"{name}.npz") as auto, np.load(folder / f"{name}.texture_space.npz") as texture_space:
        for descriptor, row in report(folder, name)["objects"][0]["descriptors"].items():
            everywhere = np.ones(len(auto[descriptor]), bool)  # the samples have no vertex without a face
            errors = compare.percent_errors(
                texture_space[descriptor], auto[descriptor], everywhere, job.registry_row(descriptor), row["radius"]
            )
            means.append(compare.statistic(errors.percent, np.mean))
    return float(np.mean(means))


def report(folder: Path, name: str) -> dict[str, object]:
    """The report that the bake left."""
    return json.loads((folder / f"{name}.json").read_text(encoding="utf-8"))


def sentence(folder: Path, names: list[str]) -> str:
    """How far the engines differ: on average, and on each sample."""
    engines = [report(folder, f"{names[0]}{suffix}")["backend"] for suffix in ("", ".texture_space")]
    found = {name: difference(folder, name) for name in names}
    each = ", ".join(f"{name} {percent:.2g} %" for name, percent in found.items())
    mean = np.mean(list(found.values()))
    pair = f"The engines {engines[0]} and {engines[1]} (texture space) differ"
    return f"{pair} by {mean:.2g} % of the range of values on average ({each})."


if __name__ == "__main__":
    print(sentence(Path(sys.argv[1]), sys.argv[2:]))
