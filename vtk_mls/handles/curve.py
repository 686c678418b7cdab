"""Curve handles: polylines whose every point is carried."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vtk_mls.base.validation import freeze, points


@dataclass(frozen=True, eq=False, init=False)
class CurveHandle:
    """A polyline of the undeformed space, and where it is in the deformed space.

    Each segment counts as one control point that is spread along it.

    Parameters
    ----------
    rest, deformed : (m, 3) array_like, world coordinates
        The nodes before and after, m >= 2.

    Raises
    ------
    ValueError
        If there are fewer than two nodes, or two consecutive nodes of `deformed` are equal.
    """

    rest: NDArray[np.float64]
    deformed: NDArray[np.float64]

    def __init__(self, rest: ArrayLike, deformed: ArrayLike) -> None:
        p, q = points("rest", rest), points("deformed", deformed)
        if p.shape != q.shape:
            raise ValueError(
                "`rest` and `deformed` must have the same number of nodes, "
                f"got {len(p)} and {len(q)}"
            )
        if len(p) < 2:
            raise ValueError(f"`rest` must have at least 2 nodes of a curve, got {len(p)}")
        for name, nodes in (("rest", p), ("deformed", q)):
            equal = np.flatnonzero((nodes[1:] == nodes[:-1]).all(axis=1))
            if len(equal):
                raise ValueError(
                    f"`{name}` must not repeat a node, got {nodes[equal[0]].tolist()} in rows "
                    f"{equal[0]} and {equal[0] + 1}; leave one out"
                )
        freeze(self, rest=p, deformed=q)


@dataclass(frozen=True, eq=False)
class Segments:
    """The segments of curves.

    Attributes
    ----------
    rest, deformed : (s, 2, 3) float64, world coordinates
        Their ends.
    weights : (s,) float64
        Factor of each segment.
    """

    rest: NDArray[np.float64]
    deformed: NDArray[np.float64]
    weights: NDArray[np.float64]

    @classmethod
    def of(cls, curves) -> Segments:
        """The segments of `curves`, a sequence of CurveHandle."""

        def ends(name):
            parts = [np.stack([x[:-1], x[1:]], axis=1) for x in (getattr(c, name) for c in curves)]
            return np.concatenate([np.zeros((0, 2, 3)), *parts])

        rest = ends("rest")
        return cls(rest, ends("deformed"), np.ones(len(rest)))

    def __len__(self) -> int:
        return len(self.weights)

    def __getitem__(self, rows) -> Segments:
        return Segments(self.rest[rows], self.deformed[rows], self.weights[rows])

    def between(self, start, stop) -> Segments:
        """The parts of the segments between the shares `start` and `stop` (s,) of their lengths.

        A part counts by its share, so that parts act like the whole.
        """

        def ends(x):
            along = x[:, 1] - x[:, 0]
            return np.stack([x[:, 0] + t[:, None] * along for t in (start, stop)], axis=1)

        return Segments(ends(self.rest), ends(self.deformed), self.weights * (stop - start))

    def on_side(self, height, side, in_rest_frame) -> Segments:
        """The parts on a `side`, 1 or -1, of a plane: as `HandleSet.on_side`."""
        ends = self.rest if in_rest_frame else self.deformed
        low, high = side * height(ends[:, 0]), side * height(ends[:, 1])
        # the share of the length at which a segment passes the plane
        crossing = np.divide(low, low - high, out=np.zeros_like(low), where=(low < 0) != (high < 0))
        start = np.where(low < 0, crossing, 0)
        stop = np.where((high < 0) & (low >= 0), crossing, 1)
        kept = ((low >= 0) | (high >= 0)) & (stop > start)
        return self[kept].between(start[kept], stop[kept])

    @property
    def swapped(self) -> Segments:
        """The same with rest and deformed swapped."""
        return Segments(self.deformed, self.rest, self.weights)
