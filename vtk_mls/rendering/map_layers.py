"""The displacement map that a renderer interpolates: a layer for each side of the cuts.

Across a face map and void distance jump, and interpolation would blur what is there. So with cuts
in the rest frame there is a layer for each side, the smooth map of the material there, continued
behind its face: two layers, and where cuts cross one for each combination of their sides. Where
layers differ the material is that whose void distance is largest.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vtk_mls.base.progress import SILENT
from vtk_mls.engine.dispatch import engine_for

_NOWHERE = 1e30  # from a void
# How far from a cut its faces are looked for, in diagonals of a cell: all nodes of a cell with a
# face are nearer, also where the map is steep.
_REACH = 3
_FAR = 1e4  # next to the size of a cut
_MOST_GROUPS = 3  # of cuts that cross: eight layers
_ROUNDS = 8  # to find a corner between cuts at sharp angles


def layers(deformation, grid):
    """The map on the nodes of a grid.

    Parameters
    ----------
    deformation : Deformation
    grid : Grid

    Returns
    -------
    (layers, nz, ny, nx, 4) float32
        One layer, two, four or eight: G(v) - v, and the void distance.
    """
    field = deformation.displacement_field(grid)
    values = np.empty((1, *grid.shape, 4), np.float32)
    values[0, ..., :3] = field.displacement
    values[0, ..., 3] = _NOWHERE if field.void_distance is None else field.void_distance
    if not deformation.in_rest_frame:
        return values
    return _of_each_side(values.reshape(-1, 4), deformation, grid).reshape(-1, *values.shape[1:])


def _of_each_side(own, deformation, grid):
    """Layers (layers, nodes, 4) that have the map of their sides near the cuts, and `own` beyond.

    Bit k of a layer's number is the side of the cuts of group k.
    """
    near = _REACH * np.linalg.norm(grid.index_to_world.sum(axis=1))
    rows = np.flatnonzero(np.abs(own[:, 3]) < near)
    v = grid.at(np.stack(np.unravel_index(rows, grid.shape)[::-1], axis=-1))
    x, distance = v + own[rows, :3], own[rows, 3]
    behind = distance < 0
    groups = _groups(deformation.cuts, x, distance, near)
    for group in groups:
        group.keep(_near_faces(group, rows, behind, grid.shape))
    values = np.repeat(own[None], 2 ** len(groups), axis=0)
    if not groups:
        return values
    bits = 2 ** np.arange(len(groups))
    beside = bits @ [group.nearest >= 0 for group in groups]
    sides = bits @ [group.below for group in groups] & beside
    asked, starts = [], []
    for layer in range(len(values)):
        wanted = (layer & beside == layer) & ((sides != layer) | (behind & (beside != 0)))
        asked.append(np.flatnonzero(wanted))
        starts.append(_starts(groups, layer, x, asked[-1], 1e-3 * near))
    numbers = np.repeat(np.arange(len(values)), [len(each) for each in asked])
    asked, starts = np.concatenate(asked), np.concatenate(starts)
    origins, distance = engine_for(deformation.device).origins_from(
        deformation, v[asked], starts, SILENT
    )
    values[numbers, rows[asked], :3] = origins - v[asked]
    values[numbers, rows[asked], 3] = distance
    for layer in range(1, len(values)):
        other = (beside != 0) & (layer & beside != layer)
        values[layer, rows[other]] = values[(layer & beside)[other], rows[other]]
    return values


@dataclass
class _Group:
    """Cuts that are nowhere close to one another, as they are seen from x (m, 3).

    Attributes
    ----------
    cuts : list
        Of `Cut`.
    nearest : (m,) ints
        Which of them is near, and does not end near by; -1 if none.
    distance : (m,) float64
        From x.
    below : (m,) bool
        On which side of it x is.
    """

    cuts: list
    nearest: np.ndarray
    distance: np.ndarray
    below: np.ndarray

    @classmethod
    def of_none(cls, count):
        return cls([], np.full(count, -1), np.full(count, np.inf), np.zeros(count, bool))

    def add(self, cut, x, distance, is_near):
        rows = np.flatnonzero(is_near & (distance < self.distance))
        self.nearest[rows], self.distance[rows] = len(self.cuts), distance[rows]
        self.below[rows] = _is_below(cut, x[rows])
        self.cuts.append(cut)

    def keep(self, rows):
        """Forget what is near in other rows."""
        self.nearest[~rows] = -1

    def across(self, x, rows, gap, distance=None):
        """Just across the nearest cuts of some rows, from `x` (rows, 3) near by."""
        result = np.empty_like(x)
        for number, here in self._parts(rows):
            cut, at = self.cuts[number], x[here]
            far = cut.void_distance(at, at) if distance is None else distance[here]
            result[here] = at - (far + gap)[:, None] * cut.away(at, at)
        return result

    def are_below(self, x, rows):
        """On which side of the nearest cuts of some rows `x` (rows, 3) near by is."""
        result = np.empty(len(x), bool)
        for number, here in self._parts(rows):
            result[here] = _is_below(self.cuts[number], x[here])
        return result

    def _parts(self, rows):
        nearest = self.nearest[rows]
        return [(number, np.flatnonzero(nearest == number)) for number in np.unique(nearest)]


def _groups(cuts, x, void_distance, near):
    """The cuts near x (m, 3) in `_Group`s; those that cross are in different ones, if possible."""
    groups, behind = [], void_distance < 0
    for cut in cuts:
        distance = np.abs(void_distance) if len(cuts) == 1 else cut.void_distance(x, x)
        is_near = distance < near
        is_near[is_near] = behind[is_near] | cut.is_over(x[is_near])
        if not is_near.any():
            continue
        shared = [np.count_nonzero(is_near & (group.nearest >= 0)) for group in groups]
        if min(shared, default=1) > 0 and len(groups) < _MOST_GROUPS:
            shared.append(0)
            groups.append(_Group.of_none(len(x)))
        groups[int(np.argmin(shared))].add(cut, x, distance, is_near)
    return groups


def _near_faces(group, rows, behind, shape):
    """Which rows are nodes of cells with a face of a group of cuts."""
    beside = group.nearest >= 0

    def cells_with(which):
        nodes = np.zeros(shape, bool)
        nodes.reshape(-1)[rows] = beside & which
        return _any_along_axes(nodes, 2)

    above, below = cells_with(~behind & ~group.below), cells_with(~behind & group.below)
    faces = (above & below) | ((above | below) & cells_with(behind))
    return _any_along_axes(np.pad(faces, 1), 2).reshape(-1)[rows]


def _any_along_axes(flags, count):
    """Whether any of `count` neighbours along each axis is set: an array smaller by count - 1."""
    for axis in range(3):
        windows = np.lib.stride_tricks.sliding_window_view(flags, count, axis)
        flags = np.logical_or.reduce([windows[..., i] for i in range(count)])
    return flags


def _starts(groups, layer, x, rows, gap):
    """Points on the sides of the cuts that a layer has, near x[rows]."""
    starts = x[rows]
    for attempt in range(_ROUNDS if len(groups) > 1 else 1):
        crossed = 0
        for bit, group in enumerate(groups):
            here = np.flatnonzero(group.nearest[rows] >= 0)
            at = rows[here]
            is_first = attempt == 0 and bit == 0
            below = group.below[at] if is_first else group.are_below(starts[here], at)
            wrong = here[below != bool(layer >> bit & 1)]
            known = group.distance[rows[wrong]] if is_first else None
            starts[wrong] = group.across(starts[wrong], rows[wrong], gap, known)
            crossed += len(wrong)
        if crossed == 0:
            break
    return starts


def _is_below(cut, x):
    """On which side of a cut `x` (m, 3) is: (m,) bool."""
    if cut.plane is not None:
        return cut.plane.height(x) < 0
    points = cut.spanning()
    centre = points.mean(axis=0)
    size = np.abs(np.concatenate([points, x]) - centre).max()
    far_above = centre + _FAR * size * np.linalg.svd(points - centre)[2][2]
    return cut.blocks(x, far_above)
