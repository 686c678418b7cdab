"""The forward map: the true inverse of the backward map, and what is kept of its search."""

import gc

import numpy as np
import pytest
from control_point_sets import (
    DEVICES,
    EVERYWHERE,
    EXTENT,
    KINDS_AND_DEGREES,
    deformation,
    on_both,
    random_handles,
)
from cut_shapes import SHAPES, are_apart
from pairwise import paired, rare

from vtk_mls import Deformation, HalfPlane, Plane, Surface
from vtk_mls.engine import dispatch
from vtk_mls.engine import opencl_engine as engine

ALPHAS = [2, *rare(0.5, 1, 3)]
# the specification takes seconds for an inverse
FEW_KINDS = [
    pytest.param(
        (kind, degree), marks=[pytest.mark.matrix] * (kind != "rigid"), id=f"{kind}{degree}"
    )
    for kind, degree in KINDS_AND_DEGREES
]


CUTS = {"none": ()} | {name: SHAPES[name] for name in ("half-plane", "polygon", "plane")}


def misses(d, x, field):
    """How far G(v) is from x where v was found, next to `EXTENT`.

    Not where a side of a cut has been pushed into another, which is what G shows there.
    """
    x, displacement = x[field.found], field.displacement[field.found].astype(float)
    origins = d.backward(x + displacement)
    distance = np.linalg.norm(origins - x, axis=1) / EXTENT
    if d.in_rest_frame:
        distance[are_apart(d.obstacles, x, origins)] = 0
    return distance


@paired(
    cuts=CUTS,
    alpha=ALPHAS,
    kind_and_degree=[("rigid", 1), *rare(*KINDS_AND_DEGREES[1:])],
    device=EVERYWHERE,
    smoothing=[0, 30, *rare(1)],
)
def test_undoes_backward_and_is_undone_by_it(cuts, alpha, kind_and_degree, device, smoothing, rng):
    """Wherever the map does not fold and no cut is in the way."""
    # each side of a plane needs more control points than a cubic has coefficients
    count = 150 if (kind_and_degree, cuts) == (("polynomial", 3), "plane") else 40
    rest, deformed = random_handles(rng, count, 2)
    options = {"alpha": alpha, "cuts": CUTS[cuts], "smoothing": smoothing}
    d = deformation(rest, deformed, kind_and_degree, device, **options)
    v = np.random.default_rng(7).uniform(30, 226, (300, 3))
    v = v[(np.linalg.det(d.jacobian(v)) > 0.3) & (d.void_distance(v) > 1e-5 * EXTENT)]
    assert len(v) > 150
    x = d.backward(v)
    field = d.forward_field(x)
    assert field.found.all()
    assert misses(d, x, field).max() <= 1e-5
    error = np.linalg.norm(x + field.displacement - v, axis=1)[field.found] / EXTENT
    # a place can have a second one with the same origin, behind a fold
    assert np.percentile(error, 98) <= 1e-5


def test_points_that_are_not_finite_have_no_image(device, rng):
    d = deformation(*random_handles(rng, 9), ("rigid", 1), device)
    x = np.array([(1, 2, 3), (np.nan, 2, 3), (1, np.inf, 3), (1, 2, -np.inf)])
    field = d.forward_field(x)
    np.testing.assert_array_equal(field.found, [True, False, False, False])
    for answer in (field.displacement, d.forward(x)):
        np.testing.assert_array_equal(np.isnan(answer).all(axis=1), ~field.found)


@paired(
    count=[1, 300, 70_000],
    world=[(0, 1), (5e5, 1), (0, 1e-11)],
    dtype=["float32", "float64"],
    device=EVERYWHERE,
)
def test_coordinates_of_every_size_and_precision(count, world, dtype, device, rng):
    offset, scale = world
    count = min(count, 300) if device == "reference" else count  # it is slow
    rest, deformed = (scale * (x + offset) for x in random_handles(rng, 15, 4))
    d = deformation(rest, deformed, ("rigid", 1), device)
    x = (scale * (rng.uniform(0, EXTENT, (count, 3)) + offset)).astype(dtype)
    field = d.forward_field(x)
    assert field.found.all()
    assert field.displacement.dtype == np.float32
    back = d.backward(x + field.displacement.astype(float)) - x
    assert np.abs(back).max() <= 1e-5 * EXTENT * scale


