"""Fixtures of the command line."""

from command_fixtures import files
from vtk_fixtures import messages, opengl

__all__ = ["files", "messages", "opengl"]
