"""Fields of a deformation on grids and at points."""

from __future__ import annotations

from dataclasses import dataclass
from functools import reduce
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from vtk_mls.base.grid import Grid
from vtk_mls.base.linear_algebra import transformed
from vtk_mls.model.cuts.plane import Plane

# Points whose displacements are in memory at once where only void distances are returned.
MAX_SLAB_POINTS = 1 << 20
# Rounding error of the device's float32, and more, as a fraction of the size.
_ROUNDING = 1e-5


@dataclass(frozen=True)
class DisplacementField:
    """The displacement map of a deformation on a grid.

    Attributes
    ----------
    displacement : (nz, ny, nx, 3) float32, world units
        G(v) - v at every point v of the grid.
    void_distance : (nz, ny, nx) float32, world units, or None without cuts
        Negative in the voids that cuts have opened, and continuous on each side of every cut: its
        zero level is the face of the void.
    grid : Grid
    """

    displacement: NDArray[np.float32]
    grid: Grid
    void_distance: NDArray[np.float32] | None = None

    @property
    def void(self) -> NDArray[np.bool_]:
        """(nz, ny, nx) bool: where the deformation has opened a void."""
        if self.void_distance is None:
            return np.zeros(self.grid.shape, bool)
        return self.void_distance < 0


@dataclass(frozen=True)
class ForwardField:
    """Displacements of the material at some points.

    Attributes
    ----------
    displacement : (m, 3) float32, world units
        v - x for the point v with G(v) = x. Without an inverse, v is the point with the smallest
        residual found, or x; NaN for points that are not finite.
    found : (m,) bool
        False without an inverse: the map folds, or the material was pushed through a cut.
    """

    displacement: NDArray[np.float32]
    found: NDArray[np.bool_]


def gaps(name, values):
    """A sentence about rows (..., n) of a map's `values` that are not finite; "" for none."""
    is_finite = np.isfinite(values)
    if is_finite.all():
        return ""
    count = np.count_nonzero(~is_finite.all(axis=-1))
    return (
        f"{count} of {is_finite[..., 0].size} {name} are not finite (NaN or infinite): the map "
        "explodes there; use a rigid kind, or fewer steps, or more smoothing"
    )


def forward_field(engine, deformation, points, progress) -> ForwardField:
    """The `ForwardField` of `points` (m, 3)."""
    displacement, found = engine.forward(deformation, points, progress)
    displacement = displacement.astype(np.float32, copy=False)
    rows = np.flatnonzero(~found)
    rows = rows[np.isfinite(points[rows]).all(axis=1)]
    # too far away for the device's float32
    displacement[rows[~np.isfinite(displacement[rows]).all(axis=1)]] = 0
    return ForwardField(displacement, found)


def void_distance(engine, deformation, points, progress) -> NDArray[np.float64]:
    """`Deformation.void_distance` at `points` (m, 3)."""
    if not deformation.cuts:
        return np.full(len(points), np.inf)
    if deformation.void_needs_map:
        return engine.void_distance(deformation, points, progress)
    mapping, measuring = progress.divided(3, 1)
    origins = engine.backward(deformation, points, mapping)
    return np.min(
        [cut.void_distance(points, origins) for cut in measuring.over(deformation.cuts)], axis=0
    )


def overlap(engine, deformation, points, progress):
    """Whether material from both sides of a cut is at each of `points` (m, 3): (m,) bool.

    The search for a second origin starts just behind each cut, at the closest point to the first
    origin, and behind all of two or three planes that intersect. False with cuts in the deformed
    frame.
    """
    found = np.zeros(len(points), bool)
    if not deformation.in_rest_frame:
        return found
    groups = _groups(deformation.cuts)
    mapping, measuring, *searches = progress.divided(*[1] * (2 + len(groups)))
    origins = engine.backward(deformation, points, mapping)
    rounding = _ROUNDING * rounding_sizes(deformation, points)
    has_material = engine.void_distance(deformation, points, measuring) > rounding
    for cuts, search in zip(groups, searches):
        rows = np.flatnonzero(has_material & ~found)
        x, limit = origins[rows], rounding[rows]
        behind = x - _to_behind(cuts, x, limit)
        second, distance = engine.origins_from(deformation, points[rows], behind, search)
        differs = np.linalg.norm(second - x, axis=1) > limit
        found[rows] = differs & (distance > limit)
    return found


def _groups(cuts):
    """Tuples of cuts that can hide a second origin: each cut, and planes that intersect."""
    planes = [cut for cut in cuts if isinstance(cut, Plane)]
    groups = [(cut,) for cut in cuts]
    for group in (*combinations(planes, 2), *combinations(planes, 3)):
        if np.linalg.matrix_rank([plane.normal for plane in group], 1e-6) == len(group):
            groups.append(group)
    return groups


def _to_behind(cuts, x, limit):
    """Vectors (m, 3) from points `limit` (m,) behind all of the cuts to x (m, 3)."""
    if len(cuts) == 1:
        (cut,) = cuts
        return (cut.void_distance(x, x) + limit)[:, None] * cut.away(x, x)
    heights = np.stack([plane.height(x) for plane in cuts], axis=1)
    distances = heights + np.where(heights < 0, -1, 1) * limit[:, None]
    return transformed(np.linalg.pinv([plane.normal for plane in cuts]), distances)


def rounding_sizes(deformation, points):
    """Length that rounding errors at `points` (m, 3) are relative to: (m,), world units."""
    regions = [region.control_points for region in deformation.regions]
    # numpy's maximum along short rows takes six times as long
    distance = reduce(np.maximum, np.abs(points - regions[0].center).T)
    return np.maximum(max(control_points.scale for control_points in regions), distance)


def slabs(grid, progress):
    """Slices along z of a grid, the parts of the grid there, and a Progress for each."""
    nx, ny, nz = grid.dimensions
    for layers, part in progress.chunks(nz, max(1, MAX_SLAB_POINTS // (nx * ny))):
        yield layers, grid.part((0, 0, layers.start), (nx, ny, layers.stop - layers.start)), part
