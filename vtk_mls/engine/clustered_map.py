"""The map of a grid where many control points are: those far away count by clusters."""

from __future__ import annotations

import functools

import numpy as np

from vtk_mls.clusters import Clusters
from vtk_mls.engine import kernel_arguments
from vtk_mls.engine.coarse_map import CONSTANTS, STEP, cells_of

# A block is so many cells of coarse_map.cl along each axis; its points have a list in common.
_ALONG = 2
_BLOCK = _ALONG * STEP
# How large clusters may be next to their distance: the first of these with which a block keeps to
# the tolerance. With none of them all of its control points count.
_RELATIVE_SIZES = 0.5, 0.35, 0.25, 0.15
_SAFETY = 4  # times that errors may be larger than at the points of a block that are looked at
_MANY = 1 << 11  # control points, from which on lists are much shorter
LISTED = 3000  # for a block, as a rule
# Beyond, a few control points outweigh all others, and what those tell of the twist about them is
# less than the error of a cluster.
_LARGEST_ALPHA = 1.5
_GROUP = 16  # points of a block that are looked at: its corners, and eight inside
_LOOKED_AT = np.array(
    [
        *[(i, j, k) for k in (0, 7) for j in (0, 7) for i in (0, 7)],
        *[(3, 1, 2), (1, 4, 5), (5, 6, 1), (6, 2, 4), (2, 5, 3), (4, 3, 6), (0, 3, 4), (4, 7, 2)],
    ]
)


def has_clusters(deformation, control_points):
    """Whether clusters of a region's control points may count on grids."""
    return (
        deformation.map_tolerance > 0
        and deformation.alpha <= _LARGEST_ALPHA
        and not deformation.cuts
        and len(control_points) >= _MANY
    )


