"""Kernels over grids of values, against numpy: differences, void cells, voxels that may fold."""

from __future__ import annotations

import numpy as np
import pytest
from control_point_sets import DEVICES, random_rotation
from pairwise import paired, rare

from vtk_mls import Grid
from vtk_mls.engine import dispatch
from vtk_mls.engine.sample import grid_kernels
from vtk_mls.queries import certificate, vector_fields, void_cells

DTYPES = ["float32", "float64", "int16", "uint64"]
DTYPES += rare("int8", "uint8", "uint16", "int32", "uint32", "int64")  # which images have, too
SPACING = 0.5, -2.0, 3.0
AXES = {
    "straight": np.diag([1e-3, 2e-3, 0.5e-3]),
    "mirrored": np.diag([1, -2, 0.5]),
    "oblique": np.array([(3, 1, 0), (-1, 2, 1), (0.5, 0, 4.0)]),
}
pytestmark = pytest.mark.skipif(not DEVICES, reason="no OpenCL device that computes right")


@pytest.fixture(params=DEVICES or [None])
def engine(request):
    return dispatch.engine_for(request.param)


def check_gradient(engine, array, grid):
    expected = vector_fields.gradient(array, grid)
    got = engine.gradient(array, grid)
    assert got.dtype == np.float32
    scale = np.nanmax(np.abs(expected), initial=1e-30)
    np.testing.assert_allclose(got / scale, expected / scale, atol=1e-6)


@paired(dtype=DTYPES)
def test_gradients_of_every_type(dtype, engine, rng):
    grid = Grid((37, 6, 7), (1, 2, 3), SPACING, random_rotation(rng))
    values = rng.uniform(0, 120, grid.shape)
    check_gradient(engine, values.astype(dtype), grid)


@pytest.mark.parametrize("n", [1, 2, 3, 4, 5, 6, 16, 17, 20, 33])
def test_gradients_of_every_size(n, engine, rng):
    """Points with no neighbor, one, or two on a side."""
    for dimensions in ((n, 7, 5), (5, n, 7), (7, 5, n)):
        grid = Grid(dimensions, (0, 0, 0), SPACING)
        check_gradient(engine, rng.normal(size=grid.shape).astype(np.float32), grid)


def with_nan(values):
    values[4, 4, 20] = np.nan
    return values


ARRAYS = {
    "large values with small differences": lambda x: (1000 + 0.01 * x).astype(np.float32),
    "NaN, which does not spread": lambda x: with_nan(x.astype(np.float32)),
    "half, by numpy": lambda x: (50 * x).astype(np.float16),
    "long double, by numpy": lambda x: (50 * x).astype(np.longdouble),
}


@pytest.mark.parametrize("name", ARRAYS)
def test_gradients_of_unusual_arrays(name, engine, rng):
    grid = Grid((40, 9, 9))
    check_gradient(engine, ARRAYS[name](rng.normal(size=grid.shape)), grid)


def test_slabs_give_the_same_gradients(engine, rng, monkeypatch):
    grid = Grid((21, 10, 30))
    array = rng.normal(size=grid.shape).astype(np.float32)
    whole = engine.gradient(array, grid)
    monkeypatch.setattr(grid_kernels, "MAX_LAUNCH_POINTS", 700)
    for in_place in {engine.memory.in_place, False}:
        monkeypatch.setattr(engine.memory, "in_place", in_place)
        np.testing.assert_array_equal(engine.gradient(array, grid), whole)
    monkeypatch.setattr(engine.memory, "limit", 60_000)
    np.testing.assert_array_equal(engine.gradient(array, grid), whole)


def distances(shape, rng):
    """Void distances of a random plane, with steps."""
    z, y, x = np.meshgrid(*[np.arange(n) for n in shape], indexing="ij")
    normal = rng.normal(size=3)
    height = normal[0] * x + normal[1] * y + normal[2] * z
    height += 20 * (rng.random(shape) < 0.002) - np.median(height)
    return height.astype(np.float32)


def check_void(engine, values, min_distance):
    got = engine.void_by_corners(values, min_distance)
    np.testing.assert_array_equal(got, void_cells.by_corners(values, min_distance))
    return got


@pytest.mark.parametrize("n", [1, 2, 3, 4, 15, 16, 17, 18, 19, 33, 50])
def test_void_cells_of_every_size(n, engine, rng):
    found = set()
    for shape in ((n, 7, 40), (9, n, 37), (20, 9, n), (n, 1, 1), (1, n, 1), (1, 1, n)):
        for min_distance in (0.0, 1.5, 6.0):
            found |= set(check_void(engine, distances(shape, rng), min_distance).ravel().tolist())
    assert {0, void_cells.UNKNOWN, void_cells.VOID | void_cells.TOUCHED} <= found or n == 1


def test_nan_and_infinity_decide_no_void_cell(engine, rng):
    values = distances((20, 21, 40), rng)
    for bad in (np.inf, -np.inf, np.nan):
        some = values.copy()
        some.flat[rng.integers(0, some.size, 5)] = bad
        with np.errstate(invalid="ignore"):
            check_void(engine, some, 1.0)
    assert (
        check_void(engine, np.full((4, 5, 20), np.inf, np.float32), np.inf) == void_cells.UNKNOWN
    ).all()


def test_slabs_give_the_same_void_cells(engine, rng, monkeypatch):
    values = distances((70, 20, 33), rng)
    monkeypatch.setattr(grid_kernels, "MAX_LAUNCH_POINTS", 1 << 12)
    check_void(engine, values, 1.5)
    monkeypatch.setattr(engine.memory, "in_place", False)
    check_void(engine, values, 1.5)
    monkeypatch.setattr(engine.memory, "limit", 20 * 33 * 5 * 2 * 9)
    check_void(engine, values, 1.5)


def check_voxels(engine, displacement, axes):
    flags = engine.doubtful_voxels(displacement, axes)
    np.testing.assert_array_equal(flags, certificate.doubtful_voxels(displacement, axes))
    return flags


@pytest.mark.parametrize("axes", AXES)
@pytest.mark.parametrize("n", [2, 3, 15, 16, 17, 18, 33, 40])
def test_doubtful_voxels_of_every_size(axes, n, engine, rng):
    axes, found = AXES[axes], set()
    for shape in ((n, 5, 3), (3, n, 20), (5, 4, n)):
        noise = rng.normal(0, 0.2, (*shape, 3))
        flags = check_voxels(engine, (noise @ axes.T).astype(np.float32), axes)
        found |= set(flags.ravel().tolist())
    assert found == {0, 1}


def test_voxels_that_are_not_finite_are_doubtful(engine, rng):
    displacement = rng.normal(0, 0.01, (6, 7, 40, 3)).astype(np.float32)
    assert not check_voxels(engine, displacement, np.eye(3)).any()
    for bad in (np.nan, np.inf):
        displacement[3, 4, 20, 1] = bad
        with np.errstate(invalid="ignore"):
            flags = check_voxels(engine, displacement, np.eye(3))
        assert flags.sum() == 8


def test_slabs_give_the_same_voxels(engine, rng, monkeypatch):
    displacement = rng.normal(0, 0.2, (40, 20, 33, 3)).astype(np.float32)
    monkeypatch.setattr(grid_kernels, "MAX_LAUNCH_POINTS", 1 << 12)
    check_voxels(engine, displacement, np.eye(3))
    monkeypatch.setattr(engine.memory, "in_place", False)
    check_voxels(engine, displacement, np.eye(3))
