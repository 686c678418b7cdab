"""Deformations in steps: compositions of maps along the paths of the handles."""

import numpy as np
import pytest
from control_point_sets import DEVICES, EVERYWHERE, slopes
from pairwise import paired, rare
from turned_column import turned

from vtk_mls import (
    Ball,
    BallMask,
    CurveHandle,
    Deformation,
    FixedFace,
    Grid,
    HalfPlane,
    Plane,
    RegionHandle,
    SlidingFace,
)
from vtk_mls.model.handles.handle_paths import blended_path, rigid_path

COUNT = 8
HALF_PLANE = HalfPlane((0.5, 0.5, 0.5), (1, 0, 0), (0, 0, 1))
PLANE = Plane((0.5, 0.5, 0.5), (1, 0.2, 0))
CUTS = {
    "none": {},
    "half-plane": {"cuts": HALF_PLANE},
    "half-plane in place": {"cuts": HALF_PLANE, "cut_frame": "deformed"},
    "plane": {"cuts": PLANE},
    "plane in place": {"cuts": PLANE, "cut_frame": "deformed"},
}


def _turn(angle, axis=2):
    motion = np.eye(4)
    i, j = (k for k in range(3) if k != axis)
    motion[i, i] = motion[j, j] = np.cos(angle)
    motion[i, j], motion[j, i] = -np.sin(angle), np.sin(angle)
    return motion


MOTION = _turn(2.0)
MOTION[:3, 3] = 0.5, 0.1, 0.2
HANDLES = {
    "points": {},
    "region": {"handles": RegionHandle(Ball((0.3, 0.3, 0.3), 0.1), MOTION)},
    "curve": {
        "handles": CurveHandle(
            [(0.1, 0.1, 0.9), (0.5, 0.2, 0.8), (0.9, 0.1, 0.9)],
            [(0.1, 0.1, 0.9), (0.5, 0.3, 0.6), (0.9, 0.1, 0.9)],
        )
    },
    "mask": {"mask": BallMask((0.5, 0.5, 0.5), 0.4, 0.3)},
    "fixed": {"constraints": FixedFace(Plane((0, 0, 0), (0, 0, 1)), 0.3)},
    "sliding": {"constraints": SlidingFace(Plane((0, 0, 0), (0, 0, 1)), 0.3)},
    "smooth": {"smoothing": 0.1},
}


def _moved(rng, amount=0.1, count=15):
    rest = rng.random((count, 3))
    return rest, rest + amount * rng.normal(size=rest.shape)


def _composed(rest, deformed, path, v, **options):
    """Origins and Jacobians of v (m, 3) by maps of one step, one after the other."""
    places = [rest, *path, deformed]
    jacobian = np.eye(3)
    for k in range(COUNT, 0, -1):
        stages = []
        for share in ((k - 1) / COUNT, k / COUNT):
            leg = min(int(share * (len(places) - 1)), len(places) - 2)
            t = share * (len(places) - 1) - leg
            stages.append((1 - t) * places[leg] + t * places[leg + 1])
        step = Deformation(*stages, device="reference", **options)
        jacobian = step.jacobian(v) @ jacobian
        v = step.backward(v)
    return v, jacobian


@pytest.mark.parametrize("kind", ["affine", "rigid", "similarity", "polynomial"])
@pytest.mark.parametrize("legs", [1, 2])
def test_steps_are_maps_one_after_the_other(kind, device, legs, rng):
    rest, deformed = _moved(rng, 0.03 if kind == "polynomial" else 0.1)
    path = np.tile((rest + deformed) / 2 + 0.05, (legs - 1, 1, 1))
    v = rng.random((200, 3))
    options = {"kind": kind, "degree": 2}
    expected, slopes = _composed(rest, deformed, path, v, **options)
    d = Deformation(rest, deformed, steps=COUNT, path=path, device=device, **options)
    assert d.steps_used == COUNT
    bound = 1e-12 if device == "reference" else 6e-6
    assert np.abs(d.backward(v) - expected).max() <= bound
    off = np.abs(d.jacobian(v) - slopes).max(axis=(1, 2))
    assert np.median(off) <= bound
    assert off.max() <= max(1e-9, 100 * bound)
    field = d.displacement_field((5, 6, 7), (0, 0, 0), (0.2, 0.15, 0.1))
    at_points = _composed(rest, deformed, path, field.grid.points(), **options)[0]
    moved = field.grid.points() + field.displacement.reshape(-1, 3)
    assert np.abs(moved - at_points).max() <= max(1e-6, bound)


