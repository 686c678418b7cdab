"""The map of a grid where many control points are: those far away count by clusters."""

from __future__ import annotations

import functools
import itertools

import numpy as np

from vtk_mls.clusters import Clusters
from vtk_mls.engine import kernel_arguments
from vtk_mls.engine.coarse_map import CONSTANTS, STEP, cells_of
from vtk_mls.linear_algebra import transformed

# A block is so many cells of coarse_map.cl along each axis; its points have a list in common.
_ALONG = 2
_BLOCK = _ALONG * STEP
# How large clusters may be next to their distance: at first, and at least. Errors fall with the
# third power of it, so that those of one try say how large it may be in the next.
_RELATIVE_SIZE = 0.5
_LEAST = 0.12  # below, all control points of the block count
_STEPS = 0.5, 0.9  # from try to try at most and at least
# Times that errors may be larger than at the points of a block that are looked at: 2.8 times in the
# worst of 6,000 blocks.
_SAFETY = 3
_SAFETY_OF_CUBICS = 6  # of maps with more functions than those of degree 2: 4.3 times
_QUADRATICS = 9
_MANY = 1 << 11  # control points, from which on lists are much shorter
LISTED = 3000  # for a block, as a rule
# Beyond, a few control points outweigh all others, and what those tell of the twist about them is
# less than the error of a cluster.
_LARGEST_ALPHA = 1.5
# Points that are looked at: the corners of a block, the middles of its edges and faces, and its own
# (so often that they fill the lanes). The exact map at what is its neighbours', too, is found once.
_REGULAR = list(itertools.product((0, 4, 8), repeat=3))
_LOOKED_AT = np.array(_REGULAR + 5 * [(4, 4, 4)])
# Where displacements change from one of these to the next by more than so many times their distance
# all control points count: at folds and jumps errors between them were up to 40 times larger.
_STEEPEST = 2
_GROUP = len(_LOOKED_AT)
_EXACT = 10  # for which the exact map is found, of each block, about
_TOGETHER = 512  # blocks whose lists are found at a time


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
        self._last = None  # of the last launch: the grid, layers of blocks in it, their lists

    def share(self, grid):
        """The share of a grid's control points that count, about; 1 if it is not worth it."""
        control_points = self.map.control_points
        is_thin = min(grid.whole.dimensions) < _BLOCK
        if is_thin or not has_clusters(self.map.deformation, control_points):
            return 1.0
        return LISTED / len(control_points) + _EXACT / _BLOCK**3

    def launch(self, name, grid, part, between, *arguments):
        """Launch a kernel for the points `part` of a grid, a few layers of blocks at a time."""
        points = kernel_arguments.grid_points(grid, part, self.map.control_points)
        first, cells = cells_of(grid)
        nx, ny, _ = grid.dimensions
        low, high = (
            (grid.first[2] + n // (nx * ny)) // _BLOCK for n in (part.start, part.stop - 1)
        )
        for layers in _layers_of(grid):
            if layers.stop <= low or layers.start > high:
                continue
            if self._last is None or self._last[:2] != (grid, layers):
                self._last = None  # before there are two
                self._last = grid, layers, *self._lists_of(grid, layers)
            _, _, count, listed = self._last
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

    def _lists_of(self, grid, layers):
        """How many cells layers of blocks have in a grid; they, and their lists, in buffers."""
        first, cells = cells_of(grid)
        last = first + cells
        low, high = _blocks_of(grid)
        axes = [np.arange(a, b) for a, b in zip(low[:2], high[:2])]
        k, j, i = np.meshgrid(layers, *axes[::-1], indexing="ij")
        blocks = np.stack([i.ravel(), j.ravel(), k.ravel()], axis=1)
        spans, listed = self._lists_by_parts(grid, blocks)
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

    def _lists_by_parts(self, grid, blocks):
        """What `_lists` says of `blocks` (b, 3), found for some at a time."""
        spans, listed, length = [], [], 0
        for first in range(0, len(blocks), _TOGETHER):
            own, rows = self._lists(grid, blocks[first : first + _TOGETHER])
            spans.append(own + np.array([length, 0], np.int32))
            listed.append(rows)
            length += len(rows)
        return np.concatenate(spans), np.concatenate(listed)

    def _lists(self, grid, blocks):
        """Which rows of the tables count in `blocks` (b, 3) of the whole grid.

        Returns
        -------
        spans : (b, 2) int32
            First row in the list, and how many.
        listed : (k,) int32
        """
        points, exact, low, high = self._looked_at(grid.whole, blocks)
        everything = np.arange(len(self.map.control_points), dtype=np.int32)
        spans = np.tile(np.array([0, len(everything)], np.int32), (len(blocks), 1))
        lists, length = [everything], len(everything)
        rest = np.flatnonzero(self._steepness(grid, exact) <= _STEEPEST)
        relative_size = np.full(len(blocks), _RELATIVE_SIZE)
        while len(rest):
            numbers, stops = self._clusters.near(low[rest], high[rest], relative_size[rest])
            counts = np.diff(stops, prepend=0)
            found = np.stack([stops - counts, counts], axis=1).astype(np.int32)
            at = (_GROUP * rest[:, None] + np.arange(_GROUP)).ravel()
            here = np.ascontiguousarray(points[:, at])
            approximate = self._with_lists(here, found, numbers)
            errors = self._errors(grid, approximate - exact[:, at])
            is_close = errors <= 1
            lists.append(numbers[np.repeat(is_close, counts)])
            counts = counts[is_close]
            starts = length + np.cumsum(counts) - counts
            spans[rest[is_close]] = np.stack([starts, counts], axis=1)
            length += len(lists[-1])
            relative_size[rest] *= np.clip(np.cbrt(1 / np.maximum(errors, 1)), *_STEPS)
            rest = rest[~is_close]
            rest = rest[relative_size[rest] >= _LEAST]
        return spans, np.concatenate(lists)

    def _looked_at(self, whole, blocks):
        """Where `blocks` (b, 3) of a grid are looked at.

        Returns
        -------
        points, exact : (3, b * _GROUP) float32, local frame
            Those of one block after those of the other, and their displacements.
        low, high : (b, 3) float64, local frame
            Corners of the boxes around them.
        """
        ends = np.array(whole.dimensions) - 1
        index = np.minimum(_BLOCK * blocks[:, None] + _LOOKED_AT, ends).reshape(-1, 3)
        numbers = index @ np.cumprod([1, *whole.dimensions[:2]])
        _, once, which = np.unique(numbers, return_index=True, return_inverse=True)
        local = self.map.control_points.local(whole.at(index[once]))
        points = kernel_arguments.planes(local)
        exact = np.empty_like(points)
        memory, count = self.map.memory, points.shape[1]
        with memory.read(points) as read, memory.written(exact) as out:
            self.map.launch("point_displacement", (None, False), count, np.int64(count), read, out)
            memory.queue.flush()
            _ = self._tables  # made meanwhile
        boxes = local[which].reshape(len(blocks), _GROUP, 3)
        return points[:, which], exact[:, which], boxes.min(axis=1), boxes.max(axis=1)

    def _with_lists(self, points, spans, numbers):
        """Displacements (3, m) at `points` (3, m) of the local frame, each _GROUP with a list."""
        memory, count = self.map.memory, points.shape[1]
        result = np.empty_like(points)
        lists = [memory.constant(each) for each in (spans, numbers)]
        with memory.read(points) as read, memory.written(result) as out:
            self._launch(
                *("clustered_displacement", (None, False), count),
                *((("POINTS_PER_LIST", _GROUP),), *lists, np.int64(count), read, out),
            )
        return result

    def _errors(self, grid, errors):
        """Largest of each group of errors (3, m), as multiples of what keeps to the tolerance."""
        control_points = self.map.control_points
        is_cubic = control_points.kind.functions(control_points) > _QUADRATICS
        safety = _SAFETY_OF_CUBICS if is_cubic else _SAFETY
        limit = self.map.deformation.map_tolerance / safety
        in_voxels = transformed(self._to_index(grid), errors.T).T
        return np.linalg.norm(in_voxels, axis=0).reshape(-1, _GROUP).max(axis=1) / limit

    def _steepness(self, grid, displacements):
        """How fast `displacements` (3, m) change in each group at most, voxels a voxel."""
        in_voxels = transformed(self._to_index(grid), displacements.T).T.reshape(3, -1, _GROUP)
        regular = in_voxels[:, :, : len(_REGULAR)].reshape(3, -1, 3, 3, 3)
        changes = [np.diff(regular, axis=axis) for axis in (2, 3, 4)]
        fastest = [np.linalg.norm(each, axis=0).max(axis=(1, 2, 3)) for each in changes]
        return np.max(fastest, axis=0) / STEP

    def _to_index(self, grid):
        """(3, 3): from the local frame to indices of a grid."""
        return grid.world_to_index * self.map.control_points.scale


def _blocks_of(grid):
    """The first block that a grid's points are in, and the one after the last: (3,) ints each."""
    first, cells = cells_of(grid)
    return first // _ALONG, (first + cells - 1) // _ALONG + 1


def _layers_of(grid):
    """Ranges of layers of blocks, whose lists are on the device together."""
    (*_, low), (*_, high) = first, stop = _blocks_of(grid)
    step = int(max(1, _TOGETHER // np.prod((stop - first)[:2])))
    return [range(k, min(k + step, high)) for k in range(low, high, step)]
