"""Cuts: their shapes, what they do to the map, and the void (section 4 of the paper)."""

import numpy as np
import pytest
from control_point_sets import (
    EXTENT,
    KINDS_AND_DEGREES,
    TOLERANCE,
    deformation,
    on_both,
    random_handles,
    random_rotation,
    slopes,
)
from cut_shapes import EVERY_SHAPE, SHAPES, are_apart, lengths
from pairwise import paired, rare
from vtkmodules.vtkFiltersSources import vtkSphereSource

from vtk_mls import CUT_FRAMES, Deformation, Grid, HalfPlane, Plane, Surface
from vtk_mls.vtk.objects import configured
from vtk_mls.vtk.shape_surfaces import triangles_of


@pytest.fixture(params=CUT_FRAMES)
def cut_frame(request):
    return request.param


def shortest(cut, v, q):
    """Length of the detour from v to q."""
    bend = cut.bend(v, q)
    return lengths(v - bend) + lengths(q - bend)


# Shapes


@pytest.mark.parametrize(
    ("make", "error", "message"),
    [
        (lambda: Plane((0, 0, 0), (0, 0, 0)), ValueError, "`normal` must not be zero"),
        (lambda: Plane((0, 0), (0, 0, 1)), ValueError, "`point` must be three finite numbers"),
        (lambda: Plane("abc", (0, 0, 1)), TypeError, "`point` must be three numbers"),
        (lambda: Plane((10**400, 0, 0), (1, 0, 0)), TypeError, "`point` must be three numbers"),
        (lambda: Plane((0, 0, 0), (1j, 0, 0)), TypeError, "`normal` must be three numbers"),
        (
            lambda: HalfPlane((0, 0, 0), (0, 0, 1), (0, 0, -3)),
            ValueError,
            "`inward` must not be parallel to the normal",
        ),
        (lambda: Surface([(0, 0, 0)], [(0, 0, 1)]), ValueError, "`triangles` must be rows of"),
        (
            lambda: Surface(np.eye(3), np.empty((0, 3))),
            ValueError,
            "`triangles` must have the shape",
        ),
        (
            lambda: Surface([(0, 0, 0), (1, 0, 0), (2, 0, 0)], [(0, 1, 2)]),
            ValueError,
            "got none for triangle 0",
        ),
        (lambda: Surface([(0, 0, np.nan)] * 3, [(0, 1, 2)]), ValueError, "`points` must be finite"),
        (lambda: Surface(np.eye(3) * 1j, [(0, 1, 2)]), TypeError, "`points` must be numbers"),
        (lambda: Surface(np.eye(3), [(0, 1, 1.5)]), TypeError, "`triangles` must be integers"),
        (lambda: Surface.polygon([(0, 0, 0), (1, 0, 0)]), ValueError, "`outline` must be at least"),
        (lambda: Surface.polygon("abc"), TypeError, "`outline` must be numbers"),
        (lambda: Grid("abc"), TypeError, "`dimensions` must be three positive integers"),
        (lambda: Grid((2, 2, 2), (1j, 0, 0)), TypeError, "`origin` must be numbers"),
    ],
)
def test_bad_shapes_are_named(make, error, message):
    with pytest.raises(error, match=message):
        make()


def test_shared_edges_are_watertight(rng):
    """Exactly through the inner edges and corners of a triangulation, nothing slips."""
    at = np.stack([*rng.integers(-3, 4, (2, 500)) / 2, np.zeros(500)], axis=1)
    half = rng.normal(size=at.shape) + [0, 0, 3]
    assert _tiles(2).blocks(at - half, at + half).all()


def _tiles(count):
    """A square of side 2 `count` around the origin, of triangles with corners at whole numbers."""
    n = 2 * count + 1
    y, x = np.mgrid[-count : count + 1, -count : count + 1]
    at = np.arange(n * n).reshape(n, n)
    a, b, c, d = at[:-1, :-1].ravel(), at[:-1, 1:].ravel(), at[1:, :-1].ravel(), at[1:, 1:].ravel()
    triangles = np.concatenate([np.stack([a, b, c], axis=1), np.stack([b, d, c], axis=1)])
    return Surface(np.stack([x, y, 0 * x], axis=-1).reshape(-1, 3), triangles)


