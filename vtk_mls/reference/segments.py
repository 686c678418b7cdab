"""Segments of curves as few points each, for every place v, in float64.

A segment adds the integrals of its weight w(t) times polynomials in t to the sums of a fit. These
integrals are computed by quadrature; the Gauss rule for the measure w(t) dt then has the same.
"""

from typing import NamedTuple

import numpy as np

# Nodes of the quadrature on each side of the point nearest to v. The weight has its poles at a
# distance of pi / 2 from the axis after the substitution t = a sinh(u): the error is below 1e-10
# for a distance from the curve of 1e-16 of a segment.
_NODES = 40
_AT, _SHARE = np.polynomial.legendre.leggauss(_NODES)


class Nearest(NamedTuple):
    """The points of segments nearest to each v."""

    t: np.ndarray  # (m, s): their shares of the segments' lengths
    p: np.ndarray  # (m, s, 3), world coordinates
    q: np.ndarray
    d2: np.ndarray  # (m, s): squared distances of q from v


def nearest_points(segments, v):
    """The `Nearest` of `segments`, a `Segments`, for the points `v` (m, 3)."""
    (p, dp), (q, dq) = ((x[:, 0], x[:, 1] - x[:, 0]) for x in (segments.rest, segments.deformed))
    projection = np.einsum("msa,sa->ms", v[:, None] - q, dq) / np.einsum("sa,sa->s", dq, dq)
    t = np.clip(projection, 0, 1)
    q = q + t[:, :, None] * dq
    return Nearest(t, p + t[:, :, None] * dp, q, ((q - v[:, None]) ** 2).sum(axis=2))


def gauss_rule(segments, v, smoothing2, scale2, alpha, order):
    """Points that have the moments of the weights up to 2 `order` - 1.

    The weights are those of t, (scale2 / (|q(t) - v|^2 + smoothing2))^alpha, with `scale2` (m,) for
    the points `v` (m, 3). The shares t of the lengths of s segments, from the point nearest to v
    on, and the weights are (m, s, order).
    """
    q, along = segments.deformed[:, 0], segments.deformed[:, 1] - segments.deformed[:, 0]
    length2 = np.einsum("sa,sa->s", along, along)
    projection = np.einsum("msa,sa->ms", v[:, None] - q, along) / length2
    off = v[:, None] - q - projection[:, :, None] * along
    width2 = (np.einsum("msa,msa->ms", off, off) + smoothing2) / length2
    width = np.sqrt(np.maximum(width2, 1e-32))
    start = np.clip(projection, 0, 1) - projection  # of the nearest point, from the projection on
    ends = [np.arcsinh(s / width) for s in (-projection, start, 1 - projection)]
    t, weights = [], []
    for low, high in zip(ends, ends[1:]):
        half = (high - low)[:, :, None] / 2
        u = (low + high)[:, :, None] / 2 + half * _AT
        t.append(width[:, :, None] * np.sinh(u) - start[:, :, None])
        distance2 = (width[:, :, None] * np.cosh(u)) ** 2 * length2[:, None]
        density = (scale2[:, None, None] / distance2) ** alpha
        weights.append(half * _SHARE * density * width[:, :, None] * np.cosh(u))
    return _reduced(np.concatenate(t, axis=2), np.concatenate(weights, axis=2), order)


def _reduced(t, weights, order):
    """The Gauss rule of `order` points for the points `t` (..., n) with `weights`.

    Stieltjes' procedure finds the recurrence of the orthogonal polynomials; the eigenvalues and
    eigenvectors of its matrix are the rule (Golub and Welsch 1969).
    """
    total = weights.sum(axis=-1)
    share = weights / total[..., None]
    mean = (share * t).sum(axis=-1)
    offset = t - mean[..., None]
    sigma = np.sqrt((share * offset**2).sum(axis=-1))
    x = offset / sigma[..., None]
    matrix = np.zeros((*total.shape, order, order))
    before, current, norm = np.zeros_like(x), np.ones_like(x), np.ones_like(total)
    for j in range(order):
        diagonal = (share * x * current**2).sum(axis=-1) / norm
        matrix[..., j, j] = diagonal
        if j + 1 == order:
            break
        ratio = matrix[..., j, j - 1] ** 2 if j > 0 else np.zeros_like(total)
        following = (x - diagonal[..., None]) * current - ratio[..., None] * before
        before, current = current, following
        norm, last = (share * current**2).sum(axis=-1), norm
        matrix[..., j, j + 1] = matrix[..., j + 1, j] = np.sqrt(norm / last)
    values, vectors = np.linalg.eigh(matrix)
    rule = mean[..., None] + sigma[..., None] * values
    return rule, total[..., None] * vectors[..., 0, :] ** 2
