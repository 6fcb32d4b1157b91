"""The panels of the sidebar, drawn from what the other folders offer."""
