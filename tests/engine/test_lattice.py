"""First guesses and samples of the inverse are kept as long as the deformation exists."""

import gc

import numpy as np
import pytest
from control_point_sets import EXTENT, deformation, random_handles

from vtk_mls import HalfPlane, Plane
from vtk_mls.engine import dispatch
from vtk_mls.engine import opencl_engine as engine

CUTS = {
    "none": (),
    "half-plane": (HalfPlane((128, 128, 128), (0.2, 0.1, 1), (1, 0.3, 0)),),
    "plane": (Plane((128, 128, 128), (0.1, 0.2, 1)),),
}


def folding(rng, key, cuts):
    """A deformation that leaves some points without an inverse."""
    return deformation(*random_handles(rng, 40, 25), ("rigid", 1), key, cuts=cuts)


def test_a_second_call_solves_for_no_nodes(key, rng, launched):
    d = deformation(*random_handles(rng, 15, 2), ("rigid", 1), key)
    x = rng.uniform(20, EXTENT - 20, (500, 3))
    first = d.forward_field(x)
    assert "point_displacement" in dict(launched)
    launched.clear()
    second = d.forward_field(x)
    names = [name for name, _ in launched]
    assert names.count("lattice_cells") == names.count("point_forward") == 1
    assert "point_displacement" not in names
    np.testing.assert_array_equal(second.displacement, first.displacement)


@pytest.mark.parametrize("cuts", CUTS)
def test_samples_are_taken_once(cuts, key, rng, launched):
    d, x = folding(rng, key, CUTS[cuts]), rng.uniform(0, EXTENT, (20_000, 3))
    for is_first in (True, False):
        launched.clear()
        d.forward_field(x)
        assert ("point_jacobian" in dict(launched)) == is_first
        assert "nearest_sample" in dict(launched)


@pytest.mark.parametrize("cuts", CUTS)
def test_earlier_calls_do_not_change_results(cuts, key, rng):
    handles = random_handles(rng, 40, 25)
    x = rng.uniform(-EXTENT, 2 * EXTENT, (4000, 3))
    x[:4] *= [[1e3], [1e5], [1e7], [1e12]]
    fresh, used = (deformation(*handles, ("rigid", 1), key, cuts=CUTS[cuts]) for _ in range(2))
    for part in (slice(3000, 3001), slice(0, 9), slice(2000, None)):
        used.forward_field(x[part])
    expected, field = fresh.forward_field(x), used.forward_field(x)
    np.testing.assert_array_equal(field.found, expected.found)
    np.testing.assert_array_equal(field.displacement, expected.displacement)


def test_they_go_with_the_deformation(key, rng):
    lattices = engine.on(dispatch.choose(key)).launcher.lattices
    gc.collect()
    before = len(lattices)
    d = folding(rng, key, CUTS["plane"])
    d.forward_field(rng.uniform(0, EXTENT, (2000, 3)))
    assert len(lattices) == before + 2
    del d
    gc.collect()
    assert len(lattices) == before
