"""`blender -c paradesc …`: the command line of an enabled add-on, since Blender 4.2, with access to the scene."""

import bpy

from paradesc.commands.common import BLENDER
from paradesc.commands.main import main

from .source import SceneSource

classes = ()
# The handle that Blender returned for the command, which is needed to remove the command.
handles: list[object] = []


def register() -> None:
    """Lets commands read the scene by this add-on, and adds the command, if this Blender has commands."""
    BLENDER.append(SceneSource)
    if hasattr(bpy.utils, "register_cli_command"):
        handles.append(bpy.utils.register_cli_command("paradesc", main))


def unregister() -> None:
    """Removes both."""
    while SceneSource in BLENDER:
        BLENDER.remove(SceneSource)
    while handles:
        bpy.utils.unregister_cli_command(handles.pop())
