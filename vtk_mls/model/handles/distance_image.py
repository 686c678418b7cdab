"""Signed distances from a closed surface or a labeled volume, on a grid of cubic cells."""

import functools
import itertools
from dataclasses import dataclass

import numpy as np

from vtk_mls.base import interpolation
from vtk_mls.base.grid import Grid
from vtk_mls.base.interpolation import linear_with_slopes
from vtk_mls.base.linear_algebra import unit
from vtk_mls.base.progress import SILENT

# Points of an image of distances from triangles, and from voxels.
_MAX_NODES, _MAX_VOXELS = 1 << 18, 1 << 20
_BAND = 3  # cells around triangles with exact distances; behind fewer, signs could be lost
_MARGIN = 0.5  # of the box around the shape, as a fraction of its largest side


@dataclass(frozen=True, eq=False)
class DistanceImage:
    """Distances at the points of a grid, linear between them."""

    grid: Grid  # with cubic cells
    values: np.ndarray  # (nz, ny, nx) float32, world units; below 0 inside of the shape

    @property
    def step(self) -> float:
        """Distance of neighboring points, world units."""
        return float(abs(self.grid.spacing[0]))

    @functools.cached_property
    def normals(self) -> np.ndarray:
        """Unit vectors (3, nz, ny, nx) along the slopes of the distance, in axes of the grid."""
        slopes = np.stack(np.gradient(self.values)[::-1], axis=-1)
        return np.moveaxis(unit(slopes), -1, 0).astype(np.float32)

    @functools.cached_property
    def border(self) -> np.ndarray:
        """Distances in steps and normals (6, rows, columns, 4) on the faces of the grid.

        Of the axes x, y and z, the lower face and then the upper one. Smaller faces are padded.
        """
        nodes = np.stack([self.values / self.step, *self.normals], axis=-1)
        faces = [nodes.take(i, axis) for axis in (2, 1, 0) for i in (0, -1)]
        rows, columns = np.max([face.shape[:2] for face in faces], axis=0)
        border = np.zeros((6, rows, columns, 4), np.float32)
        for padded, face in zip(border, faces):
            padded[: face.shape[0], : face.shape[1]] = face
        return border

    def at(self, points):
        """Distances (m,) at `points` (m, 3), 0 inside, and half the gradients of their squares.

        Beyond the grid the distance is that from the place on the shape that is closest to the
        nearest point of the grid.
        """
        index = self.grid.index_of(points)
        nearest = np.clip(index, 0, np.array(self.grid.dimensions) - 1)
        value, slope = linear_with_slopes(self.values, nearest)
        distance = np.maximum(value, 0) / self.step
        slope = slope / self.step
        square, half = distance**2, distance[:, None] * slope
        rows = np.flatnonzero((index != nearest).any(axis=1))
        beyond, slope = (index - nearest)[rows], slope[rows]
        parts = [linear_with_slopes(normal, nearest[rows]) for normal in self.normals]
        normal = np.stack([value for value, _ in parts], axis=1)
        along = np.sum(beyond * normal, axis=1)
        turned = sum(beyond[:, [axis]] * turn for axis, (_, turn) in enumerate(parts))
        short = distance[rows]
        square[rows] += 2 * short * along + np.sum(beyond**2, axis=1)
        half[rows] = np.where(
            beyond != 0,
            beyond + short[:, None] * normal,
            (short + along)[:, None] * slope + short[:, None] * turned,
        )
        half = self.step * np.einsum("mi,ji->mj", half, self.grid.direction)
        return self.step * np.sqrt(np.maximum(square, 0)), half


def cubic_grid(low, high, margin, direction=None, max_nodes=_MAX_NODES):
    """A grid of cubic cells around the box from `low` to `high` (3,), in the frame `direction`."""
    low, high = low - margin, high + margin
    step = float(np.cbrt((high - low).prod() / max_nodes))
    dimensions = np.ceil((high - low) / step).astype(int) + 1
    frame = np.eye(3) if direction is None else direction
    return Grid(dimensions, frame @ low, [step] * 3, frame)


