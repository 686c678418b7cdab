"""Splines: the smoothest map through the control points, and the choice of its settings."""

import numpy as np
import pytest
from control_point_sets import DEVICES, EVERYWHERE, EXTENT, on_both, slopes
from pairwise import paired, rare
from scipy.interpolate import RBFInterpolator

from vtk_mls import Ball, BoxMask, CurveHandle, Deformation, Grid, HalfPlane, RegionHandle
from vtk_mls.model.kinds.splines import best_choice

SCIPY = {1: "linear", 2: "thin_plate_spline", 3: "cubic"}


def landmarks(count, noise=0.0, seed=0):
    """Pairs p, q of a smooth map in a box of size EXTENT."""
    rng = np.random.default_rng(seed)
    q = rng.uniform(0, EXTENT, (count, 3))
    return smooth(q) + noise * rng.normal(size=q.shape), q


def smooth(q):
    return q + 8 * np.sin(q[:, [1, 2, 0]] / 40 + [0.3, 1, 2]) + 5 * np.cos(q[:, [2, 0, 1]] / 50)


def places(count=400, seed=1):
    return np.random.default_rng(seed).uniform(-0.1 * EXTENT, 1.1 * EXTENT, (count, 3))


@paired(order=[1, 2, 3], count=[5, 30, 300], smoothing=[0, 9.0], device=EVERYWHERE)
def test_spline_is_that_of_scipy(order, count, smoothing, device):
    p, q = landmarks(count)
    v = places()
    spline = Deformation(p, q, "spline", order=order, smoothing=smoothing, device=device)
    judge = RBFInterpolator(q, p, kernel=SCIPY[order], degree=1, smoothing=smoothing**order)
    assert np.abs(spline.backward(v) - judge(v)).max() < 1e-3


@pytest.mark.parametrize("softening", [5.0, 60.0, 300.0])
def test_softened_spline_of_order_1_is_the_multiquadric_of_scipy(softening, device):
    p, q = landmarks(60)
    spline = Deformation(p, q, "spline", order=1, softening=softening, device=device)
    judge = RBFInterpolator(q, p, kernel="multiquadric", epsilon=1 / softening, degree=1)
    v = places()
    assert np.abs(spline.backward(v) - judge(v)).max() < 1e-3


@paired(
    order=[1, 2, 3],
    count=[1, 2, 3, 12, 500],
    options=[{}, {"mask": BoxMask((90, 90, 90), (200, 200, 200), 60)}, *rare({"steps": 3})],
    softening=[0, 20.0],
    device=DEVICES,
)
def test_kernels_agree_with_the_specification(order, count, options, softening, device):
    p, q = landmarks(count, noise=2.0)
    v = np.concatenate([places(100), q[:100]])  # at cones, too
    options = {"order": order, "softening": softening, **options}
    expected, found = on_both(device, p, q, ("spline", 2), **options)
    assert np.abs(found.backward(v) - expected.backward(v)).max() < 1e-3
    v = v if order > 1 or softening else v[:100]  # r has no slope at a cone
    assert np.abs(found.jacobian(v) - expected.jacobian(v)).max() < 2e-5


@pytest.mark.parametrize("softening", [0, 40.0])
@pytest.mark.parametrize("order", [1, 2, 3])
def test_jacobian_is_the_slope_of_the_map(order, softening):
    p, q = landmarks(30)
    spline = Deformation(p, q, "spline", order=order, softening=softening, device="reference")
    v = places(50)
    np.testing.assert_allclose(spline.jacobian(v), slopes(spline, v), atol=1e-6)


@paired(order=[1, *rare(2, 3)], softening=[0, 40.0], steps=[1, *rare(4)], device=DEVICES)
def test_inverse_leads_back(order, softening, steps, device):
    p, q = landmarks(60)
    settings = {"order": order, "softening": softening, "steps": steps}
    spline = Deformation(p, q, "spline", device=device, **settings)
    np.testing.assert_allclose(spline.residuals(), 0, atol=1e-3)
    x = places(200)
    np.testing.assert_allclose(spline.backward(spline.forward(x)), x, atol=1e-5 * EXTENT)


@paired(order=[1, *rare(2, 3)], softening=[0, 4.0, 40.0], count=[6, 300], device=DEVICES)
def test_interpolated_field_is_within_the_tolerance(order, softening, count, device):
    p, q = landmarks(count, noise=4.0)
    grid = Grid((41, 38, 37), spacing=(EXTENT / 40,) * 3)
    options = {"order": order, "softening": softening, "device": device}
    exact, interpolated = (
        Deformation(p, q, "spline", map_tolerance=tolerance, **options)
        .displacement_field(grid)
        .displacement
        for tolerance in (0, 0.02)
    )
    error = np.linalg.norm(interpolated - exact, axis=-1).max() / (EXTENT / 40)
    assert error < 0.02


@paired(order=[1, 2, 3], smoothing=[0, 20.0], softening=[0, 50.0], weighted=[False, True])
def test_left_out_errors_are_those_of_splines_without_a_point(
    order, smoothing, softening, weighted
):
    p, q = landmarks(25, noise=1.0)
    weights = np.random.default_rng(5).uniform(0.3, 3, 25) if weighted else np.ones(25)
    choice = best_choice(q, p - q, weights, (order,), smoothing, softening)
    lengths = choice.smoothing, choice.softening
    assert (choice.order, lengths) == (order, pytest.approx((smoothing, softening)))
    for i in (0, 11, 24):
        others = np.arange(25) != i
        without = Deformation(
            *(p[others], q[others], "spline"),
            order=order,
            smoothing=smoothing,
            softening=softening,
            weights=weights[others],
            device="reference",
        )
        expected = p[i] - without.backward(q[i, None])[0]
        np.testing.assert_allclose(choice.left_out[i], expected, rtol=1e-9, atol=1e-9 * EXTENT)


