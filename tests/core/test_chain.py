"""Chains of deformations, affine maps and displacement fields."""

import numpy as np
import pytest
from control_point_sets import slopes
from scipy.ndimage import map_coordinates
from scipy.optimize import root

from vtk_mls import Aborted, Affine, Chain, Deformation, Field, Grid, HalfPlane, Sampling

SIZE = 10.0  # of the scenes
SOURCE = Grid((20, 21, 22), (0, 0, 0), (0.5, 0.48, 0.46))
TARGET = Grid((15, 16, 17), (0.2, 0.1, 0), (0.6, 0.6, 0.6))
CUT = HalfPlane((5, 5, 5), (1, 0.1, 0), (0, 0, 1))


def affine(rng):
    matrix = np.eye(4)
    matrix[:3] += rng.normal(0, 0.05, (3, 4))
    return Affine(matrix)


def field(rng, dimensions=(9, 10, 11)):
    """A smooth field on a turned grid around the scene."""
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    corner = 5 - turn @ (np.array(dimensions) - 1) * 1.1
    grid = Grid(dimensions, corner, (2.2, 2.2, 2.2), turn)
    return Field(rng.normal(0, 0.1, (*grid.shape, 3)), grid)


def deformation(rng, device="reference", **options):
    rest = rng.uniform(0, SIZE, (8, 3))
    return Deformation(rest, rest + rng.normal(0, 0.2, (8, 3)), device=device, **options)


def opened(device="reference", drag=0.7, **options):
    """A deformation whose cut opens, or closes for `drag` below 0."""
    rest = np.array([(x, y, z) for x in (2.0, 8) for y in (2, 8) for z in (2, 8)])
    apart = np.where(rest[:, :1] < 5, -drag, drag) * [1, 0, 0]
    return Deformation(rest, rest + apart, cuts=CUT, device=device, **options)


def mixed(rng, device):
    """A chain of everything, with a chain in it."""
    first = deformation(rng, device)
    return Chain([affine(rng), field(rng), Chain([first]), affine(rng), deformation(rng, device)])


def interpolated(values, grid, points, background=0.0):
    """Linear interpolation by scipy, the border up to half a spacing outside."""
    index = grid.index_of(points)
    columns = values.reshape(*grid.shape, -1)
    sampled = np.stack(
        [
            map_coordinates(columns[..., c].astype(float), index.T[::-1], order=1, mode="nearest")
            for c in range(columns.shape[-1])
        ],
        axis=1,
    )
    sampled[~grid.covers(index)] = background
    return sampled


def test_an_affine_map_is_its_matrix(rng):
    matrix, points = affine(rng).matrix, rng.uniform(-5, 15, (50, 3))
    moved = points @ matrix[:3, :3].T + matrix[:3, 3]
    value = Affine(matrix)
    np.testing.assert_allclose(value.forward(points), moved, atol=1e-13)
    np.testing.assert_allclose(value.backward(moved), points, atol=1e-13)
    inverse = np.linalg.inv(matrix[:3, :3])
    np.testing.assert_allclose(value.jacobian(points), np.tile(inverse, (50, 1, 1)), atol=1e-14)


def test_a_field_is_interpolated_linearly_and_nothing_outside(rng):
    value = field(rng)
    points = rng.uniform(-12, 22, (4000, 3))
    expected = points + interpolated(value.displacement, value.grid, points)
    np.testing.assert_allclose(value.backward(points), expected, atol=1e-12)
    outside = ~value.grid.covers(value.grid.index_of(points))
    assert 0 < outside.sum() < len(points)
    np.testing.assert_array_equal(value.backward(points)[outside], points[outside])


def test_a_field_of_one_layer_has_no_slope_across(rng):
    value = Field(rng.normal(0, 0.1, (1, 5, 6, 3)), Grid((6, 5, 1)))
    points = rng.uniform(0, 4, (30, 3)) * [1, 1, 0.1]
    expected = points + interpolated(value.displacement, value.grid, points)
    np.testing.assert_allclose(value.backward(points), expected, atol=1e-12)
    assert (value.jacobian(points)[:, :, 2] == [0, 0, 1]).all()


