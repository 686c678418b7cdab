"""Fixtures of PyVista."""

from vtk_fixtures import opengl

__all__ = ["opengl"]
