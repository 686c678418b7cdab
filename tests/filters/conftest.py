"""Fixtures of the filters."""

from mesh_fixtures import any_mesh
from vtk_fixtures import device, messages, opengl

__all__ = ["any_mesh", "device", "messages", "opengl"]
