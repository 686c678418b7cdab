"""The void of cells, which is asked of the map near faces only."""

import itertools

import numpy as np
import pytest
from vtk_fixtures import (
    FAST,
    connect,
    control_points,
    device,  # noqa: F401
    make_image,
)

from vtk_mls import Deformation, Grid, HalfPlane, arrays
from vtk_mls.arrays import ImageGeometry
from vtk_mls.filters import MLSDeform, void_arrays
from vtk_mls.progress import SILENT


@pytest.mark.parametrize("shape", [(30, 26, 40), (50, 1, 30), (2, 2, 2)])
@pytest.mark.parametrize("opening", [0.05, 0.5, 4.0])
def test_the_void_of_cells_is_what_the_map_says_in_each(device, shape, opening, rng):
    """Though it is asked near faces only: voids thinner than a cell, too."""
    grid, asked = Grid(shape), []
    size = np.maximum(np.array(shape) - 1.0, 0.5)
    cells = arrays.cell_grid(grid)
    for _ in range(4):
        rest = rng.uniform(-0.2, 1.2, (8, 3)) * size
        normal = rng.normal(size=3) * (size >= 1)
        edge = np.cross(normal, rng.normal(size=3))
        half_plane = HalfPlane(rng.uniform(0.3, 0.7, 3) * size, normal, edge)
        side = np.sign((rest - half_plane.point) @ half_plane.normal)
        moved = rest + opening * (side[:, None] * half_plane.normal + 0.1 * rng.normal(size=(8, 3)))
        d = Deformation(rest, moved, cuts=[half_plane], device=device)
        expected = d.void_field(cells)
        found = void_arrays.void_in_cells(d, grid, d.void_distance_field(grid), SILENT)
        np.testing.assert_array_equal(found, expected)
        asked.append(expected.sum())
    assert max(asked) > 0 or opening < 0.5 or cells.size < 10


def test_cells_far_from_faces_are_not_asked_for():
    """Of a void one cell wide, across x = 31.7."""
    distance = np.abs(np.arange(64.0) - 31.7) - 0.5
    void_distance = np.broadcast_to(distance.astype(np.float32), (64, 64, 64))
    slabs = [slice(first, first + 8) for first in range(0, 63, 8)]
    found = [void_arrays._void_by_corners(void_distance, slab, 1.8) for slab in slabs]
    void, unknown = (np.concatenate(parts) for parts in zip(*found))
    assert void.shape == (63, 63, 63)
    assert unknown.mean() < 0.2
    centres = np.abs(np.arange(63) + 0.5 - 31.7)
    assert unknown[..., centres < 4].all()
    assert not unknown[..., centres > 6].any()
    assert not void[~unknown].any()


def test_infinite_void_distances_tell_nothing_of_cells():
    near, far = np.full((3, 3, 3), np.inf, np.float32), np.full((3, 3, 3), 9.0, np.float32)
    for void_distance, is_unknown in ((near, True), (far, False)):
        void, unknown = void_arrays._void_by_corners(void_distance, slice(0, 8), 1.8)
        assert not void.any()
        assert (unknown == is_unknown).all()


def layers(heights, moves):
    """Control points above, between and below cuts across z at some heights; layer i moves."""
    x, y = (each.ravel() for each in np.meshgrid(np.linspace(-1, 20, 6), np.linspace(-1, 20, 6)))
    ends = [heights[0] - 4, *heights, heights[-1] + 4]
    middles = [(low + high) / 2 for low, high in itertools.pairwise(ends)]
    rest = np.concatenate([np.stack([x, y, 0 * x + z], axis=1) for z in middles])
    return rest, rest + np.repeat(moves, x.size)[:, None] * [0, 0, 1]


def across(height, tilt=0.0):
    """A half-plane across z."""
    return HalfPlane((9.5, -9, height), (tilt, 0, 1), (0, 1, 0))


TWO_SLICES = layers([0.5], [-0.2, 0.2])
FIVE = [4.3, 5.9, 7.5, 9.1, 10.7]
ALIKE = {  # corners are as far from a void as those on its other side, or of the next one
    "two slices": (Grid((20, 20, 2)), TWO_SLICES, [across(0.5)]),
    "two slices, tilted": (Grid((20, 20, 2)), TWO_SLICES, [across(0.5, 0.012)]),
    "one row of two": (Grid((20, 1, 2), (0, 9.5, 0)), TWO_SLICES, [across(0.5)]),
    "five cuts": (
        Grid((14, 14, 16)),
        layers(FIVE, 0.4 * (np.arange(6) - 2.5)),
        [across(height) for height in FIVE],
    ),
}


@pytest.mark.parametrize("scene", ALIKE)
def test_corners_that_lie_alike_tell_nothing(device, scene):
    grid, (rest, deformed), cuts = ALIKE[scene]
    d = Deformation(rest, deformed, cuts=cuts, device=device)
    expected = d.void_field(arrays.cell_grid(grid))
    found = void_arrays.void_in_cells(d, grid, d.void_distance_field(grid), SILENT)
    assert expected.any()
    np.testing.assert_array_equal(found, expected)


@pytest.mark.parametrize("last", [10, 11, 19])
def test_a_thin_part_has_the_void_of_the_whole(last):
    rest, deformed = layers([9.5], [-0.2, 0.2])
    image = make_image((20, 20, 20), origin=(0, 0, 0))
    image.SetSpacing(1, 1, 1)
    arrays.add(image.GetPointData(), "values", np.zeros(8000, np.float32))
    image.GetPointData().SetActiveScalars("values")
    deform = connect(MLSDeform(), image, control_points(rest, deformed))
    deform.SetDevice(FAST)
    deform.AddCut(across(9.5))
    deform.UpdateInformation()
    deform.UpdateExtent((0, 19, 0, 19, 9, last))
    output = deform.GetOutputDataObject(0)
    cells = arrays.cell_grid(ImageGeometry.of_image(output).grid)
    expected = Deformation(rest, deformed, cuts=[across(9.5)], device=FAST).void(cells.points())
    assert expected.sum() == 361
    found = arrays.to_numpy(output.GetCellData().GetArray("Void"))
    np.testing.assert_array_equal(found, expected)


@pytest.mark.parametrize(("slices", "share"), [(2, 1.0), (40, 0.3)])
def test_all_cells_of_a_single_layer_are_asked_for(monkeypatch, slices, share):
    """For there are none beside it that would tell."""
    grid, asked = Grid((20, 20, slices)), []
    rest, deformed = layers([9.5], [-0.2, 0.2])
    d = Deformation(rest, deformed, cuts=[across(9.5)], device=FAST)
    answer = Deformation.void
    monkeypatch.setattr(
        Deformation, "void", lambda d, v, p: asked.append(len(v)) or answer(d, v, p)
    )
    void_arrays.void_in_cells(d, grid, d.void_distance_field(grid), SILENT)
    assert 0 < sum(asked) <= share * arrays.cell_grid(grid).size
    assert slices > 2 or sum(asked) == 19 * 19
