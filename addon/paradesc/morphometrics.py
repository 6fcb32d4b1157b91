"""Adds the command `paradesc` to surface_morphometrics 2: curvature of membranes in place of PyCurv's step.

Each NAME.surface.vtp of the working folder becomes NAME.AVV_rhR.vtp, .csv and, where graph-tool is installed, .gt: the
files that the next steps look for, with PyCurv's names, signs and one value for each triangle. Imports no part of
Blender; the heavy modules are imported when the command runs.
"""

import importlib.util
import math
import warnings
from pathlib import Path
from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    import numpy as np

ENDING = ".surface.vtp"
# PyCurv's votes come from a quarter of the circle of the smallest feature's radius; this radius reaches as far.
REACH = math.pi / 2
NAMES = (
    "principal_curvature_max", "principal_curvature_min", "principal_direction_max", "principal_direction_min"
)  # fmt: skip


@click.command(name="paradesc", short_help="Curvature by Paradesc, in place of pycurv (step 2), in seconds.")
@click.argument("configfile", type=click.Path(exists=True))
@click.argument("surface", required=False)
@click.option("--radius", type=float, help=(
    "Radius of the neighborhood, in the surface's unit (default: radius_hit pi/2)."
))
@click.option("-f", "--force", is_flag=True, help="Overwrite existing results, also those of pycurv.")
def command(configfile: str, surface: str | None, radius: float | None, force: bool) -> None:
    """Computes curvature for the next steps, by Paradesc in place of pycurv.

    CONFIGFILE: path to config.yml. SURFACE: one NAME.surface.vtp of work_dir; if omitted, all of them.
    """
    from surface_morphometrics.config_utils import load_config

    from .bridge import ParadescError

    config = load_config(configfile, require=("work_dir",))
    folder, hit = Path(config["work_dir"]), (config.get("curvature_measurements") or {}).get("radius_hit")
    if not isinstance(hit, (int, float)):
        raise click.ClickException(f'"{configfile}" has no number radius_hit below curvature_measurements; add it.')
    found = [folder / surface] if surface else sorted(folder.glob(f"*{ENDING}"))
    if not found:
        raise click.ClickException(f'There is no *{ENDING} in "{folder}"; run morphometrics make_meshes first.')
    failed = []
    for path in found:
        try:
            written = measure(path, hit, hit * REACH if radius is None else radius, force)
            click.echo(f"{path.name}: {', '.join(one.name for one in written)}")
        except ParadescError as error:
            failed.append(f"{path.name}: {error.sentence}")
    if not importlib.util.find_spec("graph_tool"):
        click.echo("graph-tool is not installed here, so no .gt was written, which distances and thickness need.")
    if failed:
        raise click.ClickException("\n".join(failed))


def measure(path: Path, hit: float, radius: float, force: bool) -> list[Path]:
    """Writes the results of one surface beside it; returns the paths."""
    from .bridge import InputError
    from .files import mesh_files, vtk_files
    from .files.results import write_whole

    if not path.name.endswith(ENDING):
        raise InputError(f'"{path.name}" does not end in {ENDING}.')
    base = path.name.removesuffix(ENDING)
    suffixes = (".vtp", ".csv", ".gt") if importlib.util.find_spec("graph_tool") else (".vtp", ".csv")
    out, table, *graph = [path.with_name(f"{base}.AVV_rh{hit}{suffix}") for suffix in suffixes]
    there = [one.name for one in (out, table, *graph) if one.exists()]
    if there and not force:
        raise InputError(f"{there[0]} exists already; add --force to overwrite it.")
    (mesh,) = mesh_files.read(path)
    points, triangles, values = quantities(mesh.arrays.positions, mesh.arrays.triangle_vertices, radius)
    write_whole(out, None, lambda place, _: vtk_files.write_polydata(place, points, triangles, values, True))
    write_whole(table, values, write_csv)
    for one in graph:
        write_whole(one, None, lambda place, _: write_graph(place, points, triangles, values))
    return [out, table, *graph]


