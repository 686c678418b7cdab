"""The map at nodes, every few points of a grid."""

import numpy as np

from vtk_mls.base.grid import Grid
from vtk_mls.engine.launch import kernel_arguments
from vtk_mls.engine.launch.kernel_arguments import CONSTANTS

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


def evaluated(map_, nodes, spacing):
    """A buffer with the map at nodes, in planes, for a grid with a `spacing` (3,)."""
    planes = 4 if map_.deformation.cuts else 3
    table = map_.memory.pooled(4 * (planes * int(nodes.size) + _SPARE))
    for part in map_.launcher.slabs(nodes.size, map_.deformation, 4 * planes):
        points = kernel_arguments.grid_points(nodes, part, map_.control_points)
        count = part.stop - part.start
        arguments = points, np.int64(nodes.size), table
        map_.launch("node_displacement", (None, False), count, *arguments, spacing=spacing)
    return table


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
