"""The forward map: the true inverse of the backward map."""

import numpy as np
import pytest
from conftest import DEVICES, EXTENT, deformation, random_handles, random_rotation

from vtk_mls import Deformation, HalfPlane, Plane, Surface


@pytest.fixture(params=["reference", *DEVICES])
def device(request):
    return request.param


CUTS = {
    "none": (),
    "half-plane": (HalfPlane((128, 128, 128), (0.2, 0.1, 1), (1, 0.3, 0)),),
    "plane": (Plane((128, 128, 128), (0.1, 0.2, 1)),),
    "polygon": (Surface.polygon([(40, 40, 120), (200, 40, 130), (220, 200, 140), (30, 180, 130)]),),
}


@pytest.mark.parametrize("cuts", CUTS)
@pytest.mark.parametrize("alpha", [0.5, 1, 2, 3])
def test_undoes_backward_and_is_undone_by_it(cuts, alpha, kind_and_degree, device, rng):
    """Wherever the map does not fold and no cut is in the way."""
    # each side of a plane wants more control points than a cubic has coefficients
    count = 150 if (kind_and_degree, cuts) == (("polynomial", 3), "plane") else 40
    rest, deformed = random_handles(rng, count, 2)
    d = deformation(rest, deformed, kind_and_degree, device, alpha=alpha, cuts=CUTS[cuts])
    v = rng.uniform(30, 226, (300, 3))
    x = d.backward(v)
    sound = (np.linalg.det(d.jacobian(v)) > 0.3) & ~d.void(v)
    assert sound.mean() > 0.5
    found = d.forward(x)
    known = ~np.isnan(found[:, 0])
    assert known[sound].mean() > 0.99
    np.testing.assert_allclose(d.backward(found[known]), x[known], rtol=0, atol=1e-5 * EXTENT)
    error = np.linalg.norm(found - v, axis=1)[known & sound]
    # a place can have a second one with the same origin, behind a fold
    assert np.percentile(error, 98) <= 1e-5 * EXTENT


def test_large_bends(kind_and_degree, device, rng):
    """A bar bent by 90 degrees."""
    s = np.linspace(0, 1, 7)
    rest = np.stack([256 * s, 0 * s, 0 * s], axis=1)
    centre = np.stack([163 * np.sin(s * np.pi / 2), 163 * (1 - np.cos(s * np.pi / 2)), 0 * s], 1)
    offsets = np.array([(0, 20, 20), (0, -20, 20), (0, 20, -20), (0, -20, -20)], float)
    angle = s * np.pi / 2
    rest = (rest[:, None] + offsets).reshape(-1, 3)
    turned = [[[-o[1] * np.sin(a), o[1] * np.cos(a), o[2]] for o in offsets] for a in angle]
    deformed = (centre[:, None] + np.array(turned)).reshape(-1, 3)
    d = deformation(rest, deformed, kind_and_degree, device)
    x = rng.uniform((20, -15, -15), (236, 15, 15), (300, 3))
    v = d.forward(x)
    known = ~np.isnan(v[:, 0])
    assert known.mean() > (0.9 if kind_and_degree == ("polynomial", 3) else 0.99)
    np.testing.assert_allclose(d.backward(v[known]), x[known], rtol=0, atol=1e-5 * EXTENT)


def test_carries_control_points_to_where_they_were_dragged(kind_and_degree, device, rng):
    rest, deformed = random_handles(rng, 40, 2)
    d = deformation(rest, deformed, kind_and_degree, device)
    got = d.forward(rest)
    np.testing.assert_allclose(got, deformed, rtol=0, atol=1e-5 * EXTENT)


def test_identity_and_no_points(kind_and_degree, device, rng):
    _, deformed = random_handles(rng, 9)
    d = deformation(deformed, deformed, kind_and_degree, device)
    x = rng.uniform(0, EXTENT, (50, 3))
    np.testing.assert_allclose(d.forward(x), x, rtol=0, atol=1e-4)
    assert d.forward([]).shape == (0, 3)


def test_what_is_pushed_through_a_cut_has_no_place(device):
    """Both halves of a block pressed into each other: the middle is lost, and said to be."""
    cut = Plane((0, 0, 0), (0, 0, 1))
    deformed = np.array([(-9, 0, 5), (9, 0, 5), (0, 9, 6), (-9, 0, -5), (9, 0, -5), (0, 9, -6)])
    pressed = deformed + np.where(deformed[:, 2:] > 0, 1, -1) * [0, 0, 3.0]
    d = Deformation(pressed, deformed, cuts=[cut], device=device)
    x = np.array([[0, 3, z] for z in (-6.0, -2, 2, 6)])
    lost = np.isnan(d.forward(x)).all(axis=1)
    np.testing.assert_array_equal(lost, [False, True, True, False])


def test_a_fold_is_said_to_have_no_place(device):
    """Two control points exchanged along a line fold the space between them over itself."""
    deformed = np.array([(0, 0, 0), (10, 0, 0), (40, 0, 0), (50, 0, 0), (20, 30, 0), (20, 0, 30)])
    rest = deformed.astype(float)
    rest[[1, 2]] = rest[[2, 1]]
    d = Deformation(rest, deformed, "affine", alpha=2, device=device)
    x = np.random.default_rng(0).uniform(0, 50, (500, 3)) * [1, 0.2, 0.2]
    v = d.forward(x)
    known = ~np.isnan(v[:, 0])
    assert np.linalg.norm(d.backward(v[known]) - x[known], axis=1).max() <= 1e-5 * 100
    assert known.any()


def test_turns_and_scales_come_back(device, rng):
    rotation = random_rotation(rng)
    deformed = rng.uniform(0, EXTENT, (10, 3))
    d = Deformation(0.5 * deformed @ rotation.T + 40, deformed, "similarity", device=device)
    x = rng.uniform(0, EXTENT, (100, 3))
    np.testing.assert_allclose(d.forward(x), (x - 40) @ rotation / 0.5, rtol=0, atol=2e-5 * EXTENT)
