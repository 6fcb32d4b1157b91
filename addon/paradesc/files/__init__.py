"""Results to files and back: arrays, meshes, images, frames on disk. Never imports bpy."""
