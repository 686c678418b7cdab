"""The forward map, interpolated: while something is dragged, for meshes of very many points."""

from __future__ import annotations

import numpy as np
from vtkmodules.vtkCommonCore import VTK_FLOAT
from vtkmodules.vtkCommonDataModel import vtkImageData, vtkPolyData
from vtkmodules.vtkFiltersGeneral import vtkTransformFilter
from vtkmodules.vtkFiltersHybrid import vtkGridTransform

from vtk_mls.queries import first_guesses as guesses
from vtk_mls.queries.vector_fields import covariant
from vtk_mls.rendering.drawn_mesh import jacobians
from vtk_mls.vtk import arrays
from vtk_mls.vtk.splitting import height_function

# Points up to which the map itself takes no longer than its interpolation, and nodes of the grid.
MOST_EXACT, _NODES = 1 << 18, 1 << 18
_ERROR = 5e-4  # of interpolation, as a share of the grid's largest side: half of 1000 pixels
_CORNERS = np.array([(i, j, k) for k in (0, 1) for j in (0, 1) for i in (0, 1)])


class CoarseForward:
    """Moves a drawn mesh by a forward map that is linear in each cell of a grid.

    Points are moved by the map itself in cells where it bends too much, through which a cut goes,
    or of which a corner has no inverse, as are those far from all others.

    Parameters
    ----------
    drawn : DrawnMesh
    cuts : sequence of Plane, HalfPlane and Surface, in the rest frame
    """

    def __init__(self, drawn, cuts):
        self._drawn = drawn
        x = drawn.positions
        self._grid = guesses.cubic_grid(guesses.usual_bounds(x, guesses.bounds(x)), _NODES)
        self._nodes = self._grid.points()
        self._last = np.array(self._grid.dimensions) - 1
        self._cell = _cells(self._grid, x)
        self._is_crossed = np.append(_crossed(self._grid, cuts), True)  # and what is in no cell
        self._rest = vtkPolyData()
        self._rest.SetPoints(drawn.surface.GetPoints())
        self._rest.GetPointData().SetNormals(drawn.surface.GetPointData().GetNormals())

    def moved(self, deformation):
        """The surface as vtkPolyData, moved."""
        field = deformation.forward_field(self._nodes)
        moved = self._interpolated(field.displacement)
        points, normals = moved.GetPoints(), moved.GetPointData().GetNormals()
        rows = np.flatnonzero(self._is_exact(field)[self._cell])
        if len(rows) > 0:
            self._move_exactly(deformation, rows, points, normals)
        return self._drawn.with_points(points, normals)

    def _interpolated(self, displacement):
        """The points, and their normals, moved by displacements of the nodes (m, 3)."""
        image, transform, move = vtkImageData(), vtkGridTransform(), vtkTransformFilter()
        image.SetDimensions(self._grid.dimensions)
        image.SetOrigin(self._grid.origin)
        image.SetSpacing(self._grid.spacing)
        image.GetPointData().SetScalars(arrays.from_numpy(displacement, VTK_FLOAT))
        transform.SetDisplacementGridData(image)
        move.SetTransform(transform)
        move.SetInputData(self._rest)
        move.Update()
        return move.GetOutput()

    def _is_exact(self, field):
        """Cells, and at last what is in none, where the map itself is asked, by that of the nodes.

        What a linear function misses is an eighth of the second difference.
        """
        values = field.displacement.reshape(*self._grid.shape, 3)
        error = np.zeros(self._grid.shape, np.float32)
        for axis in range(3):
            if values.shape[axis] > 2:
                second = np.abs(np.diff(values, 2, axis)).max(axis=-1) / 8
                ends = [(1, 1) if each == axis else (0, 0) for each in range(3)]
                error += np.pad(second, ends, "edge")
        allowed = _ERROR * (self._grid.spacing * self._last).max()
        wrong = ~(field.found.reshape(error.shape) & (error <= allowed))
        nx, ny, nz = self._last
        corners = [wrong[k : k + nz, j : j + ny, i : i + nx] for i, j, k in _CORNERS]
        return self._is_crossed | np.append(np.any(corners, axis=0), True)

    def _move_exactly(self, deformation, rows, points, normals):
        """Move some points by the map itself, and their normals, if there are any."""
        drawn, material = self._drawn, self._drawn.material(deformation)[rows]
        before = drawn.positions[rows]
        positions = before + deformation.forward_field(material).displacement
        arrays.to_numpy(points.GetData())[rows] = positions
        if normals is None:
            return
        kept = arrays.to_numpy(drawn.surface.GetPointData().GetNormals())[rows]
        for part, jacobian in jacobians(deformation, positions, before, material):
            kept[part] = covariant(kept[part], jacobian.swapaxes(1, 2), True)
        arrays.to_numpy(normals)[rows] = kept


def _cells(grid, points):
    """Number of the cell in which each of `points` (n, 3) is, -1 outside: (n,)."""
    last = np.array(grid.dimensions) - 1
    index = grid.index_of(points)
    inside = ((index >= 0) & (index <= last)).all(axis=1)
    i, j, k = np.minimum(np.where(inside[:, None], index, 0).astype(np.int32), last - 1).T
    return np.where(inside, i + last[0] * (j + last[1] * k), -1)


def _crossed(grid, cuts):
    """Which cells of a grid a cut goes through, or all but: (n,) bool."""
    cells = grid.part((0, 0, 0), np.array(grid.dimensions) - 1)
    radius = 0.51 * np.linalg.norm(grid.spacing)
    crossed = np.zeros(cells.size, bool)
    if not cuts:
        return crossed
    centres = cells.points() + grid.spacing / 2
    for cut in cuts:
        low, high = cut.bounds
        near = ((centres > low - radius) & (centres < high + radius)).all(axis=1) & ~crossed
        rows = np.flatnonzero(near)
        rows = rows[np.abs(height_function(cut)(centres[rows])) < radius]
        if cut.plane is not None:  # which goes on where the cut ends
            rows = rows[cut.void_distance(centres[rows], centres[rows]) < radius]
        crossed[rows] = True
    return crossed
