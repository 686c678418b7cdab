"""The interface of a kind of maps: its fit in float64, and its kernel file."""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Fit:
    """The maps l fitted at points v."""

    displacement: np.ndarray  # l(v) - v, (m, 3), world units
    linear: np.ndarray  # dl/dv at fixed weights, (m, 3, 3) or (3, 3)
    # the derivative of l(v) by the weight of each control point, (m, n, 3)
    influence: Callable[[], np.ndarray]


class Kind:
    """A kind of maps.

    A kind is a subclass with a `name` in any file of this folder, and a kernel file with the
    functions of "Kinds" in opencl/README.md. `degree` is that of polynomials; `order`, `smoothing`
    and `softening` (world units) are those of splines.
    """

    name = None  # as in `Deformation`; None for a base class
    kernel = None  # the file in opencl/fit/ with the fit
    equation = math.inf  # the first one in the paper, by which kinds are sorted
    has_degree = False  # whether the kind depends on `degree`
    proxy_order = 1  # degree of polynomials that the proxies of a rigid region must determine
    # whether a map is fitted around each point, so that cuts and rigid regions can act on weights
    is_local = True
    # whether the map may have a peak or a kink at a control point, which nodes do not see
    has_peaks = True

    @property
    def segment_points(self):
        """Points by which a segment of a curve is summed, with the moments that a fit needs."""
        return self.proxy_order + 1

    def __init__(self, **settings):
        pass

    def chosen(self, handles):
        """The kind with its automatic settings chosen for a `HandleSet`."""
        return self

    def determined(self, points):
        """The part of the map that `points`, `ControlPoints`, determine."""
        return None

    def fit(self, weighted) -> Fit:
        """The best fit to `weighted`, a `vtk_mls.reference.weights.WeightedPoints`."""
        raise NotImplementedError

    def functions(self, control_points) -> int:
        """Number of functions that are summed for each control point, beside its position."""
        return 0

    def needs_float64(self, alpha, points, max_error=0.0) -> bool:
        """Whether the kernels may sum in double on devices that support it.

        Errors up to `max_error`, in local units, do not matter.
        """
        return False

    def is_wrong_in_float32(self, points) -> bool:
        """Whether only devices that support double can compute the map."""
        return False

    def constants(self) -> dict:
        """Build constants of the kernel file: values by name."""
        return {}

    def params(self, control_points) -> dict:
        """`rank` and `flip_axis` of map_params_t in structs.h, if the kernel file uses them."""
        return {}

    def table(self, control_points) -> np.ndarray:
        """The `map->kind_table` of the kernel file: float32 of any shape."""
        return np.zeros(0, np.float32)
