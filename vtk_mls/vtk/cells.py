"""The cells of vtkPolyData and vtkUnstructuredGrid as numpy arrays, and back."""

from __future__ import annotations

import numpy as np
from vtkmodules.vtkCommonCore import VTK_UNSIGNED_CHAR
from vtkmodules.vtkCommonDataModel import (
    VTK_EMPTY_CELL,
    VTK_HEXAHEDRON,
    VTK_PIXEL,
    VTK_POLY_LINE,
    VTK_POLY_VERTEX,
    VTK_POLYGON,
    VTK_POLYHEDRON,
    VTK_QUAD,
    VTK_TRIANGLE_STRIP,
    VTK_VOXEL,
    vtkCellArray,
    vtkPolyData,
    vtkUnstructuredGrid,
)

from vtk_mls.vtk import arrays

FACES = (  # of polyhedra, without the copies that the older methods make since VTK 9.4
    (vtkUnstructuredGrid.GetPolyhedronFaces, vtkUnstructuredGrid.GetPolyhedronFaceLocations)
    if hasattr(vtkUnstructuredGrid, "GetPolyhedronFaces")
    else (vtkUnstructuredGrid.GetFaces, vtkUnstructuredGrid.GetFaceLocations)
)
# How many corners a box along the axes has, the type that any box has, and its order of corners.
_BOXES = {
    VTK_PIXEL: (VTK_QUAD, (0, 1, 3, 2)),
    VTK_VOXEL: (VTK_HEXAHEDRON, (0, 1, 3, 2, 4, 5, 7, 6)),
}
# The cells of vtkPolyData in the order of their data, and the types of those with any size.
_KINDS = {
    "Verts": VTK_POLY_VERTEX,
    "Lines": VTK_POLY_LINE,
    "Polys": VTK_POLYGON,
    "Strips": VTK_TRIANGLE_STRIP,
}


def connectivity_of(cells):
    """Connectivity and offsets of a vtkCellArray or None.

    Returns
    -------
    connectivity : (m,) integers
    offsets : (n + 1,) integers
    """
    if cells is None or cells.GetNumberOfCells() == 0:
        return np.zeros(0, np.int64), np.zeros(1, np.int64)
    held = cells.GetConnectivityArray(), cells.GetOffsetsArray()
    connectivity, offsets = (arrays.to_numpy(array) for array in held)
    return connectivity, offsets


def cell_array(connectivity, offsets):
    """The vtkCellArray of a connectivity (m,) and offsets (n + 1,)."""
    cells = vtkCellArray()
    cells.SetData(arrays.ids(offsets), arrays.ids(connectivity))
    return cells


def polydata_cells(mesh):
    """Type and vtkCellArray of the vertices, lines, polygons and strips of a vtkPolyData."""
    return [(kind, getattr(mesh, f"Get{name}")()) for name, kind in _KINDS.items()]


def is_empty(mesh):
    """Which cells of a vtkDataSet have no points: (n,) bool."""
    if isinstance(mesh, vtkPolyData):
        sizes = [np.diff(connectivity_of(cells)[1]) for _, cells in polydata_cells(mesh)]
    elif isinstance(mesh, vtkUnstructuredGrid):
        sizes = [np.diff(connectivity_of(mesh.GetCells())[1])]
    else:
        return np.zeros(mesh.GetNumberOfCells(), bool)
    return np.concatenate(sizes) == 0


def without_empty(mesh):
    """A copy of a mesh without cells that have no points; the mesh itself if it has none of these.

    VTK's filters read memory that is not theirs for such cells.
    """
    empty = is_empty(mesh)
    if not empty.any():
        return mesh
    filled = mesh.NewInstance()
    filled.SetPoints(mesh.GetPoints())
    filled.GetPointData().ShallowCopy(mesh.GetPointData())
    filled.GetFieldData().ShallowCopy(mesh.GetFieldData())
    rows = np.flatnonzero(~empty)
    if isinstance(mesh, vtkPolyData):
        for name in _KINDS:
            connectivity, offsets = connectivity_of(getattr(mesh, f"Get{name}")())
            getattr(filled, f"Set{name}")(cell_array(connectivity, np.unique(offsets)))
    elif len(rows) > 0:
        connectivity, offsets = connectivity_of(mesh.GetCells())
        _set_cells(
            filled,
            arrays.cell_types(mesh)[rows],
            cell_array(connectivity, np.unique(offsets)),
            _faces(mesh, rows),
        )
    arrays.set_rows(filled.GetCellData(), mesh.GetCellData(), rows)
    return filled