def test_of_many_triangles_all_count(rng):
    """More pairs of a segment and a triangle than fit one array, or few of a polygon."""
    v, q = rng.uniform(-30, 30, (2, 500, 3))
    at = v + (q - v) * (v[:, 2] / (v[:, 2] - q[:, 2]))[:, None]
    inside = np.abs(at[:, :2]).max(axis=1) < 20
    polygon = Surface.polygon([(-20, -20, 0), (20, -20, 0), (20, 20, 0), (-20, 20, 0)])
    for cut in (_tiles(20), polygon):
        np.testing.assert_array_equal(cut.blocks(v, q), (v[:, 2] * q[:, 2] < 0) & inside)


def test_segments_through_corners_are_blocked(device, cut_frame):
    """They are common in symmetric scenes."""
    tiles, polygon = _tiles(3), Surface.polygon([(-3, -3, 0), (3, -3, 0), (3, 3, 0), (-3, 3, 0)])
    q = np.array([[0.0, 0, 2]])
    v = np.stack(np.meshgrid(*[np.arange(-4, 5)] * 2, [-2.0, -1.0], indexing="ij"), axis=-1)
    v = v.reshape(-1, 3)
    through = v + (q - v) * (v[:, 2:] / (v[:, 2:] - 2))
    inside = np.abs(through[:, :2]).max(axis=1) < 3
    for cut in (tiles, polygon):
        np.testing.assert_array_equal(cut.blocks(v, q)[inside], True)
    # behind the cut the nearer of two opposite handles has no influence
    visible, hidden = np.array([[0, 0, 2.0], [0, 0, -2.0]]), np.array([[0, 0, 2.5], [0, 0, -3.0]])
    rest, deformed = (visible, hidden) if cut_frame == "rest" else (hidden, visible)
    below = v[np.abs(v[:, :2]).max(axis=1) <= 1]
    if cut_frame == "rest":  # material that has come from there
        below = below + deformed[1] - rest[1]
    for cut in (tiles, polygon):
        d = Deformation(rest, deformed, cuts=[cut], nu=8, cut_frame=cut_frame, device=device)
        with_one = Deformation(rest[1:], deformed[1:], device="reference")
        np.testing.assert_allclose(d.backward(below), with_one.backward(below), atol=0.02)


def test_detours_are_shortest_paths(rng):
    """Against all points of the edge line, and of a polygon's outline."""
    v, q = rng.uniform(-2, 6, (2, 200, 3))
    t = np.linspace(-30, 30, 20001)[:, None]
    half = HalfPlane((1, 2, 3), (1, 2, 2), (1, -1, 0))
    line = half.point + t * half.along
    outline = np.array([(0, 0, 0), (4, 0, 1), (3, 4, 0), (1, 1, 0)], float)
    t = np.linspace(0, 1, 2001)[:, None]
    ring = np.concatenate([a + (b - a) * t for a, b in zip(outline, np.roll(outline, -1, 0))])
    for cut, points in ((half, line), (Surface.polygon(outline), ring)):
        brute = [(lengths(a - points) + lengths(b - points)).min() for a, b in zip(v, q)]
        np.testing.assert_allclose(shortest(cut, v, q), brute, rtol=0, atol=1e-4)


def test_how_far_the_detour_of_a_curved_surface_is_from_the_shortest_path():
    """Through a hemispherical cup at its pole. The shortest path is a chord to the rim, inside,
    and a quarter of a circle back, outside; the detour has two chords, 5 % less.
    """
    half = configured(vtkSphereSource(), Radius=1, EndPhi=90)
    cup = Surface(*triangles_of(configured(half, ThetaResolution=60, PhiResolution=13)))
    inside, outside = np.array([0.001, 0.001, 0.99]), np.array([0.001, 0.001, 1.01])
    assert cup.blocks(inside, outside)
    exact = np.sqrt(2) + np.pi / 2
    assert shortest(cup, inside, outside) == pytest.approx(2 * np.sqrt(2), rel=0.01)
    assert 0.94 < shortest(cup, inside, outside) / exact < 0.96


