"""The add-on that is drawn: that of this folder, or of the zip that PARADESC_ZIP names, which is installed first.

It has to be imported before whatever imports the add-on.
"""

import os
import sys
from pathlib import Path

import bpy

ZIP = os.environ.get("PARADESC_ZIP")
if ZIP:
    bpy.ops.preferences.addon_install(filepath=ZIP)
else:
    sys.path.insert(0, str(Path(__file__).resolve().parents[2]))


def enable() -> None:
    """Enables it as under Preferences > Add-ons, or registers what no preferences know of."""
    if ZIP:
        bpy.ops.preferences.addon_enable(module="paradesc")
        return
    import paradesc

    paradesc.register()
