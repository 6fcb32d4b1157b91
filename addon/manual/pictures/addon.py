"""Enables the add-on: that of this folder, or of the zip that PARADESC_ZIP names, which is installed first.

It has to be imported before whatever imports the add-on's modules: Blender would load them again.
"""

import os
import sys
from pathlib import Path

import bpy

ZIP = os.environ.get("PARADESC_ZIP")
if ZIP:
    bpy.ops.preferences.addon_install(filepath=ZIP)
    bpy.ops.preferences.addon_enable(module="paradesc_blender")
else:
    sys.path.insert(0, str(Path(__file__).resolve().parents[2]))
    import paradesc_blender

    paradesc_blender.register()
