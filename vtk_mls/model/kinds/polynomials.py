"""Affine and polynomial deformations: weighted orthogonal polynomials, Eq. 5 to 7 and 23 to 26."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vtk_mls.base.linear_algebra import transformed
from vtk_mls.model.kinds.kind import Fit, Kind

# Exponents of the monomials of degree 1, 2 and 3, in the order of basis.cl.
MONOMIALS = np.array(
    [
        *[(1, 0, 0), (0, 1, 0), (0, 0, 1)],
        *[(2, 0, 0), (0, 2, 0), (0, 0, 2), (1, 1, 0), (1, 0, 1), (0, 1, 1)],
        *[(3, 0, 0), (0, 3, 0), (0, 0, 3), (2, 1, 0), (2, 0, 1)],
        *[(1, 2, 0), (0, 2, 1), (1, 0, 2), (0, 1, 2), (1, 1, 1)],
    ]
)
MONOMIAL_COUNT = {1: 3, 2: 9, 3: 19}
_FACTORIALS = np.array([1, 1, 2, 6])

# Relative size below which a function counts as zero on the control points. A plane set in float32
# is flat to about 1e-7.
RANK_TOLERANCE = 1e-5
# Relative squared norm below which a function is rounding error after orthogonalization.
_MIN_SQUARED_NORM = 1e-20


class Polynomial(Kind):
    """Polynomials of degree 1, 2 or 3."""

    name = "polynomial"
    kernel = "fit_polynomial.cl"
    equation = 23
    has_degree = True

    def __init__(self, degree=2, **_):
        self.degree = self.proxy_order = degree

    def determined(self, points):
        return Basis.on(points.local(points.handles.positions[1]), self.degree)

    def fit(self, weighted):
        """Eq. 23 to 26: weighted orthogonal polynomials psi_j, starting from psi_0 = 1.

        The displacement p - q is fitted, so that undetermined functions are those of the identity
        map.
        """
        orthogonal, w = _orthogonal(weighted), weighted.w
        p = weighted.p + weighted.p_star[:, None]
        q = weighted.q + weighted.q_star[:, None]
        displacement = weighted.p_k - weighted.q_k
        gradient = np.zeros((len(w), 3, 3))
        # each coefficient from the remainder: near a curve weights differ by up to 1e30
        remaining = p - q
        for psi, psi_v, dpsi_v, norm in orthogonal:  # Eq. 26
            c = np.einsum("mi,mia,mi->ma", w, remaining, psi) / norm[:, None]
            remaining = remaining - psi[:, :, None] * c[:, None]
            displacement = displacement + c * psi_v[:, None]
            gradient = gradient + c[:, :, None] * dpsi_v[:, None]

        def influence():
            kernel = sum(psi * (psi_v / norm)[:, None] for psi, psi_v, _, norm in orthogonal)
            return kernel[:, :, None] * remaining

        return Fit(displacement, np.eye(3) + gradient, influence)

    def functions(self, control_points):
        return len(control_points.determined)

    def needs_float64(self, alpha, points, max_error=0.0):
        return alpha > 1 or self.degree == 3

    def constants(self):
        return {"FUNCTIONS": MONOMIAL_COUNT[self.degree]}

    def params(self, control_points):
        return {"rank": len(control_points.determined)}

    def table(self, control_points):
        """Rows of coefficients of the functions, of their values at each term, and means.

        The means are subtracted from the values. Then moments of regions, and powers along
        segments: `moments_of_region` and `powers_along` in fit_polynomial.cl.
        """
        basis, count = control_points.determined, MONOMIAL_COUNT[self.degree]
        handles, mean = control_points.handles, basis.values.mean(axis=0)
        n, terms = len(control_points), handles.term_count
        table = np.zeros((count + terms + 1, count), np.float32)
        table[: len(basis)] = basis.coefficients
        table[count:-1, : len(basis)] = handles.means(basis.values[:n] - mean)
        table[-1, : len(basis)] = mean
        at_means = basis(control_points.local(handles.means(handles.deformed))) - mean
        moments = [
            _region_moments(control_points, np.flatnonzero(handles.region == i), at_means[i])
            for i in range(len(handles.regions))
        ]
        powers = _powers_along(control_points, self.degree, mean).ravel()
        return np.concatenate([table.ravel(), *moments, powers], dtype=np.float32)


class Affine(Polynomial):
    """Affine maps: the polynomials of degree 1, the same minimum as Eq. 7."""

    name = "affine"
    equation = 5
    has_degree = False

    def __init__(self, **_):
        super().__init__(1)


@dataclass(frozen=True, eq=False)
class Basis:
    """Polynomials that are orthonormal on the control points, up to a constant each.

    Each degree adds only functions that the control points distinguish from lower degrees (singular
    value above `RANK_TOLERANCE`). So a fit in this basis never divides by a vanishing norm, and
    functions that a degenerate set does not determine are those of the identity map.
    """

    coefficients: np.ndarray  # (functions, monomials): of the `MONOMIALS` in local coordinates
    values: np.ndarray  # (n, functions): at the control points
    degree: int

    @classmethod
    def on(cls, local: np.ndarray, degree: int) -> Basis:
        """Basis of the polynomials up to `degree` on the points `local` (n, 3)."""
        n, monomials = len(local), MONOMIAL_COUNT[degree]
        values = np.ones((n, 1))
        coefficients = np.zeros((1, monomials))
        orders = MONOMIALS[:monomials].sum(axis=1)
        for order in range(1, degree + 1):
            of_order = np.flatnonzero(orders == order)
            # with these factors the norm of a form's coefficients does not depend on the axes
            factor = np.sqrt(_FACTORIALS[order] / _FACTORIALS[MONOMIALS[of_order]].prod(axis=1))
            forms = np.zeros((len(of_order), monomials))
            forms[np.arange(len(of_order)), of_order] = factor
            sampled = monomial_values(local, degree) @ forms.T
            size = np.linalg.norm(sampled, 2)
            for _ in range(2):  # twice is enough
                shadow = values.T @ sampled / n
                sampled = sampled - values @ shadow
                forms = forms - shadow.T @ coefficients
            _, singular, mix = np.linalg.svd(sampled, full_matrices=False)
            is_determined = singular > RANK_TOLERANCE * size
            mix = mix[is_determined] * (np.sqrt(n) / singular[is_determined])[:, None]
            values = np.hstack([values, sampled @ mix.T])
            coefficients = np.vstack([coefficients, mix @ forms])
        coefficients = coefficients[1:]
        return cls(coefficients, monomial_values(local, degree) @ coefficients.T, degree)

    def __len__(self) -> int:
        return len(self.coefficients)

    def __call__(self, local: np.ndarray) -> np.ndarray:
        """Values (m, functions) at `local` (m, 3)."""
        return transformed(self.coefficients, monomial_values(local, self.degree))

    def gradient(self, local: np.ndarray) -> np.ndarray:
        """Derivatives (m, functions, 3) with respect to local coordinates."""
        exponents = MONOMIALS[: MONOMIAL_COUNT[self.degree]]
        lowered = (np.maximum(exponents - axis, 0) for axis in np.eye(3, dtype=int))
        powers = [np.prod(local[:, None, :] ** e, axis=2) for e in lowered]
        return np.einsum("jm,kma->kja", self.coefficients, exponents * np.stack(powers, axis=2))


def monomial_values(x: np.ndarray, degree: int) -> np.ndarray:
    """All monomials (m, monomials) of degree 1 to `degree` at `x` (m, 3)."""
    return np.prod(x[:, None, :] ** MONOMIALS[: MONOMIAL_COUNT[degree]], axis=2)


def _region_moments(control_points, proxies, at_mean):
    """The functions at the mean of `proxies` (k,), and moments of functions and p - q, twice.

    The second half is the rounding error of the first in float32.
    """
    handles, values = control_points.handles, control_points.determined.values
    count, functions = values.shape[1], MONOMIAL_COUNT[control_points.kind.degree]
    f = handles.centered(values, proxies)
    u = handles.centered(handles.rest - handles.deformed, proxies)
    weighted = f * (handles.weights[proxies] / handles.weights[proxies].sum())[:, None]
    result = np.zeros(functions + functions * (functions + 1) // 2 + 3 * functions)
    result[:count] = at_mean
    rows, columns = np.tril_indices(count)
    result[functions:][: len(rows)] = (weighted.T @ f)[rows, columns]
    result[-3 * functions :][: 3 * count] = (weighted.T @ u / control_points.scale).ravel()
    rounded = result.astype(np.float32)
    return np.concatenate([rounded, result - rounded])


def _powers_along(control_points, degree, mean):
    """Coefficients (s, degree + 1, monomials) of 1, t, ... of the functions along segments."""
    basis, ends = control_points.determined, control_points.handles.segments.deformed
    powers = np.zeros((len(ends), degree + 1, MONOMIAL_COUNT[degree]))
    if len(ends) > 0:
        t = np.linspace(0, 1, degree + 1)
        along = ends[:, :1] + t[:, None] * (ends[:, 1:] - ends[:, :1])
        values = basis(control_points.local(along.reshape(-1, 3))) - mean
        values = values.reshape(len(ends), degree + 1, len(basis))
        powers[:, :, : len(basis)] = np.linalg.solve(np.vander(t, increasing=True), values)
    return powers


def _orthogonal(weighted):
    """psi_j at the control points (m, n) and at v, its slope at v, and its norm: Eq. 23 and 25."""
    control_points, w = weighted.control_points, weighted.w
    basis, local = control_points.determined, control_points.local(weighted.v)
    (values, origins), at_v = weighted.values_of(basis), basis(local)

    def inner(f, g):  # Eq. 23
        return np.einsum("mi,mi,mi->m", w, f, g)

    psi_0 = np.ones_like(w)
    orthogonal = [(psi_0, np.ones(len(at_v)), np.zeros((len(at_v), 3)), weighted.total)]
    slopes = basis.gradient(local) / control_points.scale
    for j in range(len(basis)):
        origin = origins[:, j]
        f, f_v, df_v = values[:, :, j] - origin[:, None], at_v[:, j] - origin, slopes[:, j]
        before = inner(f, f)
        for psi, psi_v, dpsi_v, norm in orthogonal:
            c = inner(f, psi) / norm
            f, f_v = f - c[:, None] * psi, f_v - c * psi_v
            df_v = df_v - c[:, None] * dpsi_v
        norm = inner(f, f)
        is_zero = norm <= _MIN_SQUARED_NORM * before
        f_v, df_v = np.where(is_zero, 0, f_v), np.where(is_zero[:, None], 0, df_v)
        orthogonal.append((f, f_v, df_v, np.where(is_zero, 1, norm)))
    return orthogonal
