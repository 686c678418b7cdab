"""Automatic steps on random scenes: whether the map and its field fold, by other means.

Run `python tests/fuzz/folds.py SECONDS [SEED]`. Each scene has 6 to 60 handles in the unit box,
some squeezed or turned as a cluster, or on lines. It prints each scene whose first number of steps
was too small, in which the check missed a fold, or whose certificate is wrong; then the counts.
"""

from __future__ import annotations

import sys
import time
import warnings
from collections import Counter
from dataclasses import dataclass, replace

import numpy as np

from vtk_mls import Deformation, Grid
from vtk_mls.queries import certificate

KINDS = "rigid", "affine", "similarity", "spline"
MOVES = "apart", "some", "squeezed", "turned", "line"


@dataclass
class Scene:
    """Handles and options."""

    rest: np.ndarray
    deformed: np.ndarray
    options: dict
    move: str


def scene(rng, kind=None, move=None):
    n = int(rng.integers(6, 61))
    p = rng.random((n, 3))
    move = move or str(rng.choice(MOVES))
    amount = rng.uniform(0.05, 0.5)
    q = p.copy()
    center = p[rng.integers(n)]
    near = np.argsort(np.linalg.norm(p - center, axis=1))[: max(3, n // 3)]
    if move == "apart":
        q += amount / 3 * rng.normal(size=p.shape)
    elif move == "some":
        rows = rng.integers(0, n, max(1, n // 4))
        q[rows] += amount / 2 * rng.normal(size=(len(rows), 3))
    elif move == "squeezed":
        q[near] = center + (p[near] - center) * rng.uniform(0.1, 0.6)
    elif move == "turned":
        q[near] = center + (p[near] - center) @ rotation(rng, rng.uniform(0.3, 2.5)).T
    else:
        t = np.linspace(-0.4, 0.4, len(near))[:, None]
        p[near] = 0.5 + t * unit(rng) + 1e-3 * rng.normal(size=(len(near), 3))
        q = p.copy()
        q[near] = 0.5 + t * unit(rng) * rng.uniform(0.5, 1.2) + 0.3 * amount * rng.normal(size=3)
    kind = kind or str(rng.choice(KINDS))
    options = {"kind": kind, "alpha": float(rng.choice([1, 1.5, 2, 3]))}
    if kind == "spline":
        options["order"] = int(rng.integers(1, 4))
    return Scene(p, q, options, move)


def unit(rng):
    vector = rng.normal(size=3)
    return vector / np.linalg.norm(vector)


def rotation(rng, angle):
    """A rotation by an angle about a random axis."""
    x, y, z = unit(rng)
    cross = np.array([(0, -z, y), (z, 0, -x), (-y, x, 0)])
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross


def negative_tetrahedra(field):
    """Voxels (nz - 1, ny - 1, nx - 1) bool with a tetrahedron of no positive volume, in float64."""
    v = field.grid.points().reshape(*field.displacement.shape) + field.displacement
    result = np.zeros(field.grid.cells.shape, bool)
    mirror = np.linalg.det(field.grid.index_to_world)
    first, last = slice(None, -1), slice(1, None)
    for order in ((0, 1, 2), (1, 2, 0), (2, 0, 1), (0, 2, 1), (2, 1, 0), (1, 0, 2)):
        sides, path = [first] * 3, []
        for axis in order:  # of the array: z, y, x
            before = v[tuple(sides)]
            sides[axis] = last
            path.append(v[tuple(sides)] - before)
        sign = 1 if order in ((2, 1, 0), (1, 0, 2), (0, 2, 1)) else -1
        result |= ~(sign * mirror * np.linalg.det(np.stack(path, axis=-1)) > 0)
    return result


def difference_determinants(backward, points, h):
    """Determinants (m,) of a map, by central differences."""
    columns = [(backward(points + h * e) - backward(points - h * e)) / (2 * h) for e in np.eye(3)]
    return np.linalg.det(np.stack(columns, axis=-1))


def examine(found, n=48, device=None):
    """What is found for a Scene on a grid of n^3 points: a dict of counts."""
    d = Deformation(found.rest, found.deformed, steps="auto", device=device, **found.options)
    grid = Grid((n,) * 3, (0, 0, 0), (1 / (n - 1),) * 3)
    first = d.steps_used
    field = d.displacement_field(grid)
    proof = certificate.check(d._engine, d, field)  # a Certificate also tries finer spacings
    negative = np.flatnonzero(negative_tetrahedra(field))
    centers, corners = (np.linalg.det(d.jacobian(g.points())) for g in (grid.cells, grid))
    named = certificate.corner_points(grid, proof.map_indices).reshape(-1)
    missed = (np.delete(centers, proof.map_indices) <= 0).sum() + (corners[~named] <= 0).sum()
    result = {
        "first": first,
        "steps": d.steps_used,
        "map folds": int((centers <= 0).sum() + (corners <= 0).sum()),
        "not found by the check": int(missed),
        "field folds": len(negative),
        "certificate differs": int(not np.array_equal(negative, proof.indices)),
        "smallest": float(min(centers.min(), corners.min())),
        "reported": d.smallest_determinant,
        "residual": float(np.abs(d.residuals()).max()),
    }
    worst = grid.cells.points_of(np.argsort(centers)[:200])
    exact = replace(d, steps=d.steps_used, path=d.path_used, device="reference")
    determinants = difference_determinants(exact.backward, worst, 1e-6)
    return result | {"differences": float(determinants.min())}


def main(seconds, seed=0):
    rng, start, count = np.random.default_rng(seed), time.time(), 0
    totals, steps = Counter(), []
    while time.time() - start < seconds:
        found = scene(rng)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            result = examine(found)
        count += 1
        steps.append(result["steps"])
        problems = {
            "raised": result["steps"] > result["first"],
            "at 256": result["steps"] == 256,
            "map folds": result["map folds"] > 0 or result["differences"] <= 0,
            "missed": result["not found by the check"] > 0,
            "certificate": result["certificate differs"],
            "not met": result["residual"] > 1e-5,
        }
        names = [name for name, is_true in problems.items() if is_true]
        totals.update(names + ["field folds"] * (result["field folds"] > 0))
        if any(problems.values()):
            print(count, found.move, len(found.rest), found.options, result, flush=True)
    print(
        f"{count} scenes: {dict(totals)}; steps: {np.median(steps):.0f}, mean {np.mean(steps):.1f}"
    )


if __name__ == "__main__":
    main(float(sys.argv[1]), *map(int, sys.argv[2:]))
