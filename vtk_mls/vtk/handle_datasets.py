"""Cells of point sets that are handles, and back."""

import numpy as np
from vtkmodules.vtkCommonDataModel import vtkPolyData, vtkUnstructuredGrid
from vtkmodules.vtkFiltersGeometry import vtkGeometryFilter

from vtk_mls.model.handles.handle_cells import HandleCells
from vtk_mls.vtk import arrays
from vtk_mls.vtk.cells import cell_array, connectivity_of, polydata_cells, triangulated
from vtk_mls.vtk.objects import configured, output_of

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
    triangles, _ = connectivity_of(triangulated(surface).GetPolys())
    is_free = np.ones(count, bool)
    is_free[_used_points(point_set)] = False
    return HandleCells(
        np.union1d(rows[vertices], np.flatnonzero(is_free)),
        tuple(rows[line] for line in np.split(lines, offsets[1:-1]) if len(line)),
        rows[triangles].reshape(-1, 3),
    )


def set_cells(polydata, cells):
    """Give a vtkPolyData the vertices, lines and triangles of `HandleCells`."""
    rows = np.arange(len(cells.vertices) + 1)
    polydata.SetVerts(cell_array(cells.vertices, rows))
    if cells.lines:
        offsets = np.cumsum([0, *map(len, cells.lines)])
        polydata.SetLines(cell_array(np.concatenate(cells.lines), offsets))
    if len(cells.triangles):
        connectivity = cells.triangles.ravel()
        polydata.SetPolys(cell_array(connectivity, np.arange(0, len(connectivity) + 1, 3)))


def _surface(point_set):
    """Vertices, lines and outer faces of a vtkPointSet, and the rows (m,) of their points."""
    faces = configured(vtkGeometryFilter(), InputData=point_set, NonlinearSubdivisionLevel=0)
    surface = output_of(faces, PassThroughPointIds=True, OriginalPointIdsName=_ROWS)
    rows = surface.GetPointData().GetArray(_ROWS)
    return surface, np.zeros(0, int) if rows is None else arrays.to_numpy(rows)


def _used_points(point_set):
    """Rows of the points of all cells."""
    if isinstance(point_set, vtkPolyData):
        parts = [connectivity_of(cells)[0] for _, cells in polydata_cells(point_set)]
        return np.concatenate(parts)
    if isinstance(point_set, vtkUnstructuredGrid):
        return connectivity_of(point_set.GetCells())[0]
    return np.arange(point_set.GetNumberOfPoints())  # of a structured grid
