"""Takes meshes and options as Python users have them, and gives results as arrays. Never imports bpy."""
