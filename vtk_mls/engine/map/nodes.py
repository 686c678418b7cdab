"""Nodes every few points of a grid: the map there, first guesses of searches, and cells between."""

import itertools

import numpy as np
import pyopencl as cl

from vtk_mls.base.grid import Grid
from vtk_mls.engine.launch import kernel_arguments
from vtk_mls.engine.launch.kernel_arguments import CONSTANTS, STRUCTS, filled

BEFORE, AFTER = 2, 3  # nodes around a cell, by which its points are interpolated
_SPARE = 64  # floats after the last node that kernels may read, but do not use
_FIRST = -4  # before all nodes
# Of the nodes of first guesses: points between them, and bytes of each.
NODE_STEP, NODE_SIZE = CONSTANTS["NODE_STEP"], STRUCTS["node_t"].itemsize
# Those computed at once, in whole layers; the next launch computes the last layer again.
_NODES = 1 << 18


class Box:
    """Cells between nodes, from the index `first` (3,) along x, y, z up to `stop`: (nx, ny, nz)."""

    def __init__(self, first, stop):
        self.first, self.stop = np.asarray(first), np.asarray(stop)
        self.cells = self.stop - self.first

    @property
    def shape(self):
        """(nz, ny, nx)."""
        return tuple(self.cells[::-1])

    def widened(self, before, after):
        """A box with more cells along each axis."""
        return Box(self.first - before, self.stop + after)

    def within(self, other):
        """The cells that are in another box, too."""
        return Box(np.maximum(self.first, other.first), np.minimum(self.stop, other.stop))

    def rows(self, inner):
        """The slices of another box in arrays of this one."""
        begin, end = inner.first - self.first, inner.stop - self.first
        return tuple(slice(a, b) for a, b in zip(begin[::-1], end[::-1]))

    def record(self, **members):
        """A coarse_t with this box as its cells."""
        return filled("coarse_t", first_cell=self.first, cells=self.cells, **members)


def box_of(grid, step):
    """The cells of `step` points of the whole grid that a grid's points are in."""
    first = np.array(grid.first)
    return Box(first // step, (first + grid.dimensions - 1) // step + 1)


class ListedCells:
    """Cells of a box where `mask` (nz, ny, nx) is true, in the order of memory.

    Kernels compute these only; `buffer` has their indices, int32.
    """

    def __init__(self, memory, box, mask):
        self.box = box
        self._indices = np.flatnonzero(mask).astype(np.int32)
        self.buffer = memory.constant(np.append(self._indices, np.int32(0)))  # never empty

    def records(self, layers):
        """A coarse_t with the cells in a slice of layers along z; none without cells."""
        layer = self.box.cells[0] * self.box.cells[1]
        a, b = np.searchsorted(self._indices, [layers.start * layer, layers.stop * layer])
        return [self.box.record(first_listed=a, listed=b - a)] if a < b else []


def near_handles(map_, whole, box, step):
    """Which cells of `step` points have a handle, or a neighbor that has one.

    Peaks and kinks there may be narrower than the distance of nodes.
    """
    near = np.zeros(box.shape, bool)
    handles = map_.control_points.handles
    places = [handles.deformed, *handles.segments.every(step * min(whole.spacing))]
    at = whole.index_of(np.concatenate(places)) // step
    around = np.array(list(itertools.product((-1, 0, 1), repeat=3)))
    cells = (at[:, None] + around - box.first).reshape(-1, 3)
    inside = np.all((cells >= 0) & (cells < box.cells), axis=1)
    near[tuple(cells[inside].astype(int).T[::-1])] = True
    return near


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
    lanes = map_.launcher.device.lanes
    band = CONSTANTS["BAND_CELLS"] if lanes > 1 else 1
    nx, ny, nz = map(int, cells)
    count = -(-nx // lanes) * lanes * -(-ny // band) * nz
    map_.launch(name, grid_and_pass, count, *arguments, constants=constants)


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
        table = cl.Buffer(map_.memory.context, cl.mem_flags.READ_WRITE, NODE_SIZE * nodes.size)
        for name, extra in (("node_origin", []), ("node_cell", [np.int32(nodes.size)])):
            for part in launcher.slabs(nodes.size, deformation, NODE_SIZE):
                points = kernel_arguments.grid_points(nodes, part, map_.control_points)
                map_.launch(name, (None, False), part.stop - part.start, points, *extra, table)
        self._arguments = [record, table]
