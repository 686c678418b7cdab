"""What one sees of a mesh: where rays meet it."""

from __future__ import annotations

import numpy as np
from vtkmodules.vtkCommonCore import mutable, vtkIdList
from vtkmodules.vtkCommonDataModel import vtkPolyData, vtkStaticCellLocator
from vtkmodules.vtkFiltersGeometry import vtkGeometryFilter
from vtkmodules.vtkFiltersModeling import vtkSelectEnclosedPoints

from vtk_mls.base.linear_algebra import unit

_TOLERANCE = 1e-6  # of a ray, as a share of its length


class MeshSurface:
    """The surface of a vtkDataSet as it is now, whatever becomes of the dataset."""

    def __init__(self, mesh):
        self._surface, self._built = _surface_of(mesh), None

    def hit(self, near, far):
        """Where the ray from `near` to `far` (3,) meets it: (fraction, point), or None."""
        if self._surface.GetNumberOfCells() == 0:
            return None
        share, point, where = mutable(0.0), [0.0] * 3, [0.0] * 3
        found = self._locator.IntersectWithLine(
            near, far, _TOLERANCE, share, point, where, mutable(0), mutable(0)
        )
        return (float(share), np.array(point)) if found else None

    @property
    def _locator(self):
        """Made when it is first asked."""
        if self._built is None:
            self._built = vtkStaticCellLocator()
            self._built.SetDataSet(self._surface)
            self._built.BuildLocator()
        return self._built

    def nearest(self, points):
        """What is next to each of `points` (n, 3): (n, 3); those within a closed surface stay."""
        surface, inside = self._surface, vtkSelectEnclosedPoints()
        if surface.GetNumberOfCells() == 0:
            rows = [surface.FindPoint(point) for point in points]
            return np.array([p if i < 0 else surface.GetPoint(i) for i, p in zip(rows, points)])
        is_closed = bool(inside.IsSurfaceClosed(surface))
        inside.Initialize(surface)
        found = np.array(points)
        for row, point in enumerate(points):
            if not (is_closed and inside.IsInsideSurface(*point)):
                nearest = [0.0] * 3
                self._locator.FindClosestPoint(point, nearest, mutable(0), mutable(0), mutable(0.0))
                found[row] = nearest
        inside.Complete()
        return found

    def normal(self, point):
        """The unit normal (3,) of the cell that is nearest to a point; None if it has none."""
        if self._surface.GetNumberOfCells() == 0:
            return None
        nearest, cell, corners = [0.0] * 3, mutable(0), vtkIdList()
        self._locator.FindClosestPoint(point, nearest, cell, mutable(0), mutable(0.0))
        self._surface.GetCellPoints(int(cell), corners)
        if corners.GetNumberOfIds() < 3:
            return None
        a, b, c = (np.array(self._surface.GetPoint(corners.GetId(i))) for i in range(3))
        normal = np.cross(b - a, c - a)
        return unit(normal) if normal.any() else None


def _surface_of(mesh):
    surface = vtkPolyData()
    if isinstance(mesh, vtkPolyData):
        surface.ShallowCopy(mesh)
        return surface
    extract = vtkGeometryFilter()
    extract.SetInputData(mesh)
    extract.Update()
    surface.ShallowCopy(extract.GetOutput())
    return surface
