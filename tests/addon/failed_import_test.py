"""If a module cannot be imported, enabling the add-on is one sentence, and it can be disabled again."""

import sys

import pytest

pytest.importorskip("bpy", reason="needs Blender")

from conftest import blender_program, completed, environment  # noqa: E402

SCRIPT = """
import sys
import bpy
import addon_utils


class Finder:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] == "numpy":
            raise {error}


for name in [name for name in sys.modules if name.partition(".")[0] == "numpy"]:
    del sys.modules[name]
sys.meta_path.insert(0, Finder())
assert addon_utils.enable("paradesc_blender") is not None
assert hasattr(bpy.types, "PARADESC_PT_failure")
assert not hasattr(bpy.types, "PARADESC_PT_bake")
addon_utils.disable("paradesc_blender")
assert not hasattr(bpy.types, "PARADESC_PT_failure")
print("disabled")
"""
WITHOUT_MODULE = """
sys.meta_path.pop(0)
assert addon_utils.enable("paradesc_blender") is not None
assert hasattr(bpy.types.Scene, "paradesc")
addon_utils.disable("paradesc_blender")
print("works again")
"""
ERRORS = {
    "ModuleNotFoundError(\"No module named 'numpy'\", name='numpy')": "sudo apt install python3-numpy",
    "ImportError('libblas.so.3: cannot open shared object file')": "libblas.so.3: cannot open shared object file",
    "ImportError()": "ImportError",
}


@pytest.mark.parametrize("error", ERRORS)
def test_what_cannot_be_imported_is_one_sentence_and_the_addon_can_be_disabled(error, tmp_path):
    program = blender_program()
    # Python's own bpy module has numpy loaded by then, which cannot be loaded twice in one process.
    script = SCRIPT.replace("{error}", error) + (WITHOUT_MODULE if program else "")
    words = [*program, "--python-exit-code", "1", "--python-expr"] if program else [sys.executable, "-c"]
    done = completed([*words, script], tmp_path, environment())
    assert done.returncode == 0, done.stderr
    assert "disabled" in done.stdout
    (sentence,) = [line for line in done.stderr.splitlines() if line.startswith("Paradesc ")]
    assert ERRORS[error] in sentence
    assert "Traceback" not in done.stdout + done.stderr
    assert ("works again" in done.stdout) == bool(program)