def of_triangles(points, triangles) -> DistanceImage:
    """The distance from a closed surface: `points` (n, 3), world, and `triangles` (m, 3)."""
    low, high = points.min(axis=0), points.max(axis=0)
    grid = cubic_grid(low, high, _MARGIN * (high - low).max())
    return DistanceImage(grid, _from_triangles(points, triangles, grid))


def of_face(points, triangles, reach):
    """Distances from an open or closed surface up to `reach`, and its normals; their grid.

    The array (4, nz, ny, nx) has the distance less a diagonal of a cell, so that it is 0 on the
    surface, and the normal of the closest point.
    """
    grid = cubic_grid(points.min(axis=0), points.max(axis=0), reach)
    distance = _from_triangles(points, triangles, grid)
    normals = DistanceImage(grid, distance).normals
    distance = np.maximum(np.abs(distance) - np.sqrt(3) * abs(grid.spacing[0]), 0)
    return np.concatenate([distance[None], normals]), grid


def _from_triangles(points, triangles, grid):
    """Signed distances (nz, ny, nx) float32 of the points of a grid from triangles."""
    # VTK is slow to import, and only this needs it
    from vtkmodules.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray
    from vtkmodules.vtkCommonCore import vtkPoints
    from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData
    from vtkmodules.vtkFiltersCore import vtkImplicitPolyDataDistance

    surface, corners, cells = vtkPolyData(), vtkPoints(), vtkCellArray()
    corners.SetData(numpy_to_vtk(np.ascontiguousarray(points, float), deep=True))
    rows = np.ascontiguousarray(triangles, np.int64).ravel()
    cells.SetData(3, numpy_to_vtkIdTypeArray(rows, deep=True))
    surface.SetPoints(corners)
    surface.SetPolys(cells)
    distance = vtkImplicitPolyDataDistance()
    distance.SetInput(surface)
    near = _near(points[triangles], grid)
    nodes = grid.points().reshape(*grid.shape, 3)
    places = nodes[near]
    exact = distance.EvaluateFunctionAndGetClosestPoint
    found = np.array([exact(node, place) for node, place in zip(nodes[near], places)])
    places = np.concatenate([places, np.full((1, 3), np.inf)])  # of points without one
    rows, squares = np.full(grid.shape, len(found)), np.where(near, 0, np.inf)
    rows[near] = np.arange(len(found))
    # VTK searches the longer the farther a point is: others take the closest place of neighbors
    for axis in range(3):
        _spread(places, *(np.moveaxis(array, axis, 0) for array in (nodes, rows, squares)))
    values = np.copysign(np.sqrt(squares), np.append(found, 0)[rows])
    values[near] = found
    return values.astype(np.float32)


