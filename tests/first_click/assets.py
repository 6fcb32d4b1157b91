"""The assets of the first click: real ones of shared/meshes beside the checkout, and those that the project makes."""

import atexit
import functools
import sys
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import bpy

import paradesc_blender

ROOT = Path(__file__).resolve().parents[2]
MESHES = ROOT.parent / "shared" / "meshes"
sys.path.append(str(ROOT / "blend_samples"))
import models  # noqa: E402


@dataclass(frozen=True)
class Asset:
    """An asset that is imported and clicked on."""

    name: str
    mask: str  # the one that suits it
    hard: bool  # whether it has flat faces, which have to stay black
    file: str = ""  # in shared/meshes; else one of the made ones

    @property
    def missing(self) -> str:
        """One sentence about the file if it is not there."""
        path = MESHES / self.file
        return f"{self.name}: there is no {path}, so it was left out." if self.file and not path.is_file() else ""

    def add(self) -> bpy.types.Object:
        """A new file with the asset in it, chosen as Blender leaves it after the import, and untouched settings."""
        bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
        if not hasattr(bpy.types.Scene, "paradesc"):
            paradesc_blender.register()
        if self.file:
            importer(self.file)(filepath=str(MESHES / self.file))
        else:
            with bpy.data.libraries.load(model_file(self.name)) as (_, taken):
                taken.objects = [self.name]
            bpy.context.collection.objects.link(taken.objects[0])
            bpy.context.view_layer.objects.active = taken.objects[0]
            taken.objects[0].select_set(True)
        return next(item for item in bpy.context.selected_objects if item.type == "MESH")


@functools.cache
def model_file(name: str) -> str:
    """A file with one of the models, which takes up to some seconds to make and is wanted in several scenes."""
    folder = tempfile.TemporaryDirectory()
    atexit.register(folder.cleanup)
    made = models.MODELS[name]()
    path = str(Path(folder.name) / f"{name}.blend")
    bpy.data.libraries.write(path, {made})
    bpy.data.objects.remove(made)
    return path


def importer(file: str) -> Callable[..., object]:
    """Blender's operator for a file."""
    return bpy.ops.wm.obj_import if file.endswith(".obj") else bpy.ops.import_scene.gltf


def row(name: str, mask: str, hard: bool = False, file: str = "") -> tuple[str, Asset]:
    """One asset under its name."""
    return name, Asset(name, mask, hard, file)


ASSETS = dict(
    (
        row("beast", "cavity", file="beast.obj"),
        row("human", "cavity", file="human.obj"),
        row("fox", "cavity", file="fox.glb"),
        row("pirate", "cavity", file="pirate.obj"),
        row("barracks", "edge_wear", hard=True, file="barracks.obj"),
        row("rocker-arm", "edge_wear", hard=True, file="rocker-arm.obj"),
        row("fandisk", "edge_wear", hard=True, file="fandisk.obj"),
        row("crate", "edge_wear", hard=True),
        row("stone", "cavity"),
        row("car", "edge_wear", hard=True),
        row("creature", "cavity"),
        row("gear", "edge_wear", hard=True),
        row("vase", "cavity"),
        row("column", "cavity"),
        row("helmet", "edge_wear"),
        row("rock", "cavity"),
        row("house", "edge_wear", hard=True),
    )
)
