"""Fixtures of file formats."""

from command_fixtures import disk, files, numpy_computes, refused
from vtk_fixtures import messages

__all__ = ["disk", "files", "messages", "numpy_computes", "refused"]
