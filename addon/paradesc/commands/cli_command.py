"""`blender -c paradesc …`: the command line of an enabled add-on, since Blender 4.2."""

from .main import main

classes = ()
# What Blender gave for the command, to take it back by.
handles: list[object] = []


def register() -> None:
    """Makes the command known to a Blender that knows commands."""
    import bpy

    if hasattr(bpy.utils, "register_cli_command"):
        handles.append(bpy.utils.register_cli_command("paradesc", main))


def unregister() -> None:
    """Takes it away."""
    import bpy

    while handles:
        bpy.utils.unregister_cli_command(handles.pop())
