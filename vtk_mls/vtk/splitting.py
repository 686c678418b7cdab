"""Meshes split along cuts, so that each side can move on its own.

VTK's clipping divides the cells that a cut crosses, and points on the cut become two, one for each
side. A half-plane divides the cells on its whole plane, which keeps the mesh conforming; beyond its
edge they are joined again. A surface divides the cells that touch its bounding box, and joins them
beside its edge; its bends within one cell are ignored.

Clipping returns two separate meshes. To join them away from the cut, each point gets a key, which
is equal for points to be merged; VTK merges points with the keys as coordinates.

Points without cells, poly-vertices, and flat cells that clipping cannot divide stay as they are.
"""

import numpy as np
from vtkmodules import vtkCommonDataModel as vtk
from vtkmodules.vtkCommonCore import VTK_BIT, VTK_DOUBLE, VTK_ID_TYPE
from vtkmodules.vtkFiltersCore import (
    vtkImplicitPolyDataDistance,
    vtkPolyDataNormals,
    vtkStaticCleanUnstructuredGrid,
)

from vtk_mls.base.progress import SILENT
from vtk_mls.vtk import arrays
from vtk_mls.vtk.cells import (
    append_empty,
    append_meshes,
    cell_array,
    connectivity_of,
    extract_cells,
    is_empty,
    positions_of,
    row_array,
    set_positions,
    triangle_polydata,
    without_empty,
)
from vtk_mls.vtk.clipping import HEIGHT, clip_cells
from vtk_mls.vtk.objects import configured, output_of, shallow_copy

_MAX_PAIRWISE_POINTS = 27  # lines, strips, polygons and curved cells of high order have more
_ON_CUT = 1e-6  # distance from a cut of points on it, as a share of the mesh's extent

_POINT, _TO_CUT, _SIDE, _POSITION = "_Point", "_ToCut", "_Side", "_Position"
_SOURCE = "_Source"  # point and cell array: row in the mesh


def split(mesh, cuts, progress=SILENT):
    """A vtkDataSet with its cells divided along cuts: vtkPolyData if it is one, or unstructured.

    It has all arrays of points and cells. At new points numbers are interpolated; ids, bits and
    texts are those of the nearest point. Global ids are plain arrays: pieces repeat them.

    Also returns the vectors (n, 3) from each point on a cut to the exact cut, world units, and the
    normals (n, 3) of the cut towards the cells of the point; 0 for points on no cut.
    """
    named = shallow_copy(mesh)
    arrays.name_normals(named)
    cell_data = shallow_copy(named.GetCellData())
    named.GetCellData().Initialize()  # cells have only their rows until the end
    arrays.add(named.GetPointData(), _SOURCE, np.arange(float(named.GetNumberOfPoints())))
    arrays.add(named.GetCellData(), _SOURCE, np.arange(named.GetNumberOfCells()))
    mesh, grid = named, _unstructured(without_empty(named))
    extent = _extent(positions_of(grid))
    for name in (_TO_CUT, _SIDE):
        _set_array(grid, name, np.zeros((grid.GetNumberOfPoints(), 3)))
    whole = grid
    dividing, joining = progress.divided(4, 1)
    if grid.GetNumberOfCells() == 0:
        cuts = ()
    for cut, part in dividing.parts(cuts):
        grid = _divide(grid, cut, extent, part)
    joining.report(0)
    if grid is not whole:  # dividing drops points without cells
        grid = append_meshes([grid, _without_cells(whole)])
    to_cut, side = (_values(grid, name).copy() for name in (_TO_CUT, _SIDE))
    for name in (_POINT, HEIGHT, _TO_CUT, _SIDE, _POSITION):
        grid.GetPointData().RemoveArray(name)
    _add_lost_arrays(grid.GetPointData(), mesh.GetPointData(), lambda: _nearest(grid, whole))
    rows = np.concatenate([row_array(grid, _SOURCE), append_empty(grid, mesh)])
    grid.GetCellData().Initialize()
    arrays.set_rows(grid.GetCellData(), cell_data, rows)
    grid.GetPointData().RemoveArray(_SOURCE)
    arrays.set_roles(grid.GetPointData(), mesh.GetPointData())
    point_type = mesh.GetPoints().GetDataType() if isinstance(mesh, vtk.vtkPointSet) else VTK_DOUBLE
    set_positions(grid, positions_of(grid), point_type)
    return (_polydata(grid) if isinstance(mesh, vtk.vtkPolyData) else grid), to_cut, side


