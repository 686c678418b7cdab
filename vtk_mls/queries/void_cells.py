"""What cuts have opened in the cells between the points of a grid."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

# Bits of what the corners of a cell tell: its centre is void; a corner is; of the centre nothing.
VOID, TOUCHED, UNKNOWN = 1, 2, 4
# What no cell can reach from its corners: so many times what these differ by, there and beside it,
# and its diagonal, as all control points together map it. By differences alone corners that lie
# alike on both sides of a void, or of two, would seem to be far from it. (In the worst of 10,800
# random scenes of 270 million cells, 3.3 times.)
FAR = 4
# Cells among which those are sought that the map is asked for.
_LOOKED_AT = 1 << 22
_ENDS = slice(None, -1), slice(1, None)


class VoidCells(NamedTuple):
    """What is void in each of the `Grid.cells` of a grid: (nz, ny, nx) bool of these.

    Attributes
    ----------
    at_centre : array of bool
        Whether the centre of the cell is void.
    touched : array of bool
        Whether one of its corners is.
    """

    at_centre: NDArray[np.bool_]
    touched: NDArray[np.bool_]


def of_cells(deformation, engine, grid, void_distance, progress):
    """The `VoidCells` of a grid.

    Parameters
    ----------
    deformation : Deformation
    engine : engine.protocol.Engine
    grid : Grid
    void_distance : (nz, ny, nx) float32, world units
        At the points of the grid.
    progress : Progress
    """
    if not deformation.cuts:
        return VoidCells(*np.zeros((2, *grid.cells.shape), bool))
    looking, asking = progress.divided(1, 3)
    told = engine.void_by_corners(void_distance, _least_distance(deformation, grid), looking)
    cells, layer = told.reshape(-1), told[0].size
    slabs = range(0, told.size, max(1, _LOOKED_AT // layer) * layer)
    for first, slab in zip(slabs, asking.divided(*[1] * len(slabs))):
        here = cells[first : first + slabs.step]
        unknown = np.flatnonzero(here >= UNKNOWN)
        if len(unknown):
            asked = deformation, grid.cells, first + unknown, slab
            here[unknown] |= engine.void_distance_listed(*asked) < 0
    touched = (told & TOUCHED).astype(bool)
    told &= VOID
    return VoidCells(told.view(bool), touched)


def _least_distance(deformation, grid):
    """From a void, in world units: that of corners whose cell is not near its face."""
    dimensions = np.array(grid.dimensions)
    if np.any(dimensions == 2):  # a single layer of cells has none beside it that would tell
        return np.inf
    signs = np.array([(1, 1, 1), (1, 1, -1), (1, -1, 1), (-1, 1, 1)]) * (dimensions > 1)
    diagonals = signs @ grid.index_to_world.T
    matrices = [region.control_points.affine[0] for region in deformation.regions]
    return max(np.linalg.norm(diagonals @ each.T, axis=1).max() for each in matrices)


def by_corners(void_distance: NDArray[np.float32], least: float) -> NDArray[Any]:
    """What the corners of cells tell of the void.

    Parameters
    ----------
    void_distance : (nz, ny, nx) float32, world units
        At the points of a grid.
    least : float, world units
        Corners of cells that are not near a face are at least as far from it.

    Returns
    -------
    array of uint8
        Of the shape of the `Grid.cells`: the bits VOID, UNKNOWN and TOUCHED of each.
    """
    low, high = (_over_corners(pick, void_distance) for pick in (np.minimum, np.maximum))
    with np.errstate(invalid="ignore"):  # no range of infinite ones, which stay unknown
        far = np.maximum(FAR * _largest_beside(high - low), least)
    void, full = high < -far, low > far
    told = np.where(void, VOID, np.where(full, 0, UNKNOWN)).astype(np.uint8)
    return told | TOUCHED * _touched(void_distance).astype(np.uint8)


def _touched(void_distance):
    """Which cells have a corner that is void."""
    return _over_corners(np.maximum, void_distance < 0)


def _largest_beside(values):
    """The largest of each value of (nz, ny, nx) and those beside it, across corners, too."""
    for axis in range(3):
        before, largest = np.moveaxis(values, axis, 0), values.copy()
        after = np.moveaxis(largest, axis, 0)
        np.maximum(after[1:], before[:-1], out=after[1:])
        np.maximum(after[:-1], before[1:], out=after[:-1])
        values = largest
    return values


def _over_corners(pick, points):
    """The `pick`, np.minimum or np.maximum, of the corners of each cell; points (nz, ny, nx)."""
    for axis in range(3):
        if points.shape[axis] > 1:
            points = pick(*(np.moveaxis(points, axis, 0)[part] for part in _ENDS))
            points = np.moveaxis(points, 0, axis)
    return points
