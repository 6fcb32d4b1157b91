"""Names the meshes of an object that can be measured, and what menus say about them. Never imports bpy."""

ORIGINAL, DEFORMED, EVALUATED, AUTOMATIC = "original", "deformed", "evaluated", "auto"
SOURCES = (
    (ORIGINAL, "Base Mesh", "The object's own mesh, before shape keys and modifiers"),
    (DEFORMED, "Deformed", "The same mesh as armature, shape keys, lattice, cloth and their like move it"),
    (
        EVALUATED,
        "With Modifiers",
        "What all modifiers make of it; all of its vertices get values, and so do the object's own",
    ),
)
NAMES = tuple(name for name, _, _ in SOURCES)
# What a single bake in a window measures unless another source is chosen. Files keep the numbers of the choices.
AUTOMATIC_SOURCE = (AUTOMATIC, "As Shown", "With modifiers and shape keys where the viewport shows any")


def in_words(*names: str) -> str:
    """Sources as sentences name them: by the label that the panel has, and the word that the command line has."""
    labels = {name: label for name, label, _ in SOURCES}
    return " or ".join(f"{labels[name]} ({name})" for name in names)
