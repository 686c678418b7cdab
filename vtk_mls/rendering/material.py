"""Material of the deformed space: its origins, and where there is none."""

import numpy as np


def material_at(deformation, points):
    """Origins of `points` (m, 3), world coordinates, and which of them have material: (m,) bool.

    They have none in voids between the faces of cuts. The Deformation None is the identity.
    """
    if deformation is None:
        return points, np.ones(len(points), bool)
    has_material = ~deformation.void(points) if deformation.cuts else np.ones(len(points), bool)
    return deformation.backward(points), has_material