def crossed(mesh, cuts):
    """Whether a cut crosses a line between two points of a cell: (n,) bool.

    Of cells with many points only lines between consecutive points count, of vertices none.
    """
    filled = ~is_empty(mesh)
    result = np.zeros(len(filled), bool)
    if not filled.any():
        return result
    grid = _unstructured(without_empty(mesh))
    positions, (connectivity, offsets) = positions_of(grid), connectivity_of(grid.GetCells())
    sizes, types = np.diff(offsets), arrays.cell_types(grid)
    is_crossed = np.zeros(len(sizes), bool)
    is_small = sizes <= _MAX_PAIRWISE_POINTS
    for cut in cuts:
        _, low, high = _heights(grid, cut, 0)
        candidates = (low < 0) & (high >= 0) & (types != vtk.VTK_POLY_VERTEX)
        for size in np.unique(sizes[candidates & is_small]):
            rows = np.flatnonzero(candidates & (sizes == size))
            x = positions[connectivity[offsets[rows][:, None] + np.arange(size)]]
            for a, b in zip(*np.triu_indices(size, 1)):
                is_crossed[rows] |= cut.void_distance(x[:, a], x[:, b]) < 0
        for cell in np.flatnonzero(candidates & ~is_small):
            x = positions[connectivity[offsets[cell] : offsets[cell + 1]]]
            is_crossed[cell] |= (cut.void_distance(x[:-1], x[1:]) < 0).any()
    result[filled] = is_crossed
    return result


def _nearest(grid, whole):
    """Rows (n,) of the points of `whole` that those of `grid` are, or else lie next to.

    New points count as the nearest corner of a cell that they divide.
    """
    x, places, sources = positions_of(grid), positions_of(whole), _values(grid, _SOURCE)
    rows = np.clip(np.rint(sources), 0, max(len(places) - 1, 0)).astype(np.int64)
    new = np.flatnonzero((sources != rows) | ~_same(places[rows], x))
    connectivity, offsets = connectivity_of(grid.GetCells())
    piece = np.zeros(len(x), np.int64)
    piece[connectivity] = np.repeat(np.arange(len(offsets) - 1), np.diff(offsets))
    cell = np.searchsorted(row_array(whole, _SOURCE), row_array(grid, _SOURCE)[piece[new]])
    connectivity, offsets = connectivity_of(whole.GetCells())
    sizes = np.diff(offsets)[cell]
    for size in np.unique(sizes):
        points = new[sizes == size]
        corners = connectivity[offsets[cell[sizes == size]][:, None] + np.arange(size)]
        distance = np.linalg.norm(places[corners] - x[points, None], axis=2)
        rows[points] = corners[np.arange(len(corners)), distance.argmin(axis=1)]
    return rows


def _add_lost_arrays(attributes, source, make_rows):
    """Add the arrays of `source` that VTK's filters have left out, such as ids, by rows in it."""
    lost, names = vtk.vtkDataSetAttributes(), [a.GetName() for a in arrays.all_arrays(attributes)]
    for array in arrays.all_arrays(source):
        if array.GetName() not in names:
            lost.AddArray(array)
    if lost.GetNumberOfArrays():
        arrays.set_rows(attributes, lost, make_rows())


def _unstructured(mesh):
    """A copy as vtkUnstructuredGrid, with float64 points, and of their arrays those of numbers."""
    grid = append_meshes([mesh])
    set_positions(grid, positions_of(grid), VTK_DOUBLE)
    for row, array in reversed([*enumerate(arrays.all_arrays(grid.GetPointData()))]):
        if not arrays.is_numeric(array) or array.GetDataType() in (VTK_BIT, VTK_ID_TYPE):
            grid.GetPointData().RemoveArray(row)  # VTK would join texts, and drop ids
    grid.GetPointData().SetActiveScalars(None)  # clipping drops them
    return grid


def _extent(positions):
    """Size of a mesh; points (n, 3) that are not finite, and a few far away, do not count."""
    x = positions[np.isfinite(positions).all(axis=1)]
    if len(x) < 2:
        return 1.0
    spread = 4 * np.median(np.abs(x - np.median(x, axis=0)), axis=0).max()  # if they fill a box
    return min(np.ptp(x, axis=0).max(), 30 * spread if spread > 0 else np.inf) or 1.0


