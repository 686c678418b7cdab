"""Where material from both sides of a cut overlaps."""

from itertools import combinations

import numpy as np

from vtk_mls.base.linear_algebra import transformed
from vtk_mls.model.cuts.plane import Plane

# Rounding error of the device's float32, and more, as a fraction of the size.
_ROUNDING = 1e-5


def overlap(engine, deformation, points, progress):
    """Whether material from both sides of a cut is at each of `points` (m, 3): (m,) bool.

    The search for a second origin starts just behind each cut, at the closest point to the first
    origin, and behind all of two or three planes that intersect. False with cuts in the deformed
    frame.
    """
    found = np.zeros(len(points), bool)
    if not deformation.in_rest_frame:
        return found
    groups = _groups(deformation.cuts)
    mapping, measuring, *searches = progress.divided(*[1] * (2 + len(groups)))
    origins = engine.backward(deformation, points, mapping)
    rounding = _ROUNDING * sizes(deformation, points)
    has_material = engine.void_distance(deformation, points, measuring) > rounding
    for cuts, search in zip(groups, searches):
        rows = np.flatnonzero(has_material & ~found)
        x, limit = origins[rows], rounding[rows]
        behind = x - _to_behind(cuts, x, limit)
        second, distance = engine.origins_from(deformation, points[rows], behind, search)
        differs = np.linalg.norm(second - x, axis=1) > limit
        found[rows] = differs & (distance > limit)
    return found


def _groups(cuts):
    """Tuples of cuts that can hide a second origin: each cut, and planes that intersect."""
    planes = [cut for cut in cuts if isinstance(cut, Plane)]
    groups = [(cut,) for cut in cuts]
    for group in (*combinations(planes, 2), *combinations(planes, 3)):
        if np.linalg.matrix_rank([plane.normal for plane in group], 1e-6) == len(group):
            groups.append(group)
    return groups


def _to_behind(cuts, x, limit):
    """Vectors (m, 3) from points `limit` (m,) behind all of the cuts to x (m, 3)."""
    if len(cuts) == 1:
        (cut,) = cuts
        return (cut.void_distance(x, x) + limit)[:, None] * cut.away(x, x)
    heights = np.stack([plane.height(x) for plane in cuts], axis=1)
    distances = heights + np.where(heights < 0, -1, 1) * limit[:, None]
    return transformed(np.linalg.pinv([plane.normal for plane in cuts]), distances)


def sizes(deformation, points):
    """Length that rounding errors at `points` (m, 3) are relative to: (m,), world units."""
    regions = [region.control_points for region in deformation.regions]
    distance = np.abs(points - regions[0].center).max(axis=1)
    return np.maximum(max(control_points.scale for control_points in regions), distance)
