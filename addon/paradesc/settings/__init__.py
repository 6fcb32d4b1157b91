"""What is chosen in Blender: a scene's settings, looks, presets, preferences."""
