"""Cuts: surfaces across which control points have less influence, or none (section 4).

A file of this room is a shape of cuts, and is found by itself: see `vtk_mls.cuts.cut.Obstacle`.
"""

from __future__ import annotations

from importlib import import_module
from pkgutil import iter_modules

from vtk_mls.cuts.cut import Cut, Obstacle
from vtk_mls.cuts.half_plane import HalfPlane
from vtk_mls.cuts.plane import Plane
from vtk_mls.cuts.surface import Surface

__all__ = ["Cut", "HalfPlane", "Obstacle", "Plane", "Surface"]


def _found():
    """The shapes in all files of this room, by their names: full cuts first."""
    found = []
    for module in iter_modules(__path__, f"{__name__}."):
        members = vars(import_module(module.name)).values()
        classes = [each for each in members if isinstance(each, type) and issubclass(each, Cut)]
        found += [each for each in classes if each.__module__ == module.name]
    shapes = sorted(found, key=lambda shape: (issubclass(shape, Obstacle), shape.__name__))
    return {shape.__name__: shape for shape in shapes if shape not in (Cut, Obstacle)}


_shapes = _found()
SHAPES = tuple(_shapes)
globals().update(_shapes)
