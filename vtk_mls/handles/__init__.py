"""Handles: the places that the map carries, and where it carries them."""
