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


def test_none_is_the_default_and_interpolates(kind_and_degree, device, rng):
    rest, deformed = random_handles(rng, 30)
    v = rng.uniform(0, EXTENT, (200, 3))
    plain = deformation(rest, deformed, kind_and_degree, device)
    zero = deformation(rest, deformed, kind_and_degree, device, smoothing=0)
    np.testing.assert_array_equal(plain.backward(v), zero.backward(v))
    np.testing.assert_array_equal(plain.jacobian(v), zero.jacobian(v))
    assert lengths(zero.backward(deformed) - rest).max() <= TOLERANCE[kind_and_degree][0]


def test_a_longer_one_meets_control_points_less_exactly(kind_and_degree, rng):
    rest, deformed = random_handles(rng, 60)
    misses = []
    for smoothing in (0, 1, 5, 20, 80):
        d = deformation(rest, deformed, kind_and_degree, smoothing=smoothing)
        misses.append(np.sqrt((lengths(d.backward(deformed) - rest) ** 2).mean()))
    assert misses == sorted(misses)
    assert misses[0] <= 1e-9
    assert misses[1] > 1e-6
    assert misses[-1] > 3


def test_an_endless_one_is_a_single_fit(device, rng):
    rest, deformed = random_handles(rng, 30)
    d = Deformation(rest, deformed, "affine", smoothing=1e5 * EXTENT, device=device)
    columns = np.column_stack([deformed, np.ones(30)])
    matrix, *_ = np.linalg.lstsq(columns, rest, rcond=None)
    v = rng.uniform(0, EXTENT, (100, 3))
    expected = v @ matrix[:3] + matrix[3]
    assert lengths(d.backward(v) - expected).max() <= TOLERANCE["affine", 1][0]


def test_noise_of_landmarks_is_averaged(device, rng):
    """Nearer to the true map than interpolation, if control points are off at random."""
    deformed = rng.uniform(0, EXTENT, (300, 3))
    v = rng.uniform(30, EXTENT - 30, (300, 3))

    def truth(x):
        return x + 10 * np.sin(x / 100)[:, [1, 2, 0]]

    rest = truth(deformed) + rng.normal(0, 3, deformed.shape)
    errors = [
        lengths(
            Deformation(rest, deformed, "affine", smoothing=s, device=device).backward(v) - truth(v)
        ).mean()
        for s in (0, 40)
    ]
    assert errors[1] < 0.7 * errors[0]


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


@paired(
    kind_and_degree=KINDS_AND_DEGREES, cut=CUTS, smoothing=[1, 30], alpha=[2, 1], device=EVERYWHERE
)
def test_forward_undoes_backward(kind_and_degree, cut, smoothing, alpha, device, rng):
    rest, deformed = random_handles(rng, 40, 2)
    options = {"smoothing": smoothing, "alpha": alpha, **CUTS[cut]}
    d = deformation(rest, deformed, kind_and_degree, device, **options)
    v = rng.uniform(30, 226, (200, 3))
    v = v[(np.linalg.det(d.jacobian(v)) > 0.3) & (d.void_distance(v) > 1e-5 * EXTENT)]
    assert len(v) > 100
    field = d.forward_field(d.backward(v))
    assert field.found.all()
    error = lengths(d.backward(v) + field.displacement - v)
    # a place can have a second one with the same origin, behind a fold or a cut
    assert np.percentile(error, 97) <= 1e-5 * EXTENT


@pytest.mark.parametrize("world", [2.0**-30, 2.0**20])
def test_is_a_length_of_the_world(world, device, rng):
    rest, deformed = random_handles(rng, 20)
    v = rng.uniform(0, EXTENT, (100, 3))
    unit = Deformation(rest, deformed, smoothing=20, device=device)
    scaled = Deformation(rest * world, deformed * world, smoothing=20 * world, device=device)
    error = lengths(scaled.backward(v * world) / world - unit.backward(v))
    assert error.max() <= (1e-9 if device == "reference" else 1e-4)


@pytest.mark.parametrize(
    ("value", "error", "sentence"),
    [
        (-1, ValueError, "`smoothing` must be a number from 0 on, got -1"),
        (np.nan, ValueError, "`smoothing` must be a number from 0 on, got nan"),
        (np.inf, ValueError, "`smoothing` must be a number from 0 on, got inf"),
        ("much", TypeError, "`smoothing` must be a number, got 'much'"),
        ((1, 2), TypeError, r"`smoothing` must be a number, got \(1, 2\)"),
    ],
)
def test_bad_values_are_refused_in_a_sentence(value, error, sentence):
    with pytest.raises(error, match=f"^{sentence}$"):
        Deformation(np.eye(3), np.eye(3) + 1, smoothing=value)
