"""Fixtures of rendering."""

from vtk_fixtures import messages, opengl

__all__ = ["messages", "opengl"]
