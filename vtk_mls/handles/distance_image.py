"""Signed distances from a closed surface or a labeled volume, on a grid of cubic cells."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vtk_mls.base import interpolation
from vtk_mls.base.grid import Grid

_MAX_NODES = 1 << 18  # of a distance image
_MARGIN = 0.5  # of the box around the shape, as a fraction of its largest side


@dataclass(frozen=True, eq=False)
class DistanceImage:
    """Distances at the points of a grid, linear between them.

    Attributes
    ----------
    grid : Grid
        With cubic cells.
    values : (nz, ny, nx) float32, world units
        Below 0 inside of the shape.
    """

    grid: Grid
    values: np.ndarray

    @property
    def step(self) -> float:
        """Distance of neighboring points, world units."""
        return float(abs(self.grid.spacing[0]))

    def at(self, points):
        """Distances (m,) at `points` (m, 3), 0 inside, and half the gradients of their squares.

        Outside of the grid the distance is that from the place on the shape that is closest to the
        nearest point of the grid.
        """
        index = self.grid.index_of(points)
        clamped = np.clip(index, 0, np.array(self.grid.dimensions) - 1)
        value, gradient = self._linear(clamped)
        distance = np.maximum(value, 0)[:, None] * self.step
        # axes of the grid are orthogonal: lengths are the same in steps
        direction = gradient @ self.grid.direction.T
        outside = self.step * (index - clamped) @ self.grid.direction.T
        length = np.linalg.norm(direction, axis=1, keepdims=True)
        unit = np.divide(direction, length, out=np.zeros_like(direction), where=length > 0)
        is_outside = (index != clamped).any(axis=1)[:, None]
        offset = np.where(is_outside, outside + distance * unit, distance * direction)
        far = np.linalg.norm(offset, axis=1)
        return np.where(is_outside[:, 0], far, distance[:, 0]), offset

    def _linear(self, index):
        """Values (m,) in steps, and their change per step (m, 3), at indices (m, 3) of the grid."""
        last = np.maximum(np.array(self.grid.dimensions) - 2, 0)
        cell = np.minimum(np.floor(index).astype(int), last)
        share = index - cell
        value, gradient = np.zeros(len(index)), np.zeros((len(index), 3))
        for corner in np.ndindex(2, 2, 2):
            at = cell + corner
            tap = self.values[at[:, 2], at[:, 1], at[:, 0]].astype(float) / self.step
            weights = np.where(corner, share, 1 - share)
            value += weights.prod(axis=1) * tap
            for axis in range(3):
                others = np.delete(weights, axis, axis=1).prod(axis=1)
                gradient[:, axis] += (1 if corner[axis] else -1) * others * tap
        return value, gradient


def cubic_grid(low, high, direction=None, max_nodes=_MAX_NODES):
    """A grid of cubic cells around the box from `low` to `high` (3,), in the frame `direction`."""
    margin = _MARGIN * (high - low).max()
    low, high = low - margin, high + margin
    step = float(np.cbrt((high - low).prod() / max_nodes))
    dimensions = np.ceil((high - low) / step).astype(int) + 1
    frame = np.eye(3) if direction is None else direction
    return Grid(dimensions, frame @ low, [step] * 3, frame)


def of_triangles(points, triangles) -> DistanceImage:
    """The distance from a closed surface: `points` (n, 3), world coordinates, `triangles` (m, 3)."""
    # VTK is slow to import, and only this needs it
    from vtkmodules.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray, vtk_to_numpy
    from vtkmodules.vtkCommonCore import vtkDoubleArray, vtkPoints
    from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData
    from vtkmodules.vtkFiltersCore import vtkImplicitPolyDataDistance

    surface, corners, cells = vtkPolyData(), vtkPoints(), vtkCellArray()
    corners.SetData(numpy_to_vtk(np.ascontiguousarray(points, float), deep=True))
    rows = np.column_stack([np.full(len(triangles), 3), triangles]).astype(np.int64)
    cells.SetCells(len(triangles), numpy_to_vtkIdTypeArray(rows.ravel(), deep=True))
    surface.SetPoints(corners)
    surface.SetPolys(cells)
    distance, values = vtkImplicitPolyDataDistance(), vtkDoubleArray()
    distance.SetInput(surface)
    grid = cubic_grid(points.min(axis=0), points.max(axis=0))
    distance.FunctionValue(numpy_to_vtk(grid.points(), deep=True), values)
    return DistanceImage(grid, vtk_to_numpy(values).reshape(grid.shape).astype(np.float32))


def of_mask(mask, grid) -> DistanceImage:
    """The distance from the voxels of a `mask` (nz, ny, nx) on `grid`, cubic cells of its axes.

    The surface is half a voxel around the centers of the voxels.
    """
    spacing = np.abs(grid.spacing)
    signs = np.sign(grid.spacing)
    frame = grid.direction * signs
    size = spacing * (np.array(grid.dimensions) - 1)
    low = np.linalg.solve(frame, grid.origin)
    half = spacing.min() / 2
    target = cubic_grid(low - half, low + size + half, frame)
    pad = np.ceil(_MARGIN * (size.max() + 2 * half) / spacing).astype(int) + 2
    padded = np.pad(mask, [(n, n) for n in pad[::-1]])
    outside, inside = (_euclidean(part, spacing) for part in (padded, ~padded))
    # from the center of the nearest voxel on the other side
    values = np.where(padded, half - inside, outside - half)
    source = Grid(
        np.array(padded.shape[::-1]), grid.at([-pad])[0], grid.spacing, grid.direction
    )
    index = source.index_of(target.points())
    result = interpolation.sample(values.astype(np.float32), index, "linear", 0.0, source)
    return DistanceImage(target, result.reshape(target.shape))


def _euclidean(mask, spacing):
    """Distances (nz, ny, nx) from the nearest voxel of a mask, by VTK."""
    from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
    from vtkmodules.vtkCommonDataModel import vtkImageData
    from vtkmodules.vtkImagingGeneral import vtkImageEuclideanDistance

    image = vtkImageData()
    image.SetDimensions(mask.shape[::-1])
    image.SetSpacing(spacing / spacing.min())  # its results are wrong for spacings below 1
    # the filter measures the distance from voxels of value 0
    image.GetPointData().SetScalars(numpy_to_vtk((~mask).ravel().astype(np.uint8), deep=True))
    distance = vtkImageEuclideanDistance()
    distance.SetInputData(image)
    distance.ConsiderAnisotropyOn()
    distance.SetAlgorithmToSaito()
    distance.Update()
    squares = vtk_to_numpy(distance.GetOutput().GetPointData().GetScalars())
    return spacing.min() * np.sqrt(squares).reshape(mask.shape)
