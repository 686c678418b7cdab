"""The displacement map that a renderer interpolates: a layer for each side of the cuts.

Across a face map and void distance jump, and interpolation would blur what is there. So with cuts
in the rest frame there are two layers, each the smooth map of the material on one side, continued
behind its face. Where the layers differ the material is that whose void distance is larger.
"""

from __future__ import annotations

import numpy as np

from vtk_mls.engine.dispatch import engine_for
from vtk_mls.progress import SILENT

_NOWHERE = 1e30  # from a void
# How far from a cut the other side's map is continued, in diagonals of a cell: so that all nodes of
# a cell with a face have it, also where the map is steep.
_REACH = 3
_FAR = 1e4  # next to the size of a cut


def layers(deformation, grid):
    """The map on the nodes of a grid.

    Parameters
    ----------
    deformation : Deformation
    grid : Grid

    Returns
    -------
    (layers, nz, ny, nx, 4) float32
        One layer or two: G(v) - v, and the void distance.
    """
    field = deformation.displacement_field(grid)
    values = np.empty((2 if deformation.in_rest_frame else 1, *grid.shape, 4), np.float32)
    values[..., :3] = field.displacement
    values[..., 3] = _NOWHERE if field.void_distance is None else field.void_distance
    if deformation.in_rest_frame:
        _continue_sides(values.reshape(2, -1, 4), deformation, grid)
    return values


def _continue_sides(values, deformation, grid):
    """Give each layer (nodes, 4) of two the map of its side, near the cuts."""
    distance = values[0, :, 3]
    near = _REACH * np.linalg.norm(grid.index_to_world.sum(axis=1))
    rows = np.flatnonzero(np.abs(distance) < near)
    v = grid.at(np.stack(np.unravel_index(rows, grid.shape)[::-1], axis=-1))
    x, behind = v + values[0, rows, :3], distance[rows] < 0
    sides, opposite, beside = _sides(deformation.cuts, x, behind, 1e-3 * near)
    rows, v, sides, opposite = rows[beside], v[beside], sides[beside], opposite[beside]
    if len(rows) == 0:
        return
    engine = engine_for(deformation.device)
    origins, reached = engine.origins_from(deformation, v, opposite, SILENT)
    values[1 - sides, rows, :3] = origins - v
    values[1 - sides, rows, 3] = reached


def _sides(cuts, x, behind, gap):
    """How the nearest cut sees material that was at `x` (m, 3).

    Returns
    -------
    sides : (m,) ints
        0 or 1: on which side the material is. Where it is `behind` (m,) the map has been continued
        through the cut.
    opposite : (m, 3) float64
        A place near by on the other side.
    beside : (m,) bool
        Whether there is another side: the cut does not end near by.
    """
    sides, opposite, beside = np.zeros(len(x), np.intp), x.copy(), behind.copy()
    nearest = np.full(len(x), np.inf)
    for cut in cuts:
        from_cut = cut.void_distance(x, x)
        rows = np.flatnonzero(from_cut < nearest)
        nearest[rows], here = from_cut[rows], x[rows]
        mirrored = here - (from_cut[rows] + gap)[:, None] * cut.away(here, here)
        sides[rows] = _is_below(cut, here) ^ behind[rows]
        opposite[rows] = np.where(behind[rows, None], here, mirrored)
        beside[rows] = behind[rows] | cut.is_beside(here)
    return sides, opposite, beside


def _is_below(cut, x):
    """On which side of a cut `x` (m, 3) is: (m,) bool."""
    if cut.plane is not None:
        return cut.plane.height(x) < 0
    points = cut.spanning()
    centre = points.mean(axis=0)
    size = np.abs(np.concatenate([points, x]) - centre).max()
    far_above = centre + _FAR * size * np.linalg.svd(points - centre)[2][2]
    return cut.blocks(x, far_above)
