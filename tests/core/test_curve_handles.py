"""Curve handles: every point of a polyline is carried, by integrals along its segments."""

from dataclasses import replace

import numpy as np
import pytest
from control_point_sets import deformation, on_both, slopes
from pairwise import paired, rare

from vtk_mls import CurveHandle, Deformation, Grid, HalfPlane, Plane

ALPHAS = [2, *rare(1, 3)]
KINDS = [
    ("rigid", 2),
    ("affine", 2),
    *rare(("similarity", 2), *(("polynomial", n) for n in (2, 3))),
]
EVERY_KIND_AND_ALPHA = paired(kind_and_degree=KINDS, alpha=ALPHAS)
EXTENT = 2.0


def _curve(count=6):
    """A bent curve, and where it is moved, in a cube of `EXTENT`."""
    t = np.linspace(-0.9, 0.9, count)
    deformed = np.c_[t, 0.5 * np.sin(3 * t), 0.4 * np.cos(4 * t)]
    rest = deformed + 0.1 * np.c_[np.cos(5 * t), np.sin(3 * t), np.sin(2 * t + 1)]
    return rest, deformed


def _points(rng, count=6):
    deformed = rng.uniform(-1, 1, (count, 3))
    return deformed + rng.normal(0, 0.05, (count, 3)), deformed


def _along(nodes, t):
    """Points of a polyline: shares `t` (k,) of each segment."""
    return (nodes[:-1, None] + t[:, None] * np.diff(nodes, axis=0)[:, None]).reshape(-1, 3)


def _deformation(rng, kind_and_degree, device, **options):
    curve = CurveHandle(*_curve())
    return deformation(*_points(rng), kind_and_degree, device, handles=curve, **options)


@EVERY_KIND_AND_ALPHA
def test_the_specification_is_the_map_of_many_points(kind_and_degree, alpha, rng):
    (p, q), (rest, deformed) = _points(rng), _curve()
    t, w = np.polynomial.legendre.leggauss(300)
    t, w = (1 + t) / 2, w / 2
    options = {"alpha": alpha, "device": "reference"}
    options |= zip(("kind", "degree"), kind_and_degree)
    many = Deformation(
        np.concatenate([p, _along(rest, t)]),
        np.concatenate([q, _along(deformed, t)]),
        weights=np.concatenate([np.ones(len(p)), np.tile(w, len(rest) - 1)]),
        **options,
    )
    value = Deformation(p, q, handles=CurveHandle(rest, deformed), **options)
    v = rng.uniform(-1, 1, (20, 3))
    np.testing.assert_allclose(value.backward(v), many.backward(v), atol=1e-8)


@EVERY_KIND_AND_ALPHA
def test_every_point_of_the_curve_is_carried(kind_and_degree, alpha, device, rng):
    value = _deformation(rng, kind_and_degree, device, alpha=alpha)
    t = np.concatenate([[0, 1, 1e-4], rng.random(60)])
    rest, deformed = (_along(nodes, t) for nodes in _curve())
    np.testing.assert_allclose(value.backward(deformed), rest, atol=1e-5 * EXTENT)


@EVERY_KIND_AND_ALPHA
def test_kernels_agree_with_the_specification(kind_and_degree, alpha, key, rng):
    v = rng.uniform(-1, 1, (2000, 3))
    numpy = _deformation(rng, kind_and_degree, "reference", alpha=alpha)
    kernels = replace(numpy, device=key)
    # a few handles hardly determine cubic terms
    close = (1e-3 if kind_and_degree[1] == 3 else 1e-4) * EXTENT
    np.testing.assert_allclose(kernels.backward(v), numpy.backward(v), atol=close)
    jacobians = [value.jacobian(v[:300]) for value in (kernels, numpy)]
    np.testing.assert_allclose(*jacobians, atol=1e-3 * max(1, np.abs(jacobians[1]).max()))


