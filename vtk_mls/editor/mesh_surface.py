"""What one sees of a mesh: where rays meet it."""

from __future__ import annotations

import numpy as np
from vtkmodules.vtkCommonCore import mutable, vtkIdList
from vtkmodules.vtkCommonDataModel import vtkPolyData, vtkStaticCellLocator
from vtkmodules.vtkFiltersGeometry import vtkGeometryFilter

from vtk_mls.linear_algebra import unit

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
