"""Flags of void cells: devices against numpy."""

from __future__ import annotations

import numpy as np
import pytest
from control_point_sets import DEVICES

from vtk_mls.engine import dispatch
from vtk_mls.engine.sample import void_corners
from vtk_mls.queries import void_cells

pytestmark = pytest.mark.skipif(not DEVICES, reason="no OpenCL device that computes right")


@pytest.fixture(params=DEVICES or [None])
def engine(request):
    return dispatch.engine_for(request.param)


def distances(shape, rng):
    """Void distances of a random plane, with steps."""
    z, y, x = np.meshgrid(*[np.arange(n) for n in shape], indexing="ij")
    normal = rng.normal(size=3)
    height = normal[0] * x + normal[1] * y + normal[2] * z
    height += 20 * (rng.random(shape) < 0.002) - np.median(height)
    return height.astype(np.float32)


def check(engine, values, min_distance):
    got = engine.void_by_corners(values, min_distance)
    np.testing.assert_array_equal(got, void_cells.by_corners(values, min_distance))
    return got


@pytest.mark.parametrize("n", [1, 2, 3, 4, 15, 16, 17, 18, 19, 33, 50])
def test_every_size(n, engine, rng):
    found = set()
    for shape in ((n, 7, 40), (9, n, 37), (20, 9, n), (n, 1, 1), (1, n, 1), (1, 1, n)):
        for min_distance in (0.0, 1.5, 6.0):
            found |= set(check(engine, distances(shape, rng), min_distance).ravel().tolist())
    assert {0, void_cells.UNKNOWN, void_cells.VOID | void_cells.TOUCHED} <= found or n == 1


def test_nan_and_infinity_decide_nothing(engine, rng):
    values = distances((20, 21, 40), rng)
    for bad in (np.inf, -np.inf, np.nan):
        some = values.copy()
        some.flat[rng.integers(0, some.size, 5)] = bad
        with np.errstate(invalid="ignore"):
            check(engine, some, 1.0)
    assert (
        check(engine, np.full((4, 5, 20), np.inf, np.float32), np.inf) == void_cells.UNKNOWN
    ).all()


def test_slabs_give_the_same(engine, rng, monkeypatch):
    values = distances((70, 20, 33), rng)
    monkeypatch.setattr(void_corners, "MAX_LAUNCH_CELLS", 1 << 12)
    check(engine, values, 1.5)
    monkeypatch.setattr(engine.memory, "in_place", False)
    check(engine, values, 1.5)
    monkeypatch.setattr(engine.memory, "limit", 20 * 33 * 5 * 2 * 9)
    check(engine, values, 1.5)
