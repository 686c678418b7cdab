"""Fixtures of OME-Zarr."""

from command_fixtures import numpy_computes

__all__ = ["numpy_computes"]
