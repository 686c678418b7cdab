"""Many control points as few: those far away count by clusters.

What the fits sum over control points are products of p and q times weights that change little over
a cluster far away. Four stand-ins with the weight of a cluster, the mean and the covariance of its
q, and the affine motion that fits it best have its moments up to the second order: the error falls
with the third power of its size next to its distance.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

_STAND_INS = np.array([(1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1)], float)
_FEW = 8  # control points that are no cluster
_LEVELS = 20  # of cubes in cubes at most: their numbers have 60 bits
_FLAT = 1e-9  # next to the largest a variance that is rounding


@dataclass(frozen=True, eq=False)
class _Level:
    """Cubes of one size.

    In the order of the tree, `start` to `stop` (k,) are the control points in each, and `child` to
    the next `child` (k + 1,) its cubes of the next level. `mean` (k, 3) and `radius` (k,) are of
    their q; `stand_in` (k,) is the number of the first of its stand-ins, where it is a cluster.
    """

    start: np.ndarray
    stop: np.ndarray
    child: np.ndarray
    mean: np.ndarray
    radius: np.ndarray
    stand_in: np.ndarray

    @property
    def is_cluster(self):
        return self.stop - self.start > _FEW


class Clusters:
    """Control points in cubes, in cubes of half their size, and so on; stand-ins for each.

    Parameters
    ----------
    q, p : (n, 3) float64, local frame
        Deformed and rest positions.
    weights : (n,) float64
        Factors of their weights.

    Attributes
    ----------
    q, p : (m, 3) float64, local frame
    weights : (m,) float64
        Of the control points, then of the stand-ins.
    """

    def __init__(self, q, p, weights):
        codes = _codes(q)
        self._order = np.argsort(codes, kind="stable")
        rows, starts = self._order, _starts(codes[self._order])
        moments = _moments(q[rows], p[rows], weights[rows])
        self._levels, tables = [], [(q, p, weights)]
        below, count = None, len(q)
        for start in reversed(starts):
            child = None if below is None else np.searchsorted(below, np.append(start, len(q)))
            first = start if child is None else child[:-1]
            moments, below = np.add.reduceat(moments, first, axis=0), start
            stop = np.append(start[1:], len(q))
            is_cluster = stop - start > _FEW
            stand_in = count + len(_STAND_INS) * (np.cumsum(is_cluster) - 1)
            tables.append(_stand_ins(moments[is_cluster]))
            count += len(tables[-1][2])
            mean = moments[:, 1:4] / moments[:, :1]
            apart = q[rows] - np.repeat(mean, stop - start, axis=0)
            radius = np.sqrt(np.maximum.reduceat((apart * apart).sum(axis=1), start))
            self._levels.insert(0, _Level(start, stop, child, mean, radius, stand_in))
        self.q, self.p, self.weights = (np.concatenate(column) for column in zip(*tables))

    def near(self, low, high, relative_size):
        """What counts in boxes: clusters with a radius below `relative_size` times their distance.

        Those nearer than half a box are not taken: their errors would change within it.

        Parameters
        ----------
        low, high : (b, 3) float64, local frame
            Corners of the boxes.
        relative_size : float, < 1

        Returns
        -------
        numbers : (k,) int32
            Rows of `q`, `p` and `weights`, those of one box after those of the other.
        ends : (b,) ints
            Where they end in `numbers`.
        """
        box, cube = np.arange(len(low)), np.zeros(len(low), int)
        boxes, numbers, clearance = [], [], (high - low).max(axis=1) / 2

        def take(where, first, last, order=None):
            at, owner = _ranges(first, last)
            boxes.append(where[owner])
            numbers.append(at if order is None else order[at])

        for level in self._levels:
            is_cluster = level.is_cluster[cube]
            mean = level.mean[cube]
            apart = np.maximum(np.maximum(low[box] - mean, mean - high[box]), 0)
            distance = np.sqrt((apart * apart).sum(axis=1))
            is_far = is_cluster & (level.radius[cube] < relative_size * distance)
            is_far &= distance > clearance[box]
            first = level.stand_in[cube[is_far]]
            take(box[is_far], first, first + len(_STAND_INS))
            is_open = is_cluster & ~is_far
            ends = ~is_cluster if level.child is not None else ~is_far
            take(box[ends], level.start[cube[ends]], level.stop[cube[ends]], self._order)
            if level.child is None:
                break
            box, cube = box[is_open], cube[is_open]
            cube, owner = _ranges(level.child[cube], level.child[cube + 1])
            box = box[owner]
        boxes = np.concatenate(boxes).astype(np.min_scalar_type(len(low)))
        order = np.argsort(boxes, kind="stable")
        ends = np.cumsum(np.bincount(boxes, minlength=len(low)))
        return np.concatenate(numbers)[order].astype(np.int32), ends


def _codes(q):
    """Numbers (n,) of the smallest cubes of points (n, 3): those of one cube follow each other."""
    low = q.min(axis=0)
    size = (q - low).max()
    cells = np.int64(1) << _LEVELS
    index = ((q - low) / (size if size > 0 else 1) * (cells - 1)).astype(np.int64)
    codes = np.zeros(len(q), np.int64)
    for bit in range(_LEVELS):
        for axis in range(3):
            codes |= (index[:, axis] >> bit & 1) << (3 * bit + axis)
    return codes


def _starts(codes):
    """Of each level, from the whole to cubes of few points, where in sorted codes cubes begin."""
    starts = []
    for level in range(_LEVELS + 1):
        cubes = codes >> 3 * (_LEVELS - level)
        starts.append(np.flatnonzero(np.append(True, cubes[1:] != cubes[:-1])))
        if np.diff(starts[-1], append=len(codes)).max() <= _FEW:
            break
    return starts


def _moments(q, p, weights):
    """Weights, and w times q, p, q^T q and p^T q: (n, 25)."""
    w, n = weights[:, None], len(q)
    products = [(w * a)[:, :, None] * q[:, None, :] for a in (q, p)]
    return np.hstack([w, w * q, w * p, *(product.reshape(n, 9) for product in products)])


def _stand_ins(moments):
    """q, p and weights of the stand-ins for clusters with such moments (k, 25)."""
    w = moments[:, :1]
    q, p = moments[:, 1:4] / w, moments[:, 4:7] / w
    covariances = [
        moments[:, first : first + 9].reshape(-1, 3, 3) / w[:, :, None] - a[:, :, None] * q[:, None]
        for first, a in ((7, q), (16, p))
    ]
    variances, axes = np.linalg.eigh(covariances[0])
    is_flat = variances <= _FLAT * variances[:, -1:]
    spread = np.sqrt(np.where(is_flat, 0, variances))
    motion = covariances[1] @ axes / np.where(is_flat, np.inf, spread)[:, None, :]
    corners = _STAND_INS.T
    dq, dp = (axes * spread[:, None, :]) @ corners, motion @ corners
    return (
        (q[:, :, None] + dq).transpose(0, 2, 1).reshape(-1, 3),
        (p[:, :, None] + dp).transpose(0, 2, 1).reshape(-1, 3),
        np.repeat(w[:, 0] / len(_STAND_INS), len(_STAND_INS)),
    )


def _ranges(first, last):
    """All integers from each of `first` to before `last`, and of which range each of them is."""
    counts = last - first
    owner = np.repeat(np.arange(len(first)), counts)
    return np.arange(counts.sum()) + (first - np.cumsum(counts) + counts)[owner], owner
