"""Cuts: surfaces across which control points have less influence, or none (section 4).

Each file of this folder defines a shape, which is found by import: see `cuts.cut.Obstacle`.
"""

from __future__ import annotations

from importlib import import_module
from pkgutil import iter_modules

from vtk_mls.cuts.cut import Cut, Obstacle
from vtk_mls.cuts.half_plane import HalfPlane
from vtk_mls.cuts.plane import Plane
from vtk_mls.cuts.surface import Surface

__all__ = ["Cut", "HalfPlane", "Obstacle", "Plane", "Surface"]


def _find_shapes():
    """The cut classes in all files of this folder by name, unbounded ones first."""
    modules = [import_module(module.name) for module in iter_modules(__path__, f"{__name__}.")]
    shapes = [
        member
        for module in modules
        for member in vars(module).values()
        if isinstance(member, type) and issubclass(member, Cut)
        if member.__module__ == module.__name__ and member not in (Cut, Obstacle)
    ]
    shapes.sort(key=lambda shape: (issubclass(shape, Obstacle), shape.__name__))
    return {shape.__name__: shape for shape in shapes}


_shapes = _find_shapes()
SHAPES = tuple(_shapes)
globals().update(_shapes)
