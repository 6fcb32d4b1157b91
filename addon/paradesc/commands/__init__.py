"""The commands of the command line, a module each: add_command() declares its options, run() does it."""

from importlib import import_module
from types import ModuleType

# In the order of the help.
COMMANDS = ("bake", "animate", "compare", "info", "list")


def modules() -> list[ModuleType]:
    """The commands' modules; none of them imports bpy before it runs."""
    return [import_module(f".{name}", __name__) for name in COMMANDS]