@paired(
    kind=["rigid", "affine", *rare("similarity")],
    alpha=[2, *rare(1, 3)],
    handles=list(HANDLES),
    cut=["none", "half-plane", *rare("half-plane in place", "plane", "plane in place")],
    device=DEVICES,
)
def test_devices_agree_with_the_specification(kind, alpha, handles, cut, device, rng):
    rest, deformed = _moved(rng)
    options = {"kind": kind, "alpha": alpha, "steps": COUNT, **HANDLES[handles], **CUTS[cut]}
    exact = Deformation(rest, deformed, device="reference", **options)
    d = Deformation(rest, deformed, device=device, **options)
    v = rng.random((300, 3))
    distance = exact.void_distance(v)
    # where both sides are as far, and next to faces, rounding decides
    clear = np.abs(distance) > 1e-4
    off = np.abs(d.backward(v) - exact.backward(v)).max(axis=1)
    assert np.quantile(off[clear], 0.98) <= 1e-5
    slopes = np.abs(d.jacobian(v) - exact.jacobian(v)).max(axis=(1, 2))
    assert np.quantile(slopes[clear], 0.9) <= 1e-3
    if cut != "none":
        errors = np.abs(d.void_distance(v) - distance)
        assert np.quantile(errors[np.isfinite(distance)], 0.98) <= 1e-5


@paired(kind=["affine", "rigid", "similarity"], cut=list(CUTS), device=EVERYWHERE)
def test_forward_undoes_backward(kind, cut, device, rng):
    rest, deformed = _moved(rng)
    steps, count = (8, 30) if device == "reference" else (32, 500)
    d = Deformation(rest, deformed, kind, steps=steps, device=device, **CUTS[cut])
    v = rng.random((count, 3))
    v = v[d.void_distance(v) > 1e-3]
    if CUTS[cut]:
        v = v[~d.overlap(v)]
    found = d.forward_field(d.backward(v))
    assert len(v) > 10
    assert found.found.all()
    assert np.abs(d.backward(v) + found.displacement - v).max() <= 1e-5


def _condition(rest, deformed, steps, v, **options):
    """What multiplies errors of stages, (m,): the largest stretch from one to the origin of v by
    the backward map, and from there to v by the forward map."""
    jacobians = []
    for k in range(steps, 0, -1):
        stages = (rest + share * (deformed - rest) for share in ((k - 1) / steps, k / steps))
        step = Deformation(*stages, device="reference", **options)
        jacobians.append(step.jacobian(v))
        v = step.backward(v)
    onward, largest = np.eye(3), np.ones(len(v))
    for jacobian in jacobians[::-1]:
        onward = onward @ jacobian
        largest = np.maximum(largest, np.linalg.norm(onward, 2, axis=(1, 2)))
    return largest / np.linalg.svd(onward, compute_uv=False)[:, -1]


def test_forward_is_as_exact_as_float32_allows_where_material_is_squeezed(key):
    rng = np.random.default_rng(260)
    handles = _moved(rng, 0.185)
    v, options = rng.random((8000, 3)), {"alpha": 3}
    d = Deformation(*handles, steps=32, device=key, **options)
    assert d.smallest_step_determinant > 0.1
    found = d.forward_field(d.backward(v))
    assert found.found.all()
    missed = np.linalg.norm(d.backward(v) + found.displacement - v, axis=1)
    worst = missed.argsort()[-40:]
    assert missed[worst].max() > 1e-3
    rounding = 2.0**-24 * _condition(*handles, 32, v[worst], **options)
    assert (missed[worst] / rounding).max() <= 8
    exact = Deformation(*handles, steps=32, device="reference", **options)
    assert np.abs(exact.forward(exact.backward(v[worst])) - v[worst]).max() <= 1e-5


def test_forward_finds_points_that_only_short_newton_steps_lead_to(key):
    """One such point is among these; the residual rises along most of its Newton step."""
    rng = np.random.default_rng(31)
    handles = _moved(rng, 0.07, count=60)
    v = rng.random((20000, 3))[15200:15300]
    d = Deformation(*handles, "similarity", alpha=3, steps=8, device=key)
    assert d.smallest_determinant > 0
    found = d.forward_field(d.backward(v))
    assert found.found.all()
    assert np.abs(d.backward(v) + found.displacement - v).max() <= 1e-6


def test_slopes_are_those_of_differences(device, rng):
    rest, deformed = _moved(rng)
    for cut in CUTS.values():
        d = Deformation(rest, deformed, steps=COUNT, device=device, **cut)
        v = rng.random((40, 3))
        v = v[np.abs(d.void_distance(v)) > 0.02]
        h = 1e-5 if device == "reference" else 1e-3
        off = np.abs(slopes(d, v, h) - d.jacobian(v)).max(axis=(1, 2))
        assert np.median(off) <= (1e-6 if device == "reference" else 3e-3)


