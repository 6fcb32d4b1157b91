"""Draws the panels of the sidebar from what the other folders offer."""
