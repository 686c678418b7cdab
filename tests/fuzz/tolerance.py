"""Random maps with a tolerance, held against the same without."""

from __future__ import annotations

import numpy as np

from vtk_mls import CUT_FRAMES, KINDS, Deformation, Grid, HalfPlane, Plane, Surface
from vtk_mls.model.options import named


def check_tolerance(rng, device):
    """A field with a `map_tolerance` keeps to it, and so do its voids to their signs."""
    grid, is_cut = _grid(rng), rng.random() < 0.5
    counts = [1, 2, 3, 4, 8, 15, 30, 100]
    rest, deformed, weights = _handles(rng, grid, int(rng.choice(counts)))
    options = {
        "kind": str(rng.choice(KINDS if is_cut else named("kind").choices)),
        "order": int(rng.integers(0, 4)),
        "degree": int(rng.integers(1, 4)),
        "alpha": float(rng.choice([0.5, 0.75, 1.0, 1.5, 2.0, 3.0])),
        "weights": weights,
        "cuts": [_cut(rng, grid) for _ in range(rng.choice([1, 1, 2]) if is_cut else 0)],
        "cut_frame": str(rng.choice(CUT_FRAMES)),
        "device": device,
    }
    tolerance = float(rng.choice([0.005, 0.02, 0.1, 1.0]))
    exact, coarse = (
        Deformation(rest, deformed, map_tolerance=t, **options).displacement_field(grid)
        for t in (0.0, tolerance)
    )
    error = (coarse.displacement - exact.displacement) @ np.linalg.inv(grid.index_to_world).T
    error = np.linalg.norm(error, axis=-1)
    case = f"{options} on {grid.dimensions}"
    assert np.nanmax(error) <= tolerance, f"off by {np.nanmax(error) / tolerance}: {case}"
    np.testing.assert_array_equal(np.isnan(error), np.isnan(exact.displacement).any(axis=-1))
    if is_cut:
        changed = (coarse.void_distance < 0) != (exact.void_distance < 0)
        assert not changed.any(), f"{changed.sum()} points changed to void or back: {case}"


def _grid(rng):
    spacing = rng.choice([0.3, 1, 2.5], 3) * rng.choice([1, -1], 3, p=[0.9, 0.1])
    return Grid(rng.integers(40, 90, 3), rng.normal(0, 100, 3), spacing)


def _handles(rng, grid, count):
    """Control points as users have them, and worse: pairs, flat, in line, a heap, on nodes."""
    size = np.array(grid.dimensions)
    index = rng.uniform(-5, size + 5, (count, 3))
    style = rng.integers(0, 6)
    if style == 1:
        neighbors = index[1::2]
        neighbors[:] = index[::2][: len(neighbors)] + rng.normal(0, 0.3, neighbors.shape)
    elif style == 2:
        index[:, 2] = size[2] / 2
    elif style == 3:
        index[:, 1:] = size[1:] / 2
    elif style == 4:
        index = size / 2 + rng.normal(0, 2, index.shape)
    elif style == 5:
        index = np.round(index)
    moves = rng.normal(0, rng.choice([0.2, 2, 10, 40]), index.shape)
    if rng.random() < 0.3:  # nearly all alike
        moves = moves[:1] + rng.normal(0, 0.1, index.shape)
    weights = np.exp(rng.normal(0, 2, count)) if rng.random() < 0.3 else None
    return grid.at(index), grid.at(index + moves), weights


def _cut(rng, grid):
    size = np.abs(grid.index_to_world) @ grid.dimensions
    middle = grid.at([np.array(grid.dimensions) / 2])[0] + rng.normal(0, 0.15, 3) * size
    normal, along, across = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    shape = rng.integers(0, 3)
    if shape == 0:
        return Plane(middle, normal)
    if shape == 1:
        return HalfPlane(middle, normal, along)
    corners = int(rng.integers(3, 8))
    angle = np.linspace(0, 2 * np.pi, corners, endpoint=False)[:, None]
    radius = rng.uniform(0.15, 0.6) * size.mean()
    points = middle + radius * (np.cos(angle) * along + np.sin(angle) * across)
    return Surface(points, [(0, i, i + 1) for i in range(1, corners - 1)])
