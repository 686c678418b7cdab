"""The map of a grid, interpolated between nodes where that is accurate: coarse_map.cl."""

from __future__ import annotations

import numpy as np
import pyopencl as cl

from vtk_mls.base.grid import Grid
from vtk_mls.engine.launch import kernel_arguments
from vtk_mls.engine.launch.structs import CONSTANTS, filled
from vtk_mls.engine.map import fine_map
from vtk_mls.engine.map.cells import Box, ListedCells, dilated, near_handles
from vtk_mls.engine.map.fine_map import Checked, FineMap

STEP = CONSTANTS["COARSE_STEP"]
_AROUND = range(-2, 4)  # the nodes around a cell, by which its points are interpolated
# Largest ratio of an error in a cell to those in its middle and in the middles of its neighbors:
# 6.5 in the worst of 2,100 random sets.
_SAFETY = 8
MAX_NODE_FRACTION = 0.25  # nodes and cell centers per point of the grid
MAX_NEAR_FRACTION = 0.5  # of the cells, with control points in or beside them
_SPARE = 64  # floats after the last node that kernels may read, but do not use
# The kernel that interpolates the outputs of another one.
_COARSE = {
    "grid_displacement": "coarse_displacement",
    "grid_source_index": "coarse_source_index",
    "grid_covariant": "coarse_covariant",
}


