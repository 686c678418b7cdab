"""Fixtures of OME-Zarr."""

from command_fixtures import numpy_computes, refused

__all__ = ["numpy_computes", "refused"]