def _divide(grid, cut, extent, progress):
    """`grid` with its points on `cut` doubled."""
    progress.report(0)
    height, low, high = _heights(grid, cut, _ON_CUT * extent)
    touched = (low <= 0) & (high >= 0)
    if not touched.any():
        return grid
    is_cloud = arrays.cell_types(grid) == vtk.VTK_POLY_VERTEX  # cannot be divided
    positions = positions_of(grid)
    _set_array(grid, _POINT, np.arange(len(positions), dtype=np.float64))
    _set_array(grid, HEIGHT, np.where(np.isfinite(height), height, extent))
    crossing = touched & (low < 0) & (high > 0) & ~is_cloud
    above = touched & ((low >= 0) | is_cloud)
    progress.report(0.2)
    *pieces, undivided = clip_cells(extract_cells(grid, crossing))
    progress.report(0.5)
    whole = [extract_cells(grid, cells) for cells in (above, touched & ~above & ~crossing)]
    parts = [(0, append_meshes([extract_cells(grid, ~touched), undivided]))]
    parts += [(side, append_meshes(pair)) for side, *pair in zip((1, -1), whole, pieces)]
    parts = [(side, part) for side, part in parts if part.GetNumberOfPoints() > 0]
    keys = _keys(parts, cut, positions, extent)
    progress.report(0.8)
    return _join([part for _, part in parts], keys)


def _keys(parts, cut, positions, extent):
    """Keys of the points of parts above (1), below (-1) and off (0) a cut.

    The key of an old point is its index; a point on the cut has another key on each side, and its
    arrays `_TO_CUT` and `_SIDE` are set.
    """
    height_of = height_function(cut)
    keys, edges = [], []
    for side, part in parts:
        x, point = positions_of(part), _values(part, _POINT)
        on_cut = np.flatnonzero(np.abs(_values(part, HEIGHT)) <= _ON_CUT * extent)
        normal = _normals(height_of, x[on_cut], extent)
        to_cut = -height_of(x[on_cut])[:, None] * normal
        ahead, behind = (x[on_cut] + to_cut + t * _ON_CUT * extent * normal for t in (10, -10))
        parted = (side != 0) & (cut.void_distance(ahead, behind) < 0)
        if cut.plane is None:  # else points are on the cut, not above it
            parted[parted] = ~cut.is_beside(x[on_cut[parted]], to_cut[parted])
        for name, offset in ((_TO_CUT, to_cut), (_SIDE, side * normal)):
            values = _values(part, name).copy()
            values[on_cut[parted]] += offset[parted]
            _set_array(part, name, values)
        sides = np.zeros(len(x))
        sides[on_cut[parted]] = side % 3
        nearest = np.clip(np.rint(point), 0, len(positions) - 1).astype(np.int64)
        is_old = (point == nearest) & _same(positions[nearest], x)
        keys.append(np.where(is_old, nearest + len(positions) * sides, -1))
        # new points at the same position of the same edge are the same
        edges.append(np.column_stack([x / extent * 1e10, point * 1e6, sides])[~is_old])
    _, edge_ids = np.unique(np.rint(np.concatenate(edges)), axis=0, return_inverse=True)
    counts = np.cumsum([len(rows) for rows in edges])
    for key, new_ids in zip(keys, np.split(edge_ids.reshape(-1), counts)):
        key[key < 0] = 3 * len(positions) + new_ids
    return keys


def _same(x, y):
    """Which rows are equal; NaN equals NaN."""
    return ((x == y) | (np.isnan(x) & np.isnan(y))).all(axis=1)


def _join(parts, keys):
    """The parts as one mesh in which points with the same key are one."""
    grid = append_meshes(parts)
    keys = np.concatenate(keys).astype(np.int64)
    _set_array(grid, _POSITION, positions_of(grid))
    coordinates = np.column_stack([keys & 0x1FFFF, keys >> 17 & 0x1FFFF, keys >> 34])
    set_positions(grid, coordinates, VTK_DOUBLE)
    grid = output_of(vtkStaticCleanUnstructuredGrid(), InputData=grid, Tolerance=0)
    set_positions(grid, _values(grid, _POSITION), VTK_DOUBLE)
    return grid


