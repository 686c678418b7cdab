"""Voxels in which a field may fold: devices against numpy."""

from __future__ import annotations

import numpy as np
import pytest
from control_point_sets import DEVICES

from vtk_mls.engine import dispatch
from vtk_mls.engine.sample import voxel_volumes
from vtk_mls.queries import certificate

pytestmark = pytest.mark.skipif(not DEVICES, reason="no OpenCL device that computes right")
AXES = {
    "straight": np.diag([1e-3, 2e-3, 0.5e-3]),
    "mirrored": np.diag([1, -2, 0.5]),
    "oblique": np.array([(3, 1, 0), (-1, 2, 1), (0.5, 0, 4.0)]),
}


@pytest.fixture(params=DEVICES or [None])
def engine(request):
    return dispatch.engine_for(request.param)


def check(engine, displacement, axes):
    flags = engine.doubtful_voxels(displacement, axes)
    np.testing.assert_array_equal(flags, certificate.doubtful_voxels(displacement, axes))
    return flags


@pytest.mark.parametrize("axes", AXES)
@pytest.mark.parametrize("n", [2, 3, 15, 16, 17, 18, 33, 40])
def test_all_sizes(axes, n, engine, rng):
    axes, found = AXES[axes], set()
    for shape in ((n, 5, 3), (3, n, 20), (5, 4, n)):
        noise = rng.normal(0, 0.2, (*shape, 3))
        flags = check(engine, (noise @ axes.T).astype(np.float32), axes)
        found |= set(flags.ravel().tolist())
    assert found == {0, 1}


def test_values_that_are_not_finite_are_doubtful(engine, rng):
    displacement = rng.normal(0, 0.01, (6, 7, 40, 3)).astype(np.float32)
    assert not check(engine, displacement, np.eye(3)).any()
    for bad in (np.nan, np.inf):
        displacement[3, 4, 20, 1] = bad
        with np.errstate(invalid="ignore"):
            flags = check(engine, displacement, np.eye(3))
        assert flags.sum() == 8


def test_slabs_give_the_same(engine, rng, monkeypatch):
    displacement = rng.normal(0, 0.2, (40, 20, 33, 3)).astype(np.float32)
    monkeypatch.setattr(voxel_volumes, "MAX_LAUNCH_VOXELS", 1 << 12)
    check(engine, displacement, np.eye(3))
    monkeypatch.setattr(engine.memory, "in_place", False)
    check(engine, displacement, np.eye(3))
