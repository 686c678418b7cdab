"""Boxes of cells between nodes of a grid, as arrays (nz, ny, nx) of bool."""

import itertools

import numpy as np

from vtk_mls.engine.launch.kernel_arguments import filled


class Box:
    """Cells from the index `first` (3,) along x, y, z up to `stop`: (nx, ny, nz) of them."""

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
