"""Points and cells of meshes as numpy arrays, and back; the quality of cells."""

import numpy as np
from vtkmodules import vtkCommonDataModel as vtk
from vtkmodules.vtkCommonCore import VTK_DOUBLE, VTK_FLOAT, VTK_UNSIGNED_CHAR, vtkPoints
from vtkmodules.vtkCommonExecutionModel import vtkAlgorithm
from vtkmodules.vtkFiltersCore import vtkAppendFilter, vtkPointDataToCellData, vtkTriangleFilter
from vtkmodules.vtkFiltersVerdict import vtkCellQuality

from vtk_mls.vtk import arrays
from vtk_mls.vtk.objects import configured, output_of

try:
    from vtkmodules.vtkFiltersCore import vtkExtractCells
except ImportError:  # in the releases of VTK 9.2
    from vtkmodules.vtkFiltersExtraction import vtkExtractCells

FACES = (  # getters for polyhedra; since VTK 9.4 the older ones return copies
    (vtk.vtkUnstructuredGrid.GetPolyhedronFaces, vtk.vtkUnstructuredGrid.GetPolyhedronFaceLocations)
    if hasattr(vtk.vtkUnstructuredGrid, "GetPolyhedronFaces")
    else (vtk.vtkUnstructuredGrid.GetFaces, vtk.vtkUnstructuredGrid.GetFaceLocations)
)
# For each type of box along the axes, the type of any box, and the order of its points.
BOXES = {
    vtk.VTK_PIXEL: (vtk.VTK_QUAD, (0, 1, 3, 2)),
    vtk.VTK_VOXEL: (vtk.VTK_HEXAHEDRON, (0, 1, 3, 2, 4, 5, 7, 6)),
}
_MAX_QUALITY = 2  # that of inverted wedges is down to -1.2
# Cell arrays of vtkPolyData in the order of its cell data, and the cell types of any size.
_KINDS = {
    "Verts": vtk.VTK_POLY_VERTEX,
    "Lines": vtk.VTK_POLY_LINE,
    "Polys": vtk.VTK_POLYGON,
    "Strips": vtk.VTK_TRIANGLE_STRIP,
}


def connectivity_of(cells):
    """Connectivity (m,) and offsets (n + 1,) of a vtkCellArray or None."""
    if cells is None or cells.GetNumberOfCells() == 0:
        return np.zeros(0, np.int64), np.zeros(1, np.int64)
    return arrays.to_numpy(cells.GetConnectivityArray()), arrays.to_numpy(cells.GetOffsetsArray())


def cell_array(connectivity, offsets):
    """The vtkCellArray of a connectivity (m,) and offsets (n + 1,)."""
    cells = vtk.vtkCellArray()
    cells.SetData(arrays.ids(offsets), arrays.ids(connectivity))
    return cells


def polydata_cells(mesh):
    """Type and vtkCellArray of the vertices, lines, polygons and strips of a vtkPolyData."""
    return [(kind, getattr(mesh, f"Get{name}")()) for name, kind in _KINDS.items()]


def positions_of(mesh):
    """The points (n, 3) of a vtkPointSet."""
    return arrays.to_numpy(mesh.GetPoints().GetData())


def set_positions(mesh, positions, vtk_type):
    """Set the points (n, 3) of a vtkPointSet, as VTK_FLOAT, or VTK_DOUBLE for any other type."""
    vtk_type, dtype = (VTK_FLOAT, "f4") if vtk_type == VTK_FLOAT else (VTK_DOUBLE, "f8")
    data = arrays.from_numpy(positions.astype(dtype, copy=False), vtk_type)
    mesh.SetPoints(configured(vtkPoints(), Data=data))


def triangle_polydata(points, triangles):
    """vtkPolyData of points (n, 3) and triangles (m, 3)."""
    polydata = vtk.vtkPolyData()
    set_positions(polydata, np.asarray(points), VTK_DOUBLE)
    polydata.SetPolys(cell_array(np.ravel(triangles), 3 * np.arange(len(triangles) + 1)))
    return polydata


