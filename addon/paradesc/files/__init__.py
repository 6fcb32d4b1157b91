"""Writes results to files and reads them back: arrays, meshes, images, frames. Never imports bpy."""
