"""Affine maps, displacement fields, and chains of transforms."""