def triangulated(polydata):
    """The triangles of the polygons and strips of a vtkPolyData, as vtkPolyData."""
    bare = configured(vtk.vtkPolyData(), Points=polydata.GetPoints(), Polys=polydata.GetPolys())
    bare.SetStrips(polydata.GetStrips())
    return output_of(vtkTriangleFilter(), InputData=without_empty(bare))


def convert_integer_points(mesh):
    """Convert the points of a vtkPointSet to float64 if they are integers."""
    if mesh.GetPoints().GetDataType() not in (VTK_FLOAT, VTK_DOUBLE):
        set_positions(mesh, positions_of(mesh), VTK_DOUBLE)


def extract_cells(grid, mask):
    """The cells of a vtkUnstructuredGrid where `mask` (n,) is true, with their points."""
    extract, ids = vtkExtractCells(), np.flatnonzero(mask)
    extract.SetCellIds(ids, len(ids))
    cells = output_of(extract, InputData=grid)
    cells.GetCellData().RemoveArray("vtkOriginalCellIds")
    return cells


def append_meshes(meshes):
    """Meshes as one vtkUnstructuredGrid with float64 points and the arrays that all have."""
    append = configured(vtkAppendFilter(), OutputPointsPrecision=vtkAlgorithm.DOUBLE_PRECISION)
    for mesh in meshes:
        append.AddInputData(mesh)
    return output_of(append)


def row_array(grid, name):
    """The integer cell array (n,) of a grid; clipping leaves it out where there are no cells."""
    array = grid.GetCellData().GetArray(name)
    return np.zeros(0, np.int64) if array is None else arrays.to_numpy(array)


def is_empty(mesh):
    """Which cells of a vtkDataSet have no points: (n,) bool."""
    if isinstance(mesh, vtk.vtkPolyData):
        sizes = [np.diff(connectivity_of(cells)[1]) for _, cells in polydata_cells(mesh)]
    elif isinstance(mesh, vtk.vtkUnstructuredGrid):
        sizes = [np.diff(connectivity_of(mesh.GetCells())[1])]
    else:
        return np.zeros(mesh.GetNumberOfCells(), bool)
    return np.concatenate(sizes) == 0


def without_empty(mesh):
    """A copy of a mesh without its cells that have no points; the mesh itself if all have some.

    VTK's filters read memory out of bounds for such cells.
    """
    empty = is_empty(mesh)
    if not empty.any():
        return mesh
    filled = configured(mesh.NewInstance(), Points=mesh.GetPoints())
    filled.GetPointData().ShallowCopy(mesh.GetPointData())
    filled.GetFieldData().ShallowCopy(mesh.GetFieldData())
    rows = np.flatnonzero(~empty)
    if isinstance(mesh, vtk.vtkPolyData):
        for name in _KINDS:
            getattr(filled, f"Set{name}")(_without_empty(getattr(mesh, f"Get{name}")()))
    elif len(rows) > 0:
        types, cells = arrays.cell_types(mesh)[rows], _without_empty(mesh.GetCells())
        _set_cells(filled, types, cells, _faces(mesh, rows))
    arrays.set_rows(filled.GetCellData(), mesh.GetCellData(), rows)
    return filled


def _without_empty(cells):
    connectivity, offsets = connectivity_of(cells)
    return cell_array(connectivity, np.unique(offsets))


def append_empty(grid, mesh):
    """Append the cells of a mesh that have no points to a vtkUnstructuredGrid; their rows (n,)."""
    rows = np.flatnonzero(is_empty(mesh))
    if len(rows) == 0:
        return rows
    count = grid.GetNumberOfCells()
    connectivity, offsets = connectivity_of(grid.GetCells())
    types = arrays.cell_types(grid) if count else np.zeros(0, np.uint8)
    types = np.concatenate([types, _types(mesh)[rows]])
    faces = _faces(grid, np.append(np.arange(count), np.full(len(rows), -1))) if count else None
    offsets = np.append(offsets, np.full(len(rows), offsets[-1]))
    _set_cells(grid, types, cell_array(connectivity, offsets), faces)
    return rows


