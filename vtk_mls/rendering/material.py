"""Material of the deformed space: its origins, and where there is none."""

from __future__ import annotations

import numpy as np


def material_at(deformation, points):
    """Origins of points of the deformed space, and which points have material.

    Parameters
    ----------
    deformation : Deformation or None
        None for the identity.
    points : (m, 3) float64, world coordinates

    Returns
    -------
    origins : (m, 3) float64, world coordinates
    has_material : (m,) bool
        False in voids between the faces of cuts.
    """
    if deformation is None:
        return points, np.ones(len(points), bool)
    has_material = ~deformation.void(points) if deformation.cuts else np.ones(len(points), bool)
    return deformation.backward(points), has_material
