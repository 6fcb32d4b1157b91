"""Shows the results of a bake on a mesh: colors, materials, channels, overlay."""
