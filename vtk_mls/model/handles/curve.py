"""Curve handles: polylines whose every point is carried."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vtk_mls.base.errors import InputError
from vtk_mls.base.validation import freeze, points, same_count
from vtk_mls.model.handles.handle import Handle
from vtk_mls.model.shape_fields import ShapeField

# Values of alpha for which the weights of a segment have integrals in closed form.
INTEGRATED_ALPHAS = (1, 2, 3)
# Control points in place of a segment for other values of alpha: Gauss-Legendre nodes.
_QUADRATURE = 16
# Control points in place of a segment for splines, at equal distances.
_EVENLY = 8
# Where positions of a segment are sampled: they determine polynomials up to degree 3 on it.
_SAMPLES = np.array([0, 1 / 3, 2 / 3, 1])
# Pieces of a segment that are searched for a crossing of a cut, and halvings of a piece.
_PIECES, _HALVINGS = 32, 48
# Parts of segments that are shorter, as shares of the length, are left out: a node on a cut.
_MIN_SHARE = 1e-9
# Ends of a curve that are closer, relative to its length, coincide.
_MIN_CHORD = 1e-6


@dataclass(frozen=True, eq=False, init=False)
class CurveHandle(Handle):
    """A polyline of the undeformed space, and where it is in the deformed space.

    Each segment counts as one control point that is spread along it; a segment that several curves
    share, with one motion, counts once.

    Parameters
    ----------
    rest, deformed : (m, 3) array_like, world coordinates
        The nodes before and after, m >= 2. Consecutive nodes with the same place and motion become
        one.

    Raises
    ------
    ValueError
        If there are fewer than two nodes, or two consecutive ones are equal only before or after.
    """

    rest: NDArray[np.float64]
    deformed: NDArray[np.float64]

    name = title = "curve"
    fields = ShapeField("rest", "rows"), ShapeField("deformed", "rows")

    def __init__(self, rest: ArrayLike, deformed: ArrayLike) -> None:
        p, q = points("rest", rest), points("deformed", deformed)
        same_count(p, q, "nodes")
        is_new = np.append(True, (np.diff(np.hstack([p, q]), axis=0) != 0).any(axis=1))[: len(p)]
        for name, nodes in (("rest", p), ("deformed", q)):
            equal = np.flatnonzero((nodes[1:] == nodes[:-1]).all(axis=1) & is_new[1:])
            if len(equal):
                raise InputError(
                    f"must not repeat a node, got {nodes[equal[0]].tolist()} in rows "
                    f"{equal[0]} and {equal[0] + 1}; leave one out",
                    argument=name,
                )
        count, repeated = is_new.sum(), f" and {(~is_new).sum()} that repeat it"
        if count < 2:
            text = f"{count}{repeated * (not is_new.all())}"
            raise InputError(f"must have at least 2 nodes of a curve, got {text}", argument="rest")
        p, q = p[is_new], q[is_new]
        freeze(self, rest=p, deformed=q)

    @property
    def grips(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        return self.rest, self.deformed

    def with_grips(self, deformed: NDArray[np.float64]) -> CurveHandle:
        return CurveHandle(self.rest, deformed)

    def blended(self, share: float) -> CurveHandle:
        return self.with_grips(self.rest + share * (self.deformed - self.rest))

    @property
    def is_resting(self) -> bool:
        return bool((self.rest == self.deformed).all())

    def samples(self, count: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        return Segments.of([self]).samples


def straightened(curve: CurveHandle) -> CurveHandle:
    """A curve with its deformed nodes on a line, at the distances of its rest nodes along it.

    The line has the direction from the first to the last deformed node; if these coincide, the
    principal direction of the deformed nodes. Their middle is the middle of the line: little moves,
    as both ends move by the same distance, along the line.
    """
    nodes, steps = curve.deformed, np.linalg.norm(np.diff(curve.rest, axis=0), axis=1)
    along = np.append(0, np.cumsum(steps)) - steps.sum() / 2
    direction = nodes[-1] - nodes[0]
    if np.linalg.norm(direction) <= _MIN_CHORD * steps.sum():
        direction = np.linalg.svd(nodes - nodes.mean(axis=0))[2][0]
        direction *= np.sign(along @ nodes @ direction) or 1  # less moves than for the opposite
    direction /= np.linalg.norm(direction)
    return CurveHandle(curve.rest, (nodes[0] + nodes[-1]) / 2 + np.outer(along, direction))


@dataclass(frozen=True, eq=False)
class Segments:
    """The segments of curves, by their ends and weights."""

    rest: NDArray[np.float64]  # (s, 2, 3), world coordinates
    deformed: NDArray[np.float64]
    weights: NDArray[np.float64]  # (s,)

    @classmethod
    def of(cls, curves) -> Segments:
        """The segments of `curves`, a sequence of CurveHandle; each once, in either direction."""

        def ends(name):
            parts = [np.stack([x[:-1], x[1:]], axis=1) for x in (getattr(c, name) for c in curves)]
            return np.concatenate([np.zeros((0, 2, 3)), *parts])

        rest, deformed = ends("rest"), ends("deformed")
        both = np.concatenate([rest, deformed], axis=2) + 0.0  # no -0
        every = np.arange(len(both))
        column = (both[:, 0] != both[:, 1]).argmax(axis=1)
        is_falling = both[every, 0, column] > both[every, 1, column]
        both[is_falling] = both[is_falling, ::-1]
        rows = np.sort(np.unique(both.reshape(-1, 12), axis=0, return_index=True)[1])
        return cls(rest[rows], deformed[rows], np.ones(len(rows)))

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

    @property
    def samples(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Points (4 s, 3) along the segments, their ends among them, at rest and deformed."""
        return self._at(_SAMPLES)

    def every(self, step):
        """Points (k, 3) of each segment where it is deformed, not farther apart than `step`."""
        for start, stop in self.deformed:
            count = int(np.ceil(np.linalg.norm(stop - start) / step)) + 1
            yield np.linspace(start, stop, count)

    @property
    def middles(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """The middles (s, 3), at rest and deformed: cuts see the segments there."""
        return self.rest.mean(axis=1), self.deformed.mean(axis=1)

    def quadrature(self):
        """Control points in place of the segments: rest, deformed (n, 3) and weights (n,)."""
        at, share = np.polynomial.legendre.leggauss(_QUADRATURE)
        weights = np.outer(self.weights, share / 2).ravel()
        return *self._at((1 + at) / 2), weights

    def evenly(self):
        """The same, evenly along each segment, as splines need them."""
        at = (np.arange(_EVENLY) + 0.5) / _EVENLY
        return *self._at(at), np.repeat(self.weights / _EVENLY, _EVENLY)

    def _at(self, t):
        """Points at the shares `t` (k,) of the segments' lengths (s k, 3), rest and deformed."""
        rest, deformed = (
            x[:, :1] + t[:, None] * (x[:, 1:] - x[:, :1]) for x in (self.rest, self.deformed)
        )
        return rest.reshape(-1, 3), deformed.reshape(-1, 3)

    def split_by(self, cut, in_rest_frame) -> Segments:
        """The segments, split where they cross a cut with an edge, so that no part does."""
        if len(self) == 0:
            return self
        ends = self.rest if in_rest_frame else self.deformed
        start, along = ends[:, :1], ends[:, 1:] - ends[:, :1]
        t = np.linspace(0, 1, _PIECES + 1)
        nodes = start + t[:, None] * along
        rows, pieces = np.nonzero(cut.blocks(nodes[:, :-1], nodes[:, 1:]))
        low, high = t[pieces], t[pieces + 1]
        for _ in range(_HALVINGS if len(rows) else 0):
            middle = (low + high) / 2
            a, b = (start[rows, 0] + x[:, None] * along[rows, 0] for x in (low, middle))
            is_before = cut.blocks(a, b)
            low, high = np.where(is_before, low, middle), np.where(is_before, middle, high)
        every = np.arange(len(self))
        row = np.concatenate([every, every, rows])
        share = np.concatenate([np.zeros(len(self)), np.ones(len(self)), high])
        order = np.lexsort([share, row])
        row, share = row[order], share[order]
        mask = (row[1:] == row[:-1]) & (share[1:] > share[:-1] + _MIN_SHARE)
        return self[row[:-1][mask]].between(share[:-1][mask], share[1:][mask])

    def on_side(self, height, side, in_rest_frame) -> Segments:
        """The parts on a `side`, 1 or -1, of a plane: as `HandleSet.on_side`."""
        ends = self.rest if in_rest_frame else self.deformed
        low, high = side * height(ends[:, 0]), side * height(ends[:, 1])
        # the share of the length at which a segment passes the plane
        crossing = np.divide(low, low - high, out=np.zeros_like(low), where=(low < 0) != (high < 0))
        start = np.where(low < 0, crossing, 0)
        stop = np.where((high < 0) & (low >= 0), crossing, 1)
        mask = ((low >= 0) | (high >= 0)) & (stop > start + _MIN_SHARE)
        return self[mask].between(start[mask], stop[mask])

    @property
    def swapped(self) -> Segments:
        """The same with rest and deformed swapped."""
        return Segments(self.deformed, self.rest, self.weights)
