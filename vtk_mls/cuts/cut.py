"""What a shape of cuts must tell: in float64, and to the kernels."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vtk_mls.base.validation import as_float, short_repr

if TYPE_CHECKING:
    from vtk_mls.cuts.plane import Plane
    from vtk_mls.handles.control_points import ControlPoints


class Cut:
    """A surface that keeps control points from acting on what is behind."""

    def void_distance(self, v: NDArray[np.float64], g: NDArray[np.float64]) -> NDArray[np.float64]:
        """How far points `v` (m, 3) that come from `g` (m, 3) are from being void: (m,).

        Below 0 where the segment from v to g crosses the cut; continuous on each side of it. For
        v = g the distance from the cut.
        """
        raise NotImplementedError

    def away(self, v: NDArray[np.float64], g: NDArray[np.float64]) -> NDArray[np.float64]:
        """Unit vectors (m, 3): the gradient of `void_distance` as `g` moves, at the face."""
        raise NotImplementedError

    def is_beside(self, x: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Whether the place of the cut that is nearest to `x` (m, 3) is not on its edge: (m,)."""
        raise NotImplementedError

    def farthest(self, control_points: ControlPoints) -> float:
        """How far the cut is from the centre of control points, in their local frame."""
        raise NotImplementedError

    @property
    def plane(self) -> Plane | None:
        """The `Plane` in which the cut lies; None if it is curved.

        A curved one has `points` and `triangles`.
        """
        return None

    @property
    def bounds(self) -> NDArray[np.float64]:
        """Lowest and highest coordinates (2, 3) of the cut; infinite ones if it has no end."""
        return np.array([np.full(3, -np.inf), np.full(3, np.inf)])


class Obstacle(Cut):
    """A cut that one can go round, along a detour v - b - q that bends once.

    A shape is a subclass in any file of this room, and a file opencl/cuts/cut_`kernel`.cl with
    the functions of "Cut shapes" in opencl/README.md. In the kernels, a cut is the `record` that it
    makes for a set of control points.

    Attributes
    ----------
    kernel : str
        Name of the shape in the kernels.
    """

    kernel: str

    def blocks(self, v: NDArray[np.float64], q: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Whether the cut is between `v` and `q` (..., 3): (...) bool."""
        raise NotImplementedError

    def bend(self, v: NDArray[np.float64], q: NDArray[np.float64]) -> NDArray[np.float64]:
        """The point b (..., 3) where the detour from `v` to `q` bends; NaN where there is none."""
        raise NotImplementedError

    def spanning(self) -> NDArray[np.float64]:
        """Points (n, 3) that tell how far away the cut is."""
        raise NotImplementedError

    def record(
        self, control_points: ControlPoints, seen: NDArray[np.float64]
    ) -> list[NDArray[Any]]:
        """What the kernels read of the cut: arrays of floats or ints, in the local frame.

        The cut sees the control points at `seen` (n, 3), world coordinates.
        """
        raise NotImplementedError

    @classmethod
    def constants(cls, count: int) -> dict[str, Any]:
        """Build constants of the kernel file for `count` such cuts."""
        return {}

    def farthest(self, control_points: ControlPoints) -> float:
        return np.abs(control_points.local(self.spanning())).max()


def vector(name: str, value: ArrayLike) -> NDArray[np.float64]:
    """The three finite numbers that an argument `name` must be."""
    numbers = as_float(name, value, "three numbers")
    if numbers.shape != (3,) or not np.isfinite(numbers).all():
        raise ValueError(f"`{name}` must be three finite numbers, got {short_repr(value)}")
    return numbers


def direction(name: str, value: ArrayLike) -> NDArray[np.float64]:
    """The unit vector along what an argument `name` must be."""
    along = vector(name, value)
    largest = np.abs(along).max()
    if largest == 0:
        raise ValueError(f"`{name}` must not be zero, got {short_repr(value)}")
    along = along / largest  # its square may be 0 or infinite
    return along / np.linalg.norm(along)


def freeze(cut: Cut, **values: NDArray[Any]) -> None:
    """Set attributes of a frozen cut, to arrays that cannot be written to."""
    for name, value in values.items():
        value.flags.writeable = False
        object.__setattr__(cut, name, value)
