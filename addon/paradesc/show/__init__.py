"""Makes visible what a bake leaves on a mesh: colors, materials, channels, overlay."""
