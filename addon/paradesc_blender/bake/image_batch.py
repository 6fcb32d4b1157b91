"""Bakes textures of several meshes, or of pairs of them, one worker after another, and keeps all at the end."""

import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path

import bpy

from paradesc.bridge import InputError
from paradesc.core import job
from paradesc.core.color_maps import MASKS
from paradesc.files import image_files, marks
from paradesc.files.reading import ReadRequest, part_of
from paradesc.files.results import file_fault, write_whole

from ..scene import image_nodes, image_results, images, pairs, surface_maps, targets, uv_maps
from ..settings import looks, properties
from .pieces import ObjectKey, Piece, Pieces, Work, computed, find, key_of

# The native library's warning contains these words if it computed on another layout than the UV map.
LAID_OUT = "laid out afresh"


@dataclass
class TextureBake(Piece):
    """One mesh whose textures are baked, and the results."""

    sharing: list[ObjectKey]  # all chosen objects with this mesh
    highs: list[ObjectKey] = field(default_factory=list)  # the detailed meshes that are measured in place of its own
    stem: str = ""  # with which the names of its textures begin
    computed: image_files.Computed | None = None  # until all meshes are, if they share a range
    textures: image_files.Textures | None = None
    over: uv_maps.Over | None = None  # the UV map that they lie over
    seconds: float = 0.0  # how long that and the computation lasted
    told: list[str] = field(default_factory=list)  # the notes that the panel shows
    made: list[str] = field(default_factory=list)  # names of the files, or of the images in the .blend
    kept: image_results.ImageBake | None = None  # once its images are loaded, as the mesh keeps it
    materials: list[str] = field(default_factory=list)  # names of those that have the images now

    @property
    def owner(self) -> str:
        """The object as its textures name it."""
        return " of ".join(filter(None, self.key))


