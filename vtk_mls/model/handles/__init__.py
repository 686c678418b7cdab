"""Handles: places in the undeformed space, and where the deformation moves them."""
