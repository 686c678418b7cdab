"""Faces that stay where they are, or along which material slides."""

from __future__ import annotations

import functools
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from vtk_mls.base.interpolation import linear_with_slopes
from vtk_mls.base.validation import freeze, positive, short_repr
from vtk_mls.model.cuts import Plane, Surface
from vtk_mls.model.handles import distance_image
from vtk_mls.model.limits.limit import Limit, fade
from vtk_mls.model.shape_fields import ShapeField

if TYPE_CHECKING:
    from vtk_mls.model.handles.control_points import ControlPoints


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
