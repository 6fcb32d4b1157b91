"""Baking of objects in Blender, one after another."""
