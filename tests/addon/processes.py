"""Runs Blender as another process with user folders of its own, so that it finds no add-ons or settings of the user."""

import os
import subprocess
import sys
from pathlib import Path

import bpy

USER_FOLDERS = ("config", "scripts", "extensions", "datafiles")


def script_words(script: Path) -> list[str]:
    """The words that run a script in a Blender like the one that tests: the program, or the Python module bpy."""
    if bpy.app.binary_path:
        return [bpy.app.binary_path, "-b", "--factory-startup", "--python-exit-code", "1", "-P", str(script), "--"]
    return [sys.executable, str(script), "--"]


def run_blender(words: list[object], folder: Path, timeout: int = 300) -> str:
    """Runs it with user folders below this one and without the sources on Python's path; gives its output."""
    environment = {**os.environ, "PARADESC_TEST_USER": str(folder)}
    environment.pop("PYTHONPATH", None)
    for name in USER_FOLDERS:
        (folder / name).mkdir(parents=True, exist_ok=True)
        environment[f"BLENDER_USER_{name.upper()}"] = str(folder / name)
    process = subprocess.run(
        list(map(str, words)),
        env=environment,
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        timeout=timeout,
        check=False,
    )
    said = process.stdout + process.stderr
    assert process.returncode == 0, said
    assert "Traceback" not in said, said
    return said
