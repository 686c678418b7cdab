"""Polyharmonic splines: the smoothest map through the control points.

``G(v) = v + A [1, v] + sum_i c_i phi(|v - q_i|)`` with ``phi = -r``, ``r^2 log r`` or ``r^3``, and
weights c that vanish on affine functions (Duchon 1977). With a softening l, r is
``sqrt(|v - q_i|^2 + l^2)``: order 1 is then Hardy's multiquadric, which is smooth at control points
and as straight as r far from them. A smoothing s adds ``s^order / weight_i`` to the diagonal of the
equations (Wahba 1990). One decomposition of these gives, for every s, the error at each control
point of the spline without it (Rippa 1999).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, partial
from operator import attrgetter

import numpy as np

from vtk_mls.base.errors import InputError
from vtk_mls.base.linear_algebra import distances
from vtk_mls.model.kinds.kind import Fit, Kind
from vtk_mls.model.kinds.polynomials import RANK_TOLERANCE

AUTOMATIC = 0
MIN_LANDMARKS = 5  # from which the errors of landmarks left out tell something
MAX_POINTS = 5000
_MAX_CHOSEN_FROM = 1500  # control points, from which order and smoothing are chosen
# Smoothings that are tried, as additions to the diagonal in local units.
_TRIED = np.append(0, 10.0 ** np.arange(-9, 1.1, 0.25))
# Softenings of order 1 that are tried, local units. The search begins at the third.
_SOFTENINGS = (0.0, 0.125, 0.25, 0.5, 1.0, 2.0, 4.0)
# Addition to the diagonal, relative to the bound of eigenvalues, so that it is never singular.
_FLOOR = 1e-15
_MIN_WEIGHT = 1e-6  # of the largest, where settings are chosen
_LONE = 1e-8  # below it, the diagonal of the solved equations counts as 0
# Expected error of float sums, local units, above which kernels sum in double.
_MAX_FLOAT_ERROR = 3e-6
# The same, above which a device without double does not compute the map.
_MAX_ERROR_WITHOUT_DOUBLE = 2e-4


def _log(r):
    return np.log(np.where(r > 0, r, 1))


# Radial functions, positive definite where weights vanish on affine functions.
_RADIAL = {1: lambda r: -r, 2: lambda r: r * r * _log(r), 3: lambda r: r**3}
_SLOPE = {  # phi'(r) / r; 0 in the cone of r
    1: lambda r: np.where(r > 0, -1 / np.where(r > 0, r, 1), 0),
    2: lambda r: np.where(r > 0, 2 * _log(r) + 1, 0),
    3: lambda r: 3 * r,
}
ORDERS = tuple(_RADIAL)


class Spline(Kind):
    """Splines of an order 1, 2 or 3, with a smoothing and a softening in world units."""

    name = "spline"
    kernel = "fit_spline.cl"
    is_local = False

    def __init__(self, order=AUTOMATIC, smoothing=0.0, softening=-1.0, left_out=None, **_):
        self.order, self.smoothing = order, smoothing
        self.softening = 0.0 if order != AUTOMATIC and softening < 0 else softening
        self.left_out = left_out  # errors (n, 3) by which these were chosen, world units

    @property
    def has_peaks(self):
        return self.order == 1 and self.softening == 0

    def chosen(self, handles):
        if len(handles) > MAX_POINTS:
            raise InputError(
                f"must be at most {MAX_POINTS} control points for the kind spline, got "
                f"{len(handles)}; take the kind affine, or fewer points",
                argument="rest",
            )
        if self.order != AUTOMATIC and self.smoothing >= 0:
            return self
        orders = ORDERS if self.order == AUTOMATIC else (self.order,)
        choice = best_choice(
            *(handles.deformed, handles.rest - handles.deformed, handles.weights, orders),
            *(length if length >= 0 else None for length in (self.smoothing, self.softening)),
        )
        return Spline(choice.order, choice.smoothing, choice.softening, choice.left_out)

    def determined(self, points):
        handles = points.handles
        u = (handles.rest - handles.deformed - points.mean_displacement) / points.scale
        q = points.local(handles.deformed)
        system = _System(q, handles.weights, self.order, self.softening / points.scale)
        return system.solved(u, (self.smoothing / points.scale) ** self.order)

    def fit(self, weighted):
        points = weighted.control_points
        displacement, slope = points.determined(points.local(weighted.v))
        none = np.broadcast_to(0.0, (*weighted.w.shape, 3))
        return Fit(
            points.scale * displacement + points.mean_displacement,
            np.eye(3) + slope,
            lambda: none,  # no weight depends on v
        )

    def needs_float64(self, alpha, points, max_error=0.0):
        return points.determined.float_error > max(max_error, _MAX_FLOAT_ERROR)

    def is_wrong_in_float32(self, points):
        return points.determined.float_error > _MAX_ERROR_WITHOUT_DOUBLE

    def constants(self):
        return {"ORDER": self.order}

    def table(self, points):
        """The affine part, the softening squared, q and c of each control point.

        All of them twice: in float32, then in float64.
        """
        spline = points.determined
        exact = np.append(spline.affine.T, spline.softening**2)
        exact = np.append(exact, np.hstack([spline.q, spline.c]))
        return np.append(exact.astype(np.float32), exact.view(np.float32))


@dataclass(frozen=True, eq=False)
class Solution:
    """The displacement of a spline, in local units."""

    order: int
    softening: float
    q: np.ndarray  # (n, 3)
    c: np.ndarray  # (n, 3)
    affine: np.ndarray  # (4, 3): of 1, x, y and z

    def __call__(self, x):
        """The displacements (m, 3) at `x` (m, 3), and their derivatives (m, 3, 3)."""
        r = _softened_distances(x, self.q, self.softening)
        value = self.affine[0] + x @ self.affine[1:] + _RADIAL[self.order](r) @ self.c
        slope = _SLOPE[self.order](r)
        # sum_i c_i slope_i (x - q_i)^T
        outer = np.einsum("mi,ia,ib->mab", slope, self.c, -self.q)
        outer += np.einsum("ma,mb->mab", slope @ self.c, x)
        return value, self.affine[1:].T + outer

    @cached_property
    def float_error(self):
        """The expected error of sums in float32 over the box of the control points."""
        largest = np.hypot(2.0, self.softening)
        terms = self.c * np.abs(_RADIAL[self.order](largest))
        return 4 * np.finfo(np.float32).eps * np.linalg.norm(terms)


class _System:
    """The equations of a spline through `q` (n, 3), local units, with `weights` (n,).

    Affine functions that the points do not determine (of points on a plane, those across it) are
    left out: so the map is the identity there.
    """

    def __init__(self, q, weights, order, softening):
        self.q, self.weights, self.order, self.softening = q, weights, order, softening
        self.matrix = _RADIAL[order](_softened_distances(q, q, softening))
        self.bound = np.abs(self.matrix).sum(axis=1).max() or 1.0  # of its eigenvalues
        self._middle = q.mean(axis=0)  # functions across a plane of points are 0 on it then
        self.affine, self._to_affine = affine_basis(q)

    def bordered(self, addition):
        """The equations with side conditions."""
        n, k = self.affine.shape
        result = np.zeros((n + k, n + k))
        result[:n, :n] = self.matrix
        result[:n, n:], result[n:, :n] = self.affine, self.affine.T
        result[range(n), range(n)] += addition / self.weights + _FLOOR * self.bound
        return result

    def solved(self, u, addition):
        """The spline with displacements `u` (n, 3), and an `addition` to the diagonal."""
        n, k = self.affine.shape
        found = np.linalg.solve(self.bordered(addition), np.vstack([u, np.zeros((k, 3))]))
        affine = self._to_affine @ found[n:]
        affine[0] -= self._middle @ affine[1:]
        return Solution(self.order, self.softening, self.q, found[:n], affine)

    def left_out(self, u, additions):
        """Errors (k, n, 3) at each point of the spline without it, for each of the `additions`.

        NaN where a point alone determines an affine function. Rows and columns have the factor
        sqrt(weight), so that an addition is the same for all.
        """
        root = np.sqrt(np.maximum(self.weights, _MIN_WEIGHT * self.weights.max()))[:, None]
        affine, _ = affine_basis(self.q, root)

        def projected(values):
            return values - affine @ (affine.T @ values)

        matrix = projected(projected(root * self.matrix * root.T).T)
        # affine functions have an eigenvalue of their own, above all others
        shift = 2 * self.bound * self.weights.max()
        values, vectors = np.linalg.eigh(matrix + shift * affine @ affine.T)
        count = len(values) - affine.shape[1]
        values, vectors = np.maximum(values[:count], _FLOOR * shift), vectors[:, :count]
        data = vectors.T @ (root * u)
        additions = np.maximum(additions, _FLOOR * shift)[:, None]
        inverse = (shift + additions) / (values + additions)
        diagonal = without_lone(inverse @ (vectors**2).T)
        c = vectors @ (inverse[:, :, None] * data)
        return c / diagonal[:, :, None] / root


@dataclass(frozen=True, eq=False)
class Choice:
    """Settings of a spline, and the errors of control points left out."""

    order: int
    smoothing: float  # world units
    softening: float  # world units
    left_out: np.ndarray  # (n, 3), world units

    @cached_property
    def score(self):
        """The mean square root of the errors.

        A few wrong points do not matter much, nor do a few exact ones.
        """
        return np.sqrt(self.sizes).mean() if len(self.sizes) else 0.0

    @property
    def sizes(self):
        """The errors (m,) of the points that have one."""
        size = np.linalg.norm(self.left_out, axis=1)
        return size[np.isfinite(size)]


def choices(
    q, u, weights, orders=ORDERS, smoothing=None, softening=None, key=attrgetter("score"), near=None
) -> list[Choice]:
    """All settings to choose from.

    Parameters
    ----------
    q, u, weights : (n, 3), (n, 3) and (n,) float64
        Control points, displacements and weights, world coordinates.
    orders : sequence of int
        The orders to choose from.
    smoothing, softening : float, optional
        World units; None to choose them. Only order 1 is softened then.
    key : callable
        Of a Choice; the smallest is the best.
    near : float, optional
        World units; the softening at which the search for the best begins.
    """
    local, scale = _local(q)

    def tried(order, length):
        additions = _TRIED if smoothing is None else np.array([(smoothing / scale) ** order])
        errors = _System(local, weights, order, length).left_out(u, additions)
        return [
            Choice(order, scale * addition ** (1 / order), scale * length, error)
            for addition, error in zip(additions, errors)
        ]

    found = []
    for order in orders:
        if softening is None and order == 1:
            found += _softened(partial(tried, order), key, near and near / scale)
        else:
            found += tried(order, (softening or 0) / scale)
    return found


def _softened(tried, key, near):
    """The choices `tried` from `near` on until both neighbors of the best softening are worse."""
    found = {}

    def best(i):
        if i not in found:
            found[i] = tried(_SOFTENINGS[i])
        return min(map(key, found[i]))

    i = 2 if near is None else int(np.abs(np.subtract(_SOFTENINGS, near)).argmin())
    while True:
        neighbors = [j for j in (i - 1, i + 1) if j in range(len(_SOFTENINGS))]
        better = min(neighbors, key=best)
        if best(better) >= best(i):
            return [choice for kept in found.values() for choice in kept]
        i = better


def best_choice(q, u, weights, orders=ORDERS, smoothing=None, softening=None) -> Choice:
    """The settings with the least errors of control points left out; see `choices`."""
    rows = chosen_from(len(q))
    found = choices(q[rows], u[rows], weights[rows], orders, smoothing, softening)
    return min(found, key=attrgetter("score"))


def chosen_from(count, most=None):
    """Rows (m,) of the control points to choose settings from, at most `most` or 1,500."""
    most = most or _MAX_CHOSEN_FROM
    if count <= most:
        return np.arange(count)
    return np.sort(np.random.default_rng(0).permutation(count)[:most])


def precision(q, weights, order, smoothing, softening) -> np.ndarray:
    """The matrix P (n, n) of the equations of a spline solved: ``c = P u``, up to a factor.

    By the factor the diagonal is at least 1 less the leverage of the point in an affine fit.

    The error at point i without it is ``c_i / P_ii``, and 1 / P_ii its variance as a Gaussian
    process has it (Dubrule 1983).
    """
    local, scale = _local(q)
    system = _System(local, weights, order, softening / scale)
    addition = (smoothing / scale) ** order
    inverse = np.linalg.inv(system.bordered(addition))
    return inverse[: len(q), : len(q)] * (system.bound + addition)


def affine_basis(points, factors=1.0) -> tuple[np.ndarray, np.ndarray]:
    """Of affine functions on `points` (n, 3), an orthonormal basis (n, k), and what makes it.

    The functions are 1 and the coordinates from the middle, times `factors` (n, 1).
    """
    functions = np.column_stack([np.ones(len(points)), points - points.mean(axis=0)])
    u, singular, v = np.linalg.svd(factors * functions, full_matrices=False)
    rank = int((singular > RANK_TOLERANCE * singular[0]).sum())
    return u[:, :rank], v[:rank].T / singular[:rank]


def in_words(order, smoothing, softening) -> str:
    """The settings of a spline, world units."""
    lengths = (("softening", softening), ("smoothing", smoothing))
    texts = [f"{name} {length:.3g}" for name, length in lengths if length > 0]
    return ", ".join([f"spline of order {order}", *texts])


def without_lone(diagonal):
    """The diagonal (..., n) of `precision`; NaN where a point alone determines a function."""
    return np.where(diagonal > _LONE, diagonal, np.nan)


def _softened_distances(x, q, softening):
    r = distances(x, q)
    return np.sqrt(r * r + softening**2)


def _local(q):
    center = q.mean(axis=0)
    scale = np.abs(q - center).max() or 1.0
    return (q - center) / scale, scale
