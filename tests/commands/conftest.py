"""Fixtures of the command line."""

from command_fixtures import files, numpy_computes, refused
from vtk_fixtures import messages

__all__ = ["files", "messages", "numpy_computes", "refused"]
