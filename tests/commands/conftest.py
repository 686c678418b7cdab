"""Fixtures of the command line."""

from command_fixtures import files, refused
from vtk_fixtures import messages

__all__ = ["files", "messages", "refused"]
