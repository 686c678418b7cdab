"""Gradients by differences: devices against numpy in float64."""

from __future__ import annotations

import numpy as np
import pytest
from control_point_sets import DEVICES, random_rotation
from pairwise import paired, rare

from vtk_mls import Grid
from vtk_mls.engine import dispatch
from vtk_mls.engine.sample import differences
from vtk_mls.queries import vector_fields

DTYPES = ["float32", "float64", "int16", "uint64"]
DTYPES += rare("int8", "uint8", "uint16", "int32", "uint32", "int64")  # which images have, too
SPACING = 0.5, -2.0, 3.0

pytestmark = pytest.mark.skipif(not DEVICES, reason="no OpenCL device that computes right")


@pytest.fixture(params=DEVICES or [None])
def engine(request):
    return dispatch.engine_for(request.param)


def check(engine, array, grid):
    expected = vector_fields.gradient(array, grid)
    got = engine.gradient(array, grid)
    assert got.dtype == np.float32
    scale = np.nanmax(np.abs(expected), initial=1e-30)
    np.testing.assert_allclose(got / scale, expected / scale, atol=1e-6)


@paired(dtype=DTYPES)
def test_arrays_of_every_type(dtype, engine, rng):
    grid = Grid((37, 6, 7), (1, 2, 3), SPACING, random_rotation(rng))
    values = rng.uniform(0, 120, grid.shape)
    check(engine, values.astype(dtype), grid)


@pytest.mark.parametrize("n", [1, 2, 3, 4, 5, 6, 16, 17, 20, 33])
def test_arrays_of_every_size(n, engine, rng):
    """Points with no neighbor, one, or two on a side."""
    for dimensions in ((n, 7, 5), (5, n, 7), (7, 5, n)):
        grid = Grid(dimensions, (0, 0, 0), SPACING)
        check(engine, rng.normal(size=grid.shape).astype(np.float32), grid)


def test_large_values_keep_their_small_differences(engine, rng):
    grid = Grid((40, 9, 9))
    check(engine, (1000 + 0.01 * rng.normal(size=grid.shape)).astype(np.float32), grid)


def test_nan_does_not_spread(engine, rng):
    grid = Grid((40, 9, 9))
    array = rng.normal(size=grid.shape).astype(np.float32)
    array[4, 4, 20] = np.nan
    check(engine, array, grid)


def test_numpy_handles_other_types(engine, rng):
    grid = Grid((9, 8, 7))
    for dtype in (np.float16, np.longdouble):
        check(engine, rng.normal(0, 50, grid.shape).astype(dtype), grid)


def test_slabs_give_the_same(engine, rng, monkeypatch):
    grid = Grid((21, 10, 30))
    array = rng.normal(size=grid.shape).astype(np.float32)
    whole = engine.gradient(array, grid)
    monkeypatch.setattr(differences, "MAX_LAUNCH_POINTS", 700)
    for in_place in {engine.memory.in_place, False}:
        monkeypatch.setattr(engine.memory, "in_place", in_place)
        np.testing.assert_array_equal(engine.gradient(array, grid), whole)
    monkeypatch.setattr(engine.memory, "limit", 60_000)
    np.testing.assert_array_equal(engine.gradient(array, grid), whole)
