"""The steps of a new user with files of every kind, and with a library on Dask, without Blender.

Run in an empty folder by the Python of an environment with paradesc[farms], and with trimesh, which makes files.
"""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import trimesh
from distributed import LocalCluster

PROGRAM = Path(sys.executable).with_name("paradesc")
SUFFIXES = ("stl", "off", "glb", "gltf", "obj", "ply")


def run(*words: object, code: int = 0) -> dict:
    """The report of a command, which has to end with this code."""
    done = subprocess.run([PROGRAM, *map(str, words), "--json", "r.json"], capture_output=True, text=True, check=False)
    if done.returncode != code:
        sys.exit(f"paradesc {words} gave {done.returncode}: {done.stderr}")
    return json.loads(Path("r.json").read_text())


def make_files() -> None:
    """A ball of each kind, frames of it, a detailed one, and a library with a file that is broken."""
    ball = trimesh.creation.icosphere(3)
    for suffix in SUFFIXES:
        ball.export(f"ball.{suffix}")
    Path("assets/props").mkdir(parents=True)
    Path("frames").mkdir()
    for frame in (1, 2):
        grown = ball.copy()
        grown.apply_scale([1, 1, 1 + frame])
        grown.export(f"frames/ball_{frame:04}.ply")
    ball.export("assets/ball.ply")
    trimesh.creation.torus(1, 0.4).export("assets/props/torus.glb")
    Path("assets/broken.obj").write_text("v 0 0 0\nf 1 2 3\n")
    flat = trimesh.creation.icosphere(2)
    uv = 0.5 + flat.vertices[:, :2] / 4
    flat.visual = trimesh.visual.TextureVisuals(uv, trimesh.visual.material.PBRMaterial())
    flat.export("low.glb")


def check_commands() -> None:
    """Every command, on files of every kind."""
    for suffix in SUFFIXES:
        run("bake", f"ball.{suffix}", "--radius", 0.1, "--output", f"{suffix}.npz", "--output", f"{suffix}.vtp")
        np.testing.assert_allclose(np.load(f"{suffix}.npz")["mean_curvature"], 1, rtol=0.02)
        assert run("info", f"ball.{suffix}")["objects"][0]["vertices"] in (642, 3840)
    assert run("compare", "ball.off", "--radius", 0.1)["rows"][0]["mean_percent_ae"] < 1
    assert run("animate", "frames", "--radius", 0.1, "--cache", "cache")["objects"][0]["made"] == [1, 2]
    report = run(
        "bake", "low.glb", "--from-file", "ball.ply", "--preset", "curvature", "--map", "x.exr", "--texels", 64
    )
    assert report["objects"][0]["transfer"]["missed"] == 0


def check_library() -> None:
    """A library by processes of this machine and on Dask, to the same bytes."""
    made = [run("library", "assets", "--output", "own", code=5)]
    with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster:
        made.append(run("library", "assets", "--output", "dask", "--dask", cluster.scheduler_address, code=5))
    assert [(report["made"], len(report["failed"])) for report in made] == [(3, 1), (3, 1)]
    for path in Path("own").rglob("*.npz"):
        assert path.read_bytes() == Path("dask", *path.parts[1:]).read_bytes(), path


if __name__ == "__main__":
    make_files()
    check_commands()
    check_library()
    sys.stdout.write(f"paradesc[farms]: numpy {np.__version__}, trimesh {trimesh.__version__}\n")
