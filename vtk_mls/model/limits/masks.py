"""Masks: the deformation acts inside, and less and less over a fall-off."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vtk_mls.base.grid import Grid, checked_grid
from vtk_mls.base.interpolation import linear_with_slopes
from vtk_mls.base.validation import as_float, freeze, positive, short_repr, vector
from vtk_mls.model.limits.limit import Limit, fade
from vtk_mls.model.shape_fields import ShapeField

if TYPE_CHECKING:
    from vtk_mls.model.handles.control_points import ControlPoints

_EDGE = 1e-3  # MASK_EDGE of opencl/handles/limits.cl
_ROUNDING = 2e-6  # of positions in the kernels, local units


class Mask(Limit):
    """A limit of the whole displacement."""


@dataclass(frozen=True, eq=False, init=False)
class BoxMask(Mask):
    """The deformation acts in a box, and fades over `falloff` outside of it.

    Parameters
    ----------
    low, high : (3,) array_like, world coordinates of the deformed space
        Opposite corners.
    falloff : float, > 0, world units
        Beyond this distance from the box everything stays as it was, to the bit.
    """

    low: NDArray[np.float64]
    high: NDArray[np.float64]
    falloff: float

    _radius = 0.0

    def __init__(self, low: ArrayLike, high: ArrayLike, falloff: float) -> None:
        a, b = vector("low", low), vector("high", high)
        if (b < a).any():
            raise ValueError(f"`high` must not be below `low`, got {a.tolist()} and {b.tolist()}")
        freeze(self, low=a, high=b, falloff=positive("falloff", falloff))

    def factor(self, v: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        offset = v - np.clip(v, self.low, self.high)
        distance = np.linalg.norm(offset, axis=1)
        value, slope = fade((distance - self._radius) / self.falloff)
        scale = self.falloff * np.where(distance > 0, distance, 1)
        return 1 - value, (-slope / scale)[:, None] * offset

    def record(self, control_points: ControlPoints) -> dict[str, Any]:
        falloff = self.falloff / control_points.scale
        return {
            "form": "BOX_MASK",
            "low": control_points.local(self.low),
            "high": control_points.local(self.high),
            "radius": self._radius / control_points.scale,
            # ends early by the rounding of float32, so that outside is outside
            "falloff": max(falloff - _ROUNDING, falloff / 2),
        }


@dataclass(frozen=True, eq=False, init=False)
class BallMask(BoxMask):
    """The deformation acts in a ball, and fades over `falloff` outside of it.

    Parameters
    ----------
    center : (3,) array_like, world coordinates of the deformed space
    radius : float, > 0, world units
    falloff : float, > 0, world units
        Beyond this distance from the ball everything stays as it was, to the bit.
    """

    radius: float

    name = "ball-mask"
    fields = (
        ShapeField("center", "point"),
        ShapeField("radius", "length"),
        ShapeField("falloff", "length"),
    )

    def __init__(self, center: ArrayLike, radius: float, falloff: float) -> None:
        at = vector("center", center)
        lengths = {"radius": positive("radius", radius), "falloff": positive("falloff", falloff)}
        freeze(self, low=at, high=at, **lengths)

    @property
    def center(self) -> NDArray[np.float64]:
        """(3,), world coordinates."""
        return self.low

    @property
    def _radius(self):
        return self.radius


@dataclass(frozen=True, eq=False, init=False)
class ImageMask(Mask):
    """The displacement is multiplied by the values of an image, linear between its points.

    Parameters
    ----------
    values : (nz, ny, nx) array_like
        From 0, where everything stays as it was, to 1. Outside of the grid it is 0.
    grid : Grid
        Of the values, in the deformed space.
    """

    values: NDArray[np.float32]
    grid: Grid

    def __init__(self, values: ArrayLike, grid: Grid) -> None:
        checked_grid("grid", grid)
        array = as_float("values", values)
        if array.shape != grid.shape:
            raise ValueError(
                f"`values` must have the shape {grid.shape} of `grid`, got {array.shape}; resample "
                "them to that grid"
            )
        if min(array.shape) < 2:
            raise ValueError(f"`values` must have 2 points along each axis, got {array.shape}")
        if not ((array >= 0) & (array <= 1)).all():
            raise ValueError(
                f"`values` must be from 0 to 1, got {short_repr([array.min(), array.max()])}"
            )
        freeze(self, values=array.astype(np.float32), grid=grid)

    def factor(self, v: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        index = self.grid.index_of(v)
        last = np.array(self.grid.dimensions) - 1
        inside = ((index >= -_EDGE) & (index <= last + _EDGE)).all(axis=1)
        value, slope = linear_with_slopes(self.values, index)
        slope = np.einsum("mi,ij->mj", slope, self.grid.world_to_index)
        return np.where(inside, value, 0), np.where(inside[:, None], slope, 0)

    def record(self, control_points: ControlPoints) -> dict[str, Any]:
        return {"form": "IMAGE_MASK", "image": self.values, "grid": self.grid}
