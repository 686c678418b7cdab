"""Initial handles: a lattice that is moved onto the visible data."""

import numpy as np

from vtk_mls.filters.control_point_source import lattice

_MIN_DISTANCE = 0.2  # between handles, relative to the steps of the lattice
_MIN_STEP = 0.05  # of a lattice along an axis of flat data, relative to the longest step


def handles_on(items, bounds, count):
    """Points (n, 3) of a lattice; those outside the data are moved to the nearest point of them.

    `items` have a method `nearest`, `bounds` (2, 3) are corners of the lattice, and `count` is the
    number of points along each axis. Flat or narrow data get fewer points.
    """
    nodes = lattice((count,) * 3, bounds.T.ravel())
    nearest = np.stack([item.nearest(nodes) for item in items])
    distances = np.linalg.norm(nearest - nodes, axis=2)
    points = nearest[distances.argmin(axis=0), np.arange(len(nodes))]
    steps = np.ptp(bounds, axis=0) / (count - 1)
    scaled = points / np.maximum(steps, _MIN_STEP * (steps.max() or 1.0))
    rows = [0]
    for row, point in enumerate(scaled):
        if np.linalg.norm(scaled[rows] - point, axis=1).min() > _MIN_DISTANCE:
            rows.append(row)
    return points[rows]
