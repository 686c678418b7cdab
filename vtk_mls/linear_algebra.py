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
