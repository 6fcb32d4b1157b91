"""`blender -c paradesc …`: the command line of an enabled add-on, since Blender 4.2."""

from .main import main

classes = ()
# The handle that Blender returned for the command, which is needed to remove the command.
handles: list[object] = []


def register() -> None:
    """Adds the command, if this Blender has commands."""
    import bpy

    if hasattr(bpy.utils, "register_cli_command"):
        handles.append(bpy.utils.register_cli_command("paradesc", main))


def unregister() -> None:
    """Removes the command."""
    import bpy

    while handles:
        bpy.utils.unregister_cli_command(handles.pop())
