"""The interface of masks and faces: where a deformation acts."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from vtk_mls.model.shape_fields import Described

if TYPE_CHECKING:
    from vtk_mls.model.handles.control_points import ControlPoints


class Limit(Described):
    """A factor from 0 to 1 for the displacement at each point of the deformed space."""

    slides = False  # whether the factor is only of the part along `normal`

    def factor(self, v: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """The factors (m,) at points `v` (m, 3), and their slopes (m, 3)."""
        raise NotImplementedError

    def normal(self, v: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Normals (m, 3) of a sliding face at `v` (m, 3), and their slopes (m, 3, 3)."""
        raise NotImplementedError

    def record(self, control_points: ControlPoints) -> dict[str, Any]:
        """Members of limit_t in opencl/base/structs.h, in the local frame.

        "form" is the name of a constant there; "image" the values of an image, on "grid".
        """
        raise NotImplementedError


def fade(t: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """A step from 0 at t = 0 to 1 at t = 1 with two continuous derivatives, and its slope."""
    t = np.clip(t, 0, 1)
    return t**3 * (t * (6 * t - 15) + 10), 30 * t**2 * (1 - t) ** 2