class ImageBatch(Pieces):
    """Runs the operator step by step. Only the computation itself leaves the main thread."""

    def __init__(self, context: bpy.types.Context, onto: bool = False) -> None:
        """Takes the settings as they are now, and the chosen objects; raises if nothing can be computed.

        onto: whether they are pairs, in which detailed meshes are measured over the UV map of a low-poly one.
        """
        group = context.scene.paradesc
        maps, source = surface_maps.MapChoice(material=group.material_maps), context.scene.paradesc_animation.source
        self.request = ReadRequest(group.shape_key, maps, source, placing=False)
        self.choice = image_files.Choice(
            group.texels, group.image_outside == "transparent", group.image_packed, looks.scene_look(context.scene)
        )
        self.to_material = group.image_to_material
        self.settings = self.choice.settings(properties.job_settings(group))
        job.check_descriptors(self.settings.descriptors)
        # An unsaved .blend has no folder: its images are packed into it.
        self.folder = Path(bpy.data.filepath).parent if bpy.data.filepath else None
        self.started = time.monotonic()
        self.cage = group.cage
        if onto:
            found = [([low], highs) for low, highs in pairs.chosen(context).items()]
        else:
            found = [(objects, []) for objects in targets.by_mesh(targets.chosen(context))]
        keys = (([*map(key_of, sharing)], [*map(key_of, highs)]) for sharing, highs in found)
        super().__init__([TextureBake(sharing[0], sharing, highs) for sharing, highs in keys])
        for piece in self.pieces:
            piece.stem = images.stem_of(piece.name, piece.owner)  # two objects may get the same
        # With one scale for several meshes none is drawn before all are computed.
        self.rounds = 2 if context.scene.paradesc_looks.same_scale and len(self.pieces) > 1 else 1
        self.round = 1

    @property
    def fraction(self) -> float:
        """The finished share of all the work."""
        return (self.round - 1 + super().fraction) / self.rounds

    def work(self) -> Work:
        """Processes all meshes, twice if they share a scale: drawing then begins once all are measured."""
        yield from super().work()
        measured = [results for piece in self.pieces if piece.computed is not None for results in piece.computed.found]
        if self.rounds > 1 and measured:
            self.choice = replace(self.choice, look=job.with_one_scale(self.choice.look, measured))
            self.round, self.current = self.rounds, 0
            yield from super().work()

    def work_on(self, piece: TextureBake) -> Work:
        """Reads a mesh and computes its textures, or draws those that were computed in the first round."""
        if piece.failure:
            return
        begun = time.monotonic()
        drawing = piece.computed and partial(image_files.packed, piece.computed, self.choice)
        made = yield from computed(drawing or self.measuring(piece))
        piece.seconds += time.monotonic() - begun
        if self.round < self.rounds:
            piece.computed = made
            return
        piece.textures, piece.computed = made, None
        found = piece.textures.results
        # On the processor the map that is measured over limits nothing.
        harmless = [line for line in found.warnings if LAID_OUT in line and found.backend == "cpu"]
        piece.notes += [*found.notes, *found.unused_notes(), *harmless]
        others = [line for line in found.warnings if line not in harmless]
        piece.warnings = [*others, *found.facet_notes(), *piece.warnings]

    def measuring(self, piece: TextureBake) -> Callable[..., object]:
        """Reads a mesh; returns the work that measures it."""
        target = find(piece.key)
        fault = image_nodes.fault(target) if self.to_material else ""
        if not fault and self.folder is not None:
            fault = file_fault(self.folder / f"{piece.stem}.png")
        if fault:
            raise InputError(fault)
        own = replace(self.request, maps=surface_maps.MapChoice()) if piece.highs else self.request
        read, piece.over = uv_maps.read_over(target, self.settings, own)
        mesh, piece.told = read.measured, [piece.over.note] if piece.over.note else []
        piece.notes, piece.warnings = [*read.notes, *piece.told], read.warnings
        if piece.highs:
            highs = [(high, targets.read(high, self.settings, self.request)) for high in map(find, piece.highs)]
            piece.notes += [note for _, one in highs for note in one.notes]
            piece.warnings = [line for _, one in highs for line in one.warnings]
            mesh = image_files.Onto(part_of(target, read), [part_of(*one) for one in highs], self.cage)
        run = image_files.run if self.rounds == 1 else image_files.computed
        return partial(run, piece.stem, mesh, self.settings, self.choice)

    def close(self) -> None:
        """Cancels the remaining work, waits for it, and removes new UV maps that no image uses. Safe to call again."""
        super().close()
        for piece in self.pieces:
            if piece.over is not None and piece.over.made and piece.kept is None:
                with self.attempt(piece):
                    target, name = find(piece.key), piece.over.name
                    kept = (other for other in self.pieces if other.kept is not None and other.over.name == name)
                    if all(find(other.key).data != target.data for other in kept):
                        uv_maps.remove(target, name)
                piece.over = None

    def finish(self) -> None:
        """Keeps the textures of every mesh as files and images, and puts them into materials on request."""
        if self.written:
            properties.show_radius(bpy.context.scene.paradesc, self.written[0].textures.results.settings)
        for piece in self.written:
            with self.attempt(piece):
                self.write(piece)

    def write(self, piece: TextureBake) -> None:
        """Keeps one mesh's textures."""
        target, results, made = find(piece.key), piece.textures.results, piece.textures.by_name()
        loaded = [self.loaded(piece, name, textures) for name, textures in made.items()]
        holds = [textures[0].holds for textures in made.values()]
        seen = enumerate(zip(holds, piece.textures.extremes(), strict=True))
        piece.kept = image_results.ImageBake(
            names=[image.name for image in loaded],
            holds=[",".join(names) for names in holds],
            size=self.choice.size,
            seconds=piece.seconds,
            uv_map=piece.over.name,
            cage=0.0 if results.transfer is None else results.transfer.cage,
            notes="\n".join(piece.told),
            warnings="\n".join(piece.warnings),
            percent=100 * results.radius / results.mesh_report["diagonal"],
            drawn={str(place): shares for place, (names, shares) in seen if MASKS.issuperset(names)},
        )
        if self.to_material:
            layer = target.data.uv_layers.get(piece.over.name)
            # Materials that name no map would render another one.
            uv_map = piece.over.name if layer is not None and not layer.active_render else ""
            rows = zip(loaded, holds, strict=True)
            self.add_to_materials(piece, [image_nodes.Texture(*row, uv_map, piece.over.repeats) for row in rows])
        image_results.keep(target.data, piece.kept)

    def add_to_materials(self, piece: TextureBake, found: list[image_nodes.Texture]) -> None:
        """Adds textures to the material of each object with this mesh, which need not be the same."""
        for target in map(find, piece.sharing):
            fault = image_nodes.fault(target)
            if fault:
                piece.notes.append(fault)
                continue
            piece.materials.append(image_nodes.add_to_material(target, found, piece.textures.most_telling()).name)

    def loaded(self, piece: TextureBake, name: str, textures: list[image_files.Texture]) -> bpy.types.Image:
        """Writes and loads the file of a texture, or those of its tiles; without a folder they are packed instead.

        They get the first name that is free, or that of the same object's earlier, unchanged bake.
        """
        owner = {"blend": Path(bpy.data.filepath).name, "object": piece.owner}
        tiles = {texture.tile: marks.marked(texture.content, owner) for texture in textures}
        place = images.free_name(self.folder, piece.stem, name.removeprefix(f"{piece.stem}_"), owner)
        if place != name:
            piece.told.append(
                f'"{name}" is not the image that a bake of "{piece.name}" made, or was changed, and is kept; the '
                f'texture is "{place}".'
            )
            piece.notes.append(piece.told[-1])
        names = [replace(texture, name=place).file_name for texture in textures]
        piece.made += names
        if self.folder is None:
            return images.from_memory(place, tiles, owner["object"])
        for own, content in zip(map(self.folder.joinpath, names), tiles.values(), strict=True):
            write_whole(own, content, Path.write_bytes)
        return images.from_disk(self.folder / f"{place}.png", list(tiles), owner["object"])