# The map


@EVERY_SHAPE
def test_interpolates_with_cuts(shape, kind_and_degree, device, cut_frame, rng):
    cuts = SHAPES[shape]
    rest, deformed = random_handles(rng, 25)
    if cut_frame == "rest":  # where sides overlap, only one of them is visible
        for plane in (cut for cut in cuts if isinstance(cut, Plane)):
            deformed += 30 * np.sign(plane.height(rest))[:, None] * plane.normal
    d = deformation(rest, deformed, kind_and_degree, device, cuts=cuts, cut_frame=cut_frame)
    np.testing.assert_allclose(d.backward(deformed), rest, rtol=0, atol=2e-4)


@EVERY_SHAPE
def test_is_the_identity_where_nothing_moved(shape, kind_and_degree, device, cut_frame, rng):
    cuts = SHAPES[shape]
    _, deformed = random_handles(rng, 25)
    d = deformation(deformed, deformed, kind_and_degree, device, cuts=cuts, cut_frame=cut_frame)
    v = rng.uniform(0, EXTENT, (300, 3))
    np.testing.assert_array_equal(d.backward(v), v)
    assert not d.void(v).any()


def test_a_cut_far_outside_changes_nothing(kind_and_degree, device, rng):
    rest, deformed = random_handles(rng, 15)
    v = rng.uniform(0, EXTENT, (300, 3))
    one = deformation(rest, deformed, kind_and_degree, device).backward(v)
    other = deformation(rest, deformed, kind_and_degree, device, cuts=SHAPES["outside"])
    np.testing.assert_allclose(other.backward(v), one, rtol=0, atol=1e-5)


@paired(
    shape=SHAPES,
    kind_and_degree=[*KINDS_AND_DEGREES[:2], *rare(*KINDS_AND_DEGREES[2:])],
    options=[(2, 1.5, 0), (2, 2, 1), *rare((1, 2, 0), (1.6, 2, 0), (1, 3, 30), (1.3, 2, 1000))],
    cut_frame=CUT_FRAMES,
)
def test_devices_agree_with_the_specification(key, shape, kind_and_degree, options, cut_frame, rng):
    rest, deformed = random_handles(rng, 30)
    v = rng.uniform(0, EXTENT, (400, 3))
    options = dict(zip(("alpha", "nu", "smoothing"), options), cuts=SHAPES[shape])
    options["cut_frame"] = cut_frame
    expected, got = on_both(key, rest, deformed, kind_and_degree, **options)
    error = lengths(expected.backward(v) - got.backward(v))
    largest, p99 = TOLERANCE[kind_and_degree]
    # a side of planes has a few control points only, and float32 decides a little less
    factor = 5 if "plane" in shape and "half-planes" not in shape else 1
    factor *= 10 if kind_and_degree[0] == "polynomial" else 1
    assert np.percentile(error, 99) <= factor * p99
    assert error.max() <= factor * largest
    distances = [d.void_distance(v) for d in (expected, got)]
    np.testing.assert_array_equal(*(distance < 0 for distance in distances))
    np.testing.assert_allclose(*distances, rtol=0, atol=factor * largest)
    jacobians = [d.jacobian(v[:100]) for d in (expected, got)]
    error = np.abs(jacobians[0] - jacobians[1]).max(axis=(1, 2))
    assert np.percentile(error, 97) <= 1e-3 * max(1, np.abs(jacobians[0]).max())


