"""The forward map, interpolated: for meshes with many points while the mouse drags."""

import numpy as np
from vtkmodules.vtkCommonCore import VTK_FLOAT
from vtkmodules.vtkCommonDataModel import vtkImageData, vtkPolyData
from vtkmodules.vtkFiltersGeneral import vtkTransformFilter
from vtkmodules.vtkFiltersHybrid import vtkGridTransform

from vtk_mls.base.interpolation import sample
from vtk_mls.queries import inverses
from vtk_mls.queries.vector_fields import covariant
from vtk_mls.queries.void_cells import over_corners
from vtk_mls.rendering.rest_surface import determinants, jacobians
from vtk_mls.vtk import arrays
from vtk_mls.vtk.arrays import ImageGeometry
from vtk_mls.vtk.objects import configured, output_of
from vtk_mls.vtk.splitting import height_function

# Largest mesh for which the map itself is as fast as its interpolation; nodes of the grid.
MAX_EXACT_POINTS, _NODES = 1 << 18, 1 << 18
_MAX_ERROR = 5e-4  # as a fraction of the grid's largest side: half a pixel of 1000


class CoarseForward:
    """Deforms a RestSurface by a forward map that is linear in each cell of a grid.

    The exact map is used in cells with too large an error, with a cut in the rest frame, or with a
    corner without an inverse; and for outliers beyond the grid.
    """

    def __init__(self, surface, cuts):
        self._surface = surface
        x = surface.positions
        self._grid = inverses.cubic_grid(inverses.usual_bounds(x, inverses.bounds(x)), _NODES)
        self._nodes = self._grid.points()
        self._last = np.array(self._grid.dimensions) - 1
        self._cell = _cells(self._grid, x)
        self._is_crossed = np.append(_crossed(self._grid, cuts), True)  # the last: outside
        self._rest = vtkPolyData()
        self._rest.SetPoints(surface.surface.GetPoints())
        self._rest.GetPointData().SetNormals(surface.surface.GetPointData().GetNormals())

    def moved(self, deformation, has_distortion=False):
        """The deformed surface as vtkPolyData, with arrays as of `RestSurface.moved`."""
        field = deformation.forward_field(self._nodes)
        moved = self._interpolated(field.displacement)
        points, normals = moved.GetPoints(), moved.GetPointData().GetNormals()
        rows = np.flatnonzero(self._is_exact(field)[self._cell])
        values = self._determinants(field) if has_distortion else None
        if len(rows) > 0:
            self._move_exactly(deformation, rows, points, normals, values)
        output = self._surface.with_points(points, normals)
        if has_distortion:
            self._surface.add_distortion(output, values)
        return output

    def _determinants(self, field):
        """det J_G at the points, from differences between the nodes: (n,) float32."""
        values = field.displacement.reshape(*self._grid.shape, 3)
        slopes = [np.gradient(values, h, axis=2 - i) for i, h in enumerate(self._grid.spacing)]
        forward = np.linalg.det(np.eye(3) + np.stack(slopes, axis=-1))
        with np.errstate(divide="ignore"):
            nodes = np.where(field.found.reshape(forward.shape), 1 / forward, 0)
        index = self._grid.index_of(self._surface.positions)
        return sample(nodes.astype(np.float32), index, "linear", 1.0, self._grid)

    def _interpolated(self, displacement):
        """The points and normals, moved by displacements of the nodes (m, 3)."""
        image = vtkImageData()
        ImageGeometry.of_grid(self._grid).apply_to(image)
        image.GetPointData().SetScalars(arrays.from_numpy(displacement, VTK_FLOAT))
        transform = configured(vtkGridTransform(), DisplacementGridData=image)
        return output_of(vtkTransformFilter(), Transform=transform, InputData=self._rest)

    def _is_exact(self, field):
        """Cells that need the exact map, judged by the map at the nodes.

        The last entry stands for points outside all cells. The error of linear interpolation is an
        eighth of the second difference.
        """
        values = field.displacement.reshape(*self._grid.shape, 3)
        error = np.zeros(self._grid.shape, np.float32)
        for axis in range(3):
            if values.shape[axis] > 2:
                second = np.abs(np.diff(values, 2, axis)).max(axis=-1) / 8
                ends = [(1, 1) if other == axis else (0, 0) for other in range(3)]
                error += np.pad(second, ends, "edge")
        allowed = _MAX_ERROR * (self._grid.spacing * self._last).max()
        wrong = ~(field.found.reshape(error.shape) & (error <= allowed))
        return self._is_crossed | np.append(over_corners(np.logical_or, wrong), True)

    def _move_exactly(self, deformation, rows, points, normals, values):
        """Set points, normals and determinants, if any, of some rows by the exact map."""
        surface, material = self._surface, self._surface.material(deformation)[rows]
        before = surface.positions[rows]
        field = deformation.forward_field(material)
        positions = before + field.displacement
        arrays.to_numpy(points.GetData())[rows] = positions
        if values is not None:
            parts = jacobians(deformation, positions, before, material)
            values[rows] = determinants(parts, field.found)
        if normals is None:
            return
        exact = arrays.to_numpy(surface.surface.GetPointData().GetNormals())[rows]
        for part, jacobian in jacobians(deformation, positions, before, material):
            exact[part] = covariant(exact[part], jacobian.swapaxes(1, 2), True)
        arrays.to_numpy(normals)[rows] = exact


def _cells(grid, points):
    """Ids of the cells that contain `points` (n, 3), -1 outside: (n,)."""
    last = np.array(grid.dimensions) - 1
    index = grid.index_of(points)
    inside = ((index >= 0) & (index <= last)).all(axis=1)
    i, j, k = np.minimum(np.where(inside[:, None], index, 0).astype(np.int32), last - 1).T
    return np.where(inside, i + last[0] * (j + last[1] * k), -1)


def _crossed(grid, cuts):
    """Which cells of a grid a cut crosses or nearly touches: (n,) bool."""
    cells = grid.part((0, 0, 0), np.array(grid.dimensions) - 1)
    radius = 0.51 * np.linalg.norm(grid.spacing)
    crossed = np.zeros(cells.size, bool)
    if not cuts:
        return crossed
    centers = cells.points() + grid.spacing / 2
    for cut in cuts:
        low, high = cut.bounds
        near = ((centers > low - radius) & (centers < high + radius)).all(axis=1) & ~crossed
        rows = np.flatnonzero(near)
        rows = rows[np.abs(height_function(cut)(centers[rows])) < radius]
        if cut.plane is not None:  # the height function continues beyond the edge
            rows = rows[cut.void_distance(centers[rows], centers[rows]) < radius]
        crossed[rows] = True
    return crossed
