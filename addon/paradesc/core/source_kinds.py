"""Names the meshes of an object that can be measured, and what menus say about them. Never imports bpy."""

SOURCES = (
    ("original", "Original", "The object's own mesh, before shape keys and modifiers"),
    ("deformed", "Deformed", "The same mesh as armature, shape keys, lattice, cloth and their like move it"),
    ("evaluated", "Evaluated", "What all modifiers make; results go to the original vertices where these remain"),
)
NAMES = tuple(name for name, _, _ in SOURCES)