@pytest.mark.parametrize("shape", SHAPES)
def test_grids_agree_with_points(key, shape, cut_frame, rng):
    """Region by region, opening and Jacobian included; a cut through grid points too."""
    cuts = SHAPES[shape]
    rest, deformed = random_handles(rng, 20)
    d = deformation(rest, deformed, ("rigid", 1), key, cuts=cuts, cut_frame=cut_frame)
    grid = Grid((33, 20, 17), (3.1, 5, -1), (8, 12.3, 16), random_rotation(rng))
    frame = grid.dimensions, grid.origin, grid.spacing, grid.direction
    field, v = d.displacement_field(*frame), grid.points()
    # a point nearly on a cut may count to either side
    clear = np.all([np.abs(c.void_distance(v, v)) > 1e-2 for c in cuts], axis=0)
    assert clear.mean() > 0.9
    moved = d.backward(v) - v
    np.testing.assert_allclose(
        field.displacement.reshape(-1, 3)[clear], moved[clear], rtol=0, atol=1e-3
    )
    np.testing.assert_allclose(
        field.void_distance.ravel()[clear], d.void_distance(v)[clear], atol=1e-2
    )
    jacobian = d.jacobian_field(grid).reshape(-1, 3, 3)
    np.testing.assert_allclose(jacobian[clear], d.jacobian(v)[clear], rtol=0, atol=2e-3)


@paired(shape=SHAPES, kind_and_degree=KINDS_AND_DEGREES, cut_frame=CUT_FRAMES, smoothing=[0, 30, 1])
def test_jacobian_is_the_derivative(shape, kind_and_degree, cut_frame, smoothing, rng):
    options = {"cuts": SHAPES[shape], "cut_frame": cut_frame, "smoothing": smoothing}
    rest, deformed = random_handles(rng, 20)
    d = deformation(rest, deformed, kind_and_degree, **options)
    v = rng.uniform(0, EXTENT, (200, 3))
    error = np.abs(d.jacobian(v) - slopes(d, v, 1e-4)).max(axis=(1, 2))
    # where a segment starts to be blocked the map has a kink
    assert np.percentile(error, 97) <= 1e-5


@paired(shape=SHAPES, kind_and_degree=KINDS_AND_DEGREES, cut_frame=CUT_FRAMES)
def test_continuous_along_paths_that_cross_no_cut(shape, kind_and_degree, cut_frame, rng):
    """Also where segments start to be blocked."""
    cuts = SHAPES[shape]
    rest, deformed = random_handles(rng, 12)
    d = deformation(rest, deformed, kind_and_degree, cuts=cuts, cut_frame=cut_frame)
    for _ in range(2):
        start, end = rng.uniform(0, EXTENT, (2, 3))
        # fine enough that no step passes all the way through a sliver of another side
        path = start + (end - start) * np.linspace(0, 1, 4001)[:, None]
        origins, crossed = d.backward(path), np.zeros(4000, bool)
        viewpoints = origins if cut_frame == "rest" else path
        if cut_frame == "rest" and len(cuts) > 1:  # nothing of several sides is in the void
            void = d.void(path)
            crossed |= void[:-1] & void[1:]
        crossed |= are_apart(cuts, viewpoints[:-1], viewpoints[1:])
        step = lengths(end - start) / 4000
        speed = lengths(np.diff(origins, axis=0)) / step
        around = np.linalg.norm(d.jacobian(path), axis=(1, 2))
        # the slopes at both ends of a step bound the difference
        bound = 2 * np.maximum(around[:-1], around[1:]) + 0.5
        assert (speed <= bound)[~crossed].all()


def test_sides_are_independent_as_nu_grows(rng):
    """Handles behind a half-plane, far from its edge, matter less and less."""
    cut = HalfPlane((-1000, 128, 128), (0, 0, 1), (1, 0, 0))
    deformed = rng.uniform(0, EXTENT, (20, 3))
    above = deformed[:, 2] > 128
    rest = deformed + np.where(above[:, None], [20, 0, 0], 0)
    v = np.column_stack([rng.uniform(50, 200, (100, 2)), rng.uniform(90, 127, 100)])
    moves = []
    for nu in (1.5, 3, 6, 12):
        d = deformation(rest, deformed, ("rigid", 1), cuts=[cut], nu=nu)
        moves.append(lengths(d.backward(v) - v).max())
    assert moves == sorted(moves, reverse=True)
    assert moves[-1] < 1e-4


