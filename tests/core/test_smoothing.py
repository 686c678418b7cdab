"""Smoothing: weights 1 / (|q_i - v|^2 + s^2)^alpha, which approximate instead of interpolating."""

import numpy as np
import pytest
from control_point_sets import (
    DEVICES,
    EXTENT,
    KINDS_AND_DEGREES,
    TOLERANCE,
    deformation,
    random_handles,
)
from cut_shapes import SHAPES, lengths
from map_checks import slopes
from pairwise import paired, rare

from vtk_mls import Deformation

EVERYWHERE = ["reference", *DEVICES]
CUTS = {
    "none": {},
    "half-plane": {"cuts": SHAPES["half-plane"]},
    "polygon": {"cuts": SHAPES["polygon"]},
    "half-plane in place": {"cuts": SHAPES["half-plane"], "cut_frame": "deformed"},
    "polygon in place": {"cuts": SHAPES["polygon"], "cut_frame": "deformed"},
}


def fitted(rest, deformed, v, kind, alpha, smoothing):
    """G(v) by the equations of the paper, for one v (3,): Eq. 3 to 7, and Kabsch's rotation."""
    w = 1 / (((deformed - v) ** 2).sum(axis=1) + smoothing**2) ** alpha
    p_star, q_star = w @ rest / w.sum(), w @ deformed / w.sum()
    p, q = rest - p_star, w[:, None] * (deformed - q_star)
    if kind == "affine":
        m = np.linalg.solve(q.T @ (deformed - q_star), q.T @ p)
    else:
        u, _, vt = np.linalg.svd(q.T @ p)
        m = u @ np.diag([1, 1, np.linalg.det(u @ vt)]) @ vt
    return (v - q_star) @ m + p_star


@paired(
    kind=["rigid", "affine"], alpha=[2, 1.3, *rare(1, 3)], smoothing=[0, 2, 40], device=EVERYWHERE
)
def test_is_the_fit_with_these_weights(kind, alpha, smoothing, device, rng):
    rest, deformed = random_handles(rng, 15)
    d = Deformation(rest, deformed, kind, alpha=alpha, smoothing=smoothing, device=device)
    v = np.concatenate([rng.uniform(0, EXTENT, (50, 3)), deformed + 0.1])
    expected = [fitted(rest, deformed, place, kind, alpha, smoothing) for place in v]
    bound = 1e-9 if device == "reference" else TOLERANCE[kind, 1][0]
    assert lengths(d.backward(v) - expected).max() <= bound


@paired(kind_and_degree=KINDS_AND_DEGREES, cut=CUTS, smoothing=[1, 30], alpha=[2, 1])
def test_jacobian_is_the_derivative(kind_and_degree, cut, smoothing, alpha, rng):
    rest, deformed = random_handles(rng, 40)
    options = {"smoothing": smoothing, "alpha": alpha, **CUTS[cut]}
    d = deformation(rest, deformed, kind_and_degree, **options)
    v = np.concatenate([rng.uniform(0, EXTENT, (60, 3)), deformed[:20]])
    jacobian = d.jacobian(v)
    error = np.abs(jacobian - slopes(d, v, 1e-4)).max(axis=(1, 2))
    error /= np.maximum(1, np.abs(jacobian).max(axis=(1, 2)))
    # where a way begins to be blocked the map has a kink
    assert np.percentile(error, 100 if cut == "none" else 97) <= 1e-5


@paired(
    kind_and_degree=KINDS_AND_DEGREES,
    cut=CUTS,
    smoothing=[1e-4, 1, 30, 1000],
    alpha=[2, 1, *rare(1.3, 3)],
)
@pytest.mark.parametrize("key", DEVICES)
def test_kernels_agree_with_the_specification(key, kind_and_degree, cut, smoothing, alpha, rng):
    rest, deformed = random_handles(rng, 60)
    options = {"smoothing": smoothing, "alpha": alpha, **CUTS[cut]}
    kernels, numpy = (
        deformation(rest, deformed, kind_and_degree, name, **options) for name in (key, "reference")
    )
    v = np.concatenate([rng.uniform(0, EXTENT, (1500, 3)), deformed, deformed + 0.01])
    error = lengths(kernels.backward(v) - numpy.backward(v))
    largest, p99 = TOLERANCE[kind_and_degree]
    assert np.percentile(error, 99) <= p99
    # one of two origins in the void, or a way that just touches an edge
    is_sure = np.abs(numpy.void_distance(v)) > 1e-2 if cut != "none" else slice(None)
    assert np.percentile(error[is_sure], 100 if cut == "none" else 99.8) <= largest
    slopes = numpy.jacobian(v)
    error = np.abs(kernels.jacobian(v) - slopes).max(axis=(1, 2))
    error /= np.maximum(1, np.abs(slopes).max(axis=(1, 2)))
    assert np.percentile(error, 97) <= 1e-3