def _near(corners, grid):
    """Which points (nz, ny, nx) of a grid are within `_BAND` cells of triangles (m, 3, 3)."""
    near = np.zeros(grid.shape, bool)
    longest = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
    parts = np.ceil(longest / abs(grid.spacing[0])).astype(int).clip(1)
    for count in np.unique(parts):
        i, j = np.stack(np.meshgrid(*[np.arange(count + 1)] * 2)).reshape(2, -1) / count
        shares = np.stack([1 - i - j, i, j], axis=-1)[i + j < 1 + 1e-9]
        same = corners[parts == count]
        for part, _ in SILENT.chunks(len(same), max(1, _MAX_VOXELS // len(shares))):
            index = np.rint(grid.index_of((shares @ same[part]).reshape(-1, 3))).astype(int)
            near[tuple(index[:, ::-1].T)] = True
    for axis in range(3):
        near = np.any([np.roll(near, n, axis) for n in range(-_BAND, _BAND + 1)], axis=0)
    return near


def _spread(places, nodes, rows, squares):
    """Give nodes the closest of `places`, by `rows`, that neighbors along the first axis have."""
    for layers, back in ((range(1, len(nodes)), 1), (range(len(nodes) - 2, -1, -1), -1)):
        for layer, shift in itertools.product(layers, itertools.product((0, 1, -1), repeat=2)):
            new = np.roll(rows[layer - back], shift, (0, 1))
            offset = nodes[layer] - places[new]
            square = np.einsum("ijk,ijk->ij", offset, offset)
            better = square < squares[layer]
            rows[layer][better], squares[layer][better] = new[better], square[better]


def of_mask(mask, grid) -> DistanceImage:
    """The distance from the voxels of a `mask` (nz, ny, nx) on `grid`, cubic cells of its axes.

    The surface is half a voxel around the centers of the voxels. Voxels that are smaller than the
    cells are joined; a joined voxel is inside if any of its voxels is, so that thin parts remain.
    """
    spacing = np.abs(grid.spacing)
    frame = grid.direction * np.sign(grid.spacing)
    size = spacing * (np.array(grid.dimensions) - 1)
    low = np.linalg.solve(frame, grid.origin)
    step = spacing.min()
    half = step / 2
    margin = _MARGIN * (size.max() + 2 * half)
    target = cubic_grid(low - half, low + size + half, margin, frame, _MAX_VOXELS)
    joined = np.maximum(abs(target.spacing[0]) // spacing, 1).astype(int)
    if (joined > 1).any():
        return of_mask(*_joined(mask, grid, joined))
    if target.spacing[0] < step:  # smaller cells would say no more, and take time in kernels
        cells = np.ceil((margin + half) / step).astype(int)
        dimensions = 2 * cells + np.ceil(size / step).astype(int) + 1
        target = Grid(dimensions, frame @ (low - cells * step), [step] * 3, frame)
    pad = np.ceil(margin / spacing).astype(int) + 2
    padded = np.pad(mask, [(n, n) for n in pad[::-1]])
    outside, inside = (_euclidean(part, spacing) for part in (padded, ~padded))
    # from the center of the nearest voxel on the other side
    values = np.where(padded, half - inside, outside - half)
    source = Grid(np.array(padded.shape[::-1]), grid.at([-pad])[0], grid.spacing, grid.direction)
    index = source.index_of(target.points())
    result = interpolation.sample(values.astype(np.float32), index, "linear", 0.0, source)
    return DistanceImage(target, result.reshape(target.shape))


def _joined(mask, grid, count):
    """A mask with `count` (3,) voxels along each axis joined to one, and its grid."""
    mask = np.pad(mask, [(0, n) for n in -np.array(mask.shape) % count[::-1]])
    blocks = [m for n, c in zip(mask.shape, count[::-1]) for m in (n // c, c)]
    mask = mask.reshape(blocks).any(axis=(1, 3, 5))
    origin = grid.at([(count - 1) / 2])[0]
    return mask, Grid(mask.shape[::-1], origin, grid.spacing * count, grid.direction)


def _euclidean(mask, spacing):
    """Distances (nz, ny, nx) from the nearest voxel of a mask, by VTK."""
    from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
    from vtkmodules.vtkCommonDataModel import vtkImageData
    from vtkmodules.vtkImagingGeneral import vtkImageEuclideanDistance

    image, distance = vtkImageData(), vtkImageEuclideanDistance()
    image.SetDimensions(mask.shape[::-1])
    image.SetSpacing(spacing / spacing.min())  # its results are wrong for spacings below 1
    # the filter measures the distance from voxels of value 0
    image.GetPointData().SetScalars(numpy_to_vtk((~mask).ravel().astype(np.uint8), deep=True))
    distance.SetInputData(image)
    distance.ConsiderAnisotropyOn()
    distance.SetAlgorithmToSaito()
    distance.Update()
    squares = vtk_to_numpy(distance.GetOutput().GetPointData().GetScalars())
    return spacing.min() * np.sqrt(squares).reshape(mask.shape)
