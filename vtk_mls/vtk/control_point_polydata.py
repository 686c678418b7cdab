"""Control points as polydata, the cells that are handles, and arrows to look at."""

import numpy as np
from vtkmodules.vtkCommonCore import VTK_DOUBLE
from vtkmodules.vtkCommonDataModel import vtkPolyData, vtkUnstructuredGrid
from vtkmodules.vtkFiltersCore import vtkGlyph3D
from vtkmodules.vtkFiltersGeometry import vtkGeometryFilter
from vtkmodules.vtkFiltersSources import vtkArrowSource

from vtk_mls.base.errors import InputError
from vtk_mls.model.handles.handle_cells import HandleCells
from vtk_mls.vtk import arrays
from vtk_mls.vtk.cells import (
    cell_array,
    connectivity_of,
    polydata_cells,
    positions_of,
    set_positions,
    triangulated,
)
from vtk_mls.vtk.objects import configured, output_of

# Names of the point arrays.
DISPLACEMENT, WEIGHT, LABEL, PATH = "Displacement", "Weight", "Label", "Path"


def fill_polydata(polydata, rest, deformed, weights, labels=(), cells=None, path=()):
    """Make control-point polydata, what `arrays.control_points` reads.

    It gets the active vectors "Displacement" = q - p, "Weight" if there are weights (n,), and the
    `cells`, by default a vertex for each p. p and q are (n, 3) float64, world coordinates. Labels
    become the point array "Label" if any is not empty. The intermediate places `path` (k, n, 3)
    become "Path" of 3 k components, the displacements from p to each.
    """
    set_positions(polydata, rest, VTK_DOUBLE)
    set_cells(polydata, cells or HandleCells.points(len(rest)))
    arrays.add(polydata.GetPointData(), DISPLACEMENT, deformed - rest)
    polydata.GetPointData().SetActiveVectors(DISPLACEMENT)
    if weights is not None:
        arrays.add(polydata.GetPointData(), WEIGHT, weights)
    if any(labels):
        arrays.add_texts(polydata.GetPointData(), LABEL, labels)
    if len(path):
        arrays.add(polydata.GetPointData(), PATH, np.hstack([places - rest for places in path]))


def path_of(point_set):
    """Intermediate places (k, n, 3) of control points, world coordinates, from their array "Path".

    k is 0 without the array. ValueError if it is not finite or has the wrong shape.
    """
    count, array = point_set.GetNumberOfPoints(), point_set.GetPointData().GetArray(PATH)
    if array is None or count == 0:
        return np.zeros((0, count, 3))
    components, tuples = array.GetNumberOfComponents(), array.GetNumberOfTuples()
    if components % 3 or tuples != count:
        raise InputError(
            f", array `{PATH}`, must have 3 components per intermediate place and one tuple for "
            f"each of {count} points, got {components} components, {tuples} tuples",
            argument="ControlPoints",
        )
    moves = arrays.to_numpy(array).astype(np.float64).reshape(count, -1, 3)
    if not np.isfinite(moves).all():
        raise InputError(f", array `{PATH}`, must be finite", argument="ControlPoints")
    return positions_of(point_set) + moves.swapaxes(0, 1)


def is_moving(polydata):
    """Whether any displacement of control-point polydata, also on the way, is not 0."""
    data = [polydata.GetPointData().GetArray(name) for name in (DISPLACEMENT, PATH)]
    return any(arrays.to_numpy(array).any() for array in data if array is not None)


def as_polydata(point_set):
    """A vtkPointSet as vtkPolyData with its cells as handles; polydata as it is."""
    if isinstance(point_set, vtkPolyData):
        return point_set
    polydata = configured(vtkPolyData(), Points=point_set.GetPoints())
    polydata.GetPointData().ShallowCopy(point_set.GetPointData())
    polydata.GetFieldData().ShallowCopy(point_set.GetFieldData())
    set_cells(polydata, cells_of(point_set))
    return polydata


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
    polydata.SetVerts(cell_array(cells.vertices, np.arange(len(cells.vertices) + 1)))
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
        return np.concatenate([connectivity_of(cells)[0] for _, cells in polydata_cells(point_set)])
    if isinstance(point_set, vtkUnstructuredGrid):
        return connectivity_of(point_set.GetCells())[0]
    return np.arange(point_set.GetNumberOfPoints())  # of a structured grid


def fill_arrows(polydata, rest, deformed):
    """Fill polydata with arrows from p to q, (n, 3) each, world coordinates.

    They have the point vectors "Displacement". There is none for control points that stay, or whose
    displacement is not finite.
    """
    displacement = deformed - rest
    moved = np.isfinite(displacement).all(axis=1) & displacement.any(axis=1)
    if not moved.any():
        return
    handles, glyphs = vtkPolyData(), vtkGlyph3D()
    fill_polydata(handles, rest[moved], deformed[moved], None)
    glyphs.SetScaleModeToScaleByVector()
    arrow = output_of(vtkArrowSource())
    polydata.ShallowCopy(output_of(glyphs, InputData=handles, SourceData=arrow))
    polydata.GetPointData().GetArray("GlyphVector").SetName(DISPLACEMENT)
