"""Cuts: surfaces across which control points have less influence, or none (section 4).

Each file of this folder defines a shape, which is found by import: see `cuts.cut.Obstacle`.
"""

from vtk_mls.base.lazy import classes_in
from vtk_mls.model.cuts.cut import Cut, Obstacle
from vtk_mls.model.cuts.half_plane import HalfPlane
from vtk_mls.model.cuts.plane import Plane
from vtk_mls.model.cuts.surface import Surface

__all__ = ["Cut", "HalfPlane", "Obstacle", "Plane", "Surface"]

# the cut classes in all files of this folder, unbounded ones first
_found = [shape for shape in classes_in(__name__, __path__, Cut) if shape not in (Cut, Obstacle)]
_found.sort(key=lambda shape: (issubclass(shape, Obstacle), shape.__name__))
BY_NUMBERS = {shape.name: shape for shape in _found if shape.labels()}  # the flat shapes
globals().update({shape.__name__: shape for shape in _found})
