"""Between nodes the map of a grid stays within the tolerance, and is the same in all parts."""

from dataclasses import replace

import numpy as np
import pytest
from control_point_sets import (
    DEVICES,
    HARD_SETS,
    KINDS_AND_DEGREES,
    block,
    deformation,
    random_handles,
    random_rotation,
)
from pairwise import paired, rare

from vtk_mls import CUT_FRAMES, Deformation, Grid, HalfPlane, Plane, Sampling, Surface

SETS = [name for name in HARD_SETS if name not in ("at 5e5", "at 1e-9", "ten thousand")]
GRID = Grid((49, 46, 50), (-8.0, -5.0, 3.0), (5.5, 5.9, 5.1))
TOLERANCE = 0.02


def distance(grid, displacement, expected):
    """The largest distance between displacements, in spacings of the grid."""
    difference = (displacement - expected) @ np.linalg.inv(grid.index_to_world).T
    return np.linalg.norm(difference, axis=-1).max()


def assert_parts(d, grid, *parts):
    """Parts of a grid, each a first index and dimensions, have the values of the whole."""
    whole = d.displacement_field(grid)
    for first, size in parts:
        found = d.displacement_field(grid.part(first, size))
        place = block(first, size)
        np.testing.assert_array_equal(found.displacement, whole.displacement[place])
        if d.cuts:
            np.testing.assert_array_equal(found.void_distance, whole.void_distance[place])


def assert_images(coarse, exact, sampling):
    """Images of a wave, of at most 0.04 per world unit, agree, and where they have a source."""
    wave = np.sin(sampling.source.points() @ [0.02, 0.03, 0.01]).astype(np.float32)
    wave = wave.reshape(sampling.source.shape)
    sampling = replace(sampling, background=-9)
    (found,), (expected,) = (d.resample([wave], sampling) for d in (coarse, exact))
    inside = (found != -9) & (expected != -9)
    assert inside.mean() > 0.5
    assert ((found == -9) == (expected == -9)).mean() > 0.999
    error = np.abs(found - expected)[inside].max()
    assert error < 0.04 * TOLERANCE * sampling.target.spacing.max()
    return wave


def half_a_voxel_apart(rng):
    rest, deformed = random_handles(rng, 20)
    deformed[1::2] = deformed[::2] + 0.5 * GRID.spacing * random_rotation(rng)[0]
    return rest, deformed


def uneven(rng):
    rest, deformed = random_handles(rng, 30)
    return rest, deformed, np.exp(rng.normal(0, 2, 30))


PEAKS = {"half a voxel apart": half_a_voxel_apart, "uneven": uneven}


@paired(name=SETS, kind_and_degree=[*KINDS_AND_DEGREES[:2], *rare(*KINDS_AND_DEGREES[2:])])
def test_it_keeps_to_the_tolerance_on_hard_sets(key, name, kind_and_degree, rng):
    rest, deformed = HARD_SETS[name](rng)
    exact = deformation(rest, deformed, kind_and_degree, key)
    coarse = deformation(rest, deformed, kind_and_degree, key, map_tolerance=TOLERANCE)
    found = coarse.displacement_field(GRID).displacement
    assert distance(GRID, found, exact.displacement_field(GRID).displacement) <= TOLERANCE


@paired(
    alpha=[2, *rare(0.5, 0.75, 1, 3)],
    handles=["half a voxel apart", "uneven"],
    kind_and_degree=[*KINDS_AND_DEGREES[:2], *KINDS_AND_DEGREES[3:], *rare(KINDS_AND_DEGREES[2])],
    device=DEVICES,
)
def test_peaks_between_nodes_are_not_missed(device, alpha, handles, kind_and_degree, rng):
    rest, deformed, *weights = PEAKS[handles](rng)
    options = {"alpha": alpha, "weights": weights[0] if weights else None}
    exact = deformation(rest, deformed, kind_and_degree, device, **options)
    for tolerance in (0.005, 0.1):
        coarse = replace(exact, map_tolerance=tolerance)
        found = coarse.displacement_field(GRID).displacement
        assert distance(GRID, found, exact.displacement_field(GRID).displacement) <= tolerance


