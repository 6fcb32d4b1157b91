"""Defines what people choose in Blender: a scene's settings, looks, presets, preferences."""
