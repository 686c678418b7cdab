"""First guesses for searches over grids, from few nodes: origin_nodes.cl."""

import numpy as np
import pyopencl as cl

from vtk_mls.engine.launch import kernel_arguments
from vtk_mls.engine.launch.kernel_arguments import CONSTANTS, STRUCTS, filled
from vtk_mls.engine.map.cells import Box
from vtk_mls.engine.map.nodes import node_grid

NODE_STEP, NODE_SIZE = CONSTANTS["NODE_STEP"], STRUCTS["node_t"].itemsize
# Nodes computed at once, in whole layers; the next launch computes the last layer again.
_NODES = 1 << 18


class OriginNodes:
    """Origins at the nodes around points, in one region.

    Nodes are points of the whole grid, some beyond its end, so parts find the same ones. They are
    cached for the next launches. Their RegionMap, `map_`, owns them.
    """

    def __init__(self):
        self._grid = None

    def around(self, map_, grid, part):
        """Kernel arguments: the nodes around the points `part` of a grid."""
        nx, ny, _ = grid.dimensions
        low, high = (grid.first[2] + n // (nx * ny) for n in (part.start, part.stop - 1))
        if grid is not self._grid or not self._layers[0] <= low <= high < self._layers[1]:
            self._find(map_, grid, low, high)
        return self._arguments

    def _find(self, map_, grid, low, high):
        """Find the nodes around the layers `low` to `high` of a grid, and some later ones."""
        first = np.array(grid.first) // NODE_STEP
        last = (np.array(grid.first) + grid.dimensions - 1) // NODE_STEP + 1
        first[2], end = low // NODE_STEP, last[2]
        nx, ny, _ = last - first + 1
        launcher, deformation = map_.launcher, map_.deformation
        at_once = launcher.slabs(_NODES, deformation, NODE_SIZE)[0].stop
        last[2] = min(end, max(high // NODE_STEP + 1, first[2] - 1 + at_once // (nx * ny)))
        self._grid, self._layers = grid, (first[2] * NODE_STEP, last[2] * NODE_STEP)
        record = filled("nodes_t", first=first, nx=nx, ny=ny)
        nodes = node_grid(grid.whole, NODE_STEP, Box(first, last + 1))
        self._arguments = [record, _table(map_, nodes)]


def _table(map_, nodes):
    """A buffer with the origins at the `nodes`, a grid."""
    launcher, deformation, memory = map_.launcher, map_.deformation, map_.memory
    table = cl.Buffer(memory.context, cl.mem_flags.READ_WRITE, NODE_SIZE * nodes.size)
    for name, extra in (("node_origin", []), ("node_cell", [np.int32(nodes.size)])):
        for part in launcher.slabs(nodes.size, deformation, NODE_SIZE):
            points = kernel_arguments.grid_points(nodes, part, map_.control_points)
            count = part.stop - part.start
            map_.launch(name, (None, False), count, points, *extra, table)
    return table
