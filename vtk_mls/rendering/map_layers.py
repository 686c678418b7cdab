"""The displacement map for rendering: a layer for each side of the cuts, and its box.

The map and the void distance jump across a face, and interpolation would blur it. So with cuts in
the rest frame each side has a layer: the smooth map of its material, continued behind its face.
Cuts that cross have a layer for each combination of their sides. A renderer uses the layer with the
largest void distance. Rays traverse the box, which contains the deformed volume.
"""

from dataclasses import dataclass, replace

import numpy as np

from vtk_mls.base.grid import Grid
from vtk_mls.base.messages import message_handlers
from vtk_mls.base.progress import SILENT
from vtk_mls.queries.void_cells import over_corners
from vtk_mls.vtk.arrays import ImageGeometry

_NO_VOID = 1e30  # void distance without cuts
# Distance from a cut within which its faces are searched, in diagonals of a cell: all nodes of a
# cell with a face are nearer, also where the map is steep.
_REACH = 3
_FAR = 1e4  # in sizes of a cut
_MAX_GROUPS = 3  # of cuts that cross: eight layers
_MAX_CROSSINGS = 8  # to reach a corner between cuts at sharp angles
# Of the box.
_MARGIN = 0.15  # of the size, on each side
_GROWTH = 0.4  # of the size, on a side that the volume reaches
_MAX_SIZE = 64  # times the volume: polynomials bring copies of it from far away
_SAMPLES = 17  # of the map along an axis, to find the volume
_UNBOUNDED = np.array([[-np.inf] * 3, [np.inf] * 3])
_MIN_FILLED = 0.5  # share of an axis that the volume fills, below which the box shrinks


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


@dataclass(frozen=True, eq=False)
class MapBox:
    """A box that is aligned with an image, an ImageGeometry.

    Its ends `low` and `high` (3,), and its limits `within` (2, 3), are continuous indices of the
    values: of points, or of cells if `is_cell_data`.
    """

    image: ImageGeometry
    is_cell_data: bool
    within: np.ndarray
    low: np.ndarray
    high: np.ndarray

    @classmethod
    def around(cls, image, is_cell_data, within=None):
        """The box around an undeformed volume, with a margin.

        `within`, a Grid that is aligned with the image, has at least two points along each axis.
        """
        values = _values_of(image, is_cell_data)
        ends = _ends(values, within)
        box = cls(image, is_cell_data, ends, np.full(3, -0.5), np.array(values.dimensions) - 0.5)
        if np.any(box.high <= ends[0]) or np.any(box.low >= ends[1]):
            return replace(box, low=ends[0], high=ends[1])
        return box._with_margin()

    def ends_at(self, within):
        """Whether a Grid, or None, has the same limits."""
        return np.array_equal(self.within, _ends(self.values, within))

    @property
    def values(self):
        """The `Grid` of the volume's values."""
        return _values_of(self.image, self.is_cell_data)

    def nodes(self, count):
        """The `Grid` of the map, with `count` nodes along the longest side."""
        length = (self.high - self.low) * np.abs(self.values.spacing)
        dimensions = np.maximum(np.rint(count * length / length.max()), 2).astype(int)
        spacing = self.values.spacing * (self.high - self.low) / (dimensions - 1)
        return Grid(dimensions, self.values.at(self.low[None])[0], spacing, self.values.direction)

    def image_geometry(self):
        """The geometry of an image with the same points that fills the box."""
        points = np.array(self.image.grid.dimensions)
        spacing = self.values.spacing * (self.high - self.low) / (points - 1)
        first = self.image.extent[::2]
        origin = self.values.at(self.low[None])[0] - (self.values.direction * spacing) @ first
        return ImageGeometry(self.image.extent, tuple(origin), tuple(spacing), self.image.direction)

    def fitted(self, layers, grid, control_points):
        """The box that fits the deformed volume: this one if it does.

        `layers` is the map (layers, nz, ny, nx, 4) on the `grid` of `nodes`; `control_points` (n,
        3) are parts of the volume that nodes may miss.
        """
        size = self.high - self.low
        first, last = self._filled(layers, grid)
        if len(control_points) > 0:
            share = (self.values.index_of(control_points) - self.low) / size
            first, last = np.minimum(first, share.min(axis=0)), np.maximum(last, share.max(axis=0))
        ends = (self.within - self.low) / size
        first, last = np.clip(first, *ends), np.clip(last, *ends)
        too_large = size > _MAX_SIZE * np.array(self.values.dimensions)
        short = ((first < 0) & ~too_large, (last > 1) & ~too_large)
        if np.any(short):
            first = np.where(short[0], np.minimum(first, 0) - _GROWTH, 0)
            last = np.where(short[1], np.maximum(last, 1) + _GROWTH, 1)
            return self._part(first, last)
        if (last - first < _MIN_FILLED).any():
            return self._part(first, last)._with_margin()
        return self

    def _filled(self, layers, grid):
        """The ends of the volume, as shares of the box, extended by a sample: (3,) and (3,)."""
        axes = [np.unique(np.linspace(0, n - 1, _SAMPLES).astype(int)) for n in grid.dimensions]
        values = layers[np.ix_(range(len(layers)), *axes[::-1])].reshape(-1, 4)
        index = np.stack(np.meshgrid(*axes[::-1], indexing="ij"), axis=-1)[..., ::-1]
        index = np.tile(index.reshape(-1, 3), (len(layers), 1))
        origin = self.values.index_of(grid.at(index) + values[:, :3])
        index = index[self.values.covers(origin) & (values[:, 3] >= 0)]
        if len(index) == 0:
            return np.zeros(3), np.ones(3)
        end, step = np.array(grid.dimensions) - 1, 1 / (_SAMPLES - 1)
        return index.min(axis=0) / end - step, index.max(axis=0) / end + step

    def _part(self, first, last):
        """The box from one share to another, within the limits."""
        size = self.high - self.low
        low = np.maximum(self.low + first * size, self.within[0])
        high = np.minimum(self.low + last * size, self.within[1])
        return replace(self, low=low, high=high)

    def _with_margin(self):
        return self._part(np.full(3, -_MARGIN), np.full(3, 1 + _MARGIN))


def _values_of(image, is_cell_data):
    return image.grid.cells if is_cell_data else image.grid


def _ends(values, within):
    """Continuous indices (2, 3) of the ends of a Grid; infinite for None."""
    if within is None:
        return _UNBOUNDED
    return np.sort(values.index_of(within.corners()[[0, -1]]), axis=0)
