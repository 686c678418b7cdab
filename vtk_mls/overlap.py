"""Where material from both sides of a cut is at one point: they were pushed into each other."""

from __future__ import annotations

import numpy as np

# Next to the size of what is deformed: more than the device's float32 blurs.
_BLUR = 1e-5


def overlap(engine, deformation, points, progress):
    """Whether there is material of two sides of a cut.

    Each point has an origin. From just behind each cut, where that is nearest to the origin, the
    search for another begins.

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
    first, *others = progress.divided(*[1] * (2 + len(deformation.cuts)))
    origins = engine.backward(deformation, points, first)
    found = np.zeros(len(points), bool)
    blur = _BLUR * _sizes(deformation, points)
    here = engine.void_distance(deformation, points, others[0]) > blur
    for cut, part in zip(deformation.cuts, others[1:]):
        rows = np.flatnonzero(here & ~found)
        x, limit = origins[rows], blur[rows]
        behind = x - (cut.void_distance(x, x) + limit)[:, None] * cut.away(x, x)
        other, distance = engine.origins_from(deformation, points[rows], behind, part)
        differs = np.linalg.norm(other - x, axis=1) > limit
        found[rows] = differs & (distance > limit)
    return found


def _sizes(deformation, points):
    """What rounding at `points` (m, 3) is relative to: (m,), world units."""
    regions = [region.control_points for region in deformation.regions]
    distance = np.abs(points - regions[0].centre).max(axis=1)
    return np.maximum(max(each.scale for each in regions), distance)
