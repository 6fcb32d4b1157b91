"""Blender's objects to arrays, and results to their meshes."""
