"""Checks of any map: kernels against the specification, the Jacobian, and the inverse."""

import numpy as np
from control_point_sets import slopes


def check_kernels(kernels, specification, v, degree, slope_bound=1e-4):
    """Kernels agree with the specification at `v` (m, 3)."""
    error = np.abs(kernels.backward(v) - specification.backward(v)).max(axis=1)
    # with cuts both sides may reach a point in the void, and rounding decides
    assert np.quantile(error, 0.98) < 1e-5 * (10 if degree == 3 else 1)
    assert np.mean(error > 1e-4) < (0.02 if kernels.cuts else 1e-9)
    error = np.abs(kernels.jacobian(v[:200]) - specification.jacobian(v[:200])).max(axis=(1, 2))
    assert np.quantile(error, 0.95) < slope_bound


def check_jacobian(d, v):
    """The Jacobian is the slope at `v` (m, 3), but for kinks between the cells of images."""
    v = v[np.abs(d.void_distance(v)) > 1e-3] if d.cuts else v
    error = np.abs(d.jacobian(v) - slopes(d, v)).max(axis=(1, 2))
    assert np.quantile(error, 0.97) < 1e-5


def check_inverse(d, v):
    """The forward map undoes the backward map at `v` (m, 3)."""
    v = v[d.void_distance(v) > 1e-3] if d.cuts else v
    x = d.backward(v)
    back = d.forward(x)
    found = np.isfinite(back).all(axis=1)
    assert found.mean() > 0.9
    error = np.abs(d.backward(back[found]) - x[found]).max(axis=1)
    assert np.quantile(error, 0.97) < 3e-5
