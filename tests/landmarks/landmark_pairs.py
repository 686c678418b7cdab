"""Synthetic pairs of landmarks."""

import numpy as np

OFF, NOISE = 15.0, 0.5


def smooth_warp(rng):
    """A map (m, 3) -> (m, 3): an affine map and six waves, 200 to 400 long and 8 high in all."""
    directions = rng.normal(size=(6, 3))
    length = rng.uniform(200, 400, 6) * np.linalg.norm(directions, axis=1)
    directions *= 2 * np.pi / length[:, None]
    height = rng.normal(size=(6, 3)) * 8 / np.sqrt(6)
    phase = rng.uniform(0, 2 * np.pi, 6)
    matrix = np.eye(3) + rng.normal(0, 0.05, (3, 3))
    return lambda x: x @ matrix.T + np.sin(x @ directions.T + phase) @ height


def planted_pairs(rng, count=60):
    """p and q of noisy pairs in a box of 160, two rows that are off, and two that are swapped."""
    q = rng.uniform(-80, 80, (count, 3))
    p = smooth_warp(rng)(q) + rng.normal(0, NOISE, q.shape)
    bad = rng.choice(count, 4, replace=False)
    offset = rng.normal(size=(2, 3))
    q[bad[:2]] += OFF * offset / np.linalg.norm(offset, axis=1)[:, None]
    q[bad[2:]] = q[bad[:1:-1]]
    return p, q, bad[:2], bad[2:]