def test_automatic_spline_is_near_the_best_of_scipy():
    v = places(300)
    for count, noise in ((30, 0), (200, 0), (200, 3.0), (600, 3.0)):
        p, q = landmarks(count, noise, seed=count)
        errors = [
            np.median(
                np.linalg.norm(RBFInterpolator(q, p, kernel=k, degree=1)(v) - smooth(v), axis=1)
            )
            for k in SCIPY.values()
        ]
        automatic = Deformation(p, q, "auto", device="reference")
        error = np.median(np.linalg.norm(automatic.backward(v) - smooth(v), axis=1))
        assert error <= 1.05 * min(errors), (count, noise)
        assert (np.abs(automatic.residuals()).max() > 1) == (noise > 0), (count, noise)


def test_automatic_settings_keep_those_given():
    p, q = landmarks(50, noise=2.0)
    automatic = Deformation(p, q, "auto")
    assert (automatic.kind, automatic.order, automatic.smoothing) == ("spline", 0, -1)
    used = {
        name: getattr(automatic, f"{name}_used") for name in ("order", "smoothing", "softening")
    }
    assert used["softening"] > 0
    chosen = Deformation(p, q, "spline", **used)
    np.testing.assert_array_equal(automatic.backward(q), chosen.backward(q))
    rough = Deformation(p, q, "spline", order=1, smoothing="auto")
    assert (rough.order_used, rough.softening_used) == (1, 0)
    thin_plate = Deformation(p, q, "tps")
    assert (thin_plate.kind, thin_plate.order, thin_plate.smoothing) == ("spline", 1, 0)
    exact = Deformation(p, q, "spline")
    assert exact.smoothing_used == 0
    assert exact.order_used > 0


@pytest.mark.parametrize("order", [1, 2, 3])
def test_points_on_a_plane_or_a_line_leave_what_is_across(order):
    q = landmarks(30)[1]
    across = np.array([0, 0, 50.0])
    flat = q * [1, 1, 0]
    spline = Deformation(flat + [3, 2, 1] * np.sin(flat[:, :1] / 30), flat, "spline", order=order)
    moved = [spline.backward(flat + s * across) - flat - s * across for s in (-1, 0, 1)]
    np.testing.assert_allclose(moved[0], moved[2], atol=1e-3)
    line = np.linspace(0, EXTENT, 5)[:, None] * [1, 0, 0]
    stretched = Deformation(1.5 * line, line, "spline", order=order)
    v = places(20)
    np.testing.assert_allclose(stretched.backward(v), v * [1.5, 1, 1], atol=1e-3)


@pytest.mark.parametrize("order", [1, 2, 3])
def test_points_that_nearly_coincide_are_met(order):
    p, q = landmarks(40)
    q[1], p[1] = q[0] + 1e-5 * EXTENT, p[0] + 1e-5 * EXTENT
    q[2], p[2] = q[3], p[3] + [4, 0, 0]  # contradicts: the mean
    spline = Deformation(p, q, "spline", order=order)
    residuals = spline.residuals()
    np.testing.assert_allclose(residuals[2:4], [[-2, 0, 0], [2, 0, 0]], atol=1e-2)
    np.testing.assert_allclose(np.delete(residuals, (2, 3), axis=0), 0, atol=1e-2)
    assert np.isfinite(spline.backward(places())).all()


def test_curve_acts_by_eight_points_of_each_segment():
    p, q = landmarks(8)
    curve = CurveHandle([[0, 0, 0], [80, 0, 0]], [[0, 5, 0], [80, 5, 20]])
    spline = Deformation(p, q, "spline", order=3, handles=[curve])
    t = (np.arange(8)[:, None] + 0.5) / 8
    more = [curve.rest[0] + t * np.diff(curve.rest, axis=0)]
    more += [curve.deformed[0] + t * np.diff(curve.deformed, axis=0)]
    points = Deformation(*(np.concatenate(x) for x in zip((p, q), more)), "spline", order=3)
    v = places(50)
    np.testing.assert_allclose(spline.backward(v), points.backward(v), atol=1e-3)


def test_what_a_spline_cannot_have_is_refused():
    p, q = landmarks(8)
    cut = HalfPlane((0, 0, 0), (0, 0, 1), (1, 0, 0))
    bone = RegionHandle(Ball((0, 0, 0), 3), np.eye(4))
    for what, options in (("cuts", {"cuts": [cut]}), ("rigid regions", {"handles": [bone]})):
        with pytest.raises(
            ValueError, match=f"`kind` must be one of affine, .* with {what}.*spline"
        ):
            Deformation(p, q, "spline", **options)
        assert Deformation(p, q, "auto", **options).kind == "rigid"
    assert Deformation(p[:4], q[:4], "auto").kind == "rigid"
    with pytest.raises(ValueError, match="`smoothing` must be a number from 0 on, got 'auto'"):
        Deformation(p, q, "rigid", smoothing="auto")
    with pytest.raises(ValueError, match='`order` must be 1, 2, 3 or "auto", got 4'):
        Deformation(p, q, "spline", order=4)
    with pytest.raises(ValueError, match="`rest` must be at most 5000 control points"):
        Deformation(*landmarks(5001), "tps")
