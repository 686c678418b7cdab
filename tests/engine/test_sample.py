"""Interpolated values of arrays: devices against numpy."""

import numpy as np
import pytest
from control_point_sets import DEVICES

from vtk_mls import INTERPOLATIONS, Grid
from vtk_mls.base import interpolation
from vtk_mls.engine import dispatch

pytestmark = pytest.mark.skipif(not DEVICES, reason="no OpenCL device that computes right")
WHOLE = Grid((17, 12, 9), (1, 2, 3), (0.5, 1, 2))


@pytest.fixture(params=DEVICES or [None])
def engine(request):
    return dispatch.engine_for(request.param)


@pytest.mark.parametrize("method", INTERPOLATIONS)
@pytest.mark.parametrize("dtype", ["float32", "float64", "int16", "uint8", "int64"])
@pytest.mark.parametrize("source", [WHOLE, WHOLE.part((2, 1, 3), (14, 10, 5))])
@pytest.mark.parametrize("components", [(), (3,)])
def test_values_equal_those_of_numpy(engine, method, dtype, source, components, rng):
    array = (100 * rng.random((*source.shape, *components))).astype(dtype)
    for count in (0, 1, 15, 16, 1000):
        index = np.float32(rng.uniform(-2, 18, (count, 3))).astype(np.float64)
        found = engine.sample(array, index, method, 7, source)
        expected = interpolation.sample(array, index, method, 7, source)
        assert found.shape == expected.shape
        assert found.dtype == expected.dtype
        rounding = 1 if array.dtype.kind in "iu" else 1e-4
        np.testing.assert_allclose(found, expected, rtol=0, atol=rounding)