class CoarseMap:
    """The map of a region at nodes over a grid, and the cells that are interpolated accurately.

    Nodes and cells are those of the whole grid, and some beyond its end, so parts find the same.

    Parameters
    ----------
    map_ : RegionMap
    """

    def __init__(self, map_):
        self.map = map_
        self._grid = None
        self._pays_off = {}  # by whole grid
        self._fine_map = FineMap(map_) if FineMap.pays_off(map_.deformation) else None

    def pays_off(self, grid):
        """Whether a grid has far fewer nodes, and cells near control points, than points."""
        whole = grid.whole
        if whole not in self._pays_off:
            self._pays_off[whole] = self._has_few_nodes(whole) and self._has_few_near_cells(whole)
        return self._pays_off[whole]

    def _has_few_nodes(self, whole):
        cells = cells_of(whole)[1]
        return (np.prod(cells + 5.0) + np.prod(cells)) / whole.size < MAX_NODE_FRACTION

    def _has_few_near_cells(self, whole):
        handles = self.map.control_points.handles
        count = len(handles) if len(handles.segments) == 0 else np.inf
        bound = 27 * count / np.prod(cells_of(whole)[1])
        if bound < MAX_NEAR_FRACTION:
            return True
        return near_handles(self.map, whole, _box_of(whole), STEP).mean() < MAX_NEAR_FRACTION

    def launch(self, name, grid, part, *arguments, constants=()):
        """Launch a kernel for the points `part` of a grid.

        It computes the points of inaccurate cells, after another kernel has interpolated those of
        all cells. Both take the `arguments`.
        """
        if grid is not self._grid:
            self._find(grid)
            self._grid = grid
        points = kernel_arguments.grid_points(grid, part, self.map.control_points)
        first, cells = cells_of(grid)
        nx, ny, _ = grid.dimensions
        low, high = ((grid.first[2] + n // (nx * ny)) // STEP for n in (part.start, part.stop - 1))
        grid_and_pass = (grid.whole, False)
        block = dict(first_cell=[*first[:2], low], cells=[*cells[:2], high - low + 1])
        to_local = grid.index_to_world / self.map.control_points.scale
        to_slopes = kernel_arguments.transform(np.linalg.inv(to_local).T, np.zeros(3))
        record = filled("coarse_t", **block, **self._around, to_slopes=to_slopes)
        self._launch_blocks(
            *(_COARSE[name], grid_and_pass, block, points, record, self._nodes, *arguments),
            constants=constants,
        )
        layers = slice(low - first[2], high + 1 - first[2])
        is_fine = self._fine_map and name in fine_map.KERNELS
        if is_fine:
            self._fine_map.launch(name, grid, part, layers, points, *arguments)
        listed = self._separated if is_fine else self._inaccurate
        for record in listed.records(layers):
            items = self.map.grid_items(grid, part, record, listed.buffer)
            count = int(record["listed"]) * STEP**3
            self.map.launch(
                *(name, grid_and_pass, count, points, *items, *arguments),
                constants=(*constants, ("POINTS", "CELLS")),
            )

    def _launch_blocks(self, name, grid_and_pass, block, *arguments, constants=()):
        """Launch a kernel whose work items take so many cells along x as others take points.

        Vectors of them take a band of cells along y.
        """
        lanes = dict(self.map.launcher.sums(False))["LANES"]
        band = CONSTANTS["BAND_CELLS"] if lanes > 1 else 1
        nx, ny, nz = map(int, block["cells"])
        count = -(-nx // lanes) * lanes * -(-ny // band) * nz
        self.map.launch(name, grid_and_pass, count, *arguments, constants=constants)

    def _find(self, grid):
        """Find the nodes around a grid, and its inaccurate cells."""
        own, every, memory = _box_of(grid), _box_of(grid.whole), self.map.memory
        margin = FineMap.MARGIN if self._fine_map else 1  # cells around it are checked, too
        box = own.widened(margin, margin).within(every)
        self._around = {"first_node": box.first, "nodes": box.cells + len(_AROUND) - 1}
        self._nodes = self._at_nodes(grid, box.first, self._around["nodes"], _AROUND[0] * STEP)
        middles = self._at_nodes(grid, box.first, box.cells, STEP / 2)
        to_index = grid.world_to_index * self.map.control_points.scale
        check = filled(
            "check_t",
            to_index=kernel_arguments.transform(to_index, np.zeros(3)),
            limit2=(self.map.deformation.map_tolerance / _SAFETY) ** 2,
        )
        flags = self._check(grid, box, check, middles)
        is_inaccurate, is_separated, is_other_region, is_rough = (
            (flags & CONSTANTS[name]).astype(bool)
            for name in ("INACCURATE", "SEPARATED", "OTHER_REGION", "ROUGH")
        )
        near = near_handles(self.map, grid.whole, box, STEP)
        inaccurate = dilated(is_inaccurate) | near
        rows = box.rows(own)
        self._inaccurate = ListedCells(memory, own, (inaccurate & ~is_other_region)[rows])
        if self._fine_map:
            separated = inaccurate & dilated(is_separated)
            self._separated = ListedCells(memory, own, (separated & ~is_other_region)[rows])
            around = {**self._around, "first_node": box.first + _AROUND[0]}
            checked = Checked(box, own, every, around, self._nodes, middles, check)
            refinable = inaccurate & ~separated & ~is_other_region
            self._fine_map.find(grid, checked, inaccurate, refinable, dilated(is_rough | near))

    def _check(self, grid, box, check, middles):
        """Flags of coarse_check.cl for the cells of a box (nz, ny, nx)."""
        record = box.record(**self._around)
        block = {"first_cell": box.first, "cells": box.cells}
        points = kernel_arguments.grid_points(grid, slice(0, grid.size), self.map.control_points)
        flags = np.empty(box.shape, np.uint8)
        with self.map.memory.output_buffer(flags) as out:
            self._launch_blocks(
                *("coarse_check", (grid.whole, False), block, points, record, check),
                *(self._nodes, middles, out),
            )
        return flags

    def _at_nodes(self, grid, first, dimensions, start):
        """A buffer with the map at every STEP-th point of the whole grid from `start` on.

        Of these the `dimensions` from `first` on.
        """
        whole, map_ = grid.whole, self.map
        every = Grid(
            first + dimensions, whole.at([[start] * 3])[0], STEP * whole.spacing, whole.direction
        )
        nodes = every.part(first, dimensions)
        planes = 4 if map_.deformation.cuts else 3
        size = 4 * (planes * nodes.size + _SPARE)
        table = cl.Buffer(map_.memory.context, cl.mem_flags.READ_WRITE, size)
        for part in map_.launcher.slabs(nodes.size, map_.deformation, 4 * planes):
            points = kernel_arguments.grid_points(nodes, part, map_.control_points)
            count = part.stop - part.start
            map_.launch(
                *("node_displacement", (None, False), count, points, np.int64(nodes.size)),
                *(None, table),
            )
        return table


def _box_of(grid):
    first, cells = cells_of(grid)
    return Box(first, first + cells)


def cells_of(grid):
    """The first cell that a grid's points are in, and how many, along each axis: (3,) ints."""
    first = np.array(grid.first) // STEP
    last = (np.array(grid.first) + grid.dimensions - 1) // STEP
    return first, last - first + 1
