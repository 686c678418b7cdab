"""Cuts, and the base classes of shapes of your own."""

from vtk_mls.model.cuts import BY_NUMBERS, Cut, HalfPlane, Obstacle, Plane, Surface

__all__ = ["Cut", "HalfPlane", "Obstacle", "Plane", "Surface"]
globals().update({shape.__name__: shape for shape in BY_NUMBERS.values()})