def test_a_side_without_control_points_stays_at_rest(kind_and_degree, device, cut_frame, rng):
    rest, deformed = random_handles(rng, 12)
    cut = Plane((0, 0, -10), (0, 0, 1))  # all of them are above
    v = rng.uniform(0, EXTENT, (200, 3))
    v[:100, 2] -= 300
    free = deformation(rest, deformed, kind_and_degree, device)
    if cut_frame == "rest":  # what comes there, and not into what stays
        above = free.forward(v[100:])
        v = np.concatenate([v[:100], above[above[:, 2] > -10]])
    d = deformation(rest, deformed, kind_and_degree, device, cuts=[cut], cut_frame=cut_frame)
    np.testing.assert_array_equal(d.backward(v[:100]), v[:100])
    np.testing.assert_allclose(d.backward(v[100:]), free.backward(v[100:]), rtol=0, atol=1e-6)


def test_a_side_with_one_control_point_is_translated(kind_and_degree, device, cut_frame):
    deformed = np.array([[1, 1, 5], [4, 2, 6], [2, 5, 7], [6, 6, 5], [3, 3, -4]], float)
    rest = deformed + [[0.1, 0, 0], [0, 0.3, 0], [0, 0, 0.2], [0, 0.1, 0.1], [1, 2, 3]]
    plane = Plane((0, 0, 0), (0, 0, 1))
    d = deformation(rest, deformed, kind_and_degree, device, cuts=[plane], cut_frame=cut_frame)
    v = np.array([[0, 0, -3.5], [8, -3, -5]])
    np.testing.assert_allclose(d.backward(v) - v, [[1, 2, 3]] * 2, rtol=0, atol=1e-5)


def test_a_point_on_a_plane_is_on_the_side_of_its_normal(device):
    deformed = np.array([(0, 0, 1), (0, 0, -1)], float)
    rest = deformed + [(1, 0, 0), (-1, 0, 0)]
    d = Deformation(rest, deformed, cuts=[Plane((0, 0, 0), (0, 0, 1))], device=device)
    np.testing.assert_allclose(d.backward([[5, 5, 0]]), [[6, 5, 0]], atol=1e-6)
    field = d.displacement_field((3, 3, 3), (-1, -1, -1)).displacement
    np.testing.assert_allclose(
        field[:, :, :, 0], np.broadcast_to([[[-1]], [[1]], [[1]]], (3, 3, 3))
    )


def test_inside_a_closed_surface_without_control_points_nothing_moves(device, rng):
    corners = np.array([(0, 0, 0), (100, 0, 0), (0, 100, 0), (0, 0, 100)], float) + 100
    shell = Surface(corners, [(0, 1, 2), (0, 1, 3), (0, 2, 3), (1, 2, 3)])
    rest, deformed = random_handles(rng, 12)
    inside = np.array([[110, 110, 110], [115, 120, 112]])
    keep = ~shell.blocks(np.array([-50.0, -60, -70]), deformed)
    d = Deformation(rest[keep], deformed[keep], cuts=[shell], device=device)
    np.testing.assert_allclose(d.backward(inside), inside, rtol=0, atol=1e-4)


@pytest.mark.parametrize("where", ["on the cut", "on its edge"])
def test_control_points_on_a_cut(where, kind_and_degree, device, rng):
    cut = HalfPlane((128, 128, 128), (0, 0, 1), (1, 0, 0))
    rest, deformed = random_handles(rng, 12)
    deformed[0] = (160, 100, 128) if where == "on the cut" else (128, 100, 128)
    d = deformation(rest, deformed, kind_and_degree, device, cuts=[cut])
    assert np.isfinite(d.backward(rng.uniform(0, EXTENT, (200, 3)))).all()
    np.testing.assert_allclose(d.backward(deformed), rest, rtol=0, atol=2e-4)
