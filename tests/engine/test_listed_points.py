"""Void distances at listed points of a grid, against those of the whole grid."""

import numpy as np
import pytest
from control_point_sets import DEVICES

from vtk_mls import Deformation, Grid, HalfPlane, Plane, Surface
from vtk_mls.engine import dispatch
from vtk_mls.engine.launch import launcher
from vtk_mls.engine.map import origin_nodes
from vtk_mls.reference import reference_engine as reference

HALF_PLANE = HalfPlane((15, 13, 11), (0.2, 0.1, 1), (1, 0.3, 0))
CUTS = {
    "half-plane": [HALF_PLANE],
    "plane": [Plane((15, 13, 11), (0.2, 1, 0.1))],
    "surface": [Surface.polygon([(-9, 2, 9), (34, 2, 9.5), (33, 27, 14), (-9, 26, 13)])],
    "competing regions": [
        Plane((15, 13, 11), (0.2, 1, 0.1)),
        Plane((14, 12, 9), (1, 0.1, 0)),
        HALF_PLANE,
    ],
}
GRID = Grid((31, 26, 23), (0.5, -0.3, 0.2), (0.9, 1, 1.1))
PARTS = {"whole": GRID, "part": GRID.part((3, 2, 5), (20, 23, 11))}


@pytest.fixture(params=["reference", *DEVICES])
def engine(request):
    is_device = request.param in DEVICES
    return dispatch.engine_for(request.param) if is_device else reference


@pytest.fixture(params=["rest", "deformed"])
def cut_frame(request):
    return request.param


@pytest.fixture(params=CUTS)
def opened(request, cut_frame, rng):
    rest = rng.uniform(0, 25, (12, 3))
    moved = rest + rng.normal(size=(12, 3))
    return Deformation(rest, moved, cuts=CUTS[request.param], cut_frame=cut_frame)


@pytest.mark.parametrize("part", PARTS)
def test_distances_equal_those_of_the_grid(engine, opened, part, rng):
    grid = PARTS[part]
    expected = engine.displacement_field(opened, grid)[1].ravel()
    assert 0 < (expected < 0).sum() < grid.size
    for count in (1, 2, 15, 16, 17, 500, grid.size):
        indices = np.sort(rng.choice(grid.size, count, replace=False))
        found = engine.void_distance_listed(opened, grid, indices)
        np.testing.assert_array_equal(found, expected[indices])


@pytest.mark.skipif(not DEVICES, reason="no OpenCL device that computes right")
@pytest.mark.parametrize("in_place", [True, False])
def test_slabs_give_the_same(opened, in_place, rng, monkeypatch):
    engine = dispatch.engine_for(DEVICES[0])
    expected = engine.displacement_field(opened, GRID)[1].ravel()
    monkeypatch.setattr(engine.memory, "in_place", in_place and engine.memory.in_place)
    monkeypatch.setattr(launcher, "_MAX_WORK", 12 * 4 * 2048)
    indices = np.sort(rng.choice(GRID.size, 7000, replace=False))
    found = engine.void_distance_listed(opened, GRID, indices)
    np.testing.assert_array_equal(found, expected[indices])


@pytest.mark.skipif(not DEVICES, reason="no OpenCL device that computes right")
def test_first_guesses_surround_the_points(opened, monkeypatch):
    engine = dispatch.engine_for(DEVICES[0])
    expected = engine.displacement_field(opened, GRID)[1].ravel()
    indices = np.arange(GRID.size * 3 // 4, GRID.size, 7)
    monkeypatch.setattr(origin_nodes, "_NODES", 1)
    found = engine.void_distance_listed(opened, GRID, indices)
    np.testing.assert_array_equal(found, expected[indices])
