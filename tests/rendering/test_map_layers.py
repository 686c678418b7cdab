"""The interpolated layers agree with the map up to the faces of the cuts."""

from __future__ import annotations

import numpy as np
import pytest
from vtk_fixtures import FAST

from vtk_mls import Deformation, Grid, HalfPlane, Plane, Surface
from vtk_mls.base.interpolation import sample
from vtk_mls.rendering.map_layers import layers

MIDDLE = np.array([2, 1, 0.5])
GRID = Grid((64, 40, 28), (-0.3, -0.3, -0.3), (4.6 / 63, 2.6 / 39, 1.6 / 27))
CELL = 0.07
BOX = [(2 + x, 1 + y, 0.5 + z) for z in (-0.3, 0.3) for y in (-0.6, 0.6) for x in (-1, 1)]
SQUARES = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
CUTS = {
    "plane": Plane(MIDDLE, (1, 0.1, 0)),
    "half-plane": HalfPlane(MIDDLE, (1, 0, 0), (0, 0, 1)),
    "polygon": Surface.polygon([(2, 0.3, 0.2), (2, 1.7, 0.2), (2, 1.7, 0.8), (2, 0.3, 0.8)]),
    "three planes": [Plane(MIDDLE, n) for n in ((1, 0.1, 0), (0.2, 1, 0), (0, 0.1, 1))],
    "sharp planes": [Plane(MIDDLE, (1, 0, 0)), Plane(MIDDLE, (1, 0.5, 0))],
    "plane and half-plane": [Plane(MIDDLE, (1, 0.1, 0)), HalfPlane(MIDDLE, (0, 1, 0), (0, 0, 1))],
    "half-planes that cross": [
        HalfPlane(MIDDLE, (1, 0, 0), (0, 0, 1)),
        HalfPlane(MIDDLE, (0, 1, 0), (1, 0, 0.2)),
    ],
    "parallel planes": [Plane(MIDDLE + (x, 0, 0), (1, 0, 0)) for x in (-0.9, 0, 0.9)],
    "closed box": Surface(BOX, [half for a, b, c, d in SQUARES for half in ((a, b, c), (a, c, d))]),
}


def drawn(values, points):
    """Origins and distances of the layer with the largest void distance, as in the shader."""
    index = GRID.index_of(points)
    sampled = np.stack([sample(component, index, "linear", 0.0, GRID) for component in values])
    best = sampled[..., 3].argmax(axis=0)
    nearest = sampled[best, np.arange(len(points))]
    return points + nearest[:, :3], nearest[:, 3]


@pytest.mark.parametrize("cut", CUTS)
@pytest.mark.parametrize("apart", [0.15, 0.01])
def test_faces_are_sharp_however_far_apart(cut, apart, rng):
    rest = rng.uniform((0, 0, 0), (4, 2, 1), (30, 3))
    wave = np.sin(rest @ rng.normal(0, 1.2, (3, 3)))
    deformed = rest + 0.1 * wave + apart * np.sign(rest[:, :1] - 2) * [1, 0, 0]
    d = Deformation(rest, deformed, cuts=CUTS[cut], device=FAST)
    v = rng.uniform((-0.2, -0.2, -0.2), (4.2, 2.2, 1.2), (50_000, 3))
    origins, distances = drawn(layers(d, GRID), v)
    exact, exact_distances = d.backward(v), d.void_distance(v)
    both = (distances > 0) & (exact_distances > 0) & ~d.overlap(v)
    error = np.linalg.norm(origins - exact, axis=1)[both] / CELL
    assert np.percentile(error, 99) <= 0.1
    assert np.percentile(error, 99.9) <= 0.2
    differ = (distances > 0) != (exact_distances > 0)
    assert differ.mean() <= 1e-3 * len(d.cuts)
    assert np.abs(exact_distances[differ]).max(initial=0) <= 0.4 * CELL


@pytest.mark.parametrize(
    ("cut", "count"),
    [("plane", 2), ("parallel planes", 2), ("plane and half-plane", 4), ("three planes", 8)],
)
def test_only_cuts_that_cross_have_separate_layers(cut, count, rng):
    rest = rng.uniform((0, 0, 0), (4, 2, 1), (30, 3))
    d = Deformation(rest, rest + 0.1 * np.sign(rest - MIDDLE), cuts=CUTS[cut], device=FAST)
    assert len(layers(d, GRID)) == count


def test_without_cuts_there_is_one_layer(rng):
    rest = rng.uniform((0, 0, 0), (4, 2, 1), (8, 3))
    values = layers(Deformation(rest, rest + 0.1, device=FAST), GRID)
    assert values.shape == (1, *GRID.shape, 4)
    np.testing.assert_allclose(values[..., :3], -0.1, atol=1e-5)
    assert (values[..., 3] > 1e20).all()
