"""The commands of the command line, one module each: HELP, add_options() and run()."""

from importlib import import_module
from types import ModuleType

# They stand in the order of the help.
COMMANDS = ("bake", "animate", "library", "tasks", "compare", "info", "list")


def modules() -> list[ModuleType]:
    """The commands' modules; none of them imports bpy before it runs."""
    return [import_module(f".{name}", __name__) for name in COMMANDS]
