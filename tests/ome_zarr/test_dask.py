"""`vtk_mls.dask.resample`: blocks that are the whole to the bit, and read just what they need."""

import pickle

import dask.array as da
import numpy as np
import pytest

from vtk_mls import Affine, Chain, Deformation, Grid, HalfPlane, Sampling
from vtk_mls.dask import resample
from vtk_mls.transforms import parts

SHAPE = (24, 40, 52)
GRID = Grid(SHAPE[::-1], (3.0, -2, 5), (1.5, 1, 2))
REST = GRID.at([(5.0, 5, 5), (40, 10, 8), (12, 33, 18), (45, 30, 20), (26, 20, 12)])
DEFORMED = REST + [(4.0, 1, 0), (-3, 2, 4), (0, -5, 2), (2, 3, -6), (9, 0, 0)]
CUT = HalfPlane(GRID.at([(26.0, 20, 12)])[0], (0, 1, 0.1), (1, 0, 0))


class Counting:
    """An array that notes the values that are read."""

    def __init__(self, values):
        self.values, self.shape, self.dtype = values, values.shape, values.dtype
        self.read = []

    def __getitem__(self, place):
        self.read.append(self.values[place].size)
        return self.values[place]


def image(dtype, rng, components=()):
    high = 4 if dtype == "uint8" else 60000
    return rng.uniform(0, high, SHAPE + components).astype(dtype)


CASES = {
    "linear": ("float32", {}, {}),
    "labels": ("uint8", {}, {"interpolation": "nearest", "background": 9}),
    "cubic": ("uint16", {}, {"interpolation": "cubic"}),
    "tolerance": ("uint16", {"map_tolerance": 0.05}, {}),
    "cuts": ("float32", {"cuts": CUT}, {"background": np.nan}),
    "continued": ("int64", {"cuts": CUT}, {"void_values": "continued"}),
}


@pytest.mark.parametrize("case", CASES)
def test_blocks_are_the_whole_to_the_bit(case, rng):
    dtype, options, settings = CASES[case]
    values, d = image(dtype, rng), Deformation(REST, DEFORMED, **options)
    sampling = Sampling(GRID, **settings)
    (expected,) = d.resample([values], sampling)
    assert not np.array_equal(expected, values, equal_nan=dtype == "float32")
    lazy = resample(da.from_array(values, 13), d, sampling, chunks=(9, 16, 20))
    assert (lazy.dtype, lazy.chunks[0]) == (values.dtype, (9, 9, 6))
    np.testing.assert_array_equal(lazy.compute(scheduler="threads"), expected)


def test_other_transforms_devices_targets_and_components(rng):
    values = image("uint16", rng, (2,))
    target = Grid((60, 20, 11), (0, 0, 0), (1.5, 2, 3))
    member = Deformation(REST, DEFORMED, device="reference")
    for transform in (Chain([Affine(np.eye(4)), member]), member):
        (expected,) = transform.resample([values], Sampling(GRID, target))
        found = resample(values, transform, Sampling(GRID, target), chunks=(11, 20, 30))
        np.testing.assert_array_equal(found.compute(), expected)
        assert expected.any()


def test_just_the_needed_part_is_read(rng):
    source = Counting(image("uint16", rng))
    d = Deformation(REST, REST + (0.2, 0.1, 0.3))
    lazy = resample(source, d, GRID, chunks=(12, 20, 26))
    assert not source.read, "nothing is read before the result is computed"
    block = lazy[12:, 20:, 26:].compute()
    assert source.read == [13 * 21 * 27]  # the block, and the points beside it
    np.testing.assert_array_equal(block, d.resample([source.values], GRID)[0][12:, 20:, 26:])


def test_blocks_of_one_task_each(rng):
    lazy = resample(da.from_array(image("uint8", rng), 5), Deformation(REST, DEFORMED), GRID, 26)
    assert len(dict(lazy.__dask_graph__())) == lazy.npartitions + 1  # and the shared arguments
    pickle.loads(pickle.dumps(lazy))


def test_a_part_that_needs_too_much_is_halved(rng, monkeypatch):
    source, d = Counting(image("uint16", rng)), Deformation(REST, DEFORMED)
    (expected,) = d.resample([source.values], GRID)
    monkeypatch.setattr(parts, "MAX_SOURCE_BYTES", 30_000)
    np.testing.assert_array_equal(resample(source, d, GRID, -1).compute(), expected)
    assert len(source.read) > 2
    assert max(source.read) * 2 <= 30_000


def test_outside_of_the_source_nothing_is_read(rng):
    source = Counting(image("int16", rng))
    far = Sampling(GRID, Grid((4, 5, 6), (1e4, 0, 0)), background=-3.2)
    assert (resample(source, Deformation(REST, REST), far).compute() == -3).all()
    assert not source.read


@pytest.mark.parametrize("kind", ["numpy", "dask", "slices"])
def test_masked_values_are_refused(kind, rng):
    values, d = np.ma.masked_less(image("uint16", rng), 30000), Deformation(REST, DEFORMED)
    array = {"numpy": values, "dask": da.from_array(values, 13), "slices": Counting(values)}[kind]
    with pytest.raises(ValueError, match="`array` must have no masked values.*ma.filled"):
        resample(array, d, GRID).compute()
    with pytest.raises(ValueError, match="`arrays` must have no masked values"):
        d.resample([values], GRID)
    with pytest.raises(ValueError, match="`rest` must have no masked values"):
        Deformation(np.ma.masked_less(REST, 10), DEFORMED)
    unmasked = np.ma.masked_array(values.data)
    resample(unmasked, d, GRID)


def test_errors_name_the_argument(rng):
    values, d = image("uint16", rng), Deformation(REST, DEFORMED)
    with pytest.raises(ValueError, match="`array` must have the shape of the grid, .24, 40, 52."):
        resample(values[1:], d, GRID)
    with pytest.raises(TypeError, match="`array` must hold integers or floats, got complex128"):
        resample(values.astype(complex), d, GRID)
    with pytest.raises(TypeError, match="`array` must have a shape and a dtype, got 7"):
        resample(7, d, GRID)
    with pytest.raises(TypeError, match="`deformation` must be a transform, got 3"):
        resample(values, 3, GRID)
    with pytest.raises(ValueError, match="`sampling` must have a whole grid"):
        resample(values[:3], d, GRID.part((0, 0, 0), (52, 40, 3)))
