"""Clusters of control points: what stands in for them, and the maps of very many on a grid."""

import numpy as np
import pytest
from conftest import DEVICES

from vtk_mls import Deformation, Grid, Plane, Sampling
from vtk_mls.clusters import Clusters
from vtk_mls.engine import clustered_map

COUNT = 4000
GRID = Grid((31, 27, 29), (-3.0, 4.0, 2.0), (2.0, 2.2, 1.9))
TOLERANCE = 0.02


def in_a_box(rng):
    return rng.uniform(-5, 65, (COUNT, 3))


def on_a_sphere(rng):
    out = rng.normal(size=(COUNT, 3))
    return 30 + 22 * out / np.linalg.norm(out, axis=1)[:, None]


def in_heaps(rng):
    heap = rng.integers(0, 20, COUNT)
    size = np.exp(rng.uniform(-3, 2, 20))[heap, None]
    return rng.uniform(0, 60, (20, 3))[heap] + size * rng.normal(size=(COUNT, 3))


def in_pairs(rng):
    q = in_a_box(rng)
    q[1::2] = q[::2] + rng.normal(0, 0.3, (COUNT // 2, 3))
    return q


def flat(rng):
    return in_a_box(rng) * (1, 1, 0) + (0, 0, 30)


def far_away(rng):
    return rng.uniform(100, 120, (COUNT, 3))


SETS = [in_a_box, on_a_sphere, in_heaps, in_pairs, flat, far_away]


def moved(q, rng):
    return q + 4 * np.sin(0.07 * q[:, [1, 2, 0]]) + rng.normal(0, 0.5, q.shape)


def worst(found, expected, grid=GRID):
    error = (found - expected) @ np.linalg.inv(grid.index_to_world).T
    return np.linalg.norm(error, axis=-1).max()


@pytest.fixture
def noted(monkeypatch):
    """How many rows count at each block that was asked for."""
    lengths = []
    lists = clustered_map.ClusteredMap._lists

    def listed(self, *arguments):
        spans, rows = lists(self, *arguments)
        lengths.extend(spans[:, 1].tolist())
        return spans, rows

    monkeypatch.setattr(clustered_map.ClusteredMap, "_lists", listed)
    return lengths


@pytest.mark.parametrize("places", SETS)
def test_lists_have_the_moments_of_all_control_points(places, rng):
    q = places(rng)
    p, w = moved(q, rng), np.exp(rng.normal(size=COUNT))
    clusters = Clusters(q, p, w)
    low = rng.uniform(0, 50, (7, 3))
    rows, ends = clusters.near(low, low + 8, np.full(7, 0.5))
    for first, end in zip([0, *ends], ends):
        of_box = rows[first:end]
        Q, P, W = clusters.q[of_box], clusters.p[of_box], clusters.weights[of_box]
        assert W.min() > 0
        for a, b in ((W.sum(), w.sum()), (W @ Q, w @ q), (W @ P, w @ p)):
            np.testing.assert_allclose(a, b, rtol=1e-9)
        for many, few in ((q, Q), (p, P)):
            np.testing.assert_allclose((few.T * W) @ Q, (many.T * w) @ q, rtol=1e-7)


def test_what_is_near_counts_itself(rng):
    q = in_a_box(rng)
    clusters = Clusters(q, moved(q, rng), np.ones(COUNT))
    rows, _ = clusters.near(np.full((1, 3), 20.0), np.full((1, 3), 28.0), np.full(1, 0.5))
    inside = np.flatnonzero(np.all((q >= 16) & (q <= 32), axis=1))
    assert np.isin(inside, rows).all()
    assert len(rows) < COUNT / 2
    assert len(np.unique(rows)) == len(rows)


@pytest.mark.parametrize("device", DEVICES)
@pytest.mark.parametrize("places", SETS)
def test_fields_keep_to_the_tolerance(device, places, kind_and_degree, rng, noted):
    q = places(rng)
    kind, degree = kind_and_degree
    options = {"kind": kind, "degree": degree, "device": device}
    if places is in_pairs:
        options["weights"] = np.exp(rng.normal(size=COUNT))
    alpha = {in_heaps: 0.75, on_a_sphere: 1.5}.get(places, 1.0)
    exact, clustered = (
        Deformation(moved(q, np.random.default_rng(1)), q, alpha=alpha, map_tolerance=t, **options)
        for t in (0.0, TOLERANCE)
    )
    found = clustered.displacement_field(GRID).displacement
    # elsewhere few cells have control points: nodes spare more
    assert bool(noted) == (places not in (flat, far_away))
    assert worst(found, exact.displacement_field(GRID).displacement) <= TOLERANCE


@pytest.mark.parametrize("device", DEVICES)
def test_folds_and_jumps_are_exact(device):
    rng = np.random.default_rng(1)
    q = in_a_box(rng)
    p = q + rng.normal(0, 100, q.shape)  # many times as far as it is to the next
    found, expected = (
        Deformation(p, q, "similarity", alpha=1.5, map_tolerance=t, device=device)
        .displacement_field(GRID)
        .displacement
        for t in (1.0, 0)
    )
    assert worst(found, expected) <= 1.0


@pytest.mark.parametrize("device", DEVICES)
def test_the_reference_is_as_near(device, rng, noted):
    q = in_a_box(rng)
    p, grid = moved(q, rng), Grid((11, 10, 9), (9.0, 8.0, 7.0), (2.0, 2.2, 1.9))
    clustered = Deformation(p, q, map_tolerance=TOLERANCE, device=device)
    expected = Deformation(p, q, device="reference").displacement_field(grid).displacement
    assert worst(clustered.displacement_field(grid).displacement, expected, grid) <= TOLERANCE
    assert noted


@pytest.mark.parametrize("device", DEVICES)
def test_parts_are_those_of_the_whole(device, rng):
    q = on_a_sphere(rng)
    clustered = Deformation(moved(q, rng), q, map_tolerance=TOLERANCE, device=device)
    whole = clustered.displacement_field(GRID).displacement
    parts = [((0, 0, 0), (31, 27, 11)), ((0, 0, 11), (31, 27, 18)), ((5, 3, 2), (11, 18, 23))]
    for first, size in [*parts, ((30, 26, 28), (1, 1, 1))]:
        found = clustered.displacement_field(GRID.part(first, size)).displacement
        i, j, k = (slice(a, a + n) for a, n in zip(first, size))
        np.testing.assert_array_equal(found, whole[k, j, i])


@pytest.mark.parametrize("device", DEVICES)
def test_lists_are_the_same_however_many_are_in_memory(device, rng, monkeypatch):
    q = in_heaps(rng)
    clustered = Deformation(moved(q, rng), q, map_tolerance=TOLERANCE, device=device)
    together = clustered.displacement_field(GRID).displacement
    monkeypatch.setattr(clustered_map, "_TOGETHER", 1)
    by_layers = clustered.displacement_field(GRID).displacement
    np.testing.assert_array_equal(by_layers, together)


@pytest.mark.parametrize("device", DEVICES)
@pytest.mark.parametrize("places", [in_a_box, on_a_sphere, in_heaps, in_pairs])
def test_errors_elsewhere_are_not_much_larger_than_where_blocks_are_looked_at(
    device, places, rng, monkeypatch
):
    safety = clustered_map._SAFETY
    monkeypatch.setattr(clustered_map, "_SAFETY", 1)
    monkeypatch.setattr(clustered_map, "_RELATIVE_SIZE", 0.9)  # lists are as short as they can be
    q = places(rng)
    p, weights = moved(q, rng), np.exp(rng.normal(size=COUNT))
    found, expected = (
        Deformation(p, q, map_tolerance=t, weights=weights, device=device).displacement_field(GRID)
        for t in (TOLERANCE, 0)
    )
    assert worst(found.displacement, expected.displacement) <= safety * TOLERANCE


@pytest.mark.parametrize("device", DEVICES)
def test_images_follow_it(device, rng, noted):
    q = on_a_sphere(rng)
    smooth = np.sin(GRID.points() @ [0.02, 0.03, 0.01]).astype(np.float32).reshape(GRID.shape)
    (found,), (expected,) = (
        Deformation(moved(q, np.random.default_rng(1)), q, map_tolerance=t, device=device).resample(
            [smooth], Sampling(GRID, background=-9)
        )
        for t in (TOLERANCE, 0)
    )
    inside = (found != -9) & (expected != -9)
    assert noted
    assert inside.mean() > 0.5
    assert np.abs(found - expected)[inside].max() < 0.04 * TOLERANCE * GRID.spacing.max()


@pytest.mark.parametrize("places", [in_a_box, on_a_sphere])
def test_gradients_keep_to_the_tolerance_from_point_to_point(places, rng, noted):
    q = places(rng)
    p, along_x = moved(q, rng), np.zeros((*GRID.shape, 3), np.float32)
    along_x[..., 0] = 1
    found, expected = (
        Deformation(p, q, map_tolerance=t).resample_gradients(along_x, Sampling(GRID))
        for t in (TOLERANCE, 0)
    )
    assert noted
    assert expected.any(axis=-1).mean() > 0.5
    there = found.any(axis=-1) & expected.any(axis=-1)
    assert 0 < np.abs(found - expected)[there].max() <= TOLERANCE


def test_few_count_where_control_points_are_on_a_surface(rng, noted):
    q = on_a_sphere(rng)
    Deformation(moved(q, rng), q, map_tolerance=0.1).displacement_field(GRID)
    assert np.mean(noted) < 0.35 * COUNT


@pytest.mark.parametrize(
    "options", [{"alpha": 2.0}, {"cuts": [Plane((30, 30, 30), (1, 0, 0))]}, {"map_tolerance": 0}]
)
def test_otherwise_all_control_points_count(options, rng, noted):
    q = in_a_box(rng)
    options = {"map_tolerance": TOLERANCE, **options}
    Deformation(moved(q, rng), q, **options).displacement_field(GRID)
    assert not noted
