"""Where material from both sides of a cut is at one point: they were pushed into each other."""

from __future__ import annotations

from itertools import combinations

import numpy as np

from vtk_mls.base.linear_algebra import transformed
from vtk_mls.cuts.plane import Plane

# Next to the size of what is deformed: more than the device's float32 blurs.
_BLUR = 1e-5


def overlap(engine, deformation, points, progress):
    """Whether there is material of two sides of a cut.

    Each point has an origin. From just behind each cut, where that is nearest to the origin, the
    search for another begins; and from behind all of two or three planes that cross.

    Parameters
    ----------
    engine : Engine
    deformation : Deformation
        With cuts in the rest frame.
    points : (m, 3) float64, world coordinates
    progress : Progress

    Returns
    -------
    (m,) bool
    """
    groups = _groups(deformation.cuts)
    first, *others = progress.divided(*[1] * (2 + len(groups)))
    origins = engine.backward(deformation, points, first)
    found = np.zeros(len(points), bool)
    blur = _BLUR * _sizes(deformation, points)
    here = engine.void_distance(deformation, points, others[0]) > blur
    for cuts, part in zip(groups, others[1:]):
        rows = np.flatnonzero(here & ~found)
        x, limit = origins[rows], blur[rows]
        behind = x - _to_behind(cuts, x, limit)
        other, distance = engine.origins_from(deformation, points[rows], behind, part)
        differs = np.linalg.norm(other - x, axis=1) > limit
        found[rows] = differs & (distance > limit)
    return found


def _groups(cuts):
    """Tuples of cuts behind which other material can be: each cut, and planes that cross."""
    planes = [cut for cut in cuts if isinstance(cut, Plane)]
    crossing = [each for n in (2, 3) for each in combinations(planes, n) if _cross(each)]
    return [(cut,) for cut in cuts] + crossing


def _cross(planes):
    normals = np.array([plane.normal for plane in planes])
    return np.linalg.matrix_rank(normals, 1e-6) == len(planes)


def _to_behind(cuts, x, limit):
    """Back from just behind all of the cuts to x (m, 3), each `limit` (m,) past them."""
    if len(cuts) == 1:
        (cut,) = cuts
        return (cut.void_distance(x, x) + limit)[:, None] * cut.away(x, x)
    heights = np.stack([plane.height(x) for plane in cuts], axis=1)
    past = heights + np.where(heights < 0, -1, 1) * limit[:, None]
    return transformed(np.linalg.pinv([plane.normal for plane in cuts]), past)


def _sizes(deformation, points):
    """What rounding at `points` (m, 3) is relative to: (m,), world units."""
    regions = [region.control_points for region in deformation.regions]
    distance = np.abs(points - regions[0].centre).max(axis=1)
    return np.maximum(max(each.scale for each in regions), distance)
