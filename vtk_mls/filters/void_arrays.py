"""The arrays that tell of the void which cuts open."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor

import numpy as np
from vtkmodules.vtkCommonCore import vtkVersion
from vtkmodules.vtkCommonDataModel import vtkDataSetAttributes

from vtk_mls import arrays

# Before VTK 9.3 vtkGeometryFilter, which ParaView 5.11 has as "Extract Surface", puts the last face
# of each column of an image with hidden cells at the end of the z axis, whatever axis the column
# has: beyond its memory where the image ends later along z. (Its fast mode does not.)
CAN_HIDE_CELLS = (vtkVersion.GetVTKMajorVersion(), vtkVersion.GetVTKMinorVersion()) >= (9, 3)


def add_void(attributes, void_distance):
    """Add the arrays of a void distance: "VoidDistance"; "Void" is its sign.

    Parameters
    ----------
    attributes : vtkPointData
    void_distance : (nz, ny, nx) float32, world units
        As of `DisplacementField.void_distance`.
    """
    arrays.add(attributes, "VoidDistance", void_distance.ravel())
    arrays.add(attributes, "Void", void_distance.ravel() < 0)


def add_overlap(output, overlaps):
    """Add "Overlap", (nz, ny, nx) bool, to the points of an image, and "OverlappingPoints"."""
    arrays.add(output.GetPointData(), "Overlap", overlaps.ravel())
    count = np.array([np.count_nonzero(overlaps)], np.int64)
    arrays.add(output.GetFieldData(), "OverlappingPoints", count)


def hide(attributes, hidden):
    """Mark points or cells as hidden, beside what their ghost array says already."""
    is_points = attributes.IsA("vtkPointData")
    flag = vtkDataSetAttributes.HIDDENPOINT if is_points else vtkDataSetAttributes.HIDDENCELL
    ghosts = hidden.ravel() * np.uint8(flag)
    before = attributes.GetArray(arrays.GHOSTS)
    if before is not None:
        ghosts |= arrays.to_numpy(before).astype(np.uint8)
    arrays.add(attributes, arrays.GHOSTS, ghosts)


def touched(points):
    """Cells with a corner among the points (nz, ny, nx) bool; cells as of `arrays.cell_grid`."""
    return _over_corners(np.maximum, points)


def void_in_cells(deformation, grid, void_distance, progress):
    """Whether the centres of cells are void: (nz, ny, nx) bool, of `arrays.cell_grid(grid)`.

    Parameters
    ----------
    deformation : Deformation
    grid : Grid
    void_distance : (nz, ny, nx) float32
        At the points of the grid.
    progress : Progress
    """
    cells = arrays.cell_grid(grid)
    # Planes cost no more than what follows; in the other frame no kernel measures at points.
    if not (deformation.in_rest_frame and deformation.obstacles):
        return deformation.void_field(cells, progress)
    void = np.empty(cells.shape, bool)
    unknown = np.empty(cells.shape, bool)
    least = _least_distance(deformation, grid)

    def look_at(slab):
        void[slab], unknown[slab] = _void_by_corners(void_distance, slab, least)

    slabs = [slice(first, first + _SLICES) for first in range(0, cells.shape[0], _SLICES)]
    with ThreadPoolExecutor(_THREADS) as threads:
        list(threads.map(look_at, slabs))
    unknown = np.flatnonzero(unknown)
    starts = range(0, len(unknown), _AT_ONCE)
    for start, part in zip(starts, progress.divided(*[1] * len(starts))):
        chosen = unknown[start : start + _AT_ONCE]
        index = np.stack(np.unravel_index(chosen, cells.shape)[::-1], axis=1)
        points = cells.whole.at(index + cells.first)
        void.flat[chosen] = deformation.void(points, part)
    return void


# What no cell can reach from its corners: so many times what these differ by, there and beside it,
# and its diagonal, as all control points together map it. By differences alone corners that lie
# alike on both sides of a void, or of two, would seem to be far from it.
_FAR = 4
# Few enough for answers that do not depend on which others are asked for with them.
_AT_ONCE = 1 << 16
# Of an image, at a time: what is made of them stays in the cache.
_SLICES = 6
# Two halve the time, and each needs memory of its own.
_THREADS = 2


def _least_distance(deformation, grid):
    """From a void, in world units: that of corners whose cell is not near its face."""
    dimensions = np.array(grid.dimensions)
    if np.any(dimensions == 2):  # a single layer of cells has none beside it that would tell
        return np.inf
    signs = np.array([(1, 1, 1), (1, 1, -1), (1, -1, 1), (-1, 1, 1)]) * (dimensions > 1)
    diagonals = signs @ grid.index_to_world.T
    matrices = [region.control_points.affine[0] for region in deformation.regions]
    return max(np.linalg.norm(diagonals @ each.T, axis=1).max() for each in matrices)


def _void_by_corners(void_distance, slab, least):
    """Of the cells of a slab along z, whether they are void, and whether that is unknown.

    `least` is what `_least_distance` says.
    """
    before = max(slab.start - 1, 0)
    points = void_distance[before : slab.stop + 2]
    low, high = (_over_corners(pick, points) for pick in (np.minimum, np.maximum))
    with np.errstate(invalid="ignore"):  # no range of infinite ones, which stay unknown
        far = np.maximum(_FAR * _largest_beside(high - low), least)
    void = high < -far
    inner = slice(slab.start - before, slab.stop - before)
    return void[inner], ~(void | (low > far))[inner]


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


_ENDS = slice(None, -1), slice(1, None)
