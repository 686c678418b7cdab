"""A finer map in cells where the coarse one is inaccurate: fine_map.cl."""

from __future__ import annotations

import itertools
from typing import NamedTuple

import numpy as np
import pyopencl as cl

from vtk_mls.engine.launch import kernel_arguments
from vtk_mls.engine.launch.structs import CONSTANTS
from vtk_mls.engine.map import nodes
from vtk_mls.engine.map.cells import Box, ListedCells, dilated, dilated_by, doubled, near_handles

FINE_STEP = CONSTANTS["FINE_STEP"]
_RATIO = CONSTANTS["COARSE_STEP"] // FINE_STEP
_PLACES = 8  # points of a fine cell, fine nodes of a coarse cell
_MIN_STEPS = 4  # of a deformation, from which on maps are so slow that the finer one pays off
# The kernel that interpolates the outputs of another one.
KERNELS = {"grid_displacement": "fine_displacement", "grid_source_index": "fine_source_index"}
_CONSTANTS = (("POINTS", "CELLS"), ("CELL_STEP", "FINE_STEP"))


class Checked(NamedTuple):
    """The cells of a coarse map that are checked, for a grid.

    Attributes
    ----------
    box, grid_box, every : Box
        Those checked, those of the grid, and those of the whole grid.
    nodes : dict
        Members of a coarse_t: `first_node`, `nodes`.
    node_planes, middles : Buffer
        The map at nodes, and in the middles of the cells checked.
    sure : Buffer or None
        Which of these are known to be accurate and have no middle.
    check : check_t
    """

    box: Box
    grid_box: Box
    every: Box
    nodes: dict
    node_planes: cl.Buffer
    middles: cl.Buffer
    sure: cl.Buffer | None
    check: np.ndarray


class FineMap:
    """The map of a region at nodes twice as dense as those of a CoarseMap, where it is inaccurate.

    Cells that are inaccurate here, too, are computed exactly. Nodes that the coarse map has, or
    interpolates accurately, are not evaluated again.

    Parameters
    ----------
    map_ : RegionMap
    """

    # Cells around a grid that the coarse map checks, so that parts find the same nodes. Those three
    # away from a grid have some, which are interpolated unless a cell beside them is inaccurate.
    MARGIN = 4

    def __init__(self, map_):
        self.map = map_

    @staticmethod
    def pays_off(deformation):
        """Whether points of the map take much longer than interpolation."""
        return deformation.steps_used >= _MIN_STEPS

    def find(self, grid, coarse, inaccurate, refinable, rough):
        """Find the nodes and cells of a grid.

        Parameters
        ----------
        grid : Grid
        coarse : Checked
        inaccurate, refinable, rough : arrays (nz, ny, nx) of bool
            Which of the checked cells are inaccurate, which of these the finer map is for, and
            where it must be checked, too.
        """
        box, every = coarse.grid_box, coarse.every
        refined_box = box.widened(1, 1).within(every)
        refined = refinable[coarse.box.rows(refined_box)]
        self._find_nodes(grid, coarse, inaccurate, refined_box, refined)
        checked, cells = refined_box.scaled(_RATIO), doubled(refined)
        unsure = cells & doubled(rough[coarse.box.rows(refined_box)])
        listed = ListedCells(self.map.memory, checked, unsure, **self._nodes)
        inaccurate = np.zeros(checked.shape, bool)
        inaccurate[unsure] = self._check(grid, coarse, listed)
        box = box.scaled(_RATIO)
        rows = checked.rows(box)
        is_exact = dilated(inaccurate)[rows] | near_handles(self.map, grid.whole, box, FINE_STEP)
        self._between = ListedCells(self.map.memory, box, cells[rows] & ~is_exact, **self._nodes)
        self._exact = ListedCells(self.map.memory, box, cells[rows] & is_exact)

    def launch(self, name, grid, part, layers, points, *arguments):
        """Launch a kernel for the points `part` of a grid, in the `layers` of coarse cells.

        It computes those of inaccurate cells; another kernel interpolates those of the others.
        """
        layers = slice(_RATIO * layers.start, _RATIO * layers.stop)
        for record in self._between.records(layers):
            self._launch(
                *(KERNELS[name], grid, record, points, record, self._between.buffer),
                *(self._planes, *arguments),
            )
        for record in self._exact.records(layers):
            items = self.map.grid_items(grid, part, record, self._exact.buffer)
            self._launch(name, grid, record, points, *items, *arguments)

    def _launch(self, name, grid, record, *arguments):
        count = int(record["listed"]) * _PLACES
        self.map.launch(name, (grid.whole, False), count, *arguments, constants=_CONSTANTS)

    def _find_nodes(self, grid, coarse, inaccurate, refined_box, refined):
        """Find the nodes that interpolate in `refined` cells of a box."""
        map_ = self.map
        cells = refined_box.widened(1, 2)  # that have such nodes
        inside = cells.within(coarse.every)
        rows, checked = cells.rows(inside), coarse.box.rows(inside)
        is_inaccurate, is_checked = np.ones(cells.shape, bool), np.zeros(cells.shape, bool)
        is_inaccurate[rows], is_checked[rows] = inaccurate[checked], True
        used = _used_nodes(np.pad(refined, [(1, 2)] * 3))
        box = cells.scaled(_RATIO)
        is_evaluated = np.zeros(box.shape, bool)
        for place, has_node in used.items():
            is_exact = is_checked & (sum(place) in (0, 3))  # a coarse node, or a middle
            every = tuple(slice(k, None, _RATIO) for k in place)
            is_evaluated[every] = has_node & is_inaccurate & ~is_exact
        self._nodes = {"first_node": box.first, "nodes": box.cells}
        self._planes = nodes.node_buffer(map_, np.prod(box.cells))
        has_nodes = np.zeros(coarse.box.shape, bool)
        has_nodes[checked] = np.logical_or.reduce(list(used.values()))[rows]
        listed = ListedCells(map_.memory, coarse.box, has_nodes, **coarse.nodes)
        count = len(listed.indices)
        if count == 0:
            return
        map_.launch(
            *("fine_node", (None, False), count * _PLACES, listed.record(slice(0, count))),
            *(listed.buffer, coarse.node_planes, coarse.middles, coarse.sure),
            *(box.record(**self._nodes), self._planes),
        )
        node_grid = nodes.node_grid(grid.whole, FINE_STEP, box)
        nodes.evaluate(map_, node_grid, np.flatnonzero(is_evaluated), self._planes)

    def _check(self, grid, coarse, listed):
        """Which of listed fine cells are inaccurate in the middle: (n,) bool."""
        count = len(listed.indices)
        flags = np.empty(count, np.uint8)
        points = kernel_arguments.grid_points(grid, slice(0, grid.size), self.map.control_points)
        for part in self.map.launcher.slabs(count, self.map.deformation, 1):
            record = listed.record(part)
            with self.map.memory.output_buffer(flags[part]) as out:
                self.map.launch(
                    *("fine_check", (grid.whole, False), part.stop - part.start, points, record),
                    *(listed.buffer, self._planes, coarse.check, out),
                )
        return (flags & CONSTANTS["INACCURATE"]).astype(bool)


def _used_nodes(refined):
    """Which fine nodes interpolate in `refined` cells, by their place (z, y, x) in a cell."""
    ranges = (-1, 3), (-1, 2)  # a cell uses fine nodes from two before its first to four after it
    return {
        place: dilated_by(refined, [ranges[k] for k in place])
        for place in itertools.product((0, 1), repeat=3)
    }