class ClusteredMap:
    """The map of a region whose control points are many, on a grid.

    Blocks are of the whole grid: parts find the same lists.

    Parameters
    ----------
    map_ : RegionMap
    """

    def __init__(self, map_):
        self.map = map_
        self._layer = None  # of the last launch: the grid, the number in it, the lists

    def share(self, grid):
        """The share of a grid's control points that count, about; 1 if it is not worth it."""
        control_points = self.map.control_points
        is_thin = min(grid.whole.dimensions) < _BLOCK
        if is_thin or not has_clusters(self.map.deformation, control_points):
            return 1.0
        return LISTED / len(control_points) + _GROUP / _BLOCK**3

    def launch(self, name, grid, part, between, *arguments):
        """Launch a kernel for the points `part` of a grid, layer of blocks by layer of blocks."""
        points = kernel_arguments.grid_points(grid, part, self.map.control_points)
        first, cells = cells_of(grid)
        nx, ny, _ = grid.dimensions
        low, high = (
            (grid.first[2] + n // (nx * ny)) // _BLOCK for n in (part.start, part.stop - 1)
        )
        for number in range(low, high + 1):
            if self._layer is None or self._layer[:2] != (grid, number):
                self._layer = grid, number, *self._lists_of(grid, number)
            _, _, count, listed = self._layer
            record = kernel_arguments.filled(
                kernel_arguments.COARSE, listed=count, first_cell=first, cells=cells
            )
            constants = (*CONSTANTS, ("CELLS", 1))
            self._launch(
                *(name, (grid.whole, False), count * STEP**3, constants),
                *(points, record, *listed, *arguments),
            )

    def _launch(self, name, described, count, constants, *arguments):
        of_map, (numbers, *_) = self.map.described(*described)
        self.map.launcher.launch(
            name, (*of_map, *constants, ("CLUSTERS", 1)), count, numbers, *self._tables, *arguments
        )

    @functools.cached_property
    def _clusters(self):
        control_points = self.map.control_points
        p, q = (control_points.local(a) for a in (control_points.rest, control_points.deformed))
        return Clusters(q, p, control_points.weights)

    @functools.cached_property
    def _tables(self):
        """The control points and what their kind has of them, then of stand-ins: two buffers."""
        control_points, clusters = self.map.control_points, self._clusters
        rows = kernel_arguments.control_points(control_points)
        beside = slice(len(rows), None)
        q, p = clusters.q[beside], clusters.p[beside]
        stand_ins = np.zeros(len(q), rows.dtype)
        stand_ins["q"], stand_ins["c"] = q, clusters.weights[beside] / control_points.weights.mean()
        stand_ins["u"] = p - q - control_points.mean_displacement / control_points.scale
        tables = np.concatenate([rows, stand_ins]), control_points.kind.table(control_points, q)
        return [self.map.memory.constant(kernel_arguments.not_empty(table)) for table in tables]

    def _lists_of(self, grid, number):
        """How many cells a layer of blocks has in a grid; they, and their lists, in buffers."""
        first, cells = cells_of(grid)
        last = first + cells
        low, high = first // _ALONG, (last - 1) // _ALONG + 1
        axes = [np.arange(a, b) for a, b in zip(low[:2], high[:2])]
        j, i = np.meshgrid(*axes[::-1], indexing="ij")
        blocks = np.stack([i.ravel(), j.ravel(), np.full(i.size, number)], axis=1)
        spans, listed = self._lists(grid, blocks)
        inner = np.stack(np.meshgrid(*[np.arange(_ALONG)] * 3, indexing="ij"), -1).reshape(-1, 3)
        at = (_ALONG * blocks[:, None] + inner).reshape(-1, 3)
        here = np.all((at >= first) & (at < last), axis=1)
        x, y, z = (at[here] - first).T
        numbers = x + cells[0] * (y + cells[1] * z)
        of_cells = np.repeat(spans, _ALONG**3, axis=0)[here]
        memory = self.map.memory
        return len(numbers), [
            memory.constant(numbers.astype(np.int32)),
            *(memory.constant(np.ascontiguousarray(a)) for a in (of_cells, listed)),
        ]

    def _lists(self, grid, blocks):
        """Which rows of the tables count in `blocks` (b, 3) of the whole grid.

        Returns
        -------
        spans : (b, 2) int32
            First row in the list, and how many.
        listed : (k,) int32
        """
        whole, control_points = grid.whole, self.map.control_points
        ends = np.array(whole.dimensions) - 1
        looked_at = np.minimum(_BLOCK * blocks[:, None] + _LOOKED_AT, ends)
        local = control_points.local(whole.at(looked_at.reshape(-1, 3)))
        boxes = local.reshape(len(blocks), _GROUP, 3)[:, :8]  # the corners
        low, high = boxes.min(axis=1), boxes.max(axis=1)
        points = kernel_arguments.planes(local)
        exact = self._displacements("point_displacement", points)
        everything = np.arange(len(control_points), dtype=np.int32)
        spans = np.tile(np.array([0, len(everything)], np.int32), (len(blocks), 1))
        lists, length, rest = [everything], len(everything), np.arange(len(blocks))
        for relative_size in _RELATIVE_SIZES:
            numbers, stops = self._clusters.near(low[rest], high[rest], relative_size)
            starts = np.append(0, stops[:-1])
            found = np.stack([starts, stops - starts], axis=1).astype(np.int32)
            at = (_GROUP * rest[:, None] + np.arange(_GROUP)).ravel()
            here = np.ascontiguousarray(points[:, at])
            approximate = self._displacements("clustered_displacement", here, found, numbers)
            kept = self._is_close(grid, approximate - exact[:, at])
            spans[rest[kept]] = found[kept] + (length, 0)
            lists.append(numbers)
            length, rest = length + len(numbers), rest[~kept]
            if len(rest) == 0:
                break
        return spans, np.concatenate(lists)

    def _displacements(self, name, points, *lists):
        """Displacements (3, m) at `points` (3, m) of the local frame."""
        memory = self.map.memory
        if not lists:
            return self.map.at_local_points(name, 3, points)
        result, count = np.empty(points.shape, np.float32), points.shape[1]
        of_lists = [memory.constant(each) for each in lists]
        with memory.read(points) as read, memory.written(result) as out:
            self._launch(
                *(name, (None, False), count, (("POINTS_PER_LIST", _GROUP),)),
                *(*of_lists, np.int64(count), read, out),
            )
        return result

    def _is_close(self, grid, errors):
        """Which groups of points keep to the tolerance, by their errors (3, m)."""
        to_index = np.linalg.inv(grid.index_to_world) * self.map.control_points.scale
        far = np.linalg.norm(to_index @ errors, axis=0).reshape(-1, _GROUP).max(axis=1)
        return far <= self.map.deformation.map_tolerance / _SAFETY
