"""Playback: shows frames of an object's cache as values and colors of its mesh, without computing.

For frames that the cache lacks, the nearest one is shown or a live session computes, as the scene says.
"""

import time
from dataclasses import replace
from pathlib import Path

import bpy

from paradesc.bridge import InputError
from paradesc.core import color_maps, legend
from paradesc.core.color_maps import AUTOMATIC, Look, ValueRange
from paradesc.core.corners import ATTRIBUTE
from paradesc.core.job import UNDEFINED_MASK, registry_row
from paradesc.files import cache

from ..scene import mesh_io, record
from ..settings import looks
from ..settings.animation import object_cache
from . import live, painting, surfaces

# These values have no colors.
EXTRAS = ("coverage", ATTRIBUTE, UNDEFINED_MASK)


class Player:
    """The playback state of one object, kept from frame to frame."""

    busy = computing = False  # nothing is computed beside the window

    def __init__(self) -> None:
        self.painter = painting.Painter()
        self.frame: cache.Frame | None = None
        self.shown: tuple[Path, int] | None = None  # the file, and when it was written
        self.whole: dict[str, ValueRange] = {}  # over all frames
        self.ranged: tuple[Path, Look] | None = None  # the folder and look that whole follows from
        self.seconds: dict[str, float] = {}
        self.scene_name = ""  # whose frame is shown
        self.note = ""  # for the panel
        self.edited = self.unsure = self.wrote = False  # as live sessions have them
        self.session: live.Session | None = None  # for frames that are not there

    def close(self) -> None:
        """Forgets everything."""
        if self.session is not None:
            self.session.close()
        self.session = self.frame = self.shown = None

    def refresh(
        self, target: bpy.types.Object, depsgraph: bpy.types.Depsgraph, scene: bpy.types.Scene, wait: bool = True
    ) -> bool:
        """Writes the values of the scene's frame to the object's mesh at once; False if nothing had to change."""
        if surfaces.evaluated_object(target, depsgraph) is None:  # for example in another scene
            return False
        self.scene_name = scene.name
        start = time.perf_counter()
        folder = object_cache(scene, target)
        path = self.find(folder, scene.frame_current)
        if path is None or (self.note and scene.paradesc_live.missing == "COMPUTE"):
            return self.compute(target, depsgraph, scene)
        fresh = self.read(path, target)
        scene_name = self.frame.other_scene(Path(bpy.data.filepath).name)
        if scene_name and not self.note:
            self.note = f'These frames were baked in "{scene_name}".'
        read = time.perf_counter()
        look = looks.scene_look(scene)
        wanted = (folder, replace(look, color_map=AUTOMATIC, ranges={}, levels=color_maps.Levels()))
        if wanted != self.ranged:
            self.ranged, self.whole = wanted, cache.locked_ranges({folder: self.frame.key}, wanted[1])
        ranges = painting.locked_ranges(scene.paradesc_live, look, self.shown_names(), self.found_range)
        changed = self.painter.paint(target, self.values(), ranges, fresh)
        if changed:
            painting.tag_written(target, depsgraph)
        if fresh:
            self.seconds = {"read": read - start, "write": time.perf_counter() - read}
        return changed

    def find(self, folder: Path, wanted: int) -> Path | None:
        """The file of the wanted frame, or of the nearest one (the earlier of two). The panel's note then says so."""
        found = cache.frame_path(folder, wanted)
        self.note = ""
        if found.is_file():
            return found
        there = cache.frames_in(folder)
        if not there:
            self.note = f'No frames in "{folder}".'
            return None
        nearest = min(there, key=lambda frame: (abs(frame - wanted), frame))
        self.note = f"Frame {wanted} is not in the cache: showing frame {nearest}."
        return there[nearest]

    def read(self, path: Path, target: bpy.types.Object) -> bool:
        """Reads the file; False if it is the one that was read last."""
        stamp = (path, path.stat().st_mtime_ns)
        fresh = stamp != self.shown or self.frame is None
        frame = cache.read_frame(path) if fresh else self.frame
        count = len(target.data.vertices)
        if frame.vertex_count != count:
            raise InputError(
                f'The frames in "{path.parent}" have {frame.vertex_count:,} vertices, but "{target.name}" has '
                f"{count:,}; bake them again, or play them on their own object."
            )
        mesh_io.check_writable(target)
        self.frame, self.shown = frame, stamp
        return fresh

    def compute(self, target: bpy.types.Object, depsgraph: bpy.types.Depsgraph, scene: bpy.types.Scene) -> bool:
        """Computes the values of a missing frame by a live session."""
        if scene.paradesc_live.missing != "COMPUTE":
            raise InputError(f"{self.note} Bake frames first, or let missing ones be computed.")
        if self.session is None:
            self.session = live.Session()
        self.note = f"Frame {scene.frame_current} is not in the cache: computed."
        self.shown = None
        changed = self.session.refresh(target, depsgraph, scene)
        self.seconds = self.session.seconds
        return changed

    def has_settings(self, _scene: bpy.types.Scene) -> bool:
        """True, because frames keep the settings by which they were baked."""
        return True

    def reveal(self, target: bpy.types.Object) -> None:
        """Makes the colors of the values the active ones of the mesh."""
        if self.frame is not None and self.shown is not None:
            self.painter.reveal(target.data, self.values())
        elif self.session is not None:
            self.session.reveal(target)

    def forget_ranges(self) -> None:
        """Makes the next use read the ranges over all frames again."""
        self.ranged = None

    def found_ranges(self, look: Look) -> dict[str, ValueRange]:
        """The range of each descriptor over all frames."""
        if self.frame is None:
            return {} if self.session is None else self.session.found_ranges(look)
        return {name: self.found_range(name, look) for name in self.shown_names()}

    def found_range(self, name: str, look: Look) -> ValueRange:
        """The range of one descriptor over all frames, or the one that the look fixes."""
        colors = {"map_name": color_maps.map_name(registry_row(name), look), "levels": look.levels}
        shown = replace(self.whole.get(name, ValueRange(0.0, 1.0, False)), **colors)
        low, high = look.ranges.get("", (shown.minimum, shown.maximum))
        return replace(shown, minimum=low, maximum=high)

    def shown_names(self) -> list[str]:
        """The names of the values that have colors."""
        return [name for name in self.frame.values if name not in EXTRAS]

    def values(self) -> painting.Values:
        """The frame in the form in which it is written to the mesh."""
        shown = {name: self.frame.values[name] for name in self.shown_names()}
        extras = {name: values for name, values in self.frame.values.items() if name in EXTRAS}
        return painting.Values(shown, extras, {}, self.drawing)

    def drawing(self, name: str, shown: ValueRange) -> dict[str, object]:
        """The facts about the colors of a value that a legend needs; the radius only if the frame's file has it."""
        info = self.frame.info
        settings, radii = info.get("settings"), info.get("radius")
        on = settings.get("map_descriptor", "") if isinstance(settings, dict) else ""
        radius = radii.get(name) if isinstance(radii, dict) else None
        known = {"radius": float(radius)} if isinstance(radius, (int, float)) else {}
        return {**record.drawing(shown), **known, "unit": legend.unit_of(name, str(on))}
