"""Handles for data that come without: a lattice that is drawn onto what one sees of them."""

from __future__ import annotations

import numpy as np

from vtk_mls.filters.control_points import lattice

_APART = 0.2  # of the lattice's steps: what comes nearer to another one is left out
_FLAT = 0.05  # of the longest step, below which others do not count


def handles_on(shown, bounds, count):
    """Points of a lattice over data; those beside the data go to where they are nearest.

    Parameters
    ----------
    shown : list of ShownVolume and ShownMesh
    bounds : (2, 3)
        Corners of the lattice.
    count : int
        Along each axis; where the data are flat or narrow there are fewer.

    Returns
    -------
    (n, 3) float64, world coordinates
    """
    nodes = lattice((count,) * 3, bounds.T.ravel())
    nearest = np.stack([each.nearest(nodes) for each in shown])
    away = np.linalg.norm(nearest - nodes, axis=2)
    points = nearest[away.argmin(axis=0), np.arange(len(nodes))]
    steps = np.ptp(bounds, axis=0) / (count - 1)
    return points[_apart(points / np.maximum(steps, _FLAT * (steps.max() or 1.0)))]


def _apart(points):
    """Rows of those that are far enough from each before them."""
    kept = [0]
    for row, point in enumerate(points):
        if np.linalg.norm(points[kept] - point, axis=1).min() > _APART:
            kept.append(row)
    return kept
