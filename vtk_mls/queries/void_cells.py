"""Voids that cuts have opened in the cells between the points of a grid.

A cell is void if its center is: if the void distance there is negative. `classify_cells` finds them
in two passes. `by_corners` decides cells that are far from every face of a void, from the void
distances at their corners; a device runs it as opencl/grid/void_by_corners.cl. The map is evaluated
at the centers of the others (`Engine.void_distance_listed`). The public method is
`Transform.void_of_cells`; filters/image_resampling.py stores the result as the cell array "Void".

The cell array "Void" of meshes has another meaning: a cell that a cut tears (filters/warping.py).
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

# Bits of a cell, from its corners: its center is void; a corner is void; the center is unknown.
VOID, TOUCHED, UNKNOWN = 1, 2, 4
# A cell is far from every face if its corners are farther than FAR times their differences, in the
# cell and its neighbors, and than its mapped diagonal. Differences alone would fail for corners
# placed symmetrically about one void or two. (The largest ratio found in 10,800 random scenes with
# 270 million cells was 3.3.)
FAR = 4
MAX_SLAB_CELLS = 1 << 22  # searched at once for cells that need the map
_ENDS = slice(None, -1), slice(1, None)


class VoidCells(NamedTuple):
    """Voids in each of the `Grid.cells` of a grid: (nz, ny, nx) bool.

    Attributes
    ----------
    at_center : array of bool
        Whether the center of the cell is void.
    touched : array of bool
        Whether a corner of the cell is void.
    """

    at_center: NDArray[np.bool_]
    touched: NDArray[np.bool_]

    @property
    def at_centre(self) -> NDArray[np.bool_]:
        """The name of `at_center` before version 0.2."""
        return self.at_center


def classify_cells(deformation, engine, grid, void_distance, progress):
    """The `VoidCells` of a grid, by void distances (nz, ny, nx), world units, at its points."""
    if not deformation.cuts:
        return VoidCells(*np.zeros((2, *grid.cells.shape), bool))
    classifying, mapping = progress.divided(1, 3)
    flags = engine.void_by_corners(void_distance, _min_distance(deformation, grid), classifying)
    cells, layer_size = flags.reshape(-1), flags[0].size
    for slab, part in mapping.chunks(flags.size, max(1, MAX_SLAB_CELLS // layer_size) * layer_size):
        rows = slab.start + np.flatnonzero(cells[slab] >= UNKNOWN)
        if len(rows):
            cells[rows] |= engine.void_distance_listed(deformation, grid.cells, rows, part) < 0
    touched = (flags & TOUCHED).astype(bool)
    flags &= VOID
    return VoidCells(flags.view(bool), touched)


def _min_distance(deformation, grid):
    """The longest mapped diagonal of a cell, world units: cells far from a face exceed it."""
    dimensions = np.array(grid.dimensions)
    if np.any(dimensions == 2):  # a single layer of cells has no neighbors to compare with
        return np.inf
    signs = np.array([(1, 1, 1), (1, 1, -1), (1, -1, 1), (-1, 1, 1)]) * (dimensions > 1)
    diagonals = signs @ grid.index_to_world.T
    matrices = [region.control_points.affine[0] for region in deformation.regions]
    if not matrices:  # of a chain
        return np.inf
    return max(np.linalg.norm(diagonals @ matrix.T, axis=1).max() for matrix in matrices)


def by_corners(void_distance: NDArray[np.float32], min_distance: float) -> NDArray[Any]:
    """The bits VOID, UNKNOWN and TOUCHED of the `Grid.cells`, by distances at their corners.

    `void_distance` (nz, ny, nx) is that at the points of a grid, `min_distance` the smallest one of
    the corners of a cell that is far from every face, world units.
    """
    low, high = (over_corners(pick, void_distance) for pick in (np.minimum, np.maximum))
    with np.errstate(invalid="ignore"):  # infinite distances have no difference, and stay unknown
        far = np.maximum(FAR * largest_of_neighbors(high - low), min_distance)
    is_void, is_full = high < -far, low > far
    flags = np.where(is_void, VOID, np.where(is_full, 0, UNKNOWN)).astype(np.uint8)
    return flags | TOUCHED * over_corners(np.maximum, void_distance < 0).astype(np.uint8)


def largest_of_neighbors(values):
    """The largest of each value (nz, ny, nx) and its 26 neighbors."""
    for axis in range(3):
        before, largest = np.moveaxis(values, axis, 0), values.copy()
        after = np.moveaxis(largest, axis, 0)
        np.maximum(after[1:], before[:-1], out=after[1:])
        np.maximum(after[:-1], before[1:], out=after[:-1])
        values = largest
    return values


def over_corners(pick, points):
    """A function such as np.minimum over the corners of each cell; points (nz, ny, nx)."""
    for axis in range(3):
        if points.shape[axis] > 1:
            points = pick(*(np.moveaxis(points, axis, 0)[part] for part in _ENDS))
            points = np.moveaxis(points, 0, axis)
    return points
