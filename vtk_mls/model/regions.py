"""Regions between plane cuts: each has its own control points."""

from __future__ import annotations

import functools
from dataclasses import dataclass
from itertools import product

import numpy as np

from vtk_mls.base.linear_algebra import fitted_affine
from vtk_mls.model.cuts import Plane
from vtk_mls.model.handles.control_points import ControlPoints
from vtk_mls.model.handles.handle_set import HandleSet

MAX_PLANES = 6
# Distance below which a point counts as on a plane, as a fraction of the size.
ON_PLANE = 1e-6


@dataclass(frozen=True, eq=False)
class Region:
    """The points on one side of each plane, with the control points there."""

    sides: np.ndarray  # 1 or -1 for each plane; a point on a plane is on side 1
    control_points: ControlPoints  # a fixed one if the region has none of its own

    def holds(self, planes, points):
        """Which of `points` (m, 3) are in the region: (m,) bool."""
        inside = np.ones(len(points), bool)
        for plane, side in zip(planes, self.sides):
            inside &= (plane.height(points) < 0) == (side < 0)
        return inside

    @functools.cached_property
    def swapped(self) -> Region:
        """The region with p and q swapped: its backward map approximates the inverse map."""
        return Region(self.sides, self.control_points.swapped)


def split_by_planes(
    planes, handles, in_rest_frame, kind, has_zero_mean=False
) -> tuple[Region, ...]:
    """All regions that `planes`, in the rest or the deformed frame, separate; one without any."""
    if len(planes) > MAX_PLANES:
        raise ValueError(
            f"`cuts` must have at most {MAX_PLANES} planes, got {len(planes)}; "
            "use HalfPlane or Surface for cuts with an edge"
        )
    positions = np.concatenate(handles.positions)
    # for a single fixed control point its distance from the origin
    distance = np.abs(positions - positions[0]).max()
    extent = float(distance or np.abs(positions).max() or 1.0)  # of the coordinates, world units
    regions = []
    for sides in product((1.0, -1.0), repeat=len(planes)):
        own = handles
        for plane, side in zip(planes, sides):
            own = own.on_side(plane.height, side, in_rest_frame)
        if len(own.positions[0]) == 0:
            middle = handles.positions[0 if in_rest_frame else 1].mean(axis=0)
            fixed = (middle - planes[0].height(middle) * planes[0].normal)[None]
            own = HandleSet.of(fixed, fixed, np.ones(1))
        regions.append(Region(np.array(sides), ControlPoints.of(own, kind, extent, has_zero_mean)))
    return tuple(regions)


def deformed_plane(plane, rest, deformed) -> Plane:
    """The approximate place of the material of `plane` in the deformed space.

    It is the image of the plane under the best fitting affine map of the control points.
    """
    matrix, offset = fitted_affine(deformed, rest)
    normal = plane.normal @ matrix
    size = normal @ normal
    if size < 1e-6:
        return plane
    return Plane(-plane.height(offset) / size * normal, normal)
