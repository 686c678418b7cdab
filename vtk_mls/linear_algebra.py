"""What float64 code needs of vectors and matrices beside numpy."""

from __future__ import annotations

import numpy as np


def unit(vectors):
    """`vectors` (..., 3) of length 1; 0 for 0."""
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return np.divide(vectors, length, out=np.zeros_like(vectors), where=length > 0)


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
