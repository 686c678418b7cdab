"""Limits: masks and faces that say where a deformation acts."""

from __future__ import annotations

import functools
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vtk_mls.base.grid import Grid, checked_grid
from vtk_mls.base.interpolation import linear_with_slopes
from vtk_mls.base.validation import as_float, freeze, positive, short_repr, vector
from vtk_mls.model.cuts import Plane, Surface
from vtk_mls.model.handles import distance_image
from vtk_mls.model.handles.control_points import ControlPoints
from vtk_mls.model.shape_fields import Described, ShapeField

_EDGE = 1e-3  # MASK_EDGE of opencl/handles/limits.cl
_ROUNDING = 2e-6  # of positions in the kernels, local units


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


@dataclass(frozen=True, eq=False, init=False)
class FixedFace(Limit):
    """A plane or a surface that stays where it is.

    The displacement is multiplied by a smooth function of the distance from the face, from 0 there
    to 1 at `falloff`.

    Parameters
    ----------
    face : Plane or Surface
        In the deformed space. The distance from a surface is taken from an image of about 64 cells
        along each axis: material up to a diagonal of a cell away stays, too.
    falloff : float, > 0, world units

    Raises
    ------
    TypeError, ValueError
        For another shape, or a falloff that is not positive.
    """

    face: Plane | Surface
    falloff: float

    name = "fixed-face"
    fields = ShapeField("face", "shape"), ShapeField("falloff", "length")

    def __init__(self, face: Plane | Surface, falloff: float) -> None:
        if not isinstance(face, (Plane, Surface)):
            raise TypeError(f"`face` must be a Plane or a Surface, got {short_repr(face)}")
        freeze(self, face=face, falloff=positive("falloff", falloff))

    @functools.cached_property
    def _images(self):
        """Distances from a surface, less half a cell, and its normals: (4, nz, ny, nx); grid."""
        return distance_image.of_face(self.face.points, self.face.triangles, self.falloff)

    def factor(self, v: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        if isinstance(self.face, Plane):
            height = self.face.height(v)
            value, slope = fade(np.abs(height) / self.falloff)
            return value, (np.sign(height) * slope / self.falloff)[:, None] * self.face.normal
        images, grid = self._images
        index = grid.index_of(v)
        inside = ((index >= 0) & (index <= np.array(grid.dimensions) - 1)).all(axis=1)
        distance, slope = linear_with_slopes(images[0], index)
        value, change = fade(distance / self.falloff)
        slope = np.einsum("mi,ij->mj", slope, grid.world_to_index)
        slope = (change / self.falloff)[:, None] * slope
        return np.where(inside, value, 1), np.where(inside[:, None], slope, 0)

    def normal(self, v: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        if isinstance(self.face, Plane):
            return np.broadcast_to(self.face.normal, v.shape), np.zeros((len(v), 3, 3))
        images, grid = self._images
        index = grid.index_of(v)
        parts = [linear_with_slopes(image, index) for image in images[1:]]
        slopes = np.stack([slope for _, slope in parts], axis=1)
        slopes = np.einsum("mci,ij->mcj", slopes, grid.world_to_index)
        return np.stack([value for value, _ in parts], axis=1), slopes

    def record(self, control_points: ControlPoints) -> dict[str, Any]:
        record = {"slides": self.slides, "falloff": self.falloff / control_points.scale}
        if isinstance(self.face, Plane):
            height = self.face.height(control_points.center) / control_points.scale
            return {**record, "form": "PLANE_FACE", "low": self.face.normal, "high": [height, 0, 0]}
        images, grid = self._images
        values = np.stack([images[0] / control_points.scale, *images[1:]], axis=-1)
        return {**record, "form": "IMAGE_FACE", "image": values, "grid": grid}


class SlidingFace(FixedFace):
    """A plane or a surface along which material slides: a face of symmetry.

    The part of the displacement along the normal of the face is multiplied as by `FixedFace`.
    """

    name = "sliding-face"
    slides = True


def fade(t: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """A step from 0 at t = 0 to 1 at t = 1 with two continuous derivatives, and its slope."""
    t = np.clip(t, 0, 1)
    return t**3 * (t * (6 * t - 15) + 10), 30 * t**2 * (1 - t) ** 2


def limited(limits, v, displacement):
    """The displacements (m, 3) at points `v` (m, 3) after all `limits`."""
    for limit in limits:
        factor = limit.factor(v)[0][:, None]
        if limit.slides:
            normal = limit.normal(v)[0]
            along = np.sum(normal * displacement, axis=1, keepdims=True)
            displacement = displacement - (1 - factor) * along * normal
        else:
            displacement = factor * displacement
    return displacement


def limited_jacobians(limits, v, displacement, d_dv, d_dx):
    """The derivatives (m, 3, 3) of displacements after all `limits`.

    `d_dv` and `d_dx` are those of the `displacement` (m, 3) before them, at fixed origins x and by
    the origins.
    """
    for limit in limits:
        factor, slope = limit.factor(v)
        share = (1 - factor)[:, None, None]
        if limit.slides:
            normal, turn = limit.normal(v)
            outer = normal[:, :, None] * normal[:, None]
            along = np.sum(normal * displacement, axis=1)[:, None, None]
            turned = np.einsum("mij,mi->mj", turn, displacement)
            d_dv = d_dv - share * (outer @ d_dv) + along * normal[:, :, None] * slope[:, None]
            d_dv = d_dv - share * (along * turn + normal[:, :, None] * turned[:, None])
            d_dx = d_dx - share * (outer @ d_dx)
            displacement = displacement - share[:, :, 0] * along[:, :, 0] * normal
        else:
            d_dv = factor[:, None, None] * d_dv + displacement[:, :, None] * slope[:, None]
            d_dx = factor[:, None, None] * d_dx
            displacement = factor[:, None] * displacement
    return d_dv, d_dx


def are_fixed(limits, points):
    """Which `points` (m, 3) stay at rest whatever the handles do: (m,) bool."""
    fixed = [limit.factor(points)[0] == 0 for limit in limits if not limit.slides]
    return np.any(fixed, axis=0) if fixed else np.zeros(len(points), bool)
