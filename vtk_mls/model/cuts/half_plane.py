"""The half-plane cut, with a straight edge.

The detour bends on the edge line. It is the shortest path around the edge, as unfolding the two
sides around the edge shows.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vtk_mls.base.errors import InputError
from vtk_mls.base.linear_algebra import dots, unit
from vtk_mls.base.validation import freeze, vector
from vtk_mls.model.cuts.cut import Obstacle, direction
from vtk_mls.model.cuts.plane import Plane
from vtk_mls.model.handles.control_points import ControlPoints
from vtk_mls.model.shape_fields import ShapeField


@dataclass(frozen=True, eq=False, init=False)
class HalfPlane(Obstacle):
    """A plane cut that ends at a straight edge.

    It is {x : (x - point) . normal = 0, (x - point) . inward >= 0}.

    Parameters
    ----------
    point : (3,) array_like, world coordinates
        A point of the edge, which runs along normal x inward.
    normal : (3,) array_like
        Normal of the cut.
    inward : (3,) array_like
        Direction from the edge into the cut; its component along `normal` is ignored.
    """

    point: NDArray[np.float64]
    normal: NDArray[np.float64]
    inward: NDArray[np.float64]
    along: NDArray[np.float64] = field(init=False, repr=False)

    name = "half-plane"
    help = "A half-plane ends at an edge through its origin."
    fields = (
        *Obstacle.fields,
        ShapeField(
            "inward",
            "vector",
            """Direction in which the half-plane extends from its edge. The edge goes through the
            origin, at a right angle to this direction and to the normal. The view shows the whole
            plane. A component along the normal is ignored.""",
            (0.0, 0.0, 1.0),
        ),
    )

    def __init__(self, point: ArrayLike, normal: ArrayLike, inward: ArrayLike) -> None:
        n, along = direction("normal", normal), direction("inward", inward)
        across = along - (along @ n) * n
        if np.linalg.norm(across) < 1e-6:
            raise InputError(
                f"must not be parallel to the normal, got {inward!r} and {normal!r}",
                argument="inward",
            )
        across = across / np.linalg.norm(across)
        freeze(
            self, point=vector("point", point), normal=n, inward=across, along=np.cross(n, across)
        )

    def frame(
        self, x: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
        """Height over the cut, depth from the edge and position along it, (...) each."""
        offset = x - self.point
        return dots(offset, self.normal), dots(offset, self.inward), dots(offset, self.along)

    def blocks(self, v: NDArray[np.float64], q: NDArray[np.float64]) -> NDArray[np.bool_]:
        (s, h, _), (t, g, _) = self.frame(v), self.frame(q)
        return ((s < 0) != (t < 0)) & (h * np.abs(t) + g * np.abs(s) > 0)

    def bend(self, v: NDArray[np.float64], q: NDArray[np.float64]) -> NDArray[np.float64]:
        (s, h, a), (t, g, b) = self.frame(v), self.frame(q)
        r_v, r_q = np.hypot(s, h), np.hypot(t, g)
        total = r_v + r_q
        share = np.divide(r_v, total, out=np.zeros_like(total), where=total > 0)
        return self.point + (a + (b - a) * share)[..., None] * self.along

    def void_distance(self, v: NDArray[np.float64], g: NDArray[np.float64]) -> NDArray[np.float64]:
        (s, h, _), (t, e, _) = self.frame(v), self.frame(g)
        to_cut = np.where(e > 0, np.abs(t), np.hypot(t, e))
        # distance of the edge from the segment, in the plane across the edge
        square = (t - s) ** 2 + (e - h) ** 2
        share = -(s * (t - s) + h * (e - h)) / np.where(square > 0, square, 1)
        share = np.clip(share, 0, 1)
        to_edge = np.hypot(s + (t - s) * share, h + (e - h) * share)
        reach = np.minimum(to_cut, to_edge)
        return np.where(self.blocks(v, g), -reach, reach)

    def away(self, v: NDArray[np.float64], g: NDArray[np.float64]) -> NDArray[np.float64]:
        t, e, _ = self.frame(g)
        is_inside = e > 0
        t, e = np.where(is_inside, np.where(t < 0, -1, 1), t), np.where(is_inside, 0, e)
        out = unit(t[:, None] * self.normal + e[:, None] * self.inward)
        return np.where(self.blocks(v, g)[:, None], -out, out)

    def depth(self, x: NDArray[np.float64]) -> NDArray[np.float64]:
        return self.frame(x)[1]

    def spanning(self) -> NDArray[np.float64]:
        return self.point[None]

    def record(
        self, control_points: ControlPoints, positions: NDArray[np.float64]
    ) -> list[NDArray[Any]]:
        """The half-plane; then the frame and the distance from the edge of each control point."""
        point = control_points.local(self.point)
        frames = np.stack(self.frame(positions), axis=1) / control_points.scale
        radius = np.hypot(frames[:, :1], frames[:, 1:2])
        return [point, self.normal, self.inward, self.along, np.hstack([frames, radius])]

    @classmethod
    def constants(cls, count: int) -> dict[str, Any]:
        return {"HALF_PLANES": count}

    @property
    def plane(self) -> Plane | None:
        return Plane(self.point, self.normal)
