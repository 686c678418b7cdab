"""The displacement map for rendering: a layer for each side of the cuts.

The map and the void distance jump across a face, and interpolation would blur it. So with cuts in
the rest frame each side has a layer: the smooth map of its material, continued behind its face.
Cuts that cross have a layer for each combination of their sides. A renderer uses the layer with the
largest void distance.
"""

import numpy as np

from vtk_mls.base.messages import message_handlers
from vtk_mls.base.progress import SILENT
from vtk_mls.queries.void_cells import over_corners

_NO_VOID = 1e30  # void distance without cuts
# Distance from a cut within which its faces are searched, in diagonals of a cell: all nodes of a
# cell with a face are nearer, also where the map is steep.
_REACH = 3
_FAR = 1e4  # in sizes of a cut
_MAX_GROUPS = 3  # of cuts that cross: eight layers
_MAX_CROSSINGS = 8  # to reach a corner between cuts at sharp angles


def layers(deformation, grid):
    """The map of a Deformation on the nodes of a Grid: (layers, nz, ny, nx, 4) float32.

    Each of one, two, four or eight layers has G(v) - v and the void distance.
    """
    with message_handlers(None, lambda sentence: None):  # it may be a frame of a drag
        field = deformation.displacement_field(grid)
    values = np.empty((1, *grid.shape, 4), np.float32)
    values[0, ..., :3] = field.displacement
    values[0, ..., 3] = _NO_VOID if field.void_distance is None else field.void_distance
    if not deformation.in_rest_frame:
        return values
    return _of_each_side(values.reshape(-1, 4), deformation, grid).reshape(-1, *values.shape[1:])


def _of_each_side(own, deformation, grid):
    """Layers (layers, nodes, 4): the map of each side near the cuts, and the map `own` elsewhere.

    Bit k of a layer's index is the side of the cuts of group k.
    """
    near = _REACH * np.linalg.norm(grid.index_to_world.sum(axis=1))
    rows = np.flatnonzero(np.abs(own[:, 3]) < near)
    v = grid.at(np.stack(np.unravel_index(rows, grid.shape)[::-1], axis=-1))
    x, distance = v + own[rows, :3], own[rows, 3]
    behind = distance < 0
    groups = _groups(deformation.cuts, x, distance, near)
    for group in groups:
        group.nearest[~_near_faces(group, rows, behind, grid.shape)] = -1
    values = np.repeat(own[None], 2 ** len(groups), axis=0)
    if not groups:
        return values
    bits = 2 ** np.arange(len(groups))
    near_groups = bits @ [group.nearest >= 0 for group in groups]
    sides = bits @ [group.below for group in groups] & near_groups
    searched, starts = [], []
    for layer in range(len(values)):
        is_other = (sides != layer) | (behind & (near_groups != 0))
        searched.append(np.flatnonzero((layer & near_groups == layer) & is_other))
        starts.append(_starts(groups, layer, x, searched[-1], 1e-3 * near))
    layer_ids = np.repeat(np.arange(len(values)), [len(nodes) for nodes in searched])
    nodes, starts = np.concatenate(searched), np.concatenate(starts)
    origins, distance = deformation._engine.origins_from(deformation, v[nodes], starts, SILENT)
    values[layer_ids, rows[nodes], :3] = origins - v[nodes]
    values[layer_ids, rows[nodes], 3] = distance
    for layer in range(1, len(values)):
        is_copy = (near_groups != 0) & (layer & near_groups != layer)
        values[layer, rows[is_copy]] = values[(layer & near_groups)[is_copy], rows[is_copy]]
    return values


class _Group:
    """Cuts that are nowhere close to each other, and points x (m, 3) near them.

    `nearest` (m,) is the index of the cut near x, away from its edge, or -1; `distance` is from it,
    and `below` is the side of it.
    """

    def __init__(self, count):
        self.cuts, self.nearest = [], np.full(count, -1)
        self.distance, self.below = np.full(count, np.inf), np.zeros(count, bool)

    def add(self, cut, x, distance, is_near):
        rows = np.flatnonzero(is_near & (distance < self.distance))
        self.nearest[rows], self.distance[rows] = len(self.cuts), distance[rows]
        self.below[rows] = _is_below(cut, x[rows])
        self.cuts.append(cut)

    def across(self, x, rows, gap, distance=None):
        """Points just across the nearest cuts of some rows, from `x` (rows, 3)."""
        result = np.empty_like(x)
        for index, part in self._parts(rows):
            cut, at = self.cuts[index], x[part]
            far = cut.void_distance(at, at) if distance is None else distance[part]
            result[part] = at - (far + gap)[:, None] * cut.away(at, at)
        return result

    def are_below(self, x, rows):
        """Sides of `x` (rows, 3) at the nearest cuts of some rows: (rows,) bool."""
        result = np.empty(len(x), bool)
        for index, part in self._parts(rows):
            result[part] = _is_below(self.cuts[index], x[part])
        return result

    def _parts(self, rows):
        nearest = self.nearest[rows]
        return [(index, np.flatnonzero(nearest == index)) for index in np.unique(nearest)]


def _groups(cuts, x, void_distance, near):
    """The cuts near x (m, 3) in `_Group`s; cuts that cross are in different groups if possible."""
    groups, behind = [], void_distance < 0
    for cut in cuts:
        distance = np.abs(void_distance) if len(cuts) == 1 else cut.void_distance(x, x)
        is_near = distance < near
        is_near[is_near] = behind[is_near] | cut.is_over(x[is_near])
        if not is_near.any():
            continue
        shared = [np.count_nonzero(is_near & (group.nearest >= 0)) for group in groups]
        if min(shared, default=1) > 0 and len(groups) < _MAX_GROUPS:
            shared.append(0)
            groups.append(_Group(len(x)))
        groups[int(np.argmin(shared))].add(cut, x, distance, is_near)
    return groups


def _near_faces(group, rows, behind, shape):
    """Which rows are nodes of cells with a face of a group of cuts: (rows,) bool."""
    is_near = group.nearest >= 0

    def cells_with(mask):
        nodes = np.zeros(shape, bool)
        nodes.reshape(-1)[rows] = is_near & mask
        return over_corners(np.logical_or, nodes)

    above, below = cells_with(~behind & ~group.below), cells_with(~behind & group.below)
    faces = (above & below) | ((above | below) & cells_with(behind))
    return over_corners(np.logical_or, np.pad(faces, 1)).reshape(-1)[rows]


def _starts(groups, layer, x, rows, gap):
    """Points near x[rows] on the sides of the cuts of a layer."""
    starts = x[rows]
    for attempt in range(_MAX_CROSSINGS if len(groups) > 1 else 1):
        crossed = 0
        for bit, group in enumerate(groups):
            near = np.flatnonzero(group.nearest[rows] >= 0)
            at = rows[near]
            is_first = attempt == 0 and bit == 0
            below = group.below[at] if is_first else group.are_below(starts[near], at)
            wrong = near[below != bool(layer >> bit & 1)]
            distance = group.distance[rows[wrong]] if is_first else None
            starts[wrong] = group.across(starts[wrong], rows[wrong], gap, distance)
            crossed += len(wrong)
        if crossed == 0:
            break
    return starts


def _is_below(cut, x):
    """Whether `x` (m, 3) is on the lower side of a cut: (m,) bool."""
    if cut.plane is not None:
        return cut.plane.height(x) < 0
    points = cut.spanning()
    center = points.mean(axis=0)
    size = np.abs(np.concatenate([points, x]) - center).max()
    far_above = center + _FAR * size * np.linalg.svd(points - center)[2][2]
    return cut.blocks(x, far_above)
