"""Lattices on which the search for the inverse of the map makes its first guesses."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

# How far from the control points places are looked for, in local units: farther away the squares in
# the kernels' float32 come near to what they take for unreachable.
FARTHEST = 1e10
# Far is what of so many points is outside of a box that holds most, by that many times its size.
_SOME, _MOST, _MARGIN = 1 << 12, (0.05, 0.95), 4


@dataclass(frozen=True)
class Lattice:
    """Cubic cells over a box.

    Attributes
    ----------
    low : (3,) float64
        The first node.
    step : float
    dimensions : (3,) int
        Nodes along each axis, two at least.
    """

    low: np.ndarray
    step: float
    dimensions: np.ndarray

    @classmethod
    def over(cls, bounds, nodes) -> Lattice:
        """About `nodes` of them over the box `bounds` (2, 3), which may be flat."""
        low, high = bounds
        size = np.maximum(high - low, 1e-3 * ((high - low).max() or 1))
        step = float(np.exp(np.log(size / size.max()).mean()) * size.max() / np.cbrt(nodes))
        return cls(low, step, np.maximum(np.ceil((high - low) / step).astype(int) + 1, 2))

    def points(self):
        """The nodes (n, 3), x fastest."""
        axes = [a + self.step * np.arange(n) for a, n in zip(self.low, self.dimensions)]
        z, y, x = np.meshgrid(*axes[::-1], indexing="ij")
        return np.stack([x, y, z], axis=-1).reshape(-1, 3)


def bounds(points):
    """Lowest and highest coordinates (2, 3) of the finite ones of `points` (m, 3); 0 for none."""
    if len(points) == 0:
        return np.zeros((2, 3))
    # column by column: numpy takes many times longer along the first axis
    box = np.array([(x.min(), x.max()) for x in points.T], dtype=np.float64).T
    return box if np.isfinite(box).all() else bounds(points[np.isfinite(points).all(axis=1)])


def usual_bounds(points, box):
    """`box` (2, 3), the `bounds`, without what lies far from nearly all of `points` (m, 3)."""
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


def joined(*boxes):
    """The box (2, 3) round all `boxes`."""
    return np.array([np.min([b[0] for b in boxes], 0), np.max([b[1] for b in boxes], 0)])


def padded(box, share):
    """`box` with a margin of a `share` of its largest side."""
    return box + share * np.ptp(box, axis=0).max() * np.array([[-1], [1]])