def bar(along, across):
    """Points of a bar of 256 bent by 90 degrees, at `along` (m,) in [0, 1], `across` (m, 2)."""
    angle, radius = along * np.pi / 2, 163 - across[:, 0]
    return np.stack([radius * np.sin(angle), 163 - radius * np.cos(angle), across[:, 1]], axis=1)


def bent_bar():
    """Control points, rest and deformed: the corners of seven cross-sections."""
    corners = np.array([(20, 20), (-20, 20), (20, -20), (-20, -20)], float)
    along, across = np.repeat(np.linspace(0, 1, 7), 4), np.tile(corners, (7, 1))
    return np.column_stack([256 * along, across]), bar(along, across)


BENT_CUTS = {
    "none": (),
    "half-plane": (HalfPlane((104, 60, 0), (0.1, 0.05, 1), (1, -1, 0)),),
    "plane that leaves flat sets": (Plane((0, 0, 0), (0.1, 0.05, 1)),),
    "plane across": (Plane((104, 60, 0), (1, 1, 0.1)),),
    "polygon": (Surface.polygon([(60, -20, 3), (150, 20, -2), (140, 120, 1), (60, 60, 4)]),),
}


@paired(
    cuts=BENT_CUTS,
    alpha=[*ALPHAS, *rare(1.5)],
    kind_and_degree=KINDS_AND_DEGREES,
    device=EVERYWHERE,
)
def test_large_bends_come_back(alpha, cuts, kind_and_degree, device, rng):
    d = deformation(*bent_bar(), kind_and_degree, device, alpha=alpha, cuts=BENT_CUTS[cuts])
    count = 40 if device == "reference" else 2000
    v = bar(rng.uniform(0.05, 0.95, count), rng.uniform(-18, 18, (count, 2)))
    v = v[(np.linalg.det(d.jacobian(v)) > 0.3) & (d.void_distance(v) > 1e-5 * EXTENT)]
    assert len(v) > 0.8 * count
    x = d.backward(v)
    field = d.forward_field(x)
    assert field.found.all()
    assert misses(d, x, field).max() <= 1e-5
    assert np.linalg.norm(x + field.displacement - v, axis=1).max() <= 1e-5 * EXTENT


@pytest.mark.parametrize(
    "device", ["reference", *(pytest.param(key, marks=pytest.mark.matrix) for key in DEVICES)]
)
def test_a_point_at_the_rim_of_the_hidden_part(device):
    """The path to it from any first guess leads through points hidden from x."""
    d = deformation(*bent_bar(), ("rigid", 1), device, alpha=3, cuts=BENT_CUTS["polygon"])
    v = np.array([[132.712652346, 46.04697923, -1.286414308]])
    np.testing.assert_allclose(d.forward(d.backward(v)), v, rtol=0, atol=1e-5 * EXTENT)


def test_carries_control_points_to_where_they_were_dragged(kind_and_degree, device, rng):
    rest, deformed = random_handles(rng, 40, 2)
    d = deformation(rest, deformed, kind_and_degree, device)
    got = d.forward(rest)
    np.testing.assert_allclose(got, deformed, rtol=0, atol=1e-5 * EXTENT)


def test_material_pushed_through_a_cut_has_no_image(device, rng):
    """Two halves are pressed by 3 each towards a plane, where they lose what comes to it."""
    deformed = np.array([(-9, 0, 5), (9, 0, 5), (0, 9, 6), (-9, 0, -5), (9, 0, -5), (0, 9, -6)])
    rest = deformed + np.where(deformed[:, 2:] > 0, 1, -1) * [0, 0, 3.0]
    plane = Plane((0, 0, 0), (0, 0, 1))
    d = Deformation(rest, deformed, cuts=[plane], cut_frame="deformed", device=device)
    x = rng.uniform(-9, 9, (100 if device == "reference" else 20_000, 3))
    x = x[np.abs(np.abs(x[:, 2]) - 3) > 1e-4]
    field = d.forward_field(x)
    np.testing.assert_array_equal(field.found, np.abs(x[:, 2]) > 3)
    np.testing.assert_array_equal(np.isfinite(d.forward(x)).all(axis=1), field.found)
    assert np.isfinite(field.displacement).all()


