"""Cells of point sets that are handles, and back."""

from __future__ import annotations

import numpy as np
from vtkmodules.vtkCommonDataModel import vtkPolyData, vtkUnstructuredGrid
from vtkmodules.vtkFiltersCore import vtkTriangleFilter
from vtkmodules.vtkFiltersGeometry import vtkGeometryFilter

from vtk_mls.handles.handle_cells import HandleCells
from vtk_mls.vtk import arrays
from vtk_mls.vtk.cells import cell_array, connectivity_of, without_empty

_ROWS = "vtkOriginalPointIds"


def cells_of(point_set):
    """The `HandleCells` of a vtkPointSet.

    Vertices, and points that no cell has, are points; lines and polylines are curves; polygons,
    triangle strips, and the outer faces of cells with a volume are surfaces.
    """
    count = point_set.GetNumberOfPoints()
    if point_set.GetNumberOfCells() == 0:
        return HandleCells.points(count)
    surface, rows = point_set, np.arange(count)
    if not isinstance(point_set, vtkPolyData):
        surface, rows = _surface(point_set)
    vertices, _ = connectivity_of(surface.GetVerts())
    lines, offsets = connectivity_of(surface.GetLines())
    triangles = rows[_triangles(surface)]
    is_free = np.ones(count, bool)
    is_free[_used_points(point_set)] = False
    return HandleCells(
        np.union1d(rows[vertices], np.flatnonzero(is_free)),
        tuple(rows[line] for line in np.split(lines, offsets[1:-1]) if len(line)),
        triangles,
    )


def set_cells(polydata, cells):
    """Give a vtkPolyData the vertices, lines and triangles of `HandleCells`."""
    rows = np.arange(len(cells.vertices) + 1)
    polydata.SetVerts(cell_array(cells.vertices, rows))
    if cells.lines:
        offsets = np.cumsum([0, *map(len, cells.lines)])
        polydata.SetLines(cell_array(np.concatenate(cells.lines), offsets))
    if len(cells.triangles):
        corners = cells.triangles.ravel()
        polydata.SetPolys(cell_array(corners, np.arange(0, len(corners) + 1, 3)))


def _surface(point_set):
    """Vertices, lines and outer faces of a vtkPointSet, and the rows (m,) of their points."""
    faces = vtkGeometryFilter()
    faces.SetInputData(point_set)
    faces.SetPassThroughPointIds(True)
    faces.SetOriginalPointIdsName(_ROWS)
    faces.SetNonlinearSubdivisionLevel(0)
    faces.Update()
    surface = faces.GetOutput()
    rows = surface.GetPointData().GetArray(_ROWS)
    return surface, np.zeros(0, int) if rows is None else arrays.to_numpy(rows)


def _triangles(polydata):
    """Triangles (t, 3) of the polygons and strips of a vtkPolyData, as rows of its points."""
    bare, triangles = vtkPolyData(), vtkTriangleFilter()
    bare.SetPoints(polydata.GetPoints())
    bare.SetPolys(polydata.GetPolys())
    bare.SetStrips(polydata.GetStrips())
    triangles.SetInputData(without_empty(bare))
    triangles.Update()
    connectivity, _ = connectivity_of(triangles.GetOutput().GetPolys())
    return connectivity.reshape(-1, 3)


def _used_points(point_set):
    """Rows of the points of all cells."""
    if isinstance(point_set, vtkPolyData):
        names = ("Verts", "Lines", "Polys", "Strips")
        parts = [connectivity_of(getattr(point_set, f"Get{name}")())[0] for name in names]
        return np.concatenate(parts)
    if isinstance(point_set, vtkUnstructuredGrid):
        return connectivity_of(point_set.GetCells())[0]
    return np.arange(point_set.GetNumberOfPoints())  # of a structured grid
