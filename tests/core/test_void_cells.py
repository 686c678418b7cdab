"""The void of cells, for which the map is evaluated near faces only."""

import itertools
from types import SimpleNamespace

import numpy as np
import pytest
from control_point_sets import EVERYWHERE
from pairwise import paired

from vtk_mls import Deformation, Grid, HalfPlane, Plane, Surface
from vtk_mls.base.progress import SILENT
from vtk_mls.engine.dispatch import engine_for
from vtk_mls.queries import void_cells


def half_plane(point, normal, rng):
    edge = np.cross(normal, rng.normal(size=3))
    return [HalfPlane(point, normal, edge)]


def plane(point, normal, rng):
    return [Plane(point, normal)]


def surface(point, normal, rng):
    """A square that ends in the box."""
    a = np.cross(normal, rng.normal(size=3))
    b = np.cross(normal, a)
    size = 10 / np.linalg.norm(a), 10 / np.linalg.norm(b)
    corners = [(1, 1), (1, -1), (-1, -1), (-1, 1)]
    return [Surface.polygon([point + s * size[0] * a + t * size[1] * b for s, t in corners])]


def two(point, normal, rng):
    return plane(point, normal, rng) + half_plane(point + 3, rng.normal(size=3), rng)


CUTS = {"half-plane": half_plane, "plane": plane, "surface": surface, "two": two}


@pytest.mark.parametrize("cut", CUTS)
@paired(
    shape=[(20, 17, 26), (50, 1, 30), (2, 2, 2)],
    opening=[0.05, 0.5, 4.0],
    cut_frame=["rest", "deformed"],
)
def test_it_is_that_of_the_map_at_cell_centers(device, cut, shape, opening, cut_frame, rng):
    """Also for voids thinner than a cell, though the map is evaluated near faces only."""
    grid, void_count = Grid(shape), 0
    size = np.maximum(np.array(shape) - 1.0, 0.5)
    if cut in ("surface", "two") and shape[1] == 1:
        shape = (50, 2, 30)
    for _ in range(3):
        rest = rng.uniform(-0.2, 1.2, (8, 3)) * size
        normal = rng.normal(size=3) * (size >= 1)
        normal /= np.linalg.norm(normal)
        point = rng.uniform(0.3, 0.7, 3) * size
        side = np.sign((rest - point) @ normal)
        moved = rest + opening * (side[:, None] * normal + 0.1 * rng.normal(size=(8, 3)))
        cuts = CUTS[cut](point, normal, rng)
        d = Deformation(rest, moved, cuts=cuts, cut_frame=cut_frame, device=device)
        found = d.void_of_cells(grid)
        expected = d.void_field(grid.cells)
        void_count += expected.sum()
        differ = np.flatnonzero(found.at_center != expected)
        if len(differ):  # those on the face itself, to rounding
            centers = grid.cells.at(
                np.stack(np.unravel_index(differ, expected.shape)[::-1], axis=1)
            )
            assert np.abs(d.void_distance(centers)).max() < 1e-5 * size.max()
        corners = d.void_field(grid)
        touched = np.zeros_like(expected)
        for ends in itertools.product(*[(0, 1) if n > 1 else (0,) for n in grid.shape]):
            touched |= corners[tuple(slice(a, a + n) for a, n in zip(ends, touched.shape))]
        np.testing.assert_array_equal(found.touched, touched)
    assert void_count > 0 or opening < 0.5 or grid.cells.size < 10


def test_cells_far_from_faces_are_not_evaluated():
    """Of a void one cell wide, across x = 31.7."""
    distance = np.abs(np.arange(64.0) - 31.7) - 0.5
    void_distance = np.broadcast_to(distance.astype(np.float32), (64, 64, 64))
    flags = void_cells.by_corners(void_distance, 1.8)
    void, unknown = flags & void_cells.VOID > 0, flags & void_cells.UNKNOWN > 0
    assert void.shape == (63, 63, 63)
    assert unknown.mean() < 0.2
    centers = np.abs(np.arange(63) + 0.5 - 31.7)
    assert unknown[..., centers < 4].all()
    assert not unknown[..., centers > 6].any()
    assert not void[~unknown].any()


def test_infinite_void_distances_leave_cells_undecided():
    near, far = np.full((3, 3, 3), np.inf, np.float32), np.full((3, 3, 3), 9.0, np.float32)
    assert (void_cells.by_corners(near, 1.8) == void_cells.UNKNOWN).all()
    assert (void_cells.by_corners(far, 1.8) == 0).all()
    assert (void_cells.by_corners(-far, 1.8) == void_cells.VOID | void_cells.TOUCHED).all()


