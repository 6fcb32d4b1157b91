"""What a bake leaves on a mesh made visible: colors, materials, channels, overlay."""