@EVERY_KIND_AND_ALPHA
def test_the_jacobian_is_that_of_the_map(kind_and_degree, alpha, rng):
    value = _deformation(rng, kind_and_degree, "reference", alpha=alpha)
    v = rng.uniform(-1, 1, (30, 3))
    jacobian = value.jacobian(v)
    error = np.abs(jacobian - slopes(value, v, 1e-5)).max(axis=(1, 2))
    assert (error < 1e-6 * np.abs(jacobian).max(axis=(1, 2))).all()


@paired(kind_and_degree=KINDS)
def test_segments_of_any_length_agree_with_the_specification(kind_and_degree, key, rng):
    """From less than float32 resolves to half the extent: seen from any number of lengths."""
    p, q = _points(rng, 30)
    steps = np.array([1e-9, 1e-7, 1e-5, 1e-3, 0.02, 0.1, 0.3])[:, None] * EXTENT
    nodes = np.concatenate([np.zeros((1, 3)), np.cumsum(steps * [0.6, 0, 0.8], axis=0)]) - 0.3
    v = rng.uniform(-1, 1, (1000, 3))
    curve = CurveHandle(nodes + [0, 0.1, 0], nodes)
    numpy, kernels = on_both(key, p, q, kind_and_degree, handles=curve)
    close = (1e-4 if kind_and_degree[1] == 3 else 1e-5) * EXTENT
    np.testing.assert_allclose(kernels.backward(v), numpy.backward(v), atol=close)


@paired(kind=["rigid", *rare("affine")])
def test_the_inverse_takes_points_back(kind, device, rng):
    value = _deformation(rng, (kind, 2), device)
    v = np.concatenate([rng.uniform(-1, 1, (200, 3)), _along(_curve()[1], rng.random(10))])
    np.testing.assert_allclose(value.forward(value.backward(v)), v, atol=1e-4)


@paired(frame=["rest", *rare("deformed")], cut=[HalfPlane, *rare(Plane)])
def test_cuts_and_curves_together(key, frame, cut, rng):
    axes = [(1, 0, 0.2)] if cut is Plane else [(1, 0, 0.2), (0, 1, 0.3)]
    cuts = cut((0.1, 0, 0), *axes)
    v = rng.uniform(-1, 1, (1000, 3))
    numpy = _deformation(rng, ("rigid", 2), "reference", cuts=cuts, cut_frame=frame)
    kernels = replace(numpy, device=key)
    errors = np.abs(kernels.backward(v) - numpy.backward(v)).max(axis=1)
    assert np.quantile(errors, 0.99) < 1e-5
    error = np.abs(kernels.jacobian(v[:200]) - numpy.jacobian(v[:200])).max(axis=(1, 2))
    assert np.quantile(error, 0.97) < 1e-3


@pytest.mark.parametrize("frame", ["rest", "deformed"])
def test_segments_end_at_cuts_with_an_edge(frame):
    rest, deformed = np.array([(-1.0, 0, 0), (1, 0, 0)]), np.array([(-1.0, 0.5, 0), (1, 0.5, 0)])
    cut = HalfPlane((0.3, -1, 0), (1, 0, 0), (0, 1, 0))
    handles = [CurveHandle(rest, deformed), CurveHandle(deformed + 1, rest)]
    value = Deformation(handles=handles, cuts=cut, cut_frame=frame, device="reference")
    segments = value.regions[0].control_points.handles.segments
    crossing = (segments.rest if frame == "rest" else segments.deformed)[:, :, 0] - 0.3
    assert (crossing.min(axis=1) * crossing.max(axis=1) > -1e-9).all()
    assert segments.weights.sum() == pytest.approx(2)
    assert len(segments) == 4


def test_other_alphas_carry_the_curve_nearly(device, rng):
    value = _deformation(rng, ("rigid", 2), device, alpha=1.5)
    t = rng.random(50)
    rest, deformed = (_along(nodes, t) for nodes in _curve())
    assert len(value.regions[0].control_points.handles.segments) == 0
    error = np.abs(value.backward(deformed) - rest)
    assert error.max() < 2e-3 * EXTENT


