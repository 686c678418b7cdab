"""Inverses without a search: of points in rigid regions, and of points that limits keep at rest."""

import numpy as np

from vtk_mls.model.limits import are_fixed

_TOLERANCE = 1e-5  # of the inverse, as a fraction of the size


def direct_inverses(backward, deformation, points):
    """Rows (k,) of `points` (m, 3) and their displacements (k, 3), world units.

    A search may find another place to which the map brings the same material where it folds.
    `backward` is the map, a function of points (k, 3).
    """
    indices, displacements = [np.zeros(0, np.int64)], [np.zeros((0, 3))]
    for region in deformation.handle_set.regions:
        low, high = region.shape.bounds
        rows = np.flatnonzero(((points >= low) & (points <= high)).all(axis=1))
        rows = rows[region.shape.distance(points[rows].astype(float))[0] == 0]
        x = points[rows].astype(float)
        v = region.moved(x)
        # not where another region, a mask or a face is at the same place
        tolerance = _TOLERANCE * max(r.control_points.scale for r in deformation.regions)
        met = np.linalg.norm(backward(v) - x, axis=1) <= tolerance if len(rows) else rows == 0
        indices.append(rows[met])
        displacements.append((v - x)[met])
    if deformation.limits:
        fixed = np.flatnonzero(are_fixed(deformation.limits, points))
        indices.append(fixed)
        displacements.append(np.zeros((len(fixed), 3)))
    return np.concatenate(indices), np.concatenate(displacements)