def test_the_inverse_of_a_field_is_the_root_that_scipy_finds(rng):
    value = field(rng)
    x = rng.uniform(0, SIZE, (20, 3))
    for point, v in zip(x, value.forward(x)):
        found = root(lambda p, x=point: value.backward(p[None])[0] - x, point, tol=1e-12)
        assert found.success
        np.testing.assert_allclose(v, found.x, atol=1e-9)


def test_a_folded_field_finds_what_there_is(rng):
    grid = Grid((3, 3, 3))
    displacement = np.zeros((3, 3, 3, 3))
    displacement[:, :, 0, 0] = 1  # all of the left half comes from x = 1
    value = Field(displacement, grid)
    x = np.array([(0.25, 1, 1), (1.5, 1, 1), (-3, 1, 1), (np.nan, 0, 0)])
    answer = value.forward_field(x)
    np.testing.assert_array_equal(answer.found, [False, True, True, False])
    np.testing.assert_allclose(answer.displacement[1:3], 0, atol=1e-12)
    assert np.isnan(value.forward(x)[0]).all()


def test_the_backward_map_applies_the_last_first(rng, device):
    a, b, c = affine(rng), field(rng), deformation(rng, device)
    v = rng.uniform(0, SIZE, (500, 3))
    expected = a.backward(b.backward(c.backward(v)))
    np.testing.assert_array_equal(Chain([a, b, c]).backward(v), expected)
    np.testing.assert_array_equal(Chain([Chain([a, b]), c]).backward(v), expected)


def test_forward_undoes_backward(rng, device):
    chain = mixed(rng, device)
    v = rng.uniform(1, SIZE - 1, (500, 3))
    x = chain.backward(v)
    np.testing.assert_allclose(chain.forward(x), v, atol=1e-5 * SIZE)
    answer = chain.forward_field(x)
    assert answer.found.all()
    assert answer.displacement.dtype == np.float32
    np.testing.assert_allclose(x + answer.displacement, v, atol=1e-5 * SIZE)


def test_what_one_transform_loses_is_not_found(rng):
    pressed = opened(drag=-1.0, cut_frame="deformed")
    x = rng.uniform(3, 7, (400, 3))
    a = affine(rng)
    expected = pressed.forward_field(a.forward(x)).found
    np.testing.assert_array_equal(Chain([a, pressed]).forward_field(x).found, expected)
    assert 0 < expected.sum() < len(x)


def test_the_jacobian_is_that_of_the_map(rng):
    chain = mixed(rng, "reference")
    v = rng.uniform(1, SIZE - 1, (300, 3))
    error = np.abs(chain.jacobian(v) - slopes(chain, v, 1e-4)).max(axis=(1, 2))
    # differences across the face of a cell of the field are no derivative
    assert np.quantile(error, 0.97) < 1e-6
    np.testing.assert_allclose(
        chain.jacobian_field(TARGET).reshape(-1, 3, 3), chain.jacobian(TARGET.points()), atol=1e-5
    )


@pytest.mark.parametrize("map_tolerance", [0, 0.02])
def test_fields_on_grids_are_the_map_at_their_points(rng, device, map_tolerance, monkeypatch):
    monkeypatch.setattr("vtk_mls.queries.fields.MAX_SLAB_POINTS", 1000)  # several slabs
    last = deformation(rng, device, map_tolerance=map_tolerance)
    for chain in (Chain([affine(rng), field(rng), last]), Chain([last, field(rng), affine(rng)])):
        answer = chain.displacement_field(TARGET)
        v = TARGET.points()
        expected = chain.backward(v) - v
        tolerance = max(1e-5 * SIZE, map_tolerance * TARGET.spacing.max() * 1.2)
        np.testing.assert_allclose(
            answer.displacement.reshape(-1, 3), expected, atol=tolerance, rtol=0
        )
        assert answer.void_distance is None
        part = chain.displacement_field(TARGET.part((3, 2, 1), (5, 6, 7)))
        np.testing.assert_array_equal(part.displacement, answer.displacement[1:8, 2:8, 3:8])


