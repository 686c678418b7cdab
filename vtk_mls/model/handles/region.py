"""Rigid regions: solids that move as a whole."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vtk_mls.base.errors import InputError
from vtk_mls.base.validation import as_float, freeze, short_repr
from vtk_mls.model.handles.handle import Handle
from vtk_mls.model.handles.rigid_motion import screw
from vtk_mls.model.handles.shapes import Shape
from vtk_mls.model.shape_fields import ShapeField

_ORTHOGONAL = 1e-5  # largest error of R^T R


@dataclass(frozen=True, eq=False, init=False)
class RegionHandle(Handle):
    """A solid that is moved and turned, and keeps its shape.

    Its proxies are control points that share one weight, by the distance from the moved solid.
    Inside that distance is 0, so the map is the inverse motion.

    Parameters
    ----------
    shape : Ball, Capsule, Solid or Labels
        In the undeformed space.
    motion : (4, 4) array_like, world coordinates
        From the undeformed to the deformed space: a rotation and a translation.

    Raises
    ------
    TypeError, ValueError
        If `shape` is no shape, or `motion` scales, shears or mirrors.
    """

    shape: Shape
    motion: NDArray[np.float64]

    name, title = "region", "rigid"
    fields = ShapeField("shape", "shape"), ShapeField("motion", "rows")

    def __init__(self, shape: Shape, motion: ArrayLike) -> None:
        if not isinstance(shape, Shape):
            raise TypeError(
                f"`shape` must be a Ball, Capsule, Solid or Labels, got {short_repr(shape)}"
            )
        matrix = as_float("motion", motion, "numbers of shape (4, 4)")
        if matrix.shape != (4, 4) or not np.isfinite(matrix).all():
            text = f"must be finite numbers (4, 4), got {short_repr(motion)}"
            raise InputError(text, argument="motion")
        turn = matrix[:3, :3]
        error = np.abs(turn.T @ turn - np.eye(3)).max()
        if error > _ORTHOGONAL or np.linalg.det(turn) < 0 or (matrix[3] != (0, 0, 0, 1)).any():
            raise InputError(
                f"must be a rotation and a translation, got a matrix that scales, shears or "
                f"mirrors: {short_repr(np.round(turn, 4).tolist())}",
                argument="motion",
            )
        freeze(self, shape=shape, motion=matrix)

    @property
    def swapped(self) -> RegionHandle:
        """The motion back, of the same shape: its `distance` is that from the shape at rest."""
        return RegionStep(self, self.motion, np.eye(4))

    def moved(self, x: NDArray[np.float64]) -> NDArray[np.float64]:
        """Points `x` (m, 3) of the undeformed space after the motion."""
        return moved(self.motion, x)

    @property
    def to_shape(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """The rotation (3, 3) and offset (3,) from the deformed space to that of the shape."""
        turn = self.motion[:3, :3].T
        return turn, -turn @ self.motion[:3, 3]

    def distance(self, v: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Distances (m,) of points `v` (m, 3) from the moved shape; 0 inside.

        And half the gradients (m, 3) of their squares.
        """
        turn, offset = self.to_shape
        distance, toward = self.shape.distance(np.einsum("ij,mj->mi", turn, v) + offset)
        return distance, np.einsum("ji,mj->mi", turn, toward)

    def proxies(self, order: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Control points (k, 3) at rest and moved, for polynomials of degree `order`."""
        rest = self.shape.proxies(order)
        return rest, self.moved(rest)

    @property
    def center(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """The center (3,) of the shape's bounds at rest, and moved: cuts see the region there."""
        middle = self.shape.bounds.mean(axis=0)
        return middle, self.moved(middle[None])[0]

    @property
    def grips(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        rest, deformed = self.center
        return rest[None], deformed[None]

    def with_grips(self, deformed: NDArray[np.float64]) -> RegionHandle:
        motion = self.motion.copy()
        motion[:3, 3] += deformed[0] - self.center[1]
        return RegionHandle(self.shape, motion)

    def blended(self, share: float) -> RegionHandle:
        return RegionHandle(self.shape, screw(self, share))

    @property
    def is_resting(self) -> bool:
        return bool((self.motion == np.eye(4)).all())

    def samples(self, count: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        x = self.shape.samples(count)
        return x, self.moved(x)


class RegionStep(RegionHandle):
    """The motion of a region from one place to another, with the motions (4, 4) to both."""

    def __init__(self, region, before, after):
        motion = np.einsum("ij,jk->ik", after, np.linalg.inv(before))
        freeze(self, shape=region.shape, motion=motion, before=before, after=after)

    @property
    def to_shape(self):
        turn = self.after[:3, :3].T
        return turn, -turn @ self.after[:3, 3]

    @property
    def center(self):
        middle = self.shape.bounds.mean(axis=0)
        return tuple(moved(motion, middle[None])[0] for motion in (self.before, self.after))


def moved(motion, x):
    """Points `x` (m, 3) after a `motion` (4, 4)."""
    return np.einsum("ij,mj->mi", motion[:3, :3], x) + motion[:3, 3]
