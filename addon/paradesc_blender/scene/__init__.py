"""Turns Blender's objects into arrays, and writes results to their meshes."""
