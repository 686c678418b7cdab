"""Cuts, and the base classes of shapes of your own."""

from vtk_mls.model.cuts import Cut, HalfPlane, Obstacle, Plane, Surface

__all__ = ["Cut", "HalfPlane", "Obstacle", "Plane", "Surface"]
