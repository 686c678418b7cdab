"""Cuts that belong to the material: nothing is lost when what was cut moves."""

from dataclasses import replace

import numpy as np
import pytest
from control_point_sets import (
    EVERYWHERE,
    block,
    deformation,
    random_rotation,
)
from cut_shapes import lengths
from pairwise import paired

from vtk_mls import Grid, HalfPlane, Plane, Sampling, Surface
from vtk_mls.base.progress import SILENT

SIZE = 4.0  # of the box 4 x 2 x 1 that is cut
BOX = np.array([(0, 0, 0), (4, 2, 1)], float)
MIDDLE = np.array([2, 1, 0.5])
PLANE = Plane(MIDDLE, (1, 0.1, 0))
HALF_PLANE = HalfPlane(MIDDLE, (1, 0, 0), (0, 0, 1))


CAP = Surface(
    [(2, 0.3, 0.2), (2, 1.7, 0.2), (2, 1, 0.9), (2.2, 1, 0.4)], [(0, 1, 3), (1, 2, 3), (2, 0, 3)]
)
CLOSED = Surface(
    [(-1, -1, -1), (9, -1, -1), (-1, 5, -1), (-1, -1, 4)],
    [(0, 1, 2), (0, 1, 3), (0, 2, 3), (1, 2, 3)],
)
SHAPES = {
    "crossing half-planes": [HALF_PLANE, HalfPlane((2, 1, 0.4), (0.3, 1, 0), (0, 0, -1))],
    "half-plane": [HALF_PLANE],
    "polygon": [Surface.polygon([(2, 0.3, 0.2), (2, 1.7, 0.2), (2, 1.7, 0.8), (2, 0.3, 0.8)])],
    "plane": [PLANE],
    "bent surface": [CAP],
    "two planes": [PLANE, Plane(MIDDLE, (0, 1, 0.2))],
    "plane and half-plane": [PLANE, HalfPlane(MIDDLE, (0, 1, 0), (0, 0, 1))],
    "closed surface": [CLOSED],
}


def rest_frame(rest, deformed, kind_and_degree=("rigid", 1), device="reference", **options):
    return deformation(rest, deformed, kind_and_degree, device, cut_frame="rest", **options)


def clear_of(cuts, x):
    """Which of the points x are farther from all cuts than rounding."""
    return np.all([np.abs(cut.void_distance(x, x)) > 1e-5 * SIZE for cut in cuts], axis=0)


def bent(rng, count=30):
    """Control points that are moved smoothly, but apart across the middle."""
    rest = rng.uniform(*BOX, (count, 3))
    wave = np.sin(rest @ rng.normal(0, 1.2, (3, 3)) + rng.uniform(0, 6, 3))
    return rest, rest + 0.15 * wave + 0.15 * np.sign(rest[:, :1] - 2) * [1, 0, 0]


# What moves as a whole


def _origin_map(kind, rng):
    """A map from the deformed to the undeformed space, which the kind can have everywhere."""
    turned = random_rotation(rng)
    matrix = {
        "rigid": turned,
        "similarity": 1.3 * turned,
        "affine": np.eye(3) + rng.uniform(-0.3, 0.3, (3, 3)),
        "polynomial": np.eye(3) + rng.uniform(-0.1, 0.1, (3, 3)),
    }[kind]
    square = 0.03 * rng.uniform(-1, 1, (3, 3, 3)) * (kind == "polynomial")
    towards = MIDDLE + (0.4, -0.1, 0.2)

    def origin(v):
        v = v - MIDDLE
        return v @ matrix + np.einsum("mi,mj,ijk->mk", v, v, square) + towards

    return origin


@paired(shape=SHAPES, kind=["rigid", "affine", "similarity", "polynomial"], device=EVERYWHERE)
def test_a_motion_of_everything_loses_no_material(shape, kind, device, rng):
    cuts, origin = SHAPES[shape], _origin_map(kind, rng)
    deformed = rng.uniform(*BOX, (120, 3))
    d = rest_frame(origin(deformed), deformed, (kind, 2), device, cuts=cuts)
    v = rng.uniform(*BOX, (60 if device == "reference" else 20_000, 3))
    x = origin(v)
    np.testing.assert_allclose(d.backward(v), x, rtol=0, atol=1e-5 * SIZE)
    assert not d.void(v)[clear_of(cuts, x)].any()
    some = slice(None, None, 10)
    np.testing.assert_allclose(d.forward(x[some]), v[some], rtol=0, atol=1e-5 * SIZE)


# What is pulled apart

HANDLES = np.array([(x, y, z) for x in (0, 1.2, 2.8, 4) for y in (0, 2) for z in (0, 1)], float)
RIGHT = HANDLES[:, :1] > 2
ACROSS = {
    "plane": Plane(MIDDLE, (1, 0, 0)),
    "half-plane": HALF_PLANE,
    "polygon": Surface.polygon([(2, -1, 0.5), (2, 3, 0.5), (2, 3, 3), (2, -1, 3)]),
}


def _turned(points, degrees):
    """About the edge of the half-plane; positive opens the side of x > 2."""
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return (points - MIDDLE) @ np.array([[c, 0, -s], [0, 1, 0], [s, 0, c]]) + MIDDLE


