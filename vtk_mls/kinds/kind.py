"""What a kind of maps must tell: of its fit in float64, and of its kernel file."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Fit:
    """The maps l that are fitted at some points v: what the specification needs of them.

    Attributes
    ----------
    displacement : (m, 3) float64, world units
        l(v) - v.
    linear : (m, 3, 3) or (3, 3) float64
        dl/dv at fixed weights.
    influence : callable
        Without arguments: the derivative of l(v) by the weight of each control point, (m, n, 3).
    """

    displacement: np.ndarray
    linear: np.ndarray
    influence: Callable[[], np.ndarray]


class Kind:
    """A kind of maps.

    A kind is a subclass with a `name`, in any file of this room, and a kernel file that has the
    functions of "Kinds" in opencl/README.md. A control point has its `determined` at hand.

    Attributes
    ----------
    name : str
        As `Deformation` takes it; kinds without one are only bases of others.
    kernel : str
        The file of opencl/fit/ with its fit.
    equation : float
        Its first equation in the paper: the order of the kinds.
    has_degree : bool
        Whether `degree` makes a difference.

    Parameters
    ----------
    degree : int
        Of polynomials.
    """

    name = None
    kernel = None
    equation = math.inf
    has_degree = False

    def __init__(self, degree):
        pass

    def determined(self, rest, deformed, local):
        """What the control points tell of such a map: kept as `ControlPoints.determined`.

        Parameters
        ----------
        rest, deformed : (n, 3) float64, world coordinates
        local : (n, 3) float64
            `deformed` in the local frame.
        """
        return None

    def fit(self, weighted) -> Fit:
        """The maps that fit `weighted`, a `vtk_mls.reference.weights.WeightedPoints`, best."""
        raise NotImplementedError

    def functions(self, control_points) -> int:
        """How many functions are summed for each control point, beside its position."""
        return 0

    def needs_float64(self, alpha) -> bool:
        """Whether the kernels sum in double, where the device has it."""
        return False

    def constants(self) -> dict:
        """Build constants of the kernel file: names and values."""
        return {}

    def numbers(self, control_points) -> dict:
        """`rank` and `flip_axis` of map_params_t in structs.h, if the kernel file needs them."""
        return {}

    def table(self, control_points) -> np.ndarray:
        """The `map->kind_table` of the kernel file: float32 of any shape."""
        return np.zeros(0, np.float32)
