"""Boxes and grids on which the search for the inverse of the map makes its first guesses."""

from __future__ import annotations

import numpy as np

from vtk_mls.base.grid import Grid

# Distance from the control points, in local units, up to which inverses are searched for: farther
# away squares in the kernels' float32 come near to what they take for unreachable.
FARTHEST = 1e10
# A sample of so many points; the quantiles between which most of it lies; a point is far that is
# outside of their box by more than so many times its size.
_SOME, _MOST, _MARGIN = 1 << 12, (0.05, 0.95), 4
_PADDING = 0.1  # of the box round control points, next to its largest side
_LARGEST = np.finfo(float).max / 8  # of coordinates whose differences are finite
_PAIRS = 1 << 22  # of points and control points that are looked at together


def cubic_grid(box, nodes) -> Grid:
    """A grid of about `nodes` cubic cells' corners over the `box` (2, 3), which may be flat.

    It has two points at least along each axis.
    """
    low, high = np.clip(box, -_LARGEST, _LARGEST)
    size = np.maximum(high - low, 1e-3 * ((high - low).max() or 1))
    step = float(np.exp(np.log(size / size.max()).mean()) * size.max() / np.cbrt(nodes))
    dimensions = np.maximum(np.ceil((high - low) / step).astype(int) + 1, 2)
    return Grid(dimensions, low, np.full(3, step))


def bounds(points):
    """Lowest and highest coordinates (2, 3) of the finite ones of `points` (m, 3); 0 for none."""
    if len(points) == 0:
        return np.zeros((2, 3))
    # column by column: numpy takes many times longer along the first axis
    box = np.array([(x.min(), x.max()) for x in points.T], dtype=np.float64).T
    return box if np.isfinite(box).all() else bounds(points[np.isfinite(points).all(axis=1)])


def usual_bounds(points, box):
    """`box` (2, 3), the `bounds`, without outliers among `points` (m, 3)."""
    some = points[:: max(1, len(points) // _SOME)]
    some = some[np.isfinite(some).all(axis=1)].astype(np.float64)
    if len(some) == 0:
        return box
    low, high = np.quantile(some, _MOST, axis=0)
    usual = padded(np.array([low, high]), _MARGIN)
    if (usual[0] <= box[0]).all() and (box[1] <= usual[1]).all():
        return box
    near = ((usual[0] <= some) & (some <= usual[1])).all(axis=1)
    return padded(bounds(some[near]), 0.1) if near.any() else box


def usual_box(control_points):
    """The cube (2, 3), local units, around the deformed control points, which levels double.

    Which points are asked about has no part in it.
    """
    low, high = bounds(control_points.local(control_points.deformed))
    half = (0.5 + _PADDING) * ((high - low).max() or 1)
    return (low + high) / 2 + half * np.array([[-1], [1]])


def levels(box, points):
    """How often a `box` (2, 3) must be doubled, around its center, to hold `points` (m, 3)."""
    offset = np.abs(points - box.mean(axis=0)) / (np.ptp(box, axis=0) / 2)
    share, power = np.frexp(offset.max(axis=1))  # share in [0.5, 1)
    return np.maximum(power - (share == 0.5), 0)


def doubled(box, level):
    """A `box` (2, 3) that is doubled `level` times around its center."""
    center = box.mean(axis=0)
    return center + 2.0**level * (box - center)


def padded(box, share):
    """`box` with a margin of a `share` of its largest side."""
    return box + share * np.ptp(box, axis=0).max() * np.array([[-1], [1]])


def motions(rest, deformed, points):
    """Displacements v - x that material beside a cut may have, for x of `points` (m, 3).

    A control point that is dragged along a cut takes with it what is near to it on its own side,
    and leaves the rest: the map with p and q exchanged is between the two, where nothing may be.

    Yields
    ------
    (m, 3) float64, units of the control points `rest` and `deformed` (n, 3)
        The mean of all control points' displacements, then that of the nearest one.
    """
    displacements = deformed - rest
    yield np.tile(displacements.mean(axis=0), (len(points), 1))
    step = max(1, _PAIRS // len(rest))
    nearest = [
        np.square(part[:, None] - rest).sum(axis=2).argmin(axis=1)
        for part in np.split(points, range(step, len(points), step))
    ]
    yield displacements[np.concatenate(nearest)]
