"""The void distance that a resampling tells of the points it has mapped."""

from __future__ import annotations

import numpy as np
import pytest
from control_point_sets import DEVICES
from pairwise import paired

from vtk_mls import VOID_VALUES, Deformation, Grid, HalfPlane, Plane, Sampling, Surface

CUTS = {
    "plane": [Plane((16, 16, 16), (1, 0.2, 0.1))],
    "half-plane": [HalfPlane((16, 16, 10), (1, 0.2, 0.1), (0, 0, 1))],
    "polygon": [Surface.polygon([(16, 6, 8), (17, 26, 8), (17, 26, 34), (16, 6, 34)])],
}
CUTS["two"] = [*CUTS["plane"], HalfPlane((16, 16, 10), (0.1, 0.2, 1), (0, 1, 0))]
GRID = Grid((41, 37, 33), (-2, -1, 0), (0.9, 0.9, 1))
VALUES = np.random.default_rng(3).uniform(size=GRID.shape).astype(np.float32)


def opened(cuts, device, **options):
    deformed = np.array([(x, y, z) for x in (4, 28) for y in (4, 28) for z in (4, 28)], float)
    rest = deformed - np.where(deformed[:, :1] > 16, [[3, 0, 1]], [[-1, 1, 0]])
    return Deformation(rest, deformed, cuts=cuts, device=device, **options)


ENGINES = ["reference", *DEVICES]
OPTIONS = {
    "rest": {},
    "deformed": {"cut_frame": "deformed"},
    "between nodes": {"map_tolerance": 0.05},
}


@paired(cut=CUTS, option=OPTIONS, device=ENGINES)
def test_it_is_that_of_the_grid(cut, option, device):
    d = opened(CUTS[cut], device, **OPTIONS[option])
    for part in (GRID, GRID.part((3, 4, 2), (30, 25, 20))):
        expected = d.void_distance_field(part)
        assert (expected < 0).any()
        assert (expected > 0).any()
        for void_values in VOID_VALUES:
            sampling = Sampling(GRID, part, void_values=void_values)
            got = np.full(part.shape, np.nan, np.float32)
            (values,) = d.resample([VALUES], sampling, void_distance=got)
            np.testing.assert_allclose(got, expected, atol=1e-4)
            np.testing.assert_array_equal(values, d.resample([VALUES], sampling)[0])


@pytest.mark.parametrize(
    "bad",
    [
        np.zeros(GRID.shape),
        np.zeros(GRID.shape[::-1], np.float32),
        np.zeros((*GRID.shape, 2), np.float32)[..., 0],
        "all",
    ],
    ids=["float64", "shape", "strided", "no array"],
)
def test_what_cannot_be_filled_is_refused(bad):
    with pytest.raises(ValueError, match="`void_distance` must be a writeable, contiguous array"):
        opened([], "reference").resample([VALUES], GRID, void_distance=bad)
