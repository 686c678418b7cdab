"""Formats of images, meshes, displacement fields and control points."""
