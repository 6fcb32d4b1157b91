"""Runs the notebooks and the code of the gallery's page, and keeps what they print and draw.

    python addon/notebooks/make.py                    all: outputs into the .ipynb files, pictures into pictures/
    python addon/notebooks/make.py scales gallery     some of them
    python addon/notebooks/make.py --output FOLDER    leaves copies there, and these files as they are

Needs what `pip install paradesc[notebooks]` installs. Nothing has to be drawn on a screen.
"""

import argparse
import base64
import io
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

FOLDER = Path(__file__).resolve().parent
NOTEBOOKS = ("scales", "shape_index", "sequence")
GALLERY = "gallery"
SECONDS = 300  # that one cell may take


def main() -> None:
    """Makes what was asked for."""
    parser = argparse.ArgumentParser(description="Runs the notebooks and the code of the gallery's page.")
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"of {', '.join((*NOTEBOOKS, GALLERY))}; all without")
    parser.add_argument("--output", type=Path, default=FOLDER, help="the folder to write into")
    given = parser.parse_args()
    names = given.names or [*NOTEBOOKS, GALLERY]
    if unknown := set(names) - {*NOTEBOOKS, GALLERY}:
        parser.error(f"there is no {', '.join(sorted(unknown))}")
    given.output.mkdir(parents=True, exist_ok=True)
    for name in names:
        if name == GALLERY:
            draw_gallery(given.output / "pictures")
        else:
            write_notebook(executed(FOLDER / f"{name}.ipynb"), given.output / f"{name}.ipynb")
        print(f"{name} is made")


def environment(home: Path) -> dict[str, str]:
    """The variables for a process that draws: this checkout's package, no screen, and no files left behind."""
    found = dict(os.environ)
    found["PYTHONPATH"] = os.pathsep.join(filter(None, (str(FOLDER.parent), found.get("PYTHONPATH"))))
    found["IPYTHONDIR"] = found["MPLCONFIGDIR"] = str(home)
    found["PYVISTA_OFF_SCREEN"] = "true"
    if sys.platform == "linux":  # or VTK first looks for a screen, and says so
        found["VTK_DEFAULT_OPENGL_WINDOW"] = "vtkEGLRenderWindow"
    return found


# ---- Notebooks


def executed(path: Path) -> Any:
    """The notebook with the outputs of a whole run in an empty folder; raises CellExecutionError where a cell fails."""
    import nbformat
    from nbclient import NotebookClient

    notebook = nbformat.read(path, as_version=4)
    with tempfile.TemporaryDirectory() as folder:
        where = {"metadata": {"path": folder}}
        client = NotebookClient(notebook, timeout=SECONDS, record_timing=False, coalesce_streams=True, resources=where)
        client.create_kernel_manager()
        client.km.connection_file = str(Path(folder) / "kernel.json")
        if os.name == "posix":
            client.km.transport = "ipc"  # sockets in that folder instead of ports
        client.execute(env={**environment(Path(folder)), "MPLBACKEND": "module://matplotlib_inline.backend_inline"})
    return tidied(notebook)


def tidied(notebook: Any) -> Any:
    """Without what differs from run to run or from machine to machine; pictures are made small."""
    notebook.metadata.kernelspec = {"display_name": "Python 3", "language": "python", "name": "python3"}
    notebook.metadata.language_info = {"name": "python"}
    for cell in notebook.cells:
        cell.metadata = {}
        for output in cell.get("outputs", []):
            if picture := output.get("data", {}).get("image/png"):
                output.data = {"image/png": base64.b64encode(small_png(base64.b64decode(picture))).decode()}
                output.metadata = {}
    return notebook


def write_notebook(notebook: Any, path: Path) -> None:
    """Writes it as Jupyter does."""
    import nbformat

    nbformat.validate(notebook)
    nbformat.write(notebook, path)


def small_png(picture: bytes) -> bytes:
    """A PNG in 256 colors, a third as large: white and 255 more, mixed where there would be bands in smooth light."""
    from PIL import Image

    with Image.open(io.BytesIO(picture)) as image:
        colored = image.convert("RGB")
    palette = colored.quantize(255, method=Image.Quantize.MEDIANCUT)
    reduced = colored.quantize(palette=palette, dither=Image.Dither.FLOYDSTEINBERG)
    colors = [*reduced.getpalette(), *[255] * 3 * 256]
    reduced.putpalette([*colors[: 3 * 255], 255, 255, 255])
    reduced.paste(
        255, mask=colored.convert("L").point(lambda light: 255 * (light == 255))
    )  # the background stays white
    content = io.BytesIO()
    reduced.save(content, "PNG", optimize=True)
    return content.getvalue()


# ---- The gallery


def draw_gallery(folder: Path) -> None:
    """Every picture of the page, drawn by the code above it in a process of its own."""
    with tempfile.TemporaryDirectory() as made:
        words = [sys.executable, str(FOLDER / "gallery.py"), made]
        subprocess.run(words, env={**environment(Path(made)), "MPLBACKEND": "agg"}, check=True)
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir(parents=True)
        for path in sorted(Path(made).glob("*.png")):
            (folder / path.name).write_bytes(small_png(path.read_bytes()))


if __name__ == "__main__":
    main()
