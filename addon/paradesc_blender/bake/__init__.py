"""Bakes objects in Blender, one after another."""
