"""The meshes of an object that can be measured, with their labels in menus. Never imports bpy."""

ORIGINAL, DEFORMED, EVALUATED, AUTOMATIC = "original", "deformed", "evaluated", "auto"
SOURCES = (
    (ORIGINAL, "Base Mesh", "The object's own mesh, before shape keys and modifiers"),
    (DEFORMED, "Deformed", "The same mesh as armatures, shape keys, lattices, cloth and similar modifiers deform it"),
    (
        EVALUATED,
        "With Modifiers",
        "The mesh after all modifiers; all of its vertices get values, and so do the object's own",
    ),
)
NAMES = tuple(name for name, _, _ in SOURCES)
# The source of a single bake in a window unless another one is chosen. Files keep the numbers of the choices.
AUTOMATIC_SOURCE = (AUTOMATIC, "As Shown", "With modifiers and shape keys, as the viewport shows it")


def in_words(*names: str) -> str:
    """Sources in a sentence: each by its label in the panel and its word on the command line."""
    labels = {name: label for name, label, _ in SOURCES}
    return " or ".join(f"{labels[name]} ({name})" for name in names)
