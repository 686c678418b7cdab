"""Fixtures of file formats."""

from command_fixtures import files
from vtk_fixtures import messages

__all__ = ["files", "messages"]