@paired(kind=["affine", "rigid", "similarity"], alpha=[2, *rare(1, 1.5, 3)], device=EVERYWHERE)
def test_as_many_steps_as_needed_do_not_fold(kind, alpha, device):
    for seed in range(1 if device == "reference" else 8):
        rng = np.random.default_rng(seed)
        count = rng.choice([15, 60])
        count = 15 if device == "reference" else count
        rest, deformed = _moved(rng, rng.choice([0.05, 0.1, 0.2]), count)
        options = {"kind": kind, "alpha": alpha, "device": device}
        d = Deformation(rest, deformed, steps="auto", **options)
        assert d.smallest_step_determinant > 0.1
        v = rng.uniform(-0.2, 1.2, (200 if device == "reference" else 20000, 3))
        assert np.linalg.det(d.jacobian(v)).min() > 0
        assert np.abs(d.backward(deformed) - rest).max() <= 1e-5
        field = d.forward_field(rest)
        assert field.found.all()
        assert np.abs(rest + field.displacement - deformed).max() <= 1e-5
        if d.steps_used > 1:
            fewer = Deformation(rest, deformed, steps=d.steps_used // 2, **options)
            assert fewer.smallest_step_determinant <= 0.1


@pytest.mark.parametrize("device", [pytest.param("reference", marks=pytest.mark.matrix), *DEVICES])
@pytest.mark.parametrize(("angle", "size"), [(np.radians(175), 1), (0, 0.02)])
@pytest.mark.parametrize("alpha", [2, pytest.param(1, marks=pytest.mark.matrix)])
def test_a_cluster_turns_and_shrinks_on_a_rigid_path(angle, size, alpha, device, rng):
    box = np.array(list(np.ndindex(2, 2, 2)), float)
    rest = np.concatenate([box, 0.4 + 0.2 * box])
    deformed = np.concatenate([box, 0.5 + size * 0.1 * (2 * box - 1) @ _turn(angle)[:3, :3].T])
    options = {"alpha": alpha, "device": device}
    d = Deformation(rest, deformed, steps="auto", **options)
    straight = Deformation(rest, deformed, steps=2 * d.steps_used, **options)
    assert straight.smallest_step_determinant < 0.1 < d.smallest_step_determinant
    middle = 0.5 + size**0.5 * 0.1 * (2 * box - 1) @ _turn(angle / 2)[:3, :3].T
    np.testing.assert_allclose(d.path_used[3, 8:], middle, atol=0.01)
    np.testing.assert_array_equal(d.path_used[:, :8], np.broadcast_to(box, (7, 8, 3)))
    v = rng.random((100, 3))
    again = Deformation(rest, deformed, steps=d.steps_used, path=d.path_used, **options)
    np.testing.assert_array_equal(again.backward(v), d.backward(v))
    without_folds = Deformation(rest, deformed, **options).without_folds()
    np.testing.assert_array_equal(without_folds.backward(v), d.backward(v))
    np.testing.assert_allclose(d.backward(deformed), rest, atol=1e-5)


@pytest.mark.parametrize("device", [pytest.param("reference", marks=pytest.mark.matrix), *DEVICES])
def test_a_whole_turn_by_a_path(device, rng):
    shares = [0.1, 0.5, 0.9]
    rest = np.array([(a, b, c) for a in shares for b in shares for c in (0.0, 0.33, 0.66, 1.0)])

    where = {"center": np.array([0.5, 0.5, 0]), "height": 1}
    once_around = turned(1, rest, **where)
    path = [turned(k / 16, rest, **where) for k in range(1, 16)]
    d = Deformation(rest, once_around, path=path, device=device)
    assert d.steps_used == 16
    assert d.smallest_step_determinant > 0.1
    top = np.column_stack([rng.uniform(0.2, 0.8, (50, 2)), np.ones(50)])
    moved = d.forward(np.column_stack([top[:, :2], np.full(50, 0.66)]))
    assert np.abs(moved - turned(0.66, top, **where))[:, :2].max() < 0.06
    once = Deformation(rest, once_around, device=device)
    assert np.linalg.det(once.jacobian(rng.random((4000, 3)))).min() < 0


def test_a_rigid_path_of_points_that_coincide(rng):
    rest = np.concatenate([rng.random((4, 3)), np.full((12, 3), 0.5)])
    for deformed in (rng.random(rest.shape), rest, np.zeros_like(rest)):
        for p, q in ((rest, deformed), (deformed, rest)):
            path = rigid_path(p, q, 8)
            assert np.abs(path).max() < 10


def test_a_share_of_a_path(rng):
    rest, deformed, *path = rng.normal(size=(5, 4, 3))
    places = [rest, *path, deformed]  # 4 lines
    end, between = blended_path(rest, deformed, np.array(path), 0.5)
    expected = [(places[0] + places[1]) / 2, places[1], (places[1] + places[2]) / 2, places[2]]
    np.testing.assert_allclose([*between, end], expected, atol=1e-15)
    end, between = blended_path(rest, deformed, np.array(path), 1.25)
    np.testing.assert_allclose(end, deformed + (deformed - places[3]), atol=1e-12)
    end, between = blended_path(rest, deformed, np.array(path), -0.25)
    np.testing.assert_allclose(end, rest - (places[1] - rest), atol=1e-12)
    end, between = blended_path(rest, deformed, (), 0.3)
    np.testing.assert_array_equal(end, rest + 0.3 * (deformed - rest))
    assert between.shape == (0, 4, 3)


def test_regions_go_along_a_screw_and_stay_rigid(device, rng):
    ball = Ball((0.3, 0.3, 0.3), 0.1)
    rest, deformed = _moved(rng, 0.02)
    d = Deformation(rest, deformed, handles=RegionHandle(ball, MOTION), steps=COUNT, device=device)
    inside = rng.normal(size=(200, 3))
    inside *= 0.09 * rng.random((200, 1)) / np.linalg.norm(inside, axis=1, keepdims=True)
    inside += ball.center
    moved = inside @ MOTION[:3, :3].T + MOTION[:3, 3]
    assert np.abs(d.forward(inside) - moved).max() <= 1e-5
    assert np.abs(d.backward(moved) - inside).max() <= 1e-5
    (step, *_) = d.regions[0].control_points.steps(COUNT)
    # an eighth of a screw, eight times, is the motion
    motion = step.handles.regions[0].motion
    np.testing.assert_allclose(np.linalg.matrix_power(motion, COUNT), MOTION, atol=1e-12)


def test_curves_are_carried(device, rng):
    curve = HANDLES["curve"]["handles"]
    rest, deformed = _moved(rng, 0.02)
    d = Deformation(rest, deformed, handles=curve, steps=COUNT, device=device)
    t = np.linspace(0.05, 0.95, 7)[:, None, None]
    p, q = (n[:-1] + t * np.diff(n, axis=0) for n in (curve.rest, curve.deformed))
    assert np.abs(d.backward(q.reshape(-1, 3)) - p.reshape(-1, 3)).max() <= 1e-5


def test_outside_a_mask_nothing_moves(device, rng):
    d = Deformation(*_moved(rng), steps=COUNT, device=device, **HANDLES["mask"])
    v = rng.uniform(-0.2, 1.2, (400, 3))
    outside = v[np.linalg.norm(v - 0.5, axis=1) > 0.71]
    assert len(outside) > 20
    np.testing.assert_array_equal(d.backward(outside), outside)
    np.testing.assert_array_equal(d.forward(outside), outside)


def test_one_step_is_the_single_map(rng):
    handles, v = _moved(rng), rng.random((100, 3))
    plain, one = Deformation(*handles), Deformation(*handles, steps=1)
    np.testing.assert_array_equal(plain.backward(v), one.backward(v))
    assert one.steps_used == 1


def test_steps_for_given_points(rng):
    rest, deformed = _moved(rng, 0.15)
    d = Deformation(rest, deformed)
    far = d.without_folds(np.full((1, 3), 100.0))
    grid = d.without_folds(Grid((20, 20, 20), (0, 0, 0), (0.05,) * 3))
    assert 1 <= far.steps <= grid.steps == grid.steps_used


def test_handles_that_meet_are_reported(caplog):
    rest = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1.0)])
    d = Deformation(rest, rest[[1, 0, 2, 3]], steps="auto")
    assert d.steps_used == 256
    assert d.smallest_step_determinant <= 0.1
    assert "may fold in 256 steps" in caplog.text


@pytest.mark.parametrize("method", ["displacement_field", "jacobian_field"])
@pytest.mark.parametrize("distance", [0.1, 1e5])
def test_values_that_are_not_finite_are_counted(method, distance, rng, caplog):
    p = rng.uniform(0, 1, (40, 3))
    q = p + rng.normal(0, 0.2, p.shape)
    d = Deformation(p, q, "polynomial", degree=2, steps=16, device="reference")
    grid = Grid((3, 2, 1), (0.5, 0.5, 0.5), (distance,) * 3)
    with np.errstate(all="ignore"):  # each step of a polynomial of degree 2 squares the distance
        bad = np.count_nonzero(~np.isfinite(d.jacobian(grid.points()).astype("f4")).all((1, 2)))
    result = getattr(d, method)(grid)
    assert (bad > 0) == (distance > 1)
    assert (f"{bad} of 6 " in caplog.text) == (bad > 0)
    values = result if method == "jacobian_field" else result.displacement
    assert np.isfinite(values).all() == (bad == 0)
