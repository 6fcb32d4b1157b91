"""Bakes several meshes, with one worker after another, and writes everything at the end."""

from dataclasses import dataclass, field
from functools import partial
from pathlib import Path

import bpy

from paradesc.bridge import ParadescError, abi
from paradesc.core import job
from paradesc.files import bake_files, tile_names

from ..scene import delivery, mesh_io, modes, source_meshes, surface_maps, targets
from ..settings import looks, properties
from .pieces import ObjectKey, Piece, Pieces, Work, computed, file_words, key_of

IMAGE_STEM, BUFFERS_NAME = "paradesc", "paradesc_buffers"


@dataclass
class MeshBake(Piece):
    """One mesh of a bake: the object that stands for it, and the results."""

    sharing: list[ObjectKey]  # all chosen objects with this mesh
    files: bake_files.Files | None = None
    reading: source_meshes.Reading | None = None
    placed: list[Path] = field(default_factory=list)  # files that were written

    def drop(self) -> None:
        """Forgets the results, and takes away the files that lie aside."""
        super().drop()
        if self.files is not None:
            self.files.discard()


class Batch(Pieces):
    """Runs the bake operator step by step. Only the computation itself leaves the main thread."""

    def __init__(self, context: bpy.types.Context) -> None:
        """Takes the settings as they are now, and the chosen objects; raises if nothing can be computed."""
        group = context.scene.paradesc
        maps, source = surface_maps.MapChoice(material=group.material_maps), context.scene.paradesc_animation.source
        self.write_attributes = group.write_attributes
        self.request = targets.ReadRequest(
            group.shape_key, maps, source, group.write_buffers, placing=self.write_attributes
        )
        self.settings = properties.job_settings(group)
        job.check_descriptors(self.settings.descriptors)
        shared = targets.by_mesh(targets.chosen(context))
        super().__init__([MeshBake(key_of(objects[0]), [key_of(item) for item in objects]) for objects in shared])
        self.places = file_places(group, [piece.key for piece in self.pieces])

    def work_on(self, piece: MeshBake) -> Work:
        """Reads a mesh and computes; what becomes files lies aside then."""
        target = piece.target()
        if self.write_attributes:
            mesh_io.check_writable(target)
        read = targets.read(target, self.settings, self.request)
        piece.reading, piece.notes, piece.warnings, arrays = read.reading, read.notes, read.warnings, read.measured
        sharing = [item for item in map(bpy.data.objects.get, piece.sharing) if item]
        piece.notes += targets.shared_note(sharing, self.settings.space, read.reading.source)
        image, buffers = self.places[self.current]
        piece.files = bake_files.Files(target.name, mesh_io.world_matrix(target), image, buffers)
        bake_files.check(piece.files, arrays, self.settings.backend)
        piece.results = yield from computed(partial(bake_files.run, piece.files, arrays, self.settings))
        piece.results.warnings += [*piece.results.facet_notes(), *piece.warnings]
        piece.warnings = piece.results.warnings
        piece.notes += [*piece.results.notes, *piece.results.unused_notes()]
        piece.results.notes = list(piece.notes)

    def close(self) -> None:
        """Cancels the remaining work, waits for it, and removes files that are still aside. Safe to call again."""
        super().close()
        for piece in self.pieces:
            if piece.files is not None:
                piece.files.discard()

    def finish(self, context: bpy.types.Context) -> None:
        """Writes the results of every mesh in the scene's colors; object mode lasts that long."""
        self.look = looks.scene_look(context.scene)
        if context.scene.paradesc_looks.same_scale:
            self.look = job.with_one_scale(self.look, [piece.results for piece in self.written])
        if self.written:
            properties.show_radius(context.scene.paradesc, self.written[0].results.settings)
        with modes.object_mode():
            for piece in self.written:
                with self.attempt(piece):
                    self.write(piece)

    def write(self, piece: MeshBake) -> None:
        """Moves one mesh's files to their places, then writes its attributes. If the files fail, nothing is written."""
        target = piece.target()
        try:
            piece.placed = piece.files.commit()
        except OSError as error:
            sentence = f"A file cannot be moved to its place ({error.strerror or error}): {error.filename}."
            raise ParadescError(abi.STATUS_INVALID_OPERATION, sentence) from error
        if self.write_attributes:
            piece.results.look = self.look
            piece.notes += delivery.deliver(target, piece.results, piece.reading)


# ---- Files


def file_places(group: bpy.types.PropertyGroup, keys: list[ObjectKey]) -> list[tuple[Path | None, Path | None]]:
    """The paths of each object's image and buffer folder. With several objects, their names are part of the paths."""
    image = whole_path(group.image_path, "image", IMAGE_STEM) if group.write_image else None
    buffers = whole_path(group.buffers_path, "folder", BUFFERS_NAME) if group.write_buffers else None
    if image is not None:
        image = image.with_suffix("") if image.suffix.lower() in (".exr", ".png") else image
    places = []
    for word in file_words(keys) if len(keys) > 1 else [""]:
        own = image and image.with_name(image.name + group.image_format)
        places.append(
            (
                own and (tile_names.with_word(own, word) if word else own),
                buffers and (buffers.with_name(f"{buffers.name}_{word}") if word else buffers),
            )
        )
    return places


def whole_path(text: str, what: str, name: str) -> Path:
    """The absolute path for one of the panel, where // is the .blend's folder. An image folder gets the name added."""
    if not text.strip():
        raise bake_files.refuse(f"The {what} has no path; give one under Output.")
    if text.startswith("//") and not bpy.data.filepath:
        raise bake_files.refuse(f"Save the .blend first, or give the {what} a whole path: // stands for its folder.")
    path = Path(bpy.path.abspath(text))
    if what == "image" and (text.endswith(("/", "\\")) or path.is_dir()):
        path = path / name
    return path
