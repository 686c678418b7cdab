"""The sides of full cuts: each has control points of its own, and nothing else in common."""

from __future__ import annotations

import functools
from dataclasses import dataclass
from itertools import product

import numpy as np

from vtk_mls.base.linear_algebra import fitted_affine
from vtk_mls.cuts import Plane
from vtk_mls.handles.control_points import ControlPoints

_MOST_PLANES = 6
# What is nearer to a plane than this share of its size is on both sides, to rounding.
ON_PLANE = 1e-6


@dataclass(frozen=True, eq=False)
class Region:
    """The points on one side of each of some planes, with the control points there.

    Attributes
    ----------
    sides : (planes,) float64
        1 or -1 for each plane. A point on a plane is on side 1.
    control_points : ControlPoints
        If no control point is there, one that does not move.
    """

    sides: np.ndarray
    control_points: ControlPoints

    def holds(self, planes, points):
        """Which of `points` (m, 3) are in the region: (m,) bool."""
        inside = np.ones(len(points), bool)
        for plane, side in zip(planes, self.sides):
            inside &= (plane.height(points) < 0) == (side < 0)
        return inside

    @functools.cached_property
    def exchanged(self) -> Region:
        """With p and q exchanged: its backward map is a forward map, but not quite the inverse."""
        control_points = self.control_points
        exchanged = ControlPoints(
            control_points.deformed,
            control_points.rest,
            control_points.weights,
            control_points.kind,
            control_points.scale,
        )
        return Region(self.sides, exchanged)


def divided(planes, seen, control_points, kind) -> tuple[Region, ...]:
    """All regions that `planes` make; one for no plane.

    Parameters
    ----------
    planes : sequence of Plane
    seen : (n, 3) float64, world coordinates
        Where the planes see the control points.
    control_points : tuple of float64 arrays
        Their rest and deformed positions (n, 3) and weights (n,).
    kind : Kind
    """
    rest, deformed, weights = control_points
    if len(planes) > _MOST_PLANES:
        raise ValueError(
            f"`cuts` must have at most {_MOST_PLANES} full planes, got {len(planes)}; "
            "use HalfPlane or Surface for cuts that do not go through everything"
        )
    world = _size(rest, deformed)
    regions = []
    for sides in product((1.0, -1.0), repeat=len(planes)):
        region = Region(np.array(sides), None)
        here = region.holds(planes, seen)
        if here.any():
            control_points = ControlPoints(rest[here], deformed[here], weights[here], kind, world)
        else:
            middle = seen.mean(axis=0)
            anchor = (middle - planes[0].height(middle) * planes[0].normal)[None]
            control_points = ControlPoints(anchor, anchor, np.ones(1), kind, world)
        regions.append(Region(region.sides, control_points))
    return tuple(regions)


def moved(plane, rest, deformed) -> Plane:
    """The plane where material that was on `plane` is expected in the deformed space.

    The affine map that fits the control points best has it there.
    """
    matrix, offset = fitted_affine(deformed, rest)
    normal = plane.normal @ matrix
    size = normal @ normal
    if size < 1e-6:
        return plane
    return Plane(-plane.height(offset) / size * normal, normal)


def _size(rest, deformed):
    """How large the world is: how far control points are apart or are moved, world units."""
    both = np.concatenate([rest, deformed])
    # one that does not move says nothing, but then all is at rest
    return float(np.abs(both - both[0]).max() or np.abs(both).max() or 1.0)
