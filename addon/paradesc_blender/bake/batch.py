"""Bakes several meshes, with one worker after another, and writes all results at the end."""

from dataclasses import dataclass
from functools import partial

import bpy

from paradesc.core import job

from ..scene import delivery, mesh_io, modes, source_meshes, surface_maps, targets
from ..settings import looks, properties
from .pieces import ObjectKey, Piece, Pieces, Work, computed, find, key_of


@dataclass
class MeshBake(Piece):
    """One mesh of a bake: the object that stands for it, and the results."""

    sharing: list[ObjectKey]  # all chosen objects with this mesh
    reading: source_meshes.Reading | None = None


class Batch(Pieces):
    """Runs the bake operator step by step. Only the computation itself leaves the main thread."""

    def __init__(self, context: bpy.types.Context) -> None:
        """Takes the settings as they are now, and the chosen objects; raises if nothing can be computed."""
        group = context.scene.paradesc
        maps, source = surface_maps.MapChoice(material=group.material_maps), context.scene.paradesc_animation.source
        self.request = targets.ReadRequest(group.shape_key, maps, source, placing=True)
        self.settings = properties.job_settings(group)
        job.check_descriptors(self.settings.descriptors)
        shared = targets.by_mesh(targets.chosen(context))
        super().__init__([MeshBake(key_of(objects[0]), [key_of(item) for item in objects]) for objects in shared])

    def work_on(self, piece: MeshBake) -> Work:
        """Reads a mesh and computes."""
        target = find(piece.key)
        mesh_io.check_writable(target)
        read = targets.read(target, self.settings, self.request)
        piece.reading, piece.notes, piece.warnings, arrays = read.reading, read.notes, read.warnings, read.measured
        sharing = [item for item in map(bpy.data.objects.get, piece.sharing) if item]
        piece.notes += targets.shared_note(sharing, self.settings.space, read.reading.source)
        piece.results = yield from computed(partial(job.run, arrays, self.settings))
        piece.results.warnings += [*piece.results.facet_notes(), *piece.warnings]
        piece.warnings = piece.results.warnings
        piece.notes += [*piece.results.notes, *piece.results.unused_notes()]
        piece.results.notes = list(piece.notes)

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
        """Writes one mesh's attributes."""
        piece.results.look = self.look
        piece.notes += delivery.deliver(find(piece.key), piece.results, piece.reading)
