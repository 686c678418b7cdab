"""Automatic backgrounds: the median of the corners of each array."""

import dask.array as da
import numpy as np
import pytest

from vtk_mls import Deformation, Grid, HalfPlane, Sampling, dask
from vtk_mls.base.sampling import corner_median

GRID, FAR = Grid((6, 5, 4)), Grid((2, 1, 1), (900, 0, 0))
CUT = HalfPlane((2.5, 2, 1), (1, 0, 0), (0, 0, 1))
D = Deformation([[0, 2, 3], [5, 2, 3]], [[-2, 2, 3], [7, 2, 3]], cuts=CUT, device="reference")


def lower_median(array):
    """By numpy, of the values at the corners; NaN does not count."""
    ends = [sorted({0, n - 1}) for n in array.shape[:3]]
    corners = array[np.ix_(*ends)].reshape(-1, *array.shape[3:])
    return np.nanpercentile(corners.astype(float), 50, axis=0, method="lower")


def noise(rng, dtype, components=(), shape=GRID.shape):
    values = rng.uniform(0, 250, (*shape, *components)).astype(dtype)
    if values.dtype.kind == "f":
        values[0, 0, 0] = values[-1, -1, -1] = np.nan
    return values


@pytest.mark.parametrize("interpolation", ["nearest", "linear", "cubic"])
@pytest.mark.parametrize("dtype", ["int16", "uint8", "float32", "float64", "uint64"])
@pytest.mark.parametrize("components", [(), (1,), (3,)], ids=str)
def test_void_and_outside_have_the_median_of_the_corners(
    device, dtype, components, interpolation, rng
):
    values = noise(rng, dtype, components)
    d = Deformation(D.rest, D.deformed, cuts=CUT, device=device)
    expected = lower_median(values).astype(dtype)
    settings = {"interpolation": interpolation, "background": "auto"}
    (outside,) = d.resample([values], Sampling(GRID, FAR, **settings))
    assert (outside == expected).all()
    (result,) = d.resample([values], Sampling(GRID, **settings))
    void = d.void(GRID.points()).reshape(GRID.shape)
    assert void.sum() > 5
    assert (result[void] == expected).all()
    (zero,) = d.resample([values], Sampling(GRID, interpolation=interpolation))
    covered = GRID.covers(GRID.index_of(d.backward(GRID.points()))).reshape(GRID.shape) & ~void
    np.testing.assert_array_equal(result[covered], zero[covered])


def test_each_array_has_its_own_and_the_gradient_too(rng):
    values = [noise(rng, "int16"), noise(rng, "float32", (3,)), noise(rng, "uint8")]
    sampling = Sampling(GRID, FAR, background=["auto", (1, 2.5, 3), 7])
    ct, colors, labels = D.resample(values, sampling)
    assert ct.flat[0] == lower_median(values[0])
    np.testing.assert_array_equal(colors[0, 0], [(1, 2.5, 3)] * 2)
    assert (labels == 7).all()
    number = float(lower_median(values[0]))
    gradients = [
        D.corrected_gradient(values[0], Sampling(GRID, background=background))
        for background in ("auto", number, 0)
    ]
    np.testing.assert_array_equal(*gradients[:2])
    assert not np.array_equal(*gradients[1:])


def test_medians_of_few_and_of_no_numbers():
    assert corner_median([2, 1, 4, 3]) == 2
    assert corner_median([np.nan, 1.5, np.nan, 9, 4]) == 4
    assert np.isnan(corner_median([np.nan] * 4))
    assert corner_median([np.array([2**62 + 1, 0])] * 8) == (2**62 + 1, 0)
    flat = Grid((6, 5, 1))
    values = np.arange(30.0).reshape(flat.shape)
    still = Deformation([[0, 0, 0]], [[50, 0, 0]], device="reference")
    assert (still.resample([values], Sampling(flat, background="auto"))[0] == 5).all()


@pytest.mark.parametrize("background", ["none", ["auto", "auto"], [1, "none"]])
def test_a_wrong_background_is_named(background):
    with pytest.raises(ValueError, match="`background` must be a number or auto, or one for each"):
        D.resample([np.zeros(GRID.shape)], Sampling(GRID, background=background))


def test_the_corners_of_a_part_are_not_known():
    part = GRID.part((1, 0, 0), (3, 5, 4))
    with pytest.raises(ValueError, match="`background` must be numbers for a part of a grid"):
        D.resample([np.zeros(part.shape)], Sampling(part, GRID, background="auto"))


@pytest.mark.parametrize("components", [(), (3,)], ids=str)
def test_blocks_of_dask_have_the_background_of_the_whole(components, rng):
    values, sampling = noise(rng, "int16", components), Sampling(GRID, background="auto")
    (expected,) = D.resample([values], sampling)
    lazy = dask.resample(da.from_array(values, 2), D, sampling, chunks=2)
    np.testing.assert_array_equal(lazy.compute(scheduler="synchronous"), expected)