def layers(heights, moves):
    """Control points above, between and below cuts across z at some heights; layer i moves."""
    x, y = (axis.ravel() for axis in np.meshgrid(np.linspace(-1, 20, 6), np.linspace(-1, 20, 6)))
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
    "two slices, a plane": (Grid((20, 20, 2)), TWO_SLICES, [Plane((9, 9, 0.5), (0, 0, 1))]),
    "two slices, tilted": (Grid((20, 20, 2)), TWO_SLICES, [across(0.5, 0.012)]),
    "one row of two": (Grid((20, 1, 2), (0, 9.5, 0)), TWO_SLICES, [across(0.5)]),
    "five cuts": (
        Grid((7, 7, 16)),
        layers(FIVE, 0.4 * (np.arange(6) - 2.5)),
        [across(height) for height in FIVE],
    ),
    "five planes": (
        Grid((7, 7, 16)),
        layers(FIVE, 0.4 * (np.arange(6) - 2.5)),
        [Plane((9, 9, height), (0, 0, 1)) for height in FIVE],
    ),
}


@pytest.mark.parametrize("scene", ALIKE)
def test_corners_at_equal_places_do_not_orient(device, scene):
    grid, (rest, deformed), cuts = ALIKE[scene]
    d = Deformation(rest, deformed, cuts=cuts, device=device)
    expected = d.void_field(grid.cells)
    assert expected.any()
    np.testing.assert_array_equal(d.void_of_cells(grid).at_center, expected)


@pytest.mark.parametrize(("slices", "share"), [(2, 1.0), (40, 0.3)])
def test_all_cells_of_a_single_layer_are_evaluated(slices, share):
    """For there are none beside it that would tell."""
    grid, counts = Grid((20, 20, slices)), []
    rest, deformed = layers([9.5], [-0.2, 0.2])
    d = Deformation(rest, deformed, cuts=[across(9.5)], device=EVERYWHERE[-1])
    engine = engine_for(d.device)

    def noting(deformation, cells, indices, progress):
        counts.append(len(indices))
        return engine.void_distance_listed(deformation, cells, indices, progress)

    asking = SimpleNamespace(void_by_corners=engine.void_by_corners, void_distance_listed=noting)
    void_cells.classify_cells(d, asking, grid, d.void_distance_field(grid), SILENT)
    assert 0 < sum(counts) <= share * grid.cells.size
    assert slices > 2 or sum(counts) == 19 * 19


def test_given_void_distances_replace_the_map(device):
    grid, (rest, deformed) = Grid((12, 12, 20)), layers([9.5], [-0.4, 0.4])
    d = Deformation(rest, deformed, cuts=[across(9.5)], device=device)
    expected = d.void_of_cells(grid)
    distance = d.void_distance_field(grid)
    for got, other in zip(d.void_of_cells(grid, distance), expected):
        np.testing.assert_array_equal(got, other)
    assert not d.void_of_cells(grid, np.abs(distance)).touched.any()
    with pytest.raises(ValueError, match=r"`void_distance` must have the shape.*\(20, 12, 12\)"):
        d.void_of_cells(grid, distance[1:])


def test_slabs_are_the_whole(device, monkeypatch):
    grid, (rest, deformed) = Grid((12, 10, 22)), layers([9.5], [-0.4, 0.4])
    d = Deformation(rest, deformed, cuts=[across(9.5, 0.3)], device=device)
    expected = d.void_of_cells(grid).at_center
    assert 0 < expected.sum() < expected.size
    monkeypatch.setattr(void_cells, "MAX_SLAB_CELLS", 3 * 11 * 9)
    np.testing.assert_array_equal(d.void_of_cells(grid).at_center, expected)
    if device != "reference":
        monkeypatch.setattr("vtk_mls.engine.launch.launcher._MAX_WORK", 1)
        monkeypatch.setattr("vtk_mls.engine.map.nodes._NODES", 1)
        monkeypatch.setattr(engine_for(device).memory, "in_place", False)
    np.testing.assert_array_equal(d.void_of_cells(grid).at_center, expected)
    listed = np.arange(grid.size * 3 // 4, grid.size, 7)
    distances = engine_for(device).void_distance_listed(d, grid, listed)
    np.testing.assert_array_equal(distances, d.void_distance_field(grid).ravel()[listed])
    part = grid.part((3, 2, 4), (7, 6, 16))
    found, inner = d.void_of_cells(part).at_center, expected[4:19, 2:7, 3:9]
    np.testing.assert_array_equal(found, inner)