@pytest.mark.parametrize("interpolation", ["nearest", "linear"])
def test_arrays_are_sampled_at_the_origins(rng, device, interpolation):
    chain = mixed(rng, device)
    array = rng.uniform(0, 100, SOURCE.shape)
    (got,) = chain.resample([array], Sampling(SOURCE, TARGET, interpolation, background=-7))
    index = SOURCE.index_of(chain.backward(TARGET.points()))
    order = int(interpolation == "linear")
    expected = map_coordinates(array, index.T[::-1], order=order, mode="nearest")
    inside = SOURCE.covers(index)
    expected[~inside] = -7
    # a device rounds indices to float32: some are on the other side of a border
    borders = np.abs(np.abs(index % 1 - 0.5) - (0 if order == 0 else -1)).min(axis=1) < 1e-4
    safe = ~borders & (np.abs(index + 0.5).min(axis=1) > 1e-4)
    assert 0 < inside.sum() < len(inside)
    np.testing.assert_allclose(got.ravel()[safe], expected[safe], atol=2e-2)


def test_integers_and_the_identity_keep_their_values(rng, device):
    still = Deformation([(5.0, 5, 5)], [(5.0, 5, 5)], device=device)
    nothing = Field(np.zeros((4, 4, 4, 3)), Grid((4, 4, 4)))
    array = rng.integers(-500, 500, SOURCE.shape).astype(np.int16)
    (got,) = Chain([Affine(np.eye(4)), nothing, still]).resample([array], SOURCE)
    assert got.dtype == np.int16
    np.testing.assert_array_equal(got, array)


def test_vectors_follow_the_chain(rng):
    chain = mixed(rng, "reference")
    vectors = rng.normal(size=(*SOURCE.shape, 3)).astype(np.float32)
    v = TARGET.points()
    sampled = interpolated(vectors, SOURCE, chain.backward(v))
    jacobian = chain.jacobian(v)
    covariant = chain.resample_gradients(vectors, Sampling(SOURCE, TARGET)).reshape(-1, 3)
    expected = np.einsum("mji,mj->mi", jacobian, sampled)
    np.testing.assert_allclose(covariant, expected, atol=1e-4)
    tangents = chain.resample_vectors(vectors, Sampling(SOURCE, TARGET)).reshape(-1, 3)
    expected = np.linalg.solve(jacobian, sampled[..., None])[..., 0]
    np.testing.assert_allclose(tangents, expected, atol=1e-4)


def test_the_gradient_of_a_linear_array_is_exact(rng):
    chain = mixed(rng, "reference")
    slope = np.array([1.0, -2, 3])
    array = (SOURCE.points() @ slope).reshape(SOURCE.shape)
    inner = Grid((6, 6, 6), (3, 3, 3), (0.7, 0.7, 0.7))
    gradient = chain.corrected_gradient(array, Sampling(SOURCE, inner)).reshape(-1, 3)
    expected = chain.jacobian(inner.points()).swapaxes(1, 2) @ slope
    np.testing.assert_allclose(gradient, expected, atol=1e-4)


@pytest.mark.parametrize("frame", ["rest", "deformed"])
def test_voids_are_those_of_the_members(rng, device, frame):
    a, b, cut = affine(rng), affine(rng), opened(device, cut_frame=frame)
    chain = Chain([a, cut, b])
    v = rng.uniform(1, SIZE - 1, (2000, 3))
    expected = cut.void_distance(b.backward(v))
    np.testing.assert_array_equal(chain.void_distance(v), expected)
    np.testing.assert_array_equal(chain.void(v), expected < 0)
    assert 0 < (expected < 0).sum() < len(v)
    distance = chain.void_distance_field(TARGET)
    np.testing.assert_allclose(distance.ravel(), chain.void_distance(TARGET.points()), atol=1e-4)
    np.testing.assert_array_equal(chain.void_field(TARGET), distance < 0)
    array = np.ones(SOURCE.shape, np.uint8)
    (got,) = chain.resample([array], Sampling(SOURCE, TARGET, "nearest", background=9))
    inside = SOURCE.covers(SOURCE.index_of(chain.backward(TARGET.points()))).reshape(TARGET.shape)
    clear = np.abs(distance) > 1e-4
    np.testing.assert_array_equal(got[clear], np.where(inside & (distance > 0), 1, 9)[clear])


def test_cells_are_void_by_their_centers(rng):
    chain = Chain([affine(rng), opened()])
    cells = chain.void_of_cells(TARGET)
    centers = chain.void(TARGET.cells.points()).reshape(TARGET.cells.shape)
    np.testing.assert_array_equal(cells.at_center, centers)
    assert 0 < centers.sum() < cells.touched.sum()