@pytest.mark.parametrize("cuts", [(), Plane((160, 100, 90), (1, 0.2, 0.1))])
def test_parts_are_those_of_the_whole(key, cuts, rng):
    coarse = Deformation(*random_handles(rng, 15), map_tolerance=0.1, cuts=cuts, device=key)
    parts = [((0, 0, 0), (49, 46, 17)), ((0, 0, 17), (49, 46, 33)), ((5, 3, 2), (11, 18, 23))]
    assert_parts(coarse, GRID, *parts, ((48, 45, 49), (1, 1, 1)), ((7, 0, 31), (42, 1, 1)))
    # rows of whole vectors are stored at once, past the caches where they are aligned
    grid = Grid((64, 50, 41), (-8.0, -5.0, 3.0), (4.5, 4.9, 5.1))
    assert_parts(coarse, grid, ((0, 0, 0), (63, 50, 41)), ((1, 2, 3), (60, 47, 38)))


def test_images_follow_it(key, rng):
    rest, deformed = random_handles(rng, 15)
    target = Grid((61, 43, 47), (-20, -8, 0), (4.7, 6.1, 5.6))
    sampling = Sampling(GRID, target)
    coarse = Deformation(rest, deformed, map_tolerance=TOLERANCE, device=key)
    exact = Deformation(rest, deformed, device=key)
    assert_images(coarse, exact, sampling)
    for found, expected in zip(coarse.source_bounds(sampling), exact.source_bounds(sampling)):
        assert np.abs(found - expected).max() <= 2 * TOLERANCE


def jacobians(deformation, grid):
    """What `resample_gradients` takes vectors through, by index of the grid."""
    everywhere = Grid((2, 2, 2), (-3000,) * 3, (6000,) * 3)
    columns = []
    for axis in range(3):
        vectors = np.zeros((2, 2, 2, 3), np.float32)
        vectors[..., axis] = 1
        columns.append(deformation.resample_gradients(vectors, Sampling(everywhere, grid)))
    to_world = grid.index_to_world
    return to_world.T @ np.stack(columns, axis=-1) @ np.linalg.inv(to_world).T


@paired(
    name=SETS,
    kind_and_degree=[("rigid", 1), *rare(*KINDS_AND_DEGREES[1:])],
    device=DEVICES,
)
def test_gradients_keep_to_the_tolerance_from_point_to_point(device, name, kind_and_degree, rng):
    rest, deformed = HARD_SETS[name](rng)
    grid = Grid((35, 31, 33), (-8.0, 265.0, 3.0), (7.7, -8.6, 7.6))
    exact = deformation(rest, deformed, kind_and_degree, device)
    coarse = replace(exact, map_tolerance=TOLERANCE)
    found, expected = (jacobians(d, grid) for d in (coarse, exact))
    # points whose source is outside have 0, as have maps to one place
    vanishes, should_vanish = (np.abs(j).max(axis=(-1, -2)) < 1e-5 for j in (found, expected))
    outside = vanishes != should_vanish
    assert outside.mean() < 0.5
    assert np.abs(found - expected)[~outside].max() <= TOLERANCE


def test_most_points_are_not_evaluated(launched, rng):
    rest, deformed = random_handles(rng, 5)
    coarse = Deformation(rest, deformed, map_tolerance=TOLERANCE)
    grid = Grid((128, 128, 128), spacing=(2, 2, 2))
    coarse.displacement_field(grid)
    evaluating = ("node_displacement", "grid_displacement")
    assert 0 < sum(count for name, count in launched if name in evaluating) < 0.1 * grid.size


def test_slices_are_exact(rng):
    rest, deformed = random_handles(rng, 15)
    exact = Deformation(rest, deformed)
    coarse = replace(exact, map_tolerance=0.1)
    fields = [d.displacement_field(Grid((200, 200, 1))) for d in (coarse, exact)]
    np.testing.assert_array_equal(*(field.displacement for field in fields))


