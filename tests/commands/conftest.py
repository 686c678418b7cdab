"""Fixtures of the command line."""

from command_fixtures import disk, files, folder, numpy_computes, refused
from vtk_fixtures import messages

__all__ = ["disk", "files", "folder", "messages", "numpy_computes", "refused"]