def _hinge(degrees):
    return np.where(RIGHT, _turned(HANDLES, degrees / 2), _turned(HANDLES, -degrees / 2))


MOTIONS = {
    "all moved": HANDLES + (0.3, 0, 0),
    "all turned": _turned(HANDLES, -10),
    "both sides": HANDLES + np.where(RIGHT, 0.3, 0.1) * [1, 0, 0],
    "right side": HANDLES + np.where(RIGHT, 0.3, 0) * [1, 0, 0],
    "hinge of 5": _hinge(5),
    "hinge of 25": _hinge(25),
    "hinge of 60": _hinge(60),
}


def test_where_sides_overlap_the_expected_one_is_there(device):
    deformed = HANDLES + np.where(RIGHT, 0.7, 1.3) * [1, 0, 0]
    d = rest_frame(HANDLES, deformed, device=device, cuts=[ACROSS["plane"]])
    v = MIDDLE + [(0.8, 0, 0), (1.2, 0, 0)]
    moved = [(-1.3, 0, 0), (-0.7, 0, 0)]
    np.testing.assert_allclose(d.backward(v) - v, moved, rtol=0, atol=1e-5 * SIZE)
    assert d.overlap(v).all()


def is_lost(d, x):
    """Which of the material at x has no image, or is not visible there though nothing hides it."""
    v = d.forward(x)
    gone = np.isnan(v).any(axis=1)
    v[gone] = 0
    origin, void_distance = d.backward(v), d.void_distance(v)
    gone |= (void_distance < 0) & clear_of(d.cuts, x)
    missed = np.flatnonzero(~gone & (lengths(origin - x) > 1e-4 * SIZE))
    other = d.forward(origin[missed])  # comes to the same place where sides overlap
    gone[missed[~(lengths(other - v[missed]) < 1e-4 * SIZE)]] = True
    return gone


@paired(shape=ACROSS, motion=MOTIONS, device=EVERYWHERE)
def test_opening_loses_no_material(shape, motion, device, rng):
    x = rng.uniform(*BOX, (400 if device == "reference" else 20_000, 3))
    d = rest_frame(HANDLES, MOTIONS[motion], cuts=[ACROSS[shape]], device=device)
    assert is_lost(d, x).mean() <= 1e-4


def test_material_near_a_handle_on_the_cut_is_found(device):
    for seed in (38, 64, 137):
        rng = np.random.default_rng(seed)
        rest = rng.uniform(*BOX, (15, 3))
        deformed = rest + rng.normal(0, 0.05, rest.shape)
        rest[0] = 2 - 1e-3 * (seed % 2), 1 + 0.2 * rng.normal(), rng.uniform(0.5, 0.8)
        deformed[0] = rest[0] + [rng.uniform(-0.5, 0.5), *(0.05 * rng.normal(size=2))]
        d = rest_frame(rest, deformed, cuts=[HALF_PLANE], device=device)
        x = rest[0] + 0.03 * rng.normal(size=(300, 3))
        assert np.isfinite(d.forward(x)).all()


@pytest.mark.parametrize("motion", ["all moved", "all turned", "both sides"])
def test_the_deformed_frame_loses_material_at_the_cut(motion, rng):
    x = rng.uniform(*BOX, (1000, 3))
    d = rest_frame(HANDLES, MOTIONS[motion], cuts=[ACROSS["plane"]])
    assert is_lost(replace(d, cut_frame="deformed"), x).mean() > 0.01


# Round the tip


@pytest.mark.parametrize("motion", ["right side", "hinge of 25", "hinge of 60"])
@pytest.mark.parametrize("shape", ["half-plane", "polygon"])
def test_nothing_jumps_beyond_the_edge(shape, motion, device, rng):
    d = rest_frame(HANDLES, MOTIONS[motion], cuts=[ACROSS[shape]], device=device)
    depth = np.geomspace(1e-5, 0.4, 60)
    x = np.column_stack([np.full(60, 2), rng.uniform(0.2, 1.8, 60), 0.5 - depth])
    v = d.forward(x)
    left, right = (d.backward(v + side * np.array([5e-7, 0, 0])) for side in (-1, 1))
    assert lengths(right - left).max() < 1e-4
    np.testing.assert_allclose(left, x, rtol=0, atol=1e-4)


def _bends(d, count):
    """Largest second differences of origins, by angle, along a loop round where the tip is now."""
    angles = np.linspace(-0.75, 0.75, count) * np.pi  # from the face of the void to the other
    tip = d.forward([MIDDLE - [0, 0, 1e-6]])
    loop = tip + 0.15 * np.stack([np.sin(angles), 0 * angles, -np.cos(angles)], axis=1)
    origins = d.backward(loop)
    assert not d.void(loop).any()
    return lengths(np.diff(origins, 2, axis=0)).max() / (angles[1] - angles[0]) ** 2


