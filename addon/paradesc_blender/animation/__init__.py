"""Gives values to a mesh that moves: frames baked ahead, frames played back, and live values."""
