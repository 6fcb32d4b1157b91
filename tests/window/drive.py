"""Runs one group of an artist's tasks in Blender's window, for drive.sh: drive.py -- GROUP FOLDER."""

import importlib
import json
import sys
import time
import traceback
from collections.abc import Iterator
from pathlib import Path

import bpy
import numpy as np

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent / "first_click")]
# Seconds between two turns of the event loop.
TURN = 0.02


class Run:
    """The place of a group's pictures, and its findings."""

    def __init__(self, group: str, folder: Path) -> None:
        """Begins anew."""
        self.group, self.folder, self.number = group, folder, 0
        self.found = folder / f"{group}.jsonl"
        self.found.write_text("")

    def saw(self, point: str, text: str, good: bool | None = None, picture: str = "") -> None:
        """Adds what is now at one point; good: what a check in the script says, if there is one."""
        row = {"point": point, "text": text, "good": None if good is None else bool(good), "picture": picture, "group": self.group}
        with self.found.open("a") as file:
            file.write(json.dumps(row) + "\n")
        sys.stdout.write(f"{point} {good} {text}\n")
        sys.stdout.flush()

    def picture(self, name: str, kind: str = "") -> Iterator[str]:
        """Takes a picture, of the window or of one region; gives the name of its file."""
        self.number += 1
        file = f"{self.group}_{self.number:02}_{name}.png"
        yield from person.picture(self.folder / file, kind)
        return file

    def tried(self, point: str, task: Iterator[None]) -> Iterator[None]:
        """Does a task; if it fails, that is what was found, and the next ones go on."""
        start = time.monotonic()
        try:
            yield from task
        except Exception as error:  # noqa: BLE001 (whatever it is, it is a finding)
            traceback.print_exc()
            file = yield from self.picture("failed")
            self.saw(point, f"the task ended with {type(error).__name__}: {error}", False, file)
        sys.stdout.write(f"{point}: {time.monotonic() - start:.0f} s\n")


def install(folder: Path) -> None:
    """Installs the zip once, and enables the add-on."""
    if not (folder / "scripts" / "addons" / "paradesc").is_dir():
        bpy.ops.preferences.addon_install(filepath=str(folder / "paradesc.zip"))
    bpy.ops.preferences.addon_enable(module="paradesc_blender")


def steps_of(run: Run) -> Iterator[None]:
    """The tasks of the group; that its module cannot be read is found in the first turn, so that Blender ends."""
    yield from importlib.import_module(f"tasks_{run.group}").steps(run)


def begin(group: str, folder: Path) -> None:
    """Takes a step at every turn; Blender ends after the last one."""
    run = Run(group, folder)
    steps = steps_of(run)

    def turn() -> float | None:
        try:
            next(steps)
        except StopIteration:
            sys.stdout.write(f"{group}: done\n")
            bpy.ops.wm.quit_blender()
            return None
        except Exception:  # noqa: BLE001 (Blender has to end)
            traceback.print_exc()
            bpy.ops.wm.quit_blender()
            return None
        return TURN

    bpy.app.timers.register(turn, first_interval=1.0, persistent=True)


if not hasattr(np, "bool"):
    np.bool = bool  # which the glTF importer of Debian's Blender 3.4 asks Debian's newer numpy for
words = sys.argv[sys.argv.index("--") + 1 :]
bpy.context.preferences.view.show_splash = False
bpy.context.preferences.view.smooth_view = 0
install(Path(words[1]))
import person  # noqa: E402 (needs the add-on)

begin(words[0], Path(words[1]))
