"""The interface of a shape of cuts: in float64, and for the kernels."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vtk_mls.base.errors import InputError
from vtk_mls.base.validation import short_repr, vector
from vtk_mls.model.shape_fields import Described, ShapeField

if TYPE_CHECKING:
    from vtk_mls.model.cuts.plane import Plane
    from vtk_mls.model.handles.control_points import ControlPoints


class Cut(Described):
    """A surface that keeps control points from acting on the material behind it.

    The fields of a flat shape are its point and normal, then vectors in its plane and lengths:
    numbers describe it, and the mouse moves it. Other shapes have `points` and `triangles`.
    """

    fields: tuple[ShapeField, ...] = (
        ShapeField(
            "point",
            "point",
            """A point of the plane, or of the edge of the half-plane. If CutFrame is rest, the
            plane in the view stays at the undeformed volume, while the cut itself moves with the
            material.""",
            (0.0, 0.0, 0.0),
            title="origin",
        ),
        ShapeField(
            "normal",
            "vector",
            "Normal of the plane or half-plane. Its length is ignored.",
            (1.0, 0.0, 0.0),
        ),
    )

    def void_distance(self, v: NDArray[np.float64], g: NDArray[np.float64]) -> NDArray[np.float64]:
        """Signed distance of points `v` (m, 3) with origins `g` (m, 3) from the void: (m,).

        Negative where the segment from v to g crosses the cut; continuous on each side of the cut;
        the distance from the cut for v = g.
        """
        raise NotImplementedError

    def away(self, v: NDArray[np.float64], g: NDArray[np.float64]) -> NDArray[np.float64]:
        """Unit vectors (m, 3): the gradient of `void_distance` as `g` moves, at the face."""
        raise NotImplementedError

    def depth(self, x: NDArray[np.float64]) -> NDArray[np.float64]:
        """Distances (m,) from the edge of a flat cut, within its plane, of points `x` (m, 3).

        Positive over the cut, negative beside it; infinite without an edge.
        """
        return np.full(len(x), np.inf)

    def is_over(self, x: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Whether the closest point of the cut to `x` (m, 3) is inside its edge: (m,) bool."""
        return self.depth(x) > 0

    def is_beside(self, x: NDArray[np.float64], to_cut: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Whether `x` (m, 3), `to_cut` from a curved cut, are beyond its edge, above none of it."""
        return np.zeros(len(x), bool)

    def farthest(self, control_points: ControlPoints) -> float:
        """Distance of the cut from the center of control points, in their local frame."""
        raise NotImplementedError

    @property
    def plane(self) -> Plane | None:
        """The `Plane` that contains the cut; None for a curved cut."""
        return None

    @property
    def bounds(self) -> NDArray[np.float64]:
        """Lowest and highest coordinates (2, 3) of the cut; infinite if it is unbounded."""
        return np.array([np.full(3, -np.inf), np.full(3, np.inf)])


class Obstacle(Cut):
    """A cut with an edge: influence goes around it, along a detour v - b - q that bends once.

    A shape is a subclass in any file of this folder, and a kernel file opencl/cuts/cut_`kernel`.cl
    with the functions of "Cut shapes" in opencl/README.md. The kernels read the `record` of a cut
    for a set of control points.
    """

    kernel: str  # name of the shape in the kernels: `name` with underscores

    def __init_subclass__(cls) -> None:
        super().__init_subclass__()
        cls.kernel = cls.name.replace("-", "_")

    def blocks(self, v: NDArray[np.float64], q: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Whether the cut is between `v` and `q` (..., 3): (...) bool."""
        raise NotImplementedError

    def bend(self, v: NDArray[np.float64], q: NDArray[np.float64]) -> NDArray[np.float64]:
        """The point b (..., 3) where the detour from `v` to `q` bends; NaN without a detour."""
        raise NotImplementedError

    def spanning(self) -> NDArray[np.float64]:
        """Points (n, 3) whose convex hull contains the cut, or its edge if it is unbounded."""
        raise NotImplementedError

    def record(
        self, control_points: ControlPoints, positions: NDArray[np.float64]
    ) -> list[NDArray[Any]]:
        """The data of the cut for the kernels: arrays of floats or ints, in the local frame.

        `positions` (n, 3), world coordinates, are those of the control points in the cut's frame:
        rest or deformed, as `cut_frame` says.
        """
        raise NotImplementedError

    @classmethod
    def constants(cls, count: int) -> dict[str, Any]:
        """Build constants of the kernel file for `count` such cuts."""
        return {}

    def farthest(self, control_points: ControlPoints) -> float:
        return float(np.abs(control_points.local(self.spanning())).max())


def direction(name: str, value: ArrayLike) -> NDArray[np.float64]:
    """An argument of three finite numbers, not all 0, as a unit vector."""
    along = vector(name, value)
    largest = np.abs(along).max()
    if largest == 0:
        raise InputError(f"must not be zero, got {short_repr(value)}", argument=name)
    along = along / largest  # the square of `largest` may be 0 or infinite
    return along / np.linalg.norm(along)
