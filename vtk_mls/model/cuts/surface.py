"""The cut along triangles.

The detour bends on a boundary edge. For a flat surface of any outline that is the shortest path.
For a curved surface the two straight legs may pass through the surface, and the detour is too short
by the bulge between the legs (for a hemispherical cup, from rim to pole: sqrt(2) r instead of
pi r / 2). This detour is continuous, needs no search over paths, and is exact at grazing incidence
and far from the surface.

A segment is blocked if it crosses the triangles an odd number of times. Where a segment starts to
be blocked it touches the boundary; the detour is the segment itself there, and influence is
continuous. At a fold it crosses twice, and is not blocked.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vtk_mls.base import validation
from vtk_mls.base.linear_algebra import cross, dots, transformed, unit
from vtk_mls.base.validation import as_float, freeze
from vtk_mls.model.cuts.cut import Obstacle
from vtk_mls.model.cuts.plane import Plane
from vtk_mls.model.handles.control_points import ControlPoints
from vtk_mls.model.shape_fields import ShapeField

# A segment through an edge or a corner counts as shifted along this arbitrary direction.
_TIE_BREAK = np.array([0.5377, 0.2863, 0.7930])
_MAX_PAIRS = 1 << 17  # of a segment and a triangle in one array, about


@dataclass(frozen=True, eq=False, init=False)
class Surface(Obstacle):
    """A cut along triangles; open or closed, flat or curved.

    Parameters
    ----------
    points : (n, 3) array_like, world coordinates
    triangles : (m, 3) array_like of ints
        Corners of each triangle, as rows of `points`, in any orientation.
    """

    points: NDArray[np.float64]
    triangles: NDArray[np.int32]
    boundary: NDArray[np.float64] = field(init=False, repr=False)

    name = "surface"
    fields = ShapeField("points", "rows"), ShapeField("triangles", "rows")

    def __init__(self, points: ArrayLike, triangles: ArrayLike) -> None:
        x = validation.points("points", points)
        rows = validation.corners("triangles", triangles, 3, len(x))
        a, b, c = x[rows].transpose(1, 0, 2)
        area = np.linalg.norm(cross(b - a, c - a), axis=1)
        sides = ((a, b), (b, c), (c, a))
        longest = np.max([((start - end) ** 2).sum(axis=1) for start, end in sides], axis=0)
        is_degenerate = area <= 1e-10 * longest
        if is_degenerate.any():
            raise ValueError(
                "`triangles` must have an area, got none for triangle "
                f"{int(np.flatnonzero(is_degenerate)[0])}; clean the surface"
            )
        edges = np.sort(rows[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
        edges, count = np.unique(edges, axis=0, return_counts=True)
        freeze(self, points=x, triangles=rows, boundary=x[edges[count % 2 == 1]])

    @classmethod
    def polygon(cls, outline: ArrayLike) -> Surface:
        """The flat surface inside `outline` (n, 3), the points of a closed line in order."""
        corners = as_float("outline", outline)
        if corners.ndim != 2 or corners.shape[1:] != (3,) or len(corners) < 3:
            raise ValueError(f"`outline` must be at least three points (n, 3), got {corners.shape}")
        # a fan around the center: crossings of overlapping triangles come in pairs
        n = len(corners)
        fan = [(n, i, (i + 1) % n) for i in range(n)]
        return cls(np.vstack([corners, corners.mean(axis=0)]), fan)

    def blocks(self, v: NDArray[np.float64], q: NDArray[np.float64]) -> NDArray[np.bool_]:
        odd = np.zeros(np.broadcast_shapes(v.shape, q.shape)[:-1], bool)
        corners = self.points[np.sort(self.triangles, axis=1)]
        count = min(len(corners), 1 + len(corners) * odd.size // _MAX_PAIRS)
        for part in np.array_split(corners, count):
            odd ^= np.logical_xor.reduce(_crosses(v, q, *part.swapaxes(0, 1)), axis=-1)
        return odd

    def bend(self, v: NDArray[np.float64], q: NDArray[np.float64]) -> NDArray[np.float64]:
        v, q = np.broadcast_arrays(v, q)
        best, shortest = np.full(v.shape, np.nan), np.full(v.shape[:-1], np.inf)
        for a, b in self.boundary:
            at = _bend_on_edge(v, q, a, b)
            length = np.linalg.norm(v - at, axis=-1) + np.linalg.norm(q - at, axis=-1)
            better = length < shortest
            shortest = np.where(better, length, shortest)
            best = np.where(better[..., None], at, best)
        return best

    def void_distance(self, v: NDArray[np.float64], g: NDArray[np.float64]) -> NDArray[np.float64]:
        reach = np.minimum(self._nearest(g)[0], self._from_boundary(v, g))
        return np.where(self.blocks(v, g), -reach, reach)

    def is_over(self, x: NDArray[np.float64]) -> NDArray[np.bool_]:
        return self._nearest(x)[0] < (1 - 1e-9) * self._from_boundary(x, x)

    def is_beside(self, x: NDArray[np.float64], to_cut: NDArray[np.float64]) -> NDArray[np.bool_]:
        distance = np.linalg.norm(to_cut, axis=1)
        beside = distance > 1e-6 * np.ptp(self.points, axis=0).max()
        beside &= distance >= (1 - 1e-6) * self._from_boundary(x, x)
        rows, ends = np.flatnonzero(beside), {*map(tuple, self.boundary.reshape(-1, 3).tolist())}
        at, out, reach = x[rows], unit(to_cut[rows]), (1 + 1e-6) * distance[rows]
        is_end = np.array([tuple(place) in ends for place in self.points.tolist()])
        # a triangle is below a point if its normal is within 6 degrees of the way there
        for a, b, c in self.points[self.triangles[is_end[self.triangles].any(axis=1)]]:
            cosine = np.abs(dots(out, unit(cross(b - a, c - a))))
            beside[rows] &= (_from_triangle(at, a, b, c)[0] > reach) | (cosine < 0.995)
        return beside

    def _nearest(self, x):
        """Distances (m,) of points (m, 3) from the triangles, and unit vectors (m, 3) away."""
        nearest, out = np.full(len(x), np.inf), np.zeros_like(x)
        for triangle in self.points[self.triangles]:
            distance, direction = _from_triangle(x, *triangle)
            out = np.where((distance < nearest)[:, None], direction, out)
            nearest = np.minimum(nearest, distance)
        return nearest, out

    def _from_boundary(self, v, g):
        """Distances (m,) of segments v - g (m, 3 each) from the boundary edges."""
        reach = np.full(len(v), np.inf)
        for a, b in self.boundary:
            reach = np.minimum(reach, _distance_of_segments(v, g, a, b))
        return reach

    def away(self, v: NDArray[np.float64], g: NDArray[np.float64]) -> NDArray[np.float64]:
        out = self._nearest(g)[1]
        return np.where(self.blocks(v, g)[:, None], -out, out)

    def spanning(self) -> NDArray[np.float64]:
        return self.points

    def record(
        self, control_points: ControlPoints, positions: NDArray[np.float64]
    ) -> list[NDArray[Any]]:
        """Counts of triangles and of edges, corners of the triangles, ends of the edges."""
        corners = self.points[np.sort(self.triangles, axis=1)]
        counts = np.array([len(corners), len(self.boundary)])
        return [counts, control_points.local(corners), control_points.local(self.boundary)]

    @classmethod
    def constants(cls, count: int) -> dict[str, Any]:
        return {"ASIDE": f"(float3)({', '.join(f'{x}f' for x in _TIE_BREAK)})"}

    @property
    def plane(self) -> Plane | None:
        center = self.points.mean(axis=0)
        size, axes = np.linalg.svd(self.points - center, full_matrices=False)[1:]
        return Plane(center, axes[2]) if size[2] <= 1e-9 * size[0] else None

    @property
    def bounds(self) -> NDArray[np.float64]:
        return np.array([self.points.min(axis=0), self.points.max(axis=0)])


def _crosses(v, q, a, b, c):
    """Whether segments v - q (..., 3) cross triangles a b c (t, 3 each): (..., t).

    A segment through an edge shared by two triangles crosses exactly one of them. Corners must be
    sorted, so that shared edges run in the same order in both.
    """
    normal = cross(b - a, c - a)
    below_v, below_q = (
        np.einsum("...ti,ti->...t", x[..., None, :] - a, normal) < 0 for x in (v, q)
    )
    step = q - v
    line, aside = np.concatenate([step, cross(v, q)], axis=-1), cross(_TIE_BREAK, step)

    def right_of(x, y):
        # sign of the volume of v, q, x, y; 0 to rounding is decided by the shifted line
        edge = np.concatenate([cross(x, y), y - x], axis=-1)
        side, blur = transformed(edge, line), 1e-14 * transformed(np.abs(edge), np.abs(line))
        return np.where(np.abs(side) <= blur, transformed(y - x, aside), side) < 0

    ab, bc, ac = right_of(a, b), right_of(b, c), right_of(a, c)
    return (below_v != below_q) & (ab == bc) & (bc != ac)


def _bend_on_edge(v, q, a, b):
    length = np.linalg.norm(b - a)
    along = (b - a) / length
    l_v, l_q = dots(v - a, along), dots(q - a, along)
    r_v = np.linalg.norm(v - a - l_v[..., None] * along, axis=-1)
    r_q = np.linalg.norm(q - a - l_q[..., None] * along, axis=-1)
    total = r_v + r_q
    share = np.divide(r_v, total, out=np.zeros_like(total), where=total > 0)
    return a + np.clip(l_v + (l_q - l_v) * share, 0, length)[..., None] * along


def _from_triangle(x, a, b, c):
    """Distances (m,) of points `x` (m, 3) from a triangle, and unit vectors (m, 3) away from it."""
    normal = unit(cross(b - a, c - a))
    inside = np.ones(len(x), bool)
    distance, offset = np.full(len(x), np.inf), np.zeros_like(x)
    for start, end in ((a, b), (b, c), (c, a)):
        inside &= dots(x - start, cross(normal, end - start)) >= 0
        t = np.clip(dots(x - start, end - start) / np.sum((end - start) ** 2), 0, 1)
        from_edge = x - start - t[:, None] * (end - start)
        length = np.linalg.norm(from_edge, axis=1)
        offset = np.where((length < distance)[:, None], from_edge, offset)
        distance = np.minimum(distance, length)
    height = dots(x - a, normal)
    above = np.where(height < 0, -1, 1)[:, None] * normal
    return (
        np.where(inside, np.abs(height), distance),
        np.where(inside[:, None], above, unit(offset)),
    )


def _distance_of_segments(v, g, a, b):
    """Distances (m,) between segments v - g (m, 3 each) and the segment a - b."""
    d1, d2, r = g - v, b - a, v - a
    dd1, dd2 = np.sum(d1 * d1, axis=1), np.sum(d2 * d2)
    c, f, e = np.sum(d1 * r, axis=1), dots(r, d2), dots(d1, d2)
    det = dd1 * dd2 - e * e
    apart = det > 1e-15 * dd1 * dd2  # else parallel
    s = np.clip(np.where(apart, (e * f - c * dd2) / np.where(apart, det, 1), 0), 0, 1)
    t = np.clip((e * s + f) / dd2, 0, 1)
    s = np.clip(np.where(dd1 > 0, (e * t - c) / np.where(dd1 > 0, dd1, 1), 0), 0, 1)
    t = np.clip((e * s + f) / dd2, 0, 1)
    return np.linalg.norm(r + s[:, None] * d1 - t[:, None] * d2, axis=1)
