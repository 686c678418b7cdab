"""The weights of the control points, Eq. 2 and 27, in float64.

Sums are relative to the nearest control point, and weights relative to its weight. In floating
point this keeps the digits where the weights diverge.
"""

from functools import cached_property
from typing import NamedTuple

import numpy as np

from vtk_mls.reference.segments import gauss_rule, nearest_points


class EvaluationPoints(NamedTuple):
    """Places in the undeformed space where cuts in the rest frame are evaluated.

    For cuts that the search for x has crossed, blocked and unblocked control points are swapped.
    """

    x: np.ndarray  # (m, 3)
    crossed_cuts: np.ndarray  # (m, cuts)

    def rows(self, rows):
        """The points at some rows."""
        return EvaluationPoints(self.x[rows], self.crossed_cuts[rows])


# Smallest squared distance that detours are divided by, squared world units.
_MIN_SQUARE = 1e-200
# Squared distance, in squared local units, below which a point counts as on a control point.
_ON_CONTROL_POINT = 1e-32
# The same inside rigid regions: a control point there has the larger weight.
_IN_REGION = 1e-20


class WeightedPoints:
    """The control points (n), weighted for each of the points v (m, 3).

    Segments of curves are points, too: those of `segments.gauss_rule`, which depend on v.

    Parameters
    ----------
    with_slopes : bool
        Whether points for the slopes of segments are among them. Their weights are 0.

    Attributes
    ----------
    control_points, v : ControlPoints, and (m, 3) float64, world coordinates
    w : (m, n) float64
        Weights, relative to that of the nearest.
    dw : (m, n, 3) float64
        Derivatives dw/dv, relative to the nearest control point.
    dw_dx : (m, n, 3) float64
        Derivatives by the evaluation points x, likewise; 0 for cuts in the deformed frame.
    total : (m,) float64
        Sum of the weights.
    at_rest : (m,) bool
        Where cuts block all control points, so that the material is at rest.
    nearest : (m,) int
        k, the control point, or n and more for the segment, that is nearest to v.
    p_k, q_k : (m, 3) float64, world coordinates
        That control point, or the nearest point of that segment.
    x : (m, 3) float64, world units
        v - q_k.
    p_star, q_star : (m, 3) float64, world units
        p* - p_k and q* - q_k for the weighted means p* and q*.
    p, q : (m, n, 3) float64, world units
        The control points relative to p* and q*.
    """

    def __init__(self, deformation, control_points, v, evaluation_points=None, with_slopes=False):
        self.control_points, self.v = control_points, v
        self._alpha = alpha = deformation.alpha
        self._smoothing2 = deformation.smoothing**2
        handles = control_points.handles
        p, q, segments = handles.rest, handles.deformed, handles.segments
        offset, d2 = _distances(control_points, v, deformation.smoothing)
        # d log(w_i)/dv for w_i = d(v, q_i) / (|q_i - v|^2 + s^2)^alpha, Eq. 27
        slope = 2 * alpha * offset / d2[:, :, None]
        closest = nearest_points(segments, v)
        along_d2 = _floored(control_points, closest.d2 + self._smoothing2)
        d2 = np.concatenate([d2, along_d2], axis=1)
        # of segments, the slope of the damping alone
        slope = np.concatenate([slope, np.zeros((*along_d2.shape, 3))], axis=1)
        slope_by_x = np.zeros_like(slope)
        before = d2
        for ratio2, change in _detours(deformation, control_points, v, evaluation_points):
            # the damping of Eq. 28 as a larger distance from the control point
            d2 = d2 * ratio2 ** (deformation.nu / (2 * alpha))
            if deformation.in_rest_frame:
                slope_by_x += deformation.nu * change
            else:
                slope = slope + deformation.nu * change
        self.nearest = nearest = d2.argmin(axis=1)
        rows = np.arange(len(v))
        nearest_d2 = d2[rows, nearest]
        self.at_rest = np.isinf(nearest_d2)
        nearest_d2 = np.where(self.at_rest, 1, nearest_d2)
        # w_i, relative to the nearest and times the weight of the control point
        n = len(p)
        share = np.where(np.isinf(d2[:, :n]), 0, nearest_d2[:, None] / d2[:, :n])
        self.w = handles.weights * np.where(self.at_rest[:, None], 1, share) ** alpha

        nearest_p, nearest_q = (
            np.concatenate([np.broadcast_to(points, (len(v), n, 3)), along], axis=1)
            for points, along in ((p, closest.p), (q, closest.q))
        )
        self.p_k, self.q_k = nearest_p[rows, nearest], nearest_q[rows, nearest]
        self.x = v - self.q_k
        p, q = p - self.p_k[:, None], q - self.q_k[:, None]
        self._slope, self._slope_by_x, self._extra = slope[:, :n], slope_by_x[:, :n], 0
        # a common factor of all weights cancels, so the slope of the nearest is taken as 0
        self._near, self._near_by_x = slope[rows, nearest], slope_by_x[rows, nearest]
        if len(segments) > 0:
            damping = np.where(self.at_rest[:, None], 1, before / d2)[:, n:] ** alpha
            factors = segments.weights * damping
            added = self._along(segments, closest, nearest_d2, factors, alpha)
            p, q = self._with_points(p, q, added, slope[:, n:], slope_by_x[:, n:])
            self._extra = np.zeros_like(self._slope)
        if len(segments) > 0 and with_slopes:
            added = self._along(segments, closest, nearest_d2, factors, alpha + 1)
            change = added.q + (self.q_k - v)[:, None]
            change = 2 * alpha * (added.w / nearest_d2[:, None])[:, :, None] * change
            added = added._replace(w=np.zeros_like(added.w))
            p, q = self._with_points(p, q, added, slope[:, n:], slope_by_x[:, n:])
            self._extra = np.concatenate([self._extra, change], axis=1)
        self.total = self.w.sum(axis=1)
        # p* and q*, before Eq. 4
        self.p_star, self.q_star = self._mean(p), self._mean(q)
        self.p, self.q = p - self.p_star[:, None], q - self.q_star[:, None]

    def _along(self, segments, closest, scale2, factors, alpha):
        """Points on the segments, relative to p_k and q_k, for weights of the power `alpha`."""
        order = self.control_points.kind.segment_points
        t, w = gauss_rule(segments, self.v, self._smoothing2, scale2, alpha, order)
        places = [
            (at - k[:, None])[:, :, None] + t[..., None] * (ends[:, 1] - ends[:, 0])[:, None]
            for at, k, ends in (
                (closest.p, self.p_k, segments.rest),
                (closest.q, self.q_k, segments.deformed),
            )
        ]
        shape = len(t), t.shape[1] * t.shape[2]
        weights = (w * factors[..., None]).reshape(shape)
        return _Points(*(x.reshape(*shape, 3) for x in places), weights)

    def _with_points(self, p, q, added, slope, slope_by_x):
        """p and q with the `added` points of segments, whose dampings have these slopes."""
        count = added.w.shape[1] // max(1, slope.shape[1])
        slope, slope_by_x = (np.repeat(x, count, axis=1) for x in (slope, slope_by_x))
        self.w = np.concatenate([self.w, added.w], axis=1)
        self._slope = np.concatenate([self._slope, slope], axis=1)
        self._slope_by_x = np.concatenate([self._slope_by_x, slope_by_x], axis=1)
        return np.concatenate([p, added.p], axis=1), np.concatenate([q, added.q], axis=1)

    @cached_property
    def dw(self):
        return self.w[:, :, None] * (self._slope - self._near[:, None]) + self._extra

    @cached_property
    def dw_dx(self):
        return self.w[:, :, None] * (self._slope_by_x - self._near_by_x[:, None])

    def values_of(self, basis):
        """Values of a `Basis` at the control points (m or 1, n, functions) less those at k.

        `basis` has values at the control points without those of segments.
        """
        n = len(self.control_points)
        values = np.broadcast_to(basis.values[:n], (len(self.v), n, len(basis)))
        if self.w.shape[1] == n:
            origin = basis.values[self.nearest]
        else:
            q = (self.q + (self.q_star + self.q_k)[:, None])[:, n:]
            local = self.control_points.local(q.reshape(-1, 3))
            along = basis(local).reshape(*q.shape[:2], len(basis))
            values = np.concatenate([values, along], axis=1)
            origin = basis(self.control_points.local(self.q_k))
        return values, origin

    def _mean(self, values):
        return np.einsum("mi,mia->ma", self.w, values) / self.total[:, None]