def test_smooth_curves(key, rng):
    v = rng.uniform(-1, 1, (500, 3))
    numpy = _deformation(rng, ("affine", 2), "reference", smoothing=0.1)
    kernels = replace(numpy, device=key)
    np.testing.assert_allclose(kernels.backward(v), numpy.backward(v), atol=1e-5)


@pytest.mark.matrix
def test_a_tolerance_holds_near_curves(key, rng):
    grid = Grid((48, 48, 48), (-1, -1, -1), (2 / 47,) * 3)
    exact = _deformation(rng, ("rigid", 2), key)
    coarse = replace(exact, map_tolerance=0.02)
    fields = [value.displacement_field(grid).displacement for value in (exact, coarse)]
    difference = np.subtract(*fields)
    assert np.abs(difference).max() <= 0.02 * 2 / 47


def _tree():
    """Nodes of a vessel tree at rest (n, 3): a trunk, and three branches."""
    k = np.arange(1, 5)[:, None]
    trunk = np.c_[np.linspace(-0.9, 0, 6), np.linspace(0, 0.1, 6) ** 2, np.zeros(6)]
    sides = [(0.1, 0.1, 0), (0.1, -0.1, 0.05), (0.05, 0, -0.1)]
    return trunk, [trunk[-1] + k * side for side in sides]


def _bent(nodes):
    return nodes + 0.1 * np.c_[np.sin(2 * nodes[:, 0]), np.cos(nodes[:, 0]), nodes[:, 1]]


@paired(alpha=[*ALPHAS, *rare(1.5)])
def test_a_trunk_that_lines_share_counts_once(device, alpha, rng):
    trunk, branches = _tree()
    whole = [np.concatenate([trunk, branch]) for branch in branches]
    whole[1] = whole[1][::-1]  # from its end to the root
    parts = [trunk, *(np.concatenate([trunk[-1:], branch]) for branch in branches)]
    v = rng.uniform(-1, 1, (200, 3))
    shared, once = (
        Deformation(
            handles=[CurveHandle(nodes, _bent(nodes)) for nodes in lines],
            alpha=alpha,
            device=device,
        ).backward(v)
        for lines in (whole, parts)
    )
    np.testing.assert_allclose(shared, once, rtol=0, atol=1e-12 if device == "reference" else 1e-5)


def test_lines_that_share_places_but_no_motion_all_count():
    trunk, _ = _tree()
    handles = [CurveHandle(trunk, _bent(trunk)), CurveHandle(trunk, trunk)]
    value = Deformation(handles=handles, device="reference")
    assert len(value.regions[0].control_points.handles.segments) == 2 * (len(trunk) - 1)


def test_a_closed_curve_keeps_its_closing_segment():
    ring = np.array([(1.0, 0, 0), (0, 1, 0), (-1, 0, 0), (-0.0, -1, 0), (1, 0, 0)])
    for lines in ([ring], [ring, ring[::-1]], [np.roll(ring[1:], 1, axis=0), ring]):
        handles = [CurveHandle(nodes, _bent(nodes)) for nodes in lines]
        value = Deformation(handles=handles, device="reference")
        assert len(value.regions[0].control_points.handles.segments) == 4


def test_repeated_nodes_of_one_motion_become_one():
    rest, deformed = _curve()
    rows = [0, 0, 1, 2, 2, 2, 3, 4, 5, 5]
    curve = CurveHandle(rest[rows], deformed[rows])
    np.testing.assert_array_equal(curve.rest, rest)
    np.testing.assert_array_equal(curve.deformed, deformed)
    other = deformed[rows]
    other[5] += 1
    for before, after, name in ((rest[rows], other, "rest"), (other, rest[rows], "deformed")):
        with pytest.raises(
            ValueError, match=f"`{name}` must not repeat a node, got .* rows 4 and 5"
        ):
            CurveHandle(before, after)
    for count, text in ((1, "1$"), (3, "1 and 2 that repeat it")):
        with pytest.raises(ValueError, match=f"at least 2 nodes of a curve, got {text}"):
            CurveHandle([(0, 0, 0)] * count, [(1, 0, 0)] * count)
