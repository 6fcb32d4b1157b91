"""Times an image over a mesh's UV map and its gutter, by this add-on and by another version of it in turns.

    PYTHONPATH=addon python tests/bench/uv_images.py human.obj
    PYTHONPATH=addon python tests/bench/uv_images.py human.obj --other ../before/addon

Values are those of a wave, linear on triangles. Each turn is a process of its own. The other add-on may be so old that
all its modules are in one folder and Python draws the images. All pixels are compared.
"""

import argparse
import hashlib
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from types import SimpleNamespace

import numpy as np

TURN = """
import sys
sys.path[:0] = sys.argv[1:3]
import uv_images
uv_images.turn(sys.argv[3], int(sys.argv[4]))
"""


def turn(inputs: str, texels: int) -> None:
    """Draws once with the add-on that is found first; prints seconds of both steps and a digest of the pixels."""
    with np.load(inputs) as file:
        uvs, vertices, values = file["uvs"], file["vertices"], file["values"]
    draw, fill = steps_of_this_version(uvs, vertices, values)
    times = [now()]
    image = draw(texels)
    times.append(now())
    filled = fill(image)
    times.append(now())
    digest = hashlib.sha256(image.tobytes() + filled.tobytes()).hexdigest()
    sys.stdout.write(" ".join(map(str, np.diff(times, axis=0).ravel())) + f" {digest}\n")


def now() -> tuple[float, float]:
    """Seconds by the clock, and of all cores."""
    return time.perf_counter(), time.process_time()


def steps_of_this_version(uvs, vertices, values):
    """The two steps as functions, one of the number of texels and one of the image."""
    try:
        from paradesc import bridge
        from paradesc.files import maps

        bridge.draw_uv_image(uvs[:1], vertices[:1], values, 1)  # loads the library
        return (
            lambda texels: bridge.draw_uv_image(uvs, vertices, values, texels),
            lambda image: bridge.fill_gutter(image, maps.GUTTER),
        )
    except ImportError:
        from paradesc import maps

        results = SimpleNamespace(values={"wave": values}, maps={})
        baked = SimpleNamespace(results=results, arrays=SimpleNamespace(triangle_vertices=vertices))
        return lambda texels: maps.drawn(maps.Raster(uvs, texels), baked, "wave"), maps.fill_gutter


def write_inputs(mesh: Path, path: Path) -> None:
    """Writes what is drawn as a .npz file."""
    from sampling_choices import read_obj

    arrays = read_obj(mesh)
    wave = np.sin(10 * arrays.positions @ np.float32([1.0, 0.7, 0.4])).astype(np.float32)
    vertices = arrays.triangle_vertices
    np.savez(path, uvs=arrays.corner_uvs[arrays.triangle_corners], vertices=vertices, values=wave)


def main() -> None:
    """Prints the medians of both steps, and whether the pixels are the same."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("mesh", type=Path)
    parser.add_argument("--texels", type=int, default=4096)
    parser.add_argument("--turns", type=int, default=5)
    parser.add_argument("--other", metavar="FOLDER", help="another folder addon/, to be timed in turns with this one")
    arguments = parser.parse_args()
    here = Path(__file__).resolve()
    folders = {"this": here.parents[2] / "addon"}
    if arguments.other:
        folders["other"] = Path(arguments.other).resolve()
    times: dict[str, list] = {name: [] for name in folders}
    digests = set()
    with tempfile.TemporaryDirectory() as folder:
        inputs = Path(folder) / "inputs.npz"
        write_inputs(arguments.mesh, inputs)
        for _ in range(arguments.turns):
            for name, addon in folders.items():
                command = [sys.executable, "-c", TURN, addon, here.parent, inputs, str(arguments.texels)]
                environment = {**os.environ, "PYTHONPATH": ""}
                printed = subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True, env=environment).stdout
                *seconds, digest = printed.split()
                times[name].append([float(one) for one in seconds])
                digests.add(digest)
    for name, rows in times.items():
        image, image_cores, gutter, gutter_cores = np.median(rows, axis=0)
        line = f"{name}: image {image:.2f} s ({image_cores:.2f} s of all cores)"
        line += f", gutter {gutter:.2f} s ({gutter_cores:.2f} s)"
        sys.stdout.write(line + "\n")
    sys.stdout.write("The pixels are the same.\n" if len(digests) == 1 else "The pixels DIFFER.\n")


if __name__ == "__main__":
    main()
