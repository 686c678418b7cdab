"""The cut along triangles.

The detour bends on a boundary edge. For a flat surface of any outline that is the shortest path
there is. For a curved one the two straight legs may pass through the surface: the detour is then
too short, by as much as the surface bulges between the legs (a hemispherical cup seen from its
axis: sqrt(2) r instead of pi r / 2 from rim to pole). It is chosen because it is continuous, has no
search over paths, and is exact where it matters: at grazing, and far from the surface.

Blocked means an odd number of crossings. Where a segment begins to be blocked it touches the
boundary, there the detour is the segment itself, and influence is continuous; at a fold it crosses
twice, and nothing changes.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vtk_mls.base.linear_algebra import cross, dots, transformed, unit
from vtk_mls.base.validation import as_float
from vtk_mls.cuts.cut import Obstacle, freeze
from vtk_mls.cuts.plane import Plane

if TYPE_CHECKING:
    from vtk_mls.handles.control_points import ControlPoints

# No direction that surfaces have by design: a segment through an edge counts as moved along it.
_ASIDE = np.array([0.5377, 0.2863, 0.7930])
_AT_ONCE = 1 << 17  # pairs of a segment and a triangle, for the sake of memory


@dataclass(frozen=True, eq=False)
class Surface(Obstacle):
    """A cut along triangles; open or closed, flat or curved.

    Parameters
    ----------
    points : (n, 3) array_like, world coordinates
    triangles : (m, 3) array_like of ints
        Corners of each triangle, as rows of `points`. Orientation does not matter.
    """

    points: NDArray[np.float64]
    triangles: NDArray[np.int32]
    boundary: NDArray[np.float64] = field(init=False, repr=False)

    if TYPE_CHECKING:

        def __init__(self, points: ArrayLike, triangles: ArrayLike) -> None: ...

    def __post_init__(self) -> None:
        points = as_float("points", self.points)
        rows = as_float("triangles", self.triangles)
        triangles = np.where(np.isfinite(rows), rows, -1).astype(np.int64)
        if (triangles != rows).any():
            raise TypeError("`triangles` must be whole numbers, rows of `points`")
        if points.ndim != 2 or points.shape[1:] != (3,) or not np.isfinite(points).all():
            raise ValueError(f"`points` must be finite numbers (n, 3), got shape {points.shape}")
        if triangles.ndim != 2 or triangles.shape[1:] != (3,) or len(triangles) == 0:
            raise ValueError(
                f"`triangles` must be rows of three point numbers, got shape {triangles.shape}"
            )
        if triangles.min() < 0 or triangles.max() >= len(points):
            raise ValueError(
                f"`triangles` must be numbers of the {len(points)} points, "
                f"got {triangles.min()} to {triangles.max()}"
            )
        a, b, c = points[triangles].transpose(1, 0, 2)
        area = np.linalg.norm(cross(b - a, c - a), axis=1)
        longest = np.max([((x - y) ** 2).sum(axis=1) for x, y in ((a, b), (b, c), (c, a))], axis=0)
        flat = area <= 1e-10 * longest
        if flat.any():
            raise ValueError(
                f"`triangles` must have an area, triangle {int(np.flatnonzero(flat)[0])} has none; "
                "clean the surface first"
            )
        edges = np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
        edges, count = np.unique(edges, axis=0, return_counts=True)
        freeze(self, points=points, triangles=triangles, boundary=points[edges[count % 2 == 1]])

    kernel = "surface"

    @classmethod
    def polygon(cls, outline: ArrayLike) -> Surface:
        """The flat surface within `outline` (n, 3), a closed line of any shape, in order."""
        outline = as_float("outline", outline)
        if outline.ndim != 2 or outline.shape[1:] != (3,) or len(outline) < 3:
            raise ValueError(f"`outline` must be at least three points (n, 3), got {outline.shape}")
        # A fan around the middle: where its triangles overlap, crossings come in pairs.
        n = len(outline)
        fan = [(n, i, (i + 1) % n) for i in range(n)]
        return cls(np.vstack([outline, outline.mean(axis=0)]), fan)

    def blocks(self, v: NDArray[np.float64], q: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Whether an odd number of triangles is between `v` and `q` (..., 3)."""
        odd = np.zeros(np.broadcast_shapes(v.shape, q.shape)[:-1], bool)
        corners = self.points[np.sort(self.triangles, axis=1)]
        for some in _parts(corners, odd.size):
            odd ^= np.logical_xor.reduce(_crosses(v, q, *some.swapaxes(0, 1)), axis=-1)
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
        reach = np.minimum(self._distance(g), self._from_boundary(v, g))
        return np.where(self.blocks(v, g), -reach, reach)

    def is_beside(self, x: NDArray[np.float64]) -> NDArray[np.bool_]:
        return self._distance(x) < (1 - 1e-9) * self._from_boundary(x, x)

    def _distance(self, x):
        """Of points (m, 3) from the triangles: (m,)."""
        reach = np.full(len(x), np.inf)
        for triangle in self.points[self.triangles]:
            reach = np.minimum(reach, _from_triangle(x, *triangle)[0])
        return reach

    def _from_boundary(self, v, g):
        """Of segments v - g (m, 3 each) from the edges that only one triangle has: (m,)."""
        reach = np.full(len(v), np.inf)
        for a, b in self.boundary:
            reach = np.minimum(reach, _distance_of_segments(v, g, a, b))
        return reach

    def away(self, v: NDArray[np.float64], g: NDArray[np.float64]) -> NDArray[np.float64]:
        nearest, out = np.full(len(g), np.inf), np.zeros_like(g)
        for triangle in self.points[self.triangles]:
            distance, direction = _from_triangle(g, *triangle)
            out = np.where((distance < nearest)[:, None], direction, out)
            nearest = np.minimum(nearest, distance)
        return np.where(self.blocks(v, g)[:, None], -out, out)

    def spanning(self) -> NDArray[np.float64]:
        return self.points

    def record(
        self, control_points: ControlPoints, seen: NDArray[np.float64]
    ) -> list[NDArray[Any]]:
        """Numbers of triangles and of edges, corners of the triangles, ends of the edges."""
        corners = self.points[np.sort(self.triangles, axis=1)]
        numbers = np.array([len(corners), len(self.boundary)])
        return [numbers, control_points.local(corners), control_points.local(self.boundary)]

    @classmethod
    def constants(cls, count: int) -> dict[str, Any]:
        return {"ASIDE": f"(float3)({', '.join(f'{x}f' for x in _ASIDE)})"}

    @property
    def plane(self) -> Plane | None:
        centre = self.points.mean(axis=0)
        size, axes = np.linalg.svd(self.points - centre, full_matrices=False)[1:]
        return Plane(centre, axes[2]) if size[2] <= 1e-9 * size[0] else None

    @property
    def bounds(self) -> NDArray[np.float64]:
        return np.array([self.points.min(axis=0), self.points.max(axis=0)])


def _parts(triangles, count):
    """Parts of the triangles: about `_AT_ONCE` pairs of one of them and one of `count` segments."""
    pairs = len(triangles) * count
    return np.array_split(triangles, min(len(triangles), 1 + pairs // _AT_ONCE))


def _crosses(v, q, a, b, c):
    """Whether segments v - q (..., 3) pass triangles a b c (t, 3 each): (..., t).

    Of two that share an edge it is exactly one. Edges must run in the same order in both: sort the
    corners.
    """
    normal = cross(b - a, c - a)
    below_v, below_q = (
        np.einsum("...ti,ti->...t", x[..., None, :] - a, normal) < 0 for x in (v, q)
    )
    step = q - v
    line, aside = np.concatenate([step, cross(v, q)], axis=-1), cross(_ASIDE, step)

    def right_of(x, y):
        # sign of the volume of v, q, x, y; a line through a corner counts as moved aside
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
    """Distances (m,) of points `x` (m, 3) from a triangle, and the unit vectors away from it."""
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
    """Between segments v - g (m, 3 each) and the segment a - b."""
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
