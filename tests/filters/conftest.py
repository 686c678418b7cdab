"""Fixtures of the filters."""

from mesh_fixtures import any_mesh
from smooth_images import deform
from vtk_fixtures import device, messages, opengl

__all__ = ["any_mesh", "deform", "device", "messages", "opengl"]