def quantities(
    points: "np.ndarray", triangles: "np.ndarray", radius: float
) -> "tuple[np.ndarray, np.ndarray, dict[str, np.ndarray]]":
    """The surface without triangles of zero area, and PyCurv's quantities for the others, by PyCurv's names.

    PyCurv's curvature is positive where the surface bends toward the normals that its triangles are wound by, and
    Paradesc's where it bends away from them. n_v is the normal of the plane in which the principal directions lie.
    """
    import numpy as np

    from .api import ParadescWarning, compute

    corners = points[triangles].astype(np.float64)
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    length = np.linalg.norm(across, axis=1)
    keep = length > 0
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ParadescWarning)  # one of them is that PyCurv's triangles are wound inwards
        result = compute(points, triangles, NAMES, radius, radius_unit="absolute", domain="faces")
    largest, least, along_largest, along_least = (result[name][keep].astype(np.float64) for name in NAMES)
    one, other, normal = -least, -largest, across[keep] / length[keep, None]
    voted = np.cross(along_least, along_largest)
    voted *= np.sign((voted * normal).sum(axis=1, keepdims=True))
    values = {
        "kappa_1": one,
        "kappa_2": other,
        "gauss_curvature_VV": one * other,
        "mean_curvature_VV": (one + other) / 2,
        "shape_index_VV": 2 / np.pi * np.arctan2(one + other, one - other),
        "curvedness_VV": np.sqrt((one**2 + other**2) / 2),
        "area": length[keep] / 2,
        "coverage": result.coverage[keep],
        "xyz": corners[keep].mean(axis=1),
        "normal": normal,
        "n_v": np.where(np.isfinite(voted), voted, normal),
        "t_1": along_least,
        "t_2": along_largest,
    }
    return points, triangles[keep], {name: array.astype(np.float32) for name, array in values.items()}


def write_csv(path: Path, values: "dict[str, np.ndarray]") -> None:
    """Writes a row for each triangle, vectors by their components, as the steps of statistics and plots read it."""
    import numpy as np

    from .files.results import columns_of

    columns = columns_of(values)
    rows = np.column_stack([np.arange(len(values["area"])), *columns.values()])
    header = ",".join(["index", *columns])
    np.savetxt(path, rows, ["%d", *["%.7g"] * len(columns)], ",", header=header, comments="")


def write_graph(path: Path, points: "np.ndarray", triangles: "np.ndarray", values: "dict[str, np.ndarray]") -> None:
    """Writes graph-tool's file of the triangles, connected where they have an edge in common, as PyCurv does."""
    import graph_tool
    import numpy as np

    graph = graph_tool.Graph(directed=False)
    graph.add_vertex(len(triangles))
    for name, array in values.items():
        kind = "double" if array.ndim == 1 else "vector<double>"
        graph.vp[name] = graph.new_vertex_property(kind, vals=array.astype(np.float64))
    corners = points[triangles].astype(np.float64)
    graph.vp["points"] = graph.new_vertex_property("object", vals=[list(three) for three in corners])
    edges = neighbors(triangles)
    graph.add_edge_list(edges)
    ways = values["xyz"][edges[:, 0]] - values["xyz"][edges[:, 1]]
    graph.ep["distance"] = graph.new_edge_property("double", vals=np.linalg.norm(ways, axis=1))
    graph.ep["is_strong"] = graph.new_edge_property("int", vals=np.ones(len(edges), int))
    graph.gp["total_area"] = graph.new_graph_property("double", float(values["area"].sum()))
    graph.gp["max_triangle_area"] = graph.new_graph_property("double", float(values["area"].max()))
    graph.save(str(path), fmt="gt")


def neighbors(triangles: "np.ndarray") -> "np.ndarray":
    """(k, 2) the pairs of triangles (m, 3) that share an edge, each once."""
    import numpy as np

    edges = np.sort(np.concatenate([triangles[:, [k, (k + 1) % 3]] for k in range(3)]), axis=1)
    owners = np.tile(np.arange(len(triangles)), 3)
    order = np.lexsort(edges.T)
    edges, owners = edges[order], owners[order]
    same = np.flatnonzero((edges[1:] == edges[:-1]).all(axis=1))
    pairs = np.sort(np.column_stack([owners[same], owners[same + 1]]), axis=1)
    return np.unique(pairs[pairs[:, 0] != pairs[:, 1]], axis=0)