class _Points(NamedTuple):
    """Points of segments for each v: p and q (m, n, 3), and weights (m, n)."""

    p: np.ndarray
    q: np.ndarray
    w: np.ndarray


def _floored(control_points, d2):
    return np.maximum(d2, _ON_CONTROL_POINT * control_points.scale**2)


def _detours(deformation, control_points, v, evaluation_points):
    """The `_detour`s of the cuts with an edge, to control points and segments."""
    rest_anchors, anchors = control_points.handles.anchors
    if not deformation.in_rest_frame:
        return [_detour(cut, v, anchors, False) for cut in deformation.obstacles]
    if evaluation_points is None:
        return []
    x, crossed_cuts = evaluation_points
    return [
        _detour(cut, x, rest_anchors, is_crossed[:, None])
        for cut, is_crossed in zip(deformation.obstacles, crossed_cuts.T)
    ]


def _distances(control_points, v, smoothing):
    """q_i - v (m, n, 3), and the squared distances (m, n) in the weights.

    Proxies of a rigid region share the distance from the region, and the offset to its surface.
    """
    offset = control_points.handles.deformed - v[:, None]
    d2 = np.einsum("mia,mia->mi", offset, offset)
    d2 = _floored(control_points, d2 + smoothing**2)
    for row, region in enumerate(control_points.handles.regions):
        proxies = control_points.handles.region == row
        distance, away = region.distance(v)
        floor = _IN_REGION * control_points.scale**2
        d2[:, proxies] = np.maximum(distance**2, floor)[:, None]
        offset[:, proxies] = -away[:, None]
    return offset, d2


def _detour(cut, v, q, is_crossed):
    """(|detour| / |q - v|)^2 for each v and q; d log(d)/dv / nu of Eq. 28.

    For a crossed cut, blocked and unblocked are swapped.
    """
    v = v[:, None]
    blocked = cut.blocks(v, q) ^ is_crossed
    v, q = (points[blocked] for points in np.broadcast_arrays(v, q))
    offset = q - v
    d2 = np.maximum(np.einsum("ma,ma->m", offset, offset), _MIN_SQUARE)
    bend = cut.bend(v, q)
    leg = v - bend
    length = np.linalg.norm(leg, axis=1)
    path = length + np.linalg.norm(q - bend, axis=1)
    closed = np.isnan(path)
    ratio2, change = np.ones(blocked.shape), np.zeros((*blocked.shape, 3))
    ratio2[blocked] = np.where(closed, np.inf, np.maximum(path**2 / d2, 1))
    slope = -offset / d2[:, None] - leg / np.maximum(length * path, 1e-300)[:, None]
    change[blocked] = np.where(closed[:, None], 0, slope)
    return ratio2, change
