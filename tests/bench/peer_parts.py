"""Measures other programs beside our frames: times on the bunny, and errors there and on a torus."""

import meshes
import numpy as np
import peers
import programs
import surfaces
import timing
from parts import Run, common_error
from programs import MissingError

from paradesc.bridge import MeshArrays, Options

PEER_MESH = 12000  # vertices of the torus on which errors against the closed form are taken
TURNS = 3  # of peers and our frames; a peer that takes longer than LONG_TURN seconds has one
LONG_TURN = 2.5


def others(run: Run, arrays: MeshArrays | None) -> None:
    """Measures every peer and our frames in turns on the bunny, and the errors there and on a torus."""
    if arrays is None:
        run.reasons |= dict.fromkeys(peers.PEERS, run.reasons["bunny"])
        return
    surface = surfaces.torus(PEER_MESH)
    radius = 0.02 * meshes.diagonal(arrays)
    path = programs.write_mesh(run.folder / "peers", arrays)
    with run.part("truth of the peers", *peers.PEERS):
        truth = programs.object_space(run.build, path, radius, points=2000, methods="reference")[1]["reference"]
    if "truth of the peers" in run.reasons:
        return
    closed = programs.Values(np.arange(len(surface.mean)), surface.mean)
    found = run.measured.setdefault("peers", {})
    for turn in range(TURNS):
        for name, peer in peers.PEERS.items():
            if turn > 0 and (name not in found or found[name]["seconds"] > LONG_TURN):
                continue
            with run.part(name):
                if turn == 0:
                    found[name] = first_of(run, peer, (arrays, radius, truth), (surface, closed))
                else:
                    found[name]["seconds"] = min(found[name]["seconds"], ran(run, peer, arrays, radius).seconds)
        with run.part("our turns"):
            our_turn(run, arrays)
    ours(run, surface, closed)


def first_of(run: Run, peer: peers.Peer, bunny: tuple, torus: tuple) -> dict[str, object]:
    """A peer's time on the bunny and its errors there and on the torus."""
    arrays, radius, truth = bunny
    surface, closed = torus
    torus_radius = 0.02 * surface.diagonal
    here, there = ran(run, peer, arrays, radius), ran(run, peer, surface.arrays, torus_radius)
    return {
        "label": peer.label,
        "seconds": here.seconds,
        "note": here.note,
        "same_radius": peer.same_radius,
        "error": peer_error(here, truth, radius),
        "error_closed": peer_error(there, closed, torus_radius),
    }


def ran(run: Run, peer: peers.Peer, arrays: MeshArrays, radius: float) -> peers.Found:
    """The result of a peer, whose own failure must not end the run."""
    try:
        return peer.function(peers.Task(arrays, radius, run.build, run.folder))
    except ImportError:
        raise MissingError(f"{peer.package} is not installed ({peers.INSTALL}).") from None
    except MissingError:
        raise
    except Exception as error:  # noqa: BLE001
        raise MissingError(f"{peer.label} failed: {error}") from None


def our_turn(run: Run, arrays: MeshArrays) -> None:
    """Measures the bunny's frames once more, between peers; the fastest of all turns counts."""
    bunny = run.measured["bunny"]
    one_core = timing.Bench(threads=1)  # for a peer that computes on one
    for bench, wanted in ((run.bench, ("at_256", "fewest")), (one_core, ("one_core",))):
        mesh, _ = bench.mesh(arrays, Options())
        with mesh:
            for way in wanted:
                before = bunny.get(way, bunny["at_256"] | {"seconds": np.inf})
                again = bench.frame(mesh, arrays, settings_of(before))
                del again["values"]
                bunny[way] = timing.fastest([before, again | {"error": before["error"]}])
    one_core.context.close()


def settings_of(frame: dict) -> Options:
    """The options of a frame that was measured."""
    return Options(samples=frame["samples"])


def ours(run: Run, surface: surfaces.Surface, closed: programs.Values) -> None:
    """Measures the same errors for us and for the baseline."""
    with run.part("errors on the torus"):
        bunny = run.measured["bunny"]

        mesh, _ = run.bench.mesh(surface.arrays, Options())
        with mesh:
            frames = {
                way: run.bench.frame(mesh, surface.arrays, settings_of(bunny[way]), repeats=1)
                for way in ("at_256", "fewest")
            }
        found = {way: timing.with_error(frame, closed)["error"] for way, frame in frames.items()}
        path = programs.write_mesh(run.folder / "peers", surface.arrays)
        base = programs.object_space(run.build, path, 0.02 * surface.diagonal, methods="baseline")[1]["baseline"]
        truth = closed.values[base.vertices]
        found["baseline"] = timing.percent_error(base.values, truth, 0.02 * surface.diagonal)
        run.measured["errors_closed"] = found


def peer_error(found: peers.Found, truth: programs.Values, radius: float) -> float | None:
    """Mean %AE at the vertices that both have; None if a peer has no H."""
    if found.values is None:
        return None
    vertices = np.arange(len(found.values)) if found.vertices is None else found.vertices
    return common_error(programs.Values(vertices, found.values), truth, radius, either_sign=True)
