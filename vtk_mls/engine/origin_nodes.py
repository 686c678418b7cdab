"""First guesses for searches over grids and many points, from few nodes: origin_nodes.cl."""

from __future__ import annotations

import numpy as np
import pyopencl as cl

from vtk_mls import guesses
from vtk_mls.engine import kernel_arguments
from vtk_mls.engine.kernel_arguments import NODE_BYTES, NODE_STEP
from vtk_mls.grid import Grid
from vtk_mls.linear_algebra import transformed

# Nodes that are found at once, in whole layers: what follows needs the last layer again.
_NODES = 1 << 18
# On no grid so many points are worth nodes, and so many of them: more do not stay in a CPU's cache.
_MANY, _NODES_OVER = 1 << 17, 1 << 13
_AFFINE = 1e-6  # local units: a residual of the affine map that is none


class OriginNodes:
    """Where the material at the nodes around points comes from, in one region.

    Nodes are points of the whole grid, some beyond its end: parts find the same ones. They are kept
    for the launches that follow.

    Parameters
    ----------
    map_ : RegionMap
    """

    def __init__(self, map_):
        self.map = map_
        self._grid = None

    def around(self, grid, part):
        """Kernel arguments: the nodes around the points `part` of a grid."""
        nx, ny, _ = grid.dimensions
        low, high = (grid.first[2] + n // (nx * ny) for n in (part.start, part.stop - 1))
        if grid is not self._grid or not self._layers[0] <= low <= high < self._layers[1]:
            self._find(grid, low, high)
        return self._arguments

    def _find(self, grid, low, high):
        """Find the nodes around the layers `low` to `high` of a grid, and some that follow."""
        first = np.array(grid.first) // NODE_STEP
        last = (np.array(grid.first) + grid.dimensions - 1) // NODE_STEP + 1
        first[2], end = low // NODE_STEP, last[2]
        nx, ny, _ = last - first + 1
        launcher, deformation = self.map.launcher, self.map.deformation
        at_once = launcher.slabs(_NODES, deformation, NODE_BYTES)[0].stop
        last[2] = min(end, max(high // NODE_STEP + 1, first[2] - 1 + at_once // (nx * ny)))
        self._grid, self._layers = grid, (first[2] * NODE_STEP, last[2] * NODE_STEP)
        record = kernel_arguments.filled(kernel_arguments.NODES, first=first, nx=nx, ny=ny)
        self._arguments = [record, self._table(_every(grid.whole, first, last))]

    def over(self, points):
        """Kernel arguments: nodes over `points` (m, 3) of the world; None if they are not worth it.

        They are not for few points, nor where searches end at once anyway.
        """
        if len(points) < _MANY or _is_affine(self.map.control_points):
            return None
        box = guesses.usual_bounds(points, guesses.bounds(points))
        nodes = guesses.cubic_grid(box, _NODES_OVER)
        control_points = self.map.control_points
        record = kernel_arguments.filled(
            kernel_arguments.GUESS,
            dimensions=nodes.dimensions,
            low=control_points.local(nodes.origin),
            density=control_points.scale / nodes.spacing,
        )
        return [record, self._table(nodes)]

    def _table(self, nodes):
        """A buffer with what is found at the `nodes`, a grid."""
        launcher, deformation, memory = self.map.launcher, self.map.deformation, self.map.memory
        table = cl.Buffer(memory.context, cl.mem_flags.READ_WRITE, NODE_BYTES * nodes.size)
        for name, extra in (("node_origin", []), ("node_cell", [np.int32(nodes.size)])):
            for part in launcher.slabs(nodes.size, deformation, NODE_BYTES):
                points = kernel_arguments.grid_points(nodes, part, self.map.control_points)
                count = part.stop - part.start
                self.map.launch(name, (None, False), count, points, *extra, table)
        return table


def _is_affine(control_points):
    """Whether an affine map, from which searches begin, fits all control points."""
    matrix, offset = control_points.affine
    residual = transformed(matrix, control_points.deformed) + offset - control_points.rest
    return np.abs(residual).max(initial=0) <= _AFFINE * control_points.scale


def _every(whole, first, last):
    """The nodes `first` to `last` (3,) of a grid, as part of a grid of all nodes."""
    nodes = Grid(last + 1, whole.origin, NODE_STEP * whole.spacing, whole.direction)
    return nodes.part(first, last - first + 1)