def _heights(grid, cut, tolerance):
    """Signed distances of points from a cut or its continuation, and their range in each cell.

    Distances up to `tolerance` are 0. They are infinite for points far from a bounded cut, points
    that are not finite, and cells with such a point.
    """
    positions, (connectivity, offsets) = positions_of(grid), connectivity_of(grid.GetCells())
    near = np.ones(len(positions), bool)
    lowest, highest = cut.bounds
    if np.isfinite([lowest, highest]).all():
        touching = np.ones(len(offsets) - 1, bool)
        for axis in range(3):
            low, high = _range(positions[:, axis], connectivity, offsets)
            touching &= (low <= highest[axis]) & (high >= lowest[axis])
        near = np.zeros(len(positions), bool)
        near[connectivity[np.repeat(touching, np.diff(offsets))]] = True
    height = np.full(len(positions), np.inf)
    height[near] = height_function(cut)(positions[near])
    height[~np.isfinite(height)] = np.inf
    height[np.abs(height) <= tolerance] = 0
    low, high = _range(height, connectivity, offsets)
    low[np.isinf(high)] = np.inf
    return height, low, high


def height_function(cut):
    """The signed distance from a cut as a function of points (n, 3)."""
    plane = cut.plane
    if plane is not None:
        return plane.height
    surface = triangle_polydata(cut.points, cut.triangles)
    oriented = output_of(vtkPolyDataNormals(), InputData=surface, Splitting=False)
    distance = configured(vtkImplicitPolyDataDistance(), Input=oriented)

    def height(positions):
        points = arrays.from_numpy(positions, VTK_DOUBLE)
        result = arrays.from_numpy(np.empty(len(positions)), VTK_DOUBLE)
        vtk.vtkImplicitFunction.EvaluateFunction(distance, points, result)
        return arrays.to_numpy(result).copy()

    return height


def _normals(height_of, positions, extent):
    """Directions (n, 3) in which the signed distance grows."""
    steps = _ON_CUT * extent * np.eye(3)
    slopes = [height_of(positions + step) - height_of(positions - step) for step in steps]
    normals = np.stack(slopes, axis=1)
    return normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)


def _without_cells(grid):
    """The points of `grid` that no cell uses, without cells."""
    is_used = np.zeros(grid.GetNumberOfPoints(), bool)
    is_used[connectivity_of(grid.GetCells())[0]] = True
    rows = np.flatnonzero(~is_used)
    loose = vtk.vtkUnstructuredGrid()
    set_positions(loose, positions_of(grid)[rows], VTK_DOUBLE)
    arrays.set_rows(loose.GetPointData(), grid.GetPointData(), rows)
    # vtkAppendFilter keeps the arrays that all have
    arrays.set_rows(loose.GetCellData(), grid.GetCellData(), rows[:0])
    return loose


def _range(values, connectivity, offsets):
    """Least and greatest value of the points of each cell; infinite for cells without points."""
    low, high = np.full((2, len(offsets) - 1), np.inf)
    filled = np.diff(offsets) > 0
    if filled.any():
        values, first = values[connectivity], offsets[:-1][filled]
        low[filled] = np.minimum.reduceat(values, first)
        high[filled] = np.maximum.reduceat(values, first)
    return low, high


def _values(grid, name):
    return arrays.to_numpy(grid.GetPointData().GetArray(name))


def _set_array(grid, name, values):
    arrays.add(grid.GetPointData(), name, values.astype(np.float64, copy=False))


def _polydata(grid):
    """A grid of vertices, lines, polygons and strips as vtkPolyData."""
    polydata = configured(vtk.vtkPolyData(), Points=grid.GetPoints())
    polydata.GetPointData().ShallowCopy(grid.GetPointData())
    types, (connectivity, offsets) = arrays.cell_types(grid), connectivity_of(grid.GetCells())
    sizes, order = np.diff(offsets), []
    for set_cells, cell_types in (
        (polydata.SetVerts, (vtk.VTK_VERTEX, vtk.VTK_POLY_VERTEX)),
        (polydata.SetLines, (vtk.VTK_LINE, vtk.VTK_POLY_LINE)),
        (polydata.SetPolys, (vtk.VTK_TRIANGLE, vtk.VTK_QUAD, vtk.VTK_POLYGON)),
        (polydata.SetStrips, (vtk.VTK_TRIANGLE_STRIP,)),
    ):
        mask = np.isin(types, cell_types)
        offsets = np.concatenate([[0], np.cumsum(sizes[mask])])
        set_cells(cell_array(connectivity[np.repeat(mask, sizes)], offsets))
        order.append(np.flatnonzero(mask))
    arrays.set_rows(polydata.GetCellData(), grid.GetCellData(), np.concatenate(order))
    return polydata