@pytest.mark.parametrize(
    ("cuts", "cut_frame"), [("none", "rest"), ("half-plane", "rest"), ("half-plane", "deformed")]
)
@pytest.mark.parametrize("kind_and_degree", FEW_KINDS)
def test_points_lost_in_folds_are_those_of_the_specification(
    cuts, cut_frame, kind_and_degree, key, rng
):
    """Control points moved past each other; right at a fold or a cut rounding decides."""
    rest, deformed = random_handles(rng, 60, 25)
    x = rng.uniform(0, EXTENT, (300, 3))
    options = {"cuts": CUTS[cuts], "cut_frame": cut_frame}
    expected, got = on_both(key, rest, deformed, kind_and_degree, **options)
    field = got.forward_field(x)
    assert (field.found != expected.forward_field(x).found).mean() <= 0.01
    assert misses(expected, x, field).max() <= 1e-5


def test_folds_without_cuts_lose_next_to_nothing(key, rng):
    """Far away the map moves all alike, so every place has an origin, however the map folds."""
    rest, deformed = random_handles(rng, 60, 25)
    x = rng.uniform(0, EXTENT, (70_000, 3))
    assert deformation(rest, deformed, ("rigid", 1), key).forward_field(x).found.mean() >= 0.9998


def scaled_world(world, cut, device, kind="rigid", count=9, seed=61):
    """A deformation with a cut through its middle, and places, all times `world`."""
    rng = np.random.default_rng(seed)
    rest = rng.uniform(0, 1, (count, 3))
    deformed = rest + rng.normal(0, 0.03, rest.shape)
    middle = np.full(3, 0.5)
    cuts = {
        "none": (),
        "plane": (Plane(middle * world, (1, 0.2, 0)),),
        "half-plane": (HalfPlane(middle * world, (1, 0.2, 0), (0, 0, 1)),),
        "polygon": (
            Surface.polygon(
                np.array([(0.5, 0, 0), (0.5, 1, 0), (0.5, 1, 1), (0.5, 0, 0.6)]) * world
            ),
        ),
    }
    d = Deformation(rest * world, deformed * world, kind, cuts=cuts[cut], device=device)
    return d, rng.uniform(0, 1, (400, 3)) * world


@paired(
    cut=["none", "plane", "half-plane", "polygon"],
    world=[2.0**-30, 2.0**30],
    kind=["rigid", *rare("affine")],
    device=EVERYWHERE,
)
def test_a_world_of_any_size_gives_the_same_scaled(world, cut, kind, device):
    (unit, x), (d, y) = (scaled_world(size, cut, device, kind) for size in (1.0, world))
    np.testing.assert_array_equal(x * world, y)
    np.testing.assert_allclose(d.backward(y) / world, unit.backward(x), rtol=0, atol=1e-13)
    np.testing.assert_allclose(d.jacobian(y), unit.jacobian(x), rtol=0, atol=1e-12)
    np.testing.assert_array_equal(d.void(y), unit.void(x))
    np.testing.assert_allclose(
        d.void_distance(y) / world, unit.void_distance(x), rtol=0, atol=1e-13
    )
    ours, theirs = d.forward_field(y), unit.forward_field(x)
    np.testing.assert_array_equal(ours.found, theirs.found)
    assert ours.found.mean() > 0.5
    both = ours.displacement / world, theirs.displacement
    np.testing.assert_allclose(*both, rtol=0, atol=1e-7)


@pytest.mark.parametrize("world", [1e-9, 1e-4, 1.0, 1e9])
@pytest.mark.parametrize("dragged", [1, 2])
def test_results_near_a_single_control_point_are_right(world, dragged, device):
    """Places that are pushed through the plane have no place, however small the world is."""
    rest = np.array([(0.9, 0.5, 0.5), (0.1, 0.2, 0.5), (0.2, 0.8, 0.5), (0.3, 0.4, 0.9)]) * world
    deformed = rest.copy()
    deformed[:dragged, 0] -= 0.02 * world
    cut = {"cuts": [Plane(np.full(3, 0.5) * world, (1, 0, 0))], "cut_frame": "deformed"}
    d = Deformation(rest, deformed, device=device, **cut)
    x = np.c_[np.linspace(0.501, 0.56, 12), np.full(12, 0.5), np.full(12, 0.5)] * world
    v = d.forward(x)
    found = np.isfinite(v).all(axis=1)
    np.testing.assert_array_equal(found, x[:, 0] > 0.52 * world)
    truth = Deformation(rest, deformed, device="reference", **cut)
    assert np.abs(truth.backward(v[found]) - x[found]).max() <= 1e-5 * world


