"""The add-on as users install it: in the add-ons folder, or as an extension."""

import ast
import os
import re
import subprocess
import sys

import pytest

from shapes import ADDON

bpy = pytest.importorskip("bpy", reason="needs Blender")

USE = """
import bpy, sys
assert bpy.ops.preferences.addon_enable(module={module!r}) == {{'FINISHED'}}
bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
bpy.ops.mesh.primitive_torus_add(generate_uvs=True)
bpy.context.scene.paradesc.backend = 'software'
assert bpy.ops.paradesc.bake() == {{'FINISHED'}}
assert 'mean_curvature' in bpy.context.active_object.data.attributes
assert bpy.ops.preferences.addon_disable(module={module!r}) == {{'FINISHED'}}
assert not hasattr(bpy.types.Scene, 'paradesc')
print('used and disabled')
"""


def run_with(folder, variable, module, tmp_path):
    """Uses the add-on from a folder of links to it, in a process of its own."""
    folder.mkdir(parents=True)
    (folder / "paradesc").symlink_to(ADDON / "paradesc")
    script = tmp_path / "use.py"
    script.write_text(USE.format(module=module))
    if bpy.app.binary_path:
        words = [bpy.app.binary_path, "-b", "--factory-startup", "--python-exit-code", "1", "-P", script]
    else:
        words = [sys.executable, script]
    environment = {**os.environ, variable: str(tmp_path / "user")}
    environment.pop("PYTHONPATH", None)
    process = subprocess.run(
        list(map(str, words)), env=environment, capture_output=True, text=True, timeout=300, check=False
    )
    assert process.returncode == 0, process.stdout + process.stderr
    assert "used and disabled" in process.stdout
    assert "Traceback" not in process.stdout + process.stderr


def test_addon_folder_is_enough(tmp_path):
    run_with(tmp_path / "user" / "addons", "BLENDER_USER_SCRIPTS", "paradesc", tmp_path)


@pytest.mark.skipif(bpy.app.version < (4, 2, 0), reason="extensions came with Blender 4.2")
def test_extension_folder_is_enough(tmp_path):
    module = "bl_ext.user_default.paradesc"
    run_with(tmp_path / "user" / "user_default", "BLENDER_USER_EXTENSIONS", module, tmp_path)


def test_manifest_and_bl_info_agree():
    tree = ast.parse((ADDON / "paradesc" / "__init__.py").read_text())
    assigned = {
        node.targets[0].id: ast.literal_eval(node.value)
        for node in tree.body
        if isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Name)
    }
    manifest = (ADDON / "paradesc" / "blender_manifest.toml").read_text()
    version = re.search(r'^version = "(.*)"', manifest, re.M).group(1)
    assert version == assigned["__version__"] == ".".join(map(str, assigned["bl_info"]["version"]))
    assert re.search(r'^name = "(.*)"', manifest, re.M).group(1) == assigned["bl_info"]["name"]


def test_manifest_tagline_fits_the_platform():
    manifest = (ADDON / "paradesc" / "blender_manifest.toml").read_text()
    tagline = re.search(r'^tagline = "(.*)"', manifest, re.M).group(1)
    assert len(tagline) <= 64
    assert tagline[-1].isalnum()