CUT_GRID = Grid((60, 57, 63), (-4.0, -8.0, -2.0), (4.4, 4.6, 4.1))
PENTAGON = [(128, 128, 128), (128, 220, 140), (120, 190, 215), (131, 70, 200), (125, 50, 90)]
CUTS = {
    "half-plane": [HalfPlane((128, 130, 120), (1, 0.1, 0.2), (0, 1, 0.1))],
    "plane": [Plane((128, 120, 131), (1, 0.2, 0.1))],
    "two planes": [Plane((128, 120, 131), (1, 0.2, 0.1)), Plane((100, 128, 90), (0, 1, -0.3))],
    "plane and half-plane": [
        Plane((60, 120, 131), (1, 0.2, 0.1)),
        HalfPlane((158, 130, 120), (1, 0.1, 0.2), (0, 1, 0.1)),
    ],
    "polygon": [Surface(PENTAGON, [(0, 1, 2), (0, 2, 3), (0, 3, 4)])],
}


def with_cuts(cuts, frame, count, rng, **options):
    """A deformation with these cuts, exact and within the tolerance."""
    options |= {"cuts": CUTS[cuts], "cut_frame": frame, "device": DEVICES[0]}
    exact = Deformation(*random_handles(rng, count), **options)
    return exact, replace(exact, map_tolerance=TOLERANCE)


@pytest.mark.parametrize("steps", [1, pytest.param(4, marks=pytest.mark.matrix)])
@pytest.mark.parametrize("frame", CUT_FRAMES)
@pytest.mark.parametrize("cuts", CUTS)
def test_cuts_and_voids_stay_exact(cuts, frame, steps, rng):
    exact, coarse = with_cuts(cuts, frame, 12, rng, steps=steps)
    expected, found = exact.displacement_field(CUT_GRID), coarse.displacement_field(CUT_GRID)
    assert distance(CUT_GRID, found.displacement, expected.displacement) <= TOLERANCE
    assert not np.array_equal(found.displacement, expected.displacement)
    np.testing.assert_array_equal(found.void, expected.void)
    assert found.void.mean() < 0.5
    assert found.void.any() or cuts == "polygon"  # which these control points do not open
    error = np.abs(found.void_distance - expected.void_distance)
    assert (error <= 0.5 * np.abs(expected.void_distance)).all()
    assert_parts(coarse, CUT_GRID, ((0, 0, 0), (60, 57, 22)), ((31, 9, 22), (29, 41, 37)))


@paired(
    cuts=["half-plane", "plane and half-plane", *rare("plane", "two planes", "polygon")],
    frame=["rest", *rare("deformed")],
)
def test_images_that_are_cut_follow_it(cuts, frame, rng):
    exact, coarse = with_cuts(cuts, frame, 12, rng)
    wave = assert_images(coarse, exact, Sampling(CUT_GRID))
    sampling = Sampling(CUT_GRID, background=-9)
    found, expected = (d.corrected_gradient(wave, sampling) for d in (coarse, exact))
    there = found.any(axis=-1) & expected.any(axis=-1)
    assert there.mean() > 0.3
    error = np.linalg.norm(found - expected, axis=-1)[there]
    assert np.quantile(error, 0.999) < TOLERANCE * np.linalg.norm(expected, axis=-1).max()


def test_many_steps_keep_to_the_tolerance(rng):
    exact = Deformation(*random_handles(rng, 8), steps=8, device=DEVICES[0])
    coarse = replace(exact, map_tolerance=TOLERANCE)
    expected, whole = exact.displacement_field(GRID), coarse.displacement_field(GRID)
    assert distance(GRID, whole.displacement, expected.displacement) <= TOLERANCE
    assert_parts(coarse, GRID, ((0, 0, 0), (49, 46, 17)), ((5, 3, 2), (11, 18, 23)))