@pytest.mark.parametrize(
    ("shape", "motion"), [("half-plane", "hinge of 60"), ("polygon", "hinge of 25")]
)
def test_a_loop_round_the_edge_has_no_kink(shape, motion):
    """At a kink, second differences over finer and finer steps would grow beyond all bounds."""
    d = rest_frame(HANDLES, MOTIONS[motion], cuts=[ACROSS[shape]])
    coarse, fine = (_bends(d, count) for count in (75, 300))
    paper = _bends(replace(d, cut_frame="deformed"), 300)
    assert fine < 1.1 * coarse
    assert fine < 1.5 * paper


@pytest.mark.parametrize("shape", ["half-plane", "plane and half-plane", "polygon"])
def test_guesses_on_fine_grids(key, shape, rng, monkeypatch):
    """Searches end where they do without, and guesses are the same in slabs and parts."""
    d = rest_frame(*bent(rng), device=key, cuts=SHAPES[shape])
    grid = Grid((61, 46, 33), (-0.1, -0.1, -0.1), (0.07, 0.047, 0.036))
    field, v = d.displacement_field(grid), grid.points()
    some = slice(None, None, 7)
    distance = d.void_distance(v[some])
    clear = np.abs(distance) > 1e-3 * SIZE
    error = lengths(field.displacement.reshape(-1, 3)[some] - (d.backward(v[some]) - v[some]))
    assert np.percentile(error, 99.9) <= 1e-6 * SIZE
    assert error[clear & (distance > 0)].max() <= 1e-5 * SIZE
    first, dimensions = (6, 3, 9), (41, 30, 19)
    part = d.displacement_field(grid.part(first, dimensions))
    here = block(first, dimensions)
    monkeypatch.setattr("vtk_mls.engine.map.nodes._NODES", 1)
    monkeypatch.setattr("vtk_mls.engine.launch.launcher._MAX_WORK", 5e5)
    slabs = d.displacement_field(grid)
    for name in ("displacement", "void_distance"):
        whole = getattr(field, name)
        np.testing.assert_array_equal(getattr(slabs, name), whole)
        np.testing.assert_array_equal(getattr(part, name), whole[here])


@pytest.mark.parametrize("shape", ["plane and half-plane", "polygon"])
def test_devices_agree_on_images(key, shape, rng):
    rest, deformed = bent(rng)
    devices = [rest_frame(rest, deformed, device=e, cuts=SHAPES[shape]) for e in ("reference", key)]
    source = Grid((9, 5, 5), (0, 0, 0), (0.5, 0.5, 0.25))
    image = np.sin(source.points() @ (1, 2, 3)).reshape(source.shape)
    vectors = np.stack([image, 2 * image, 1 - image], axis=-1)
    sampling = Sampling(source, source)
    images = [d.resample([image], sampling)[0] for d in devices]
    gradients = [d.resample_gradients(vectors, sampling) for d in devices]
    np.testing.assert_allclose(*images, rtol=0, atol=1e-4)
    np.testing.assert_allclose(*gradients, rtol=0, atol=1e-4)
    bounds = [d.source_bounds(sampling) for d in devices]
    np.testing.assert_allclose(*bounds, rtol=0, atol=1e-4)


def test_the_map_of_one_side_continues_behind_its_face(device, rng):
    rest, deformed = bent(rng)
    d = rest_frame(rest, deformed, device=device, cuts=[HALF_PLANE])
    v = MIDDLE + np.linspace((-0.1, 0, 0.4), (0.1, 0, 0.4), 41)
    heights, distances = [], []
    for side in (-1, 1):
        starts = np.tile(v[20] + 0.5 * side * HALF_PLANE.normal, (len(v), 1))
        x, distance = d._engine.origins_from(d, v, starts, SILENT)
        height = (x - HALF_PLANE.point) @ HALF_PLANE.normal
        assert np.abs(np.diff(height, n=2)).max() < 1e-4
        np.testing.assert_allclose(distance, side * height, atol=1e-5)
        heights.append(height)
        distances.append(distance)
    assert (heights[0] > heights[1] + 0.05).all()  # the sides were pulled apart
    np.testing.assert_allclose(np.max(distances, axis=0), d.void_distance(v), atol=1e-5)


@pytest.mark.parametrize("motion", [(-0.6, -0.3, 0), (-1.2, -0.6, 0)])
def test_a_quarter_pushed_over_crossing_planes_overlaps_all_others(motion, device, rng):
    """Also the one opposite, behind both planes."""
    cuts = [Plane(MIDDLE, (1, 0, 0)), Plane(MIDDLE, (0.4, 1, 0))]

    def is_quarter(x):
        return np.all([cut.height(x) > 0 for cut in cuts], axis=0)

    rest = rng.uniform(*BOX, (60, 3))
    deformed = rest + is_quarter(rest)[:, None] * motion
    d = rest_frame(rest, deformed, device=device, cuts=cuts)
    v = rng.uniform(*BOX, (200 if device == "reference" else 20_000, 3))
    v = v[np.all([clear_of(cuts, v), clear_of(cuts, v - motion)], axis=0)]
    expected = is_quarter(v - motion) & ~is_quarter(v)
    opposite = np.all([cut.height(v) < 0 for cut in cuts], axis=0) & expected
    assert opposite.any()
    np.testing.assert_array_equal(d.overlap(v), expected)
