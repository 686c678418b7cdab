"""The map at nodes, every few points of a grid, and the check of interpolation between them."""

from __future__ import annotations

import numpy as np

from vtk_mls.base.grid import Grid
from vtk_mls.engine.launch import kernel_arguments
from vtk_mls.engine.launch.structs import CONSTANTS, filled
from vtk_mls.engine.map.cells import dilated

BEFORE, AFTER = 2, 3  # nodes around a cell, by which its points are interpolated
_SPARE = 64  # floats after the last node that kernels may read, but do not use
_FIRST = -4  # before all nodes


def node_grid(whole, step, box, offset=0):
    """Nodes at every `step`-th point of a whole grid, as a Grid.

    Node 0 is `offset` points after the first point of the grid, and the nodes are those of a Box.
    """
    first = box.first - _FIRST
    origin = whole.at([[offset + _FIRST * step] * 3])[0]
    every = Grid(first + box.cells, origin, step * whole.spacing, whole.direction)
    return every.part(first, box.cells)


def node_buffer(map_, count):
    """A buffer for the map at `count` nodes, in planes."""
    return map_.memory.pooled(4 * (_planes(map_) * int(count) + _SPARE))


def evaluated(map_, nodes):
    """A buffer with the map at all nodes."""
    table = node_buffer(map_, nodes.size)
    for part in map_.launcher.slabs(nodes.size, map_.deformation, 4 * _planes(map_)):
        _launch(map_, nodes, part, None, table)
    return table


def evaluate(map_, nodes, indices, table):
    """Evaluate the map at nodes by their `indices` (n,) int64, in a buffer for all nodes."""
    for part in map_.launcher.slabs(len(indices), map_.deformation, 8):
        listed = indices[part]
        with map_.memory.input_buffer(listed) as buffer:
            _launch(map_, nodes, slice(0, len(listed)), buffer, table)


def _launch(map_, nodes, part, listed, table):
    points = kernel_arguments.grid_points(nodes, part, map_.control_points)
    map_.launch(
        *("node_displacement", (None, False), part.stop - part.start, points),
        *(np.int64(nodes.size), listed, table),
    )


def _planes(map_):
    return 4 if map_.deformation.cuts else 3


def around(box):
    """The nodes around a box of cells, as members of a coarse_t."""
    return {"first_node": box.first, "nodes": box.cells + BEFORE + AFTER}


def launch_cells(map_, name, grid_and_pass, cells, *arguments, constants=()):
    """Launch a kernel for (nx, ny, nz) cells.

    Its work items take so many cells along x as others take points. Vectors of them take a band
    of cells along y.
    """
    lanes = dict(map_.launcher.sums(False))["LANES"]
    band = CONSTANTS["BAND_CELLS"] if lanes > 1 else 1
    nx, ny, nz = map(int, cells)
    count = -(-nx // lanes) * lanes * -(-ny // band) * nz
    map_.launch(name, grid_and_pass, count, *arguments, constants=constants)


def check_of(map_, grid, safety):
    """The check_t of cells: errors in their middles are at most the tolerance over `safety`."""
    to_index = grid.world_to_index * map_.control_points.scale
    return filled(
        "check_t",
        to_index=kernel_arguments.transform(to_index, np.zeros(3)),
        limit2=(map_.deformation.map_tolerance / safety) ** 2,
    )


def inaccurate(flags):
    """Which cells are inaccurate by their flags of coarse_check.cl or those of neighbors."""
    own, spreads = (flags & CONSTANTS[name] for name in ("INACCURATE", "SPREADS"))
    return (own | dilated(spreads)) != 0


def check_flags(map_, grid, box, check, members, table, middles, sure=None):
    """Flags of coarse_check.cl for the cells of a box (nz, ny, nx).

    `members` are those of a coarse_t for the nodes of `table`. Cells that are `sure` have none.
    """
    points = kernel_arguments.grid_points(grid, slice(0, grid.size), map_.control_points)
    flags = np.zeros(box.shape, np.uint8)
    with map_.memory.output_buffer(flags) as out:
        launch_cells(
            *(map_, "coarse_check", (grid.whole, False), box.cells, points),
            *(box.record(**members), check, table, middles, sure, out),
        )
    return flags