@paired(
    far=[1e6, 1e12, 1e18, 1e30, 1e150, 1e300],
    cut=["none", "plane", "half-plane", "polygon"],
    device=EVERYWHERE,
)
def test_a_far_point_does_not_spoil_the_others(far, cut, device):
    d, x = scaled_world(1.0, cut, device)
    clean = d.forward_field(x)
    y = x.copy()
    y[7], y[8] = (far, 0, 0), (0, -far, far)
    spoilt = d.forward_field(y)
    near = np.arange(len(x)) > 8
    np.testing.assert_array_equal(spoilt.found[near], clean.found[near])
    np.testing.assert_allclose(
        spoilt.displacement[near & clean.found], clean.displacement[near & clean.found], atol=1e-6
    )
    assert np.isfinite(spoilt.displacement).all() or far > 1e37
    if far > 1e12:
        assert not spoilt.found[7:9].any()
    v = d.forward(y)
    truth, _ = scaled_world(1.0, cut, "reference")
    y, origins = y[spoilt.found], truth.backward(v[spoilt.found])
    error = np.linalg.norm(origins - y, axis=1)
    overlapping = are_apart(truth.cuts, y, origins)  # one side has been pushed into the other
    assert overlapping.sum() <= 3
    error[overlapping] = 0
    size = np.maximum(1, np.abs(y).max(axis=1))
    assert (error <= 2e-5 * size).all()


def test_a_side_on_which_the_map_is_inside_out_everywhere(device):
    """No sample of it can begin a search."""
    rng = np.random.default_rng(61)
    count = int(rng.integers(3, 15))
    rng.choice(["rigid", "affine", "similarity"])
    rest = rng.uniform(0, 1, (count, 3))
    deformed = rest + rng.normal(0, 0.03, (count, 3))
    plane = Plane((0.5, 0.5, 0.5), rng.normal(size=3))
    d = Deformation(rest, deformed, "affine", cuts=[plane], cut_frame="deformed", device=device)
    x = np.random.default_rng(0).uniform(0, 1, (3000, 3))
    field = d.forward_field(x)
    assert 0.8 < field.found.mean() < 1
    assert np.isfinite(field.displacement).all()


# First guesses and samples are kept as long as the deformation exists


def folding(rng, key, cuts):
    """A deformation that leaves some points without an inverse."""
    return deformation(*random_handles(rng, 40, 25), ("rigid", 1), key, cuts=cuts)


def test_a_second_call_solves_for_no_nodes(key, rng, launched):
    d = deformation(*random_handles(rng, 15, 2), ("rigid", 1), key)
    x = rng.uniform(20, EXTENT - 20, (500, 3))
    first = d.forward_field(x)
    assert "point_displacement" in dict(launched)
    launched.clear()
    second = d.forward_field(x)
    names = [name for name, _ in launched]
    assert names.count("lattice_cells") == names.count("point_forward") == 1
    assert "point_displacement" not in names
    np.testing.assert_array_equal(second.displacement, first.displacement)


@pytest.mark.parametrize("cuts", ["none", "half-plane", "plane"])
def test_samples_are_taken_once(cuts, key, rng, launched):
    d, x = folding(rng, key, CUTS[cuts]), rng.uniform(0, EXTENT, (20_000, 3))
    for is_first in (True, False):
        launched.clear()
        d.forward_field(x)
        assert ("point_jacobian" in dict(launched)) == is_first
        assert "nearest_sample" in dict(launched)


@pytest.mark.parametrize("cuts", ["none", "half-plane", "plane"])
def test_earlier_calls_do_not_change_results(cuts, key, rng):
    handles = random_handles(rng, 40, 25)
    x = rng.uniform(-EXTENT, 2 * EXTENT, (4000, 3))
    x[:4] *= [[1e3], [1e5], [1e7], [1e12]]
    fresh, used = (deformation(*handles, ("rigid", 1), key, cuts=CUTS[cuts]) for _ in range(2))
    for part in (slice(3000, 3001), slice(0, 9), slice(2000, None)):
        used.forward_field(x[part])
    expected, field = fresh.forward_field(x), used.forward_field(x)
    np.testing.assert_array_equal(field.found, expected.found)
    np.testing.assert_array_equal(field.displacement, expected.displacement)


def test_they_go_with_the_deformation(key, rng):
    lattices = engine.on(dispatch.choose(key)).launcher.lattices
    gc.collect()
    before = len(lattices)
    d = folding(rng, key, CUTS["plane"])
    d.forward_field(rng.uniform(0, EXTENT, (2000, 3)))
    assert len(lattices) == before + 2
    del d
    gc.collect()
    assert len(lattices) == before
