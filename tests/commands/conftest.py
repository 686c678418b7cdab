"""Fixtures of the command line."""

from command_fixtures import files, refused
from vtk_fixtures import messages, opengl

__all__ = ["files", "messages", "opengl", "refused"]