def append_empty(grid, mesh):
    """Append cells of a mesh that have no points, with their data, to a vtkUnstructuredGrid."""
    rows = np.flatnonzero(is_empty(mesh))
    if len(rows) == 0:
        return
    count = grid.GetNumberOfCells()
    connectivity, offsets = connectivity_of(grid.GetCells())
    types = arrays.cell_types(grid) if count else np.zeros(0, np.uint8)
    everything = np.concatenate([np.arange(count), np.full(len(rows), -1)])
    faces = _faces(grid, everything) if count else None
    _set_cells(
        grid,
        np.concatenate([types, _types(mesh)[rows]]),
        cell_array(connectivity, np.concatenate([offsets, np.full(len(rows), offsets[-1])])),
        faces,
    )
    data = grid.GetCellData()
    numbers = range(data.GetNumberOfArrays())
    held = [(data.GetAbstractArray(i), data.IsArrayAnAttribute(i)) for i in numbers]
    data.Initialize()
    for array, role in held:
        longer = _with_tuples(array, _of_same_kind(mesh.GetCellData(), array, role), rows)
        position = data.AddArray(longer)
        if role >= 0:
            data.SetActiveAttribute(position, role)


def _of_same_kind(attributes, array, role):
    """The array with the name of another, or, if that has none, with its role; None if unknown."""
    if array.GetName():
        return attributes.GetAbstractArray(array.GetName())
    return attributes.GetAbstractAttribute(role) if role >= 0 else None


def _with_tuples(array, source, rows):
    """A copy of an array, and behind it the tuples `rows` of another; zeros if that is None."""
    longer = array.NewInstance()
    longer.DeepCopy(array)
    count = array.GetNumberOfTuples()
    if source is not None:
        for row in rows.tolist():
            longer.InsertNextTuple(row, source)
        return longer
    longer.Resize(count + len(rows))
    longer.SetNumberOfTuples(count + len(rows))
    if arrays.is_numeric(longer):
        arrays.to_numpy(longer)[count:] = 0
    return longer


def make_boxes_free(grid):
    """Make hexahedra and quads of the voxels and pixels of a vtkUnstructuredGrid.

    Those have edges along the axes by definition, which they have no more when points move.
    """
    if grid.GetNumberOfCells() == 0:
        return
    types = arrays.cell_types(grid).copy()
    if not np.isin(types, list(_BOXES)).any():
        return
    connectivity, offsets = connectivity_of(grid.GetCells())
    connectivity = connectivity.copy()
    for kind, (free, order) in _BOXES.items():
        boxes = np.flatnonzero((types == kind) & (np.diff(offsets) == len(order)))
        first = offsets[boxes][:, None]
        connectivity[first + np.arange(len(order))] = connectivity[first + order]
        types[boxes] = free
    rows = np.arange(len(types))
    _set_cells(grid, types, cell_array(connectivity, offsets), _faces(grid, rows))


def _types(mesh):
    """Types of cells; those of vtkPolyData as if they had any size."""
    if isinstance(mesh, vtkUnstructuredGrid):
        types = arrays.cell_types(mesh)
        return np.where(types == VTK_POLYHEDRON, VTK_EMPTY_CELL, types)  # which must have faces
    kinds = polydata_cells(mesh)
    return np.repeat([kind for kind, _ in kinds], [cells.GetNumberOfCells() for _, cells in kinds])


def _set_cells(grid, types, cells, faces):
    """Set the cells of a vtkUnstructuredGrid; `faces` are None or as of `_faces`."""
    types = arrays.from_numpy(types.astype(np.uint8), VTK_UNSIGNED_CHAR)
    if faces is None:
        grid.SetCells(types, cells)
    else:
        getattr(grid, "SetPolyhedralCells", grid.SetCells)(types, cells, *faces)


def _faces(grid, rows):
    """What VTK stores of the faces of polyhedra, for the cells `rows`; -1 is one without faces.

    Returns
    -------
    locations, faces : vtkCellArray, or vtkIdTypeArray before VTK 9.4; or None without polyhedra
    """
    faces, locations = (get(grid) for get in FACES)
    if faces is None or locations is None:
        return None
    if not isinstance(locations, vtkCellArray):
        found = np.append(arrays.to_numpy(locations), -1)[rows]
        return arrays.ids(found), faces
    if faces.GetNumberOfCells() == 0:
        return None
    connectivity, offsets = connectivity_of(locations)
    sizes = np.append(np.diff(offsets), 0)
    is_kept = np.isin(np.arange(len(sizes) - 1), rows)
    kept = connectivity[np.repeat(is_kept, sizes[:-1])]
    return cell_array(kept, np.concatenate([[0], np.cumsum(sizes[rows])])), faces