def make_boxes_free(grid):
    """Convert the voxels and pixels of a vtkUnstructuredGrid to hexahedra and quads.

    The edges of voxels and pixels lie along the axes by definition; those of moved points do not.
    """
    if grid.GetNumberOfCells() == 0:
        return
    types = arrays.cell_types(grid).copy()
    if not any((types == kind).any() for kind in BOXES):  # np.isin takes 40 times as long
        return
    connectivity, offsets = connectivity_of(grid.GetCells())
    connectivity = connectivity.copy()
    for kind, (free, order) in BOXES.items():
        boxes = np.flatnonzero((types == kind) & (np.diff(offsets) == len(order)))
        first = offsets[boxes][:, None]
        connectivity[first + np.arange(len(order))] = connectivity[first + order]
        types[boxes] = free
    _set_cells(grid, types, cell_array(connectivity, offsets), _faces(grid, np.arange(len(types))))


def _types(mesh):
    """Types of cells; for vtkPolyData the types for cells of any size."""
    if isinstance(mesh, vtk.vtkUnstructuredGrid):
        types = arrays.cell_types(mesh)
        # polyhedra need faces
        return np.where(types == vtk.VTK_POLYHEDRON, vtk.VTK_EMPTY_CELL, types)
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
    """VTK's locations and faces for the cells `rows`; -1 stands for a cell without faces.

    They are vtkCellArray, or vtkIdTypeArray before VTK 9.4; None without polyhedra.
    """
    faces, locations = (get(grid) for get in FACES)
    if faces is None or locations is None:
        return None
    if not isinstance(locations, vtk.vtkCellArray):
        return arrays.ids(np.append(arrays.to_numpy(locations), -1)[rows]), faces
    if faces.GetNumberOfCells() == 0:
        return None
    connectivity, offsets = connectivity_of(locations)
    sizes = np.append(np.diff(offsets), 0)
    selected = connectivity[np.repeat(np.isin(np.arange(len(sizes) - 1), rows), sizes[:-1])]
    return cell_array(selected, np.concatenate([[0], np.cumsum(sizes[rows])])), faces


def scaled_jacobians(mesh, positions):
    """VTK's scaled Jacobian (m,) of the cells of a vtkPointSet with its points at `positions`.

    At most 1, for regular cells; 0 or less for solid cells that are inside out at a corner, and for
    concave quads. NaN for cells that are no triangles, quads, tetrahedra, hexahedra, wedges or
    pyramids, and for those with a point that is not finite.
    """
    moved = mesh.NewInstance()
    moved.CopyStructure(mesh)
    set_positions(moved, positions, VTK_DOUBLE)
    result = np.full(mesh.GetNumberOfCells(), np.nan)
    filled = without_empty(moved)
    if filled.GetNumberOfCells() == 0:
        return result
    quality = configured(vtkCellQuality(), UndefinedQuality=np.nan, UnsupportedGeometry=np.nan)
    quality.SetQualityMeasureToScaledJacobian()
    data = output_of(quality, InputData=filled).GetCellData()
    values = arrays.to_numpy(data.GetArray("CellQuality")).copy()
    values[np.abs(values) > _MAX_QUALITY] = np.nan  # 1e30 if all corners are at one place
    if not np.isfinite(positions).all():
        values[~_are_finite(filled, positions)] = np.nan
    result[~is_empty(moved)] = values
    return result


def _are_finite(mesh, positions):
    """Which cells have finite points only: (m,) bool. Others have any quality by VTK."""
    arrays.add(mesh.GetPointData(), "sum", positions.sum(axis=1, dtype=np.float64))
    means = output_of(vtkPointDataToCellData(), InputData=mesh)
    return np.isfinite(arrays.to_numpy(means.GetCellData().GetArray("sum")))