def test_the_overlap_is_that_of_the_member(rng):
    pressed = opened(drag=-1.0)
    b = affine(rng)
    v = rng.uniform(3, 7, (500, 3))
    expected = pressed.overlap(b.backward(v))
    np.testing.assert_array_equal(Chain([pressed, b]).overlap(v), expected)
    assert expected.any()


def test_gradients_at_a_face_point_across_it_in_the_whole_chain(rng):
    """At the face, a constant array has a step, whose gradient is along that of the distance."""
    cut, shear = opened(), Affine([(1, 0.8, 0, -4), (0, 1, 0, 0), (0, 0, 1, 0), (0, 0, 0, 1)])
    array = np.full(SOURCE.shape, 100.0)
    chain = Chain([shear, cut])
    near = Grid((24, 12, 12), (3.5, 3.5, 5.5), (0.125, 0.25, 0.25))
    gradient = chain.corrected_gradient(array, Sampling(SOURCE, near)).reshape(-1, 3)
    v, distance = near.points(), chain.void_distance(near.points())
    rows = np.flatnonzero((distance > 0.02) & (distance < 0.15))
    step = 1e-4
    sides = [
        chain.void_distance(v[rows] + step * e) - chain.void_distance(v[rows] - step * e)
        for e in np.eye(3)
    ]
    normal = np.stack(sides, axis=1)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    length = np.linalg.norm(gradient[rows], axis=1)
    steep = length > 10  # not at the edge of the cut, where it hardly opens
    assert steep.sum() > 100
    assert np.median(np.sum(gradient[rows] * normal, axis=1)[steep] / length[steep]) > 0.999


def test_source_bounds_hold_all_origins(rng, device):
    chain, inner = mixed(rng, device), Grid((5, 5, 5), (4, 4, 4), (0.4, 0.4, 0.4))
    low, high = chain.source_bounds(Sampling(SOURCE, inner))
    index = SOURCE.index_of(chain.backward(inner.points()))
    np.testing.assert_allclose((low, high), (index.min(axis=0), index.max(axis=0)), atol=1e-4)


def test_the_fitted_grid_follows_far_moves(rng):
    matrix = np.eye(4)
    matrix[:3, 3] = 300, -200, 100
    chain = Chain([deformation(rng), Affine(matrix)])
    grid = chain.fitted_grid(SOURCE)
    index = grid.index_of(chain.forward(SOURCE.points()))
    assert grid.covers(index).all()
    assert grid.size < 4 * SOURCE.size


def test_long_questions_can_be_stopped(rng):
    fractions = []
    chain = mixed(rng, "reference")
    chain.displacement_field(TARGET, progress=fractions.append)
    assert fractions == sorted(fractions)
    assert fractions[-1] == 1
    with pytest.raises(Aborted):
        chain.displacement_field(TARGET, progress=lambda done: done > 0.3)


@pytest.mark.parametrize(
    ("make", "error", "match"),
    [
        (lambda: Affine(np.eye(3)), ValueError, r"`matrix` must be \(4, 4\) finite numbers"),
        (lambda: Affine(np.zeros((4, 4))), ValueError, r"last row \(0, 0, 0, 1\)"),
        (lambda: Affine(np.diag([1, 0, 1, 1])), ValueError, "`matrix` must be invertible"),
        (lambda: Affine("a"), TypeError, "`matrix` must be numbers"),
        (lambda: Field(np.zeros((2, 3, 4, 3)), Grid((2, 3, 4))), ValueError, "shape of the grid"),
        (lambda: Field(np.full((1, 1, 1, 3), np.nan), Grid((1, 1, 1))), ValueError, "finite"),
        (lambda: Field(np.zeros((1, 1, 1, 3)), 3), TypeError, "`grid` must be a Grid"),
        (lambda: Chain([]), ValueError, "`transforms` is empty"),
        (lambda: Chain([Affine(np.eye(4)), 3]), TypeError, "`transforms` must be .*got 3"),
    ],
)
def test_bad_arguments_are_named(make, error, match):
    with pytest.raises(error, match=match):
        make()


def test_values_cannot_be_changed(rng):
    value = field(rng)
    with pytest.raises(ValueError, match="read-only"):
        value.displacement[0] = 1
    assert "9 x 10 x 11" in repr(Chain([value]))
