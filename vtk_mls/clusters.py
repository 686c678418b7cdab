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
_SPREAD = (
    (32, 0x1F00000000FFFF),
    (16, 0x1F0000FF0000FF),
    (8, 0x100F00F00F00F00F),
    (4, 0x10C30C30C30C30C3),
    (2, 0x1249249249249249),
)
_FLAT = 1e-9  # next to the largest a variance that is rounding


@dataclass(frozen=True, eq=False)
class _Level:
    """Cubes of one size.

    In the order of the tree, `start` to `stop` (k,) are the control points in each, and `child` to
    the next `child` (k + 1,) its cubes of the next level. `mean` (3, k) and the square of the
    `radius` (k,) are of their q; `stand_in` (k,) is the number of the first of its stand-ins, where
    it `is_cluster` (k,).
    """

    start: np.ndarray
    stop: np.ndarray
    child: np.ndarray
    is_cluster: np.ndarray
    mean: np.ndarray
    radius2: np.ndarray
    stand_in: np.ndarray


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
        order = np.argsort(codes, kind="stable")
        starts = _starts(codes[order])
        inside = np.ascontiguousarray(q[order].T)
        moments = _moments(inside, np.ascontiguousarray(p[order].T), weights[order])
        self._levels, tables = [], [(q, p, weights)]
        below, count = None, len(q)
        for start in reversed(starts):
            child = None if below is None else np.searchsorted(below, np.append(start, len(q)))
            first = start if child is None else child[:-1]
            moments, below = np.add.reduceat(moments, first, axis=1), start
            stop = np.append(start[1:], len(q))
            is_cluster = stop - start > _FEW
            stand_in = count + len(_STAND_INS) * (np.cumsum(is_cluster) - 1)
            tables.append(_stand_ins(moments[:, is_cluster].T))
            count += len(tables[-1][2])
            mean, owner = moments[1:4] / moments[0], np.repeat(np.arange(len(start)), stop - start)
            apart2 = sum(np.square(axis - of_cube[owner]) for axis, of_cube in zip(inside, mean))
            radius2 = np.maximum.reduceat(apart2, start)
            level = _Level(start, stop, child, is_cluster, mean, radius2, stand_in)
            self._levels.insert(0, level)
        self.q, self.p, self.weights = (np.concatenate(column) for column in zip(*tables))
        # what ranges of control points in the order of the tree, and of stand-ins, are made of
        self._rows = np.concatenate([order, np.arange(len(q), count)]).astype(np.int32)

    def near(self, low, high, relative_size):
        """What counts in boxes: clusters with a radius below `relative_size` times their distance.

        Those nearer than half a box are not taken: their errors would change within it.

        Parameters
        ----------
        low, high : (b, 3) float64, local frame
            Corners of the boxes.
        relative_size : (b,) float64, < 1

        Returns
        -------
        numbers : (k,) int32
            Rows of `q`, `p` and `weights`, those of one box after those of the other.
        ends : (b,) ints
            Where they end in `numbers`.
        """
        middle, half = (low + high).T / 2, (high - low).T / 2
        size2, clearance2 = np.square(relative_size), np.square(half.max(axis=0))
        box, cube = np.arange(len(low)), np.zeros(len(low), int)
        boxes, firsts, lasts = [], [], []

        def take(which, first, last):
            boxes.append(box[which])
            firsts.append(first)
            lasts.append(last)

        def take_points(which):
            take(which, level.start[cube[which]], level.stop[cube[which]])

        for level in self._levels:
            is_cluster = level.is_cluster[cube]
            take_points(~is_cluster)
            box, cube = box[is_cluster], cube[is_cluster]
            distance2 = _distance2(level.mean, cube, middle, half, box)
            is_far = level.radius2[cube] < size2[box] * distance2
            is_far &= distance2 > clearance2[box]
            first = level.stand_in[cube[is_far]]
            take(is_far, first, first + len(_STAND_INS))
            if level.child is None:
                take_points(~is_far)
                break
            box, cube = box[~is_far], cube[~is_far]
            cube, owner = _ranges(level.child[cube], level.child[cube + 1])
            box = box[owner]
        boxes, firsts, lasts = map(np.concatenate, (boxes, firsts, lasts))
        order = np.argsort(boxes.astype(np.min_scalar_type(len(low))), kind="stable")
        boxes, firsts, lasts = boxes[order], firsts[order], lasts[order]
        lengths = np.bincount(boxes, lasts - firsts, len(low))
        return self._rows[_ranges(firsts, lasts)[0]], np.cumsum(lengths).astype(int)


def _distance2(mean, cube, middle, half, box):
    """Squared distances of means (3, k) of cubes from boxes about middles (3, b), pair by pair."""
    squares = 0
    for axis in range(3):
        apart = np.abs(mean[axis][cube] - middle[axis][box])
        apart -= half[axis][box]
        squares = squares + np.square(np.maximum(apart, 0, out=apart), out=apart)
    return squares


def _codes(q):
    """Numbers (n,) of the smallest cubes of points (n, 3): those of one cube follow each other."""
    low = q.min(axis=0)
    size = (q - low).max()
    cells = np.int64(1) << _LEVELS
    index = ((q - low) / (size if size > 0 else 1) * (cells - 1)).astype(np.int64)
    # each of the 20 bits moves to three times its place
    for shift, kept in _SPREAD:
        index = (index | index << shift) & kept
    return index @ np.array([1, 2, 4])


def _starts(codes):
    """Of each level with clusters, and of the whole, where in sorted codes cubes begin."""
    starts = []
    for level in range(_LEVELS + 1):
        cubes = codes >> 3 * (_LEVELS - level)
        start = np.flatnonzero(np.append(True, cubes[1:] != cubes[:-1]))
        if starts and np.diff(start, append=len(codes)).max() <= _FEW:
            break
        starts.append(start)
    return starts


def _moments(q, p, weights):
    """Weights, and w times q, p, q^T q and p^T q of points (3, n): (25, n)."""
    moments = np.empty((25, len(weights)))
    moments[0] = weights
    for rows, factors, by in (
        (slice(1, 4), q, weights),
        (slice(4, 7), p, weights),
        *((slice(7 + 3 * i, 10 + 3 * i), q, moments[1 + i]) for i in range(6)),
    ):
        np.multiply(factors, by, out=moments[rows])
    return moments


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
    before = np.cumsum(counts) - counts
    owner = np.repeat(np.arange(len(first)), counts)
    integers = (first - before)[owner]
    integers += np.arange(len(owner))
    return integers, owner
