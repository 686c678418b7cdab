"""What float64 code needs of vectors and matrices beside numpy.

Products with many vectors are not left to BLAS: after one its threads wait for the next, busily,
for tens of milliseconds, and take the processor from the kernels.
"""

from __future__ import annotations

import numpy as np

_NEXT, _LAST = [1, 2, 0], [2, 0, 1]  # of the coordinates, for each of them


def dots(vectors, vector):
    """`vectors` (..., n) times `vector` (n,) each: (...)."""
    return np.einsum("...i,i->...", vectors, vector)


def transformed(matrix, vectors):
    """`matrix` (m, n) times each of `vectors` (..., n): (..., m)."""
    return np.einsum("ij,...j->...i", matrix, vectors)


def unit(vectors):
    """`vectors` (..., 3) of length 1; 0 for 0."""
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return np.divide(vectors, length, out=np.zeros_like(vectors), where=length > 0)


def cross(a, b):
    """a x b (..., 3), as numpy's but quick for a few vectors."""
    return a[..., _NEXT] * b[..., _LAST] - a[..., _LAST] * b[..., _NEXT]


def finite(matrices):
    """`matrices`, as numpy's decompositions take them: they fail for all if one is not finite."""
    return np.where(np.isfinite(matrices), matrices, 0)


def fitted_affine(before, after):
    """The affine map x -> A x + b that takes points (n, 3) to others best; A (3, 3), b (3,).

    Of what the points do not determine it is the map nearest to the identity.
    """
    centre, change = before.mean(axis=0), after - before
    mean = change.mean(axis=0)
    tilt = np.linalg.lstsq(before - centre, change - mean, rcond=1e-6)[0].T
    return np.eye(3) + tilt, mean - tilt @ centre
