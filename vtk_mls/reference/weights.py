"""The weights of the control points, Eq. 2 and 27, in float64.

Sums are relative to the nearest control point, and weights relative to its weight. In floating
point this keeps the digits where the weights diverge.
"""

from __future__ import annotations

from functools import cached_property
from typing import NamedTuple

import numpy as np


class EvaluationPoints(NamedTuple):
    """Places in the undeformed space where cuts in the rest frame are evaluated.

    Attributes
    ----------
    x : (m, 3) float64, world coordinates of the undeformed space
    crossed_cuts : (m, cuts) bool
        Cuts that the search for x has crossed: for these, blocked and unblocked control points are
        swapped.
    """

    x: np.ndarray
    crossed_cuts: np.ndarray

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

    Attributes
    ----------
    control_points : ControlPoints
    v : (m, 3) float64, world coordinates
    w : (m, n) float64
        Weights, relative to the largest.
    dw : (m, n, 3) float64
        Derivatives dw/dv, relative to the nearest control point.
    dw_dx : (m, n, 3) float64
        Derivatives by the evaluation points x, likewise; 0 for cuts in the deformed frame.
    total : (m,) float64
        Sum of the weights.
    at_rest : (m,) bool
        Where cuts block all control points, so that the material is at rest.
    nearest : (m,) int
        k, the control point of the largest weight.
    p_k, q_k : (m, 3) float64, world coordinates
        That control point.
    x : (m, 3) float64, world units
        v - q_k.
    p_star, q_star : (m, 3) float64, world units
        p* - p_k and q* - q_k for the weighted means p* and q*.
    p, q : (m, n, 3) float64, world units
        The control points relative to p* and q*.
    """

    def __init__(self, deformation, control_points, v, evaluation_points=None):
        self.control_points, self.v = control_points, v
        in_rest_frame = deformation.in_rest_frame
        alpha = deformation.alpha
        p, q = control_points.rest, control_points.deformed
        offset, d2 = _distances(control_points, v, deformation.smoothing)
        # d log(w_i)/dv for w_i = d(v, q_i) / (|q_i - v|^2 + s^2)^alpha, Eq. 27
        slope = 2 * alpha * offset / d2[:, :, None]
        rest_anchors, anchors = control_points.handles.anchors
        slope_by_x = np.zeros_like(slope)
        detours = []
        if not in_rest_frame:
            detours = [_detour(cut, v, anchors, False) for cut in deformation.obstacles]
        elif evaluation_points is not None:
            x, crossed_cuts = evaluation_points
            detours = [
                _detour(cut, x, rest_anchors, is_crossed[:, None])
                for cut, is_crossed in zip(deformation.obstacles, crossed_cuts.T)
            ]
        for ratio2, change in detours:
            # the damping of Eq. 28 as a larger distance from the control point
            d2 = d2 * ratio2 ** (deformation.nu / (2 * alpha))
            if in_rest_frame:
                slope_by_x += deformation.nu * change
            else:
                slope = slope + deformation.nu * change
        nearest = d2.argmin(axis=1)
        rows = np.arange(len(v))
        nearest_d2 = d2[rows, nearest][:, None]
        self.at_rest = np.isinf(nearest_d2[:, 0])
        # w_i, relative to the largest and times the weight of the control point
        share = np.where(np.isinf(d2), 0, np.where(self.at_rest[:, None], 1, nearest_d2) / d2)
        self.w = control_points.weights * np.where(self.at_rest[:, None], 1, share) ** alpha
        self._slope, self._slope_by_x = slope, slope_by_x
        self.total = self.w.sum(axis=1)

        self.p_k, self.q_k = p[nearest], q[nearest]
        p, q = p - self.p_k[:, None], q - self.q_k[:, None]
        self.x = v - self.q_k
        # p* and q*, before Eq. 4
        self.p_star, self.q_star = self._mean(p), self._mean(q)
        self.p, self.q = p - self.p_star[:, None], q - self.q_star[:, None]
        self.nearest = nearest

    @cached_property
    def dw(self):
        return self._derivatives(self._slope)

    @cached_property
    def dw_dx(self):
        return self._derivatives(self._slope_by_x)

    def _derivatives(self, slope):
        # a common factor of all weights cancels, so the slope of the nearest is taken as 0
        nearest = slope[np.arange(len(self.v)), self.nearest]
        return self.w[:, :, None] * (slope - nearest[:, None])

    def _mean(self, values):
        return np.einsum("mi,mia->ma", self.w, values) / self.total[:, None]


def _distances(control_points, v, smoothing):
    """q_i - v (m, n, 3), and the squared distances (m, n) in the weights.

    Proxies of a rigid region share the distance from the region, and the offset to its surface.
    """
    offset = control_points.deformed - v[:, None]
    d2 = np.einsum("mia,mia->mi", offset, offset)
    d2 = np.maximum(d2 + smoothing**2, _ON_CONTROL_POINT * control_points.scale**2)
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
