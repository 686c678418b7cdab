"""Fixtures of the filters."""

from mesh_fixtures import any_mesh
from smooth_images import deform
from vtk_fixtures import messages, opengl

__all__ = ["any_mesh", "deform", "messages", "opengl"]
