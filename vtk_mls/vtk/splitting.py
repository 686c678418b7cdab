"""Meshes split along cuts, so that each side can move on its own.

Cells that a cut crosses are divided there by VTK's clipping, and points on the cut become two, one
for each side. A half-plane divides the cells on all of its plane, which keeps the mesh conforming,
and joins them again beyond its edge. A surface divides the cells that touch its bounding box; how
it bends within one cell does not count.

Clipping leaves two meshes that know nothing of each other. To join them again where they are not
apart, whatever types their cells have, each point gets a key, the same for points that are to be
one. With the keys as coordinates VTK's merging of points does the rest.

Nothing gets lost: points without cells and poly-vertices stay as they are, and so do cells that
clipping makes nothing of, as it does of some that are flat.
"""

from __future__ import annotations

from functools import partial

import numpy as np
from vtkmodules.vtkCommonCore import VTK_DOUBLE, VTK_FLOAT, VTK_UNSIGNED_CHAR, vtkPoints
from vtkmodules.vtkCommonDataModel import (
    VTK_CONVEX_POINT_SET,
    VTK_HEXAGONAL_PRISM,
    VTK_LINE,
    VTK_POLY_LINE,
    VTK_POLY_VERTEX,
    VTK_POLYGON,
    VTK_POLYHEDRON,
    VTK_QUAD,
    VTK_TETRA,
    VTK_TRIANGLE,
    VTK_TRIANGLE_STRIP,
    VTK_VERTEX,
    VTK_WEDGE,
    vtkCellArray,
    vtkDataObject,
    vtkDataSetAttributes,
    vtkImplicitFunction,
    vtkPointSet,
    vtkPolyData,
    vtkUnstructuredGrid,
)
from vtkmodules.vtkCommonExecutionModel import vtkAlgorithm
from vtkmodules.vtkFiltersCore import (
    vtkAppendFilter,
    vtkImplicitPolyDataDistance,
    vtkPolyDataNormals,
    vtkStaticCleanUnstructuredGrid,
)
from vtkmodules.vtkFiltersGeneral import vtkDataSetTriangleFilter, vtkTableBasedClipDataSet
from vtkmodules.vtkFiltersVerdict import vtkCellSizeFilter

from vtk_mls.base.progress import SILENT
from vtk_mls.vtk import arrays
from vtk_mls.vtk.cells import append_empty, is_empty, without_empty
from vtk_mls.vtk.orientation import TETRAHEDRA

try:
    from vtkmodules.vtkFiltersCore import vtkExtractCells
except ImportError:  # where the releases of VTK 9.2 have it
    from vtkmodules.vtkFiltersExtraction import vtkExtractCells

_MANY = 27  # more corners have only lines, strips, polygons and curved cells of high order
_ON_CUT = 1e-6  # how near to a cut a point counts as on it, as a share of the mesh's extent

_POINT, _HEIGHT, _FOOT, _SIDE, _POSITION = "_Point", "_Height", "_Foot", "_Side", "_Position"
_CELL = "_Cell"
_NUMBERS = "vtkOriginalCellIds"  # of vtkExtractCells

# Types of which the pieces get the right cell data from VTK's clipping: those with straight edges.
_STRAIGHT = (*range(VTK_VERTEX, VTK_HEXAGONAL_PRISM + 1), VTK_CONVEX_POINT_SET, VTK_POLYHEDRON)


def split(mesh, cuts, progress=SILENT):
    """A mesh with its cells divided along cuts.

    Parameters
    ----------
    mesh : vtkDataSet
    cuts : sequence of Plane, HalfPlane and Surface
    progress : Progress, optional

    Returns
    -------
    mesh : vtkPolyData if `mesh` is one, else vtkUnstructuredGrid
        With all arrays of points and cells but the points' global ids; at new points they are
        interpolated.
    foot : (n, 3) float64, world units
        From each point to where it is exactly on its cut; 0 for points on no cut.
    side : (n, 3) float64
        Normal of the cut, to the side on which the cells of the point are; 0 for points on no cut.

    Raises
    ------
    Aborted
    """
    named = mesh.NewInstance()
    named.ShallowCopy(mesh)
    arrays.name_normals(named)
    mesh, grid = named, _unstructured(without_empty(named))
    extent = _extent(_positions(grid))
    for name in (_FOOT, _SIDE):
        _set_array(grid, name, np.zeros((grid.GetNumberOfPoints(), 3)))
    whole = grid
    dividing, joining = progress.divided(4, 1)
    if grid.GetNumberOfCells() == 0:
        cuts = ()
    for cut, part in zip(cuts, dividing.divided(*[1] * len(cuts))):
        grid = _divided(grid, cut, extent, part)
    joining.report(0)
    if grid is not whole:  # what is divided has no points without cells any more
        grid = _appended([grid, _without_cells(whole)])
    foot, side = (_values(grid, name).copy() for name in (_FOOT, _SIDE))
    for name in (_POINT, _HEIGHT, _FOOT, _SIDE, _POSITION):
        grid.GetPointData().RemoveArray(name)
    append_empty(grid, mesh)
    has_points = isinstance(mesh, vtkPointSet)
    kept = mesh.GetPoints().GetDataType() if has_points else VTK_DOUBLE
    set_positions(grid, _positions(grid), kept)
    for of in ("GetPointData", "GetCellData"):
        arrays.set_roles(getattr(grid, of)(), getattr(mesh, of)())
    return (_polydata(grid) if isinstance(mesh, vtkPolyData) else grid), foot, side


def crossed(mesh, cuts):
    """Which cells of a mesh are crossed by a cut, seen between their corners: (n,) bool.

    Of cells with many corners only those count that follow each other; of points none.
    """
    filled = ~is_empty(mesh)
    result = np.zeros(len(filled), bool)
    if not filled.any():
        return result
    grid = _unstructured(without_empty(mesh))
    positions, (corners, starts) = _positions(grid), _corners(grid)
    sizes, types = np.diff(starts), arrays.cell_types(grid)
    found = np.zeros(len(sizes), bool)
    for cut in cuts:
        _, low, high = _heights(grid, cut, 0)
        candidates = (low < 0) & (high >= 0) & (types != VTK_POLY_VERTEX)
        few = candidates & (sizes <= _MANY)
        for size in np.unique(sizes[few]):
            some = np.flatnonzero(few & (sizes == size))
            x = positions[corners[starts[some][:, None] + np.arange(size)]]
            for a, b in zip(*np.triu_indices(size, 1)):
                found[some] |= cut.void_distance(x[:, a], x[:, b]) < 0
        for cell in np.flatnonzero(candidates & ~few):
            x = positions[corners[starts[cell] : starts[cell + 1]]]
            found[cell] |= (cut.void_distance(x[:-1], x[1:]) < 0).any()
    result[filled] = found
    return result


def set_positions(dataset, positions, vtk_type):
    """Set the points of a vtkPointSet to (n, 3) numbers: VTK_FLOAT, or VTK_DOUBLE if it is not."""
    points = vtkPoints()
    is_single = vtk_type == VTK_FLOAT
    vtk_type, dtype = (VTK_FLOAT, np.float32) if is_single else (VTK_DOUBLE, np.float64)
    points.SetDataType(vtk_type)
    points.SetData(arrays.from_numpy(positions.astype(dtype, copy=False), vtk_type))
    dataset.SetPoints(points)


def make_points_real(dataset):
    """Make the points of a vtkPointSet float64 if they are integers."""
    if dataset.GetPoints().GetDataType() not in (VTK_FLOAT, VTK_DOUBLE):
        set_positions(dataset, _positions(dataset), VTK_DOUBLE)


def _unstructured(mesh):
    """A copy as vtkUnstructuredGrid, with float64 points and without global ids of points."""
    grid = _appended([mesh])
    set_positions(grid, _positions(grid), VTK_DOUBLE)
    ids = grid.GetPointData().GetGlobalIds()
    if ids is not None:
        grid.GetPointData().RemoveArray(ids.GetName())
    grid.GetPointData().SetActiveAttribute(-1, vtkDataSetAttributes.SCALARS)  # clipping drops them
    return grid


def _extent(positions):
    """Size of a mesh, though some of its points (n, 3) be nowhere or far away from all others."""
    x = positions[np.isfinite(positions).all(axis=1)]
    if len(x) < 2:
        return 1.0
    spread = 4 * np.median(np.abs(x - np.median(x, axis=0)), axis=0).max()  # if they fill a box
    return min(np.ptp(x, axis=0).max(), 30 * spread if spread > 0 else np.inf) or 1.0


def _divided(grid, cut, extent, progress):
    """`grid` with its points on `cut` doubled where the cut is."""
    progress.report(0)
    height, low, high = _heights(grid, cut, _ON_CUT * extent)
    touched = (low <= 0) & (high >= 0)
    if not touched.any():
        return grid
    cloud = arrays.cell_types(grid) == VTK_POLY_VERTEX  # nothing to divide
    positions = _positions(grid)
    _set_array(grid, _POINT, np.arange(len(positions), dtype=np.float64))
    _set_array(grid, _HEIGHT, np.where(np.isfinite(height), height, extent))
    crossing, above = touched & (low < 0) & (high > 0) & ~cloud, touched & ((low >= 0) | cloud)
    progress.report(0.2)
    *pieces, undivided = _clipped(_extracted(grid, crossing))
    progress.report(0.5)
    whole = [_extracted(grid, cells) for cells in (above, touched & ~above & ~crossing)]
    parts = [(0, _appended([_extracted(grid, ~touched), undivided]))]
    parts += [(side, _appended(pair)) for side, *pair in zip((1, -1), whole, pieces)]
    parts = [(side, part) for side, part in parts if part.GetNumberOfPoints() > 0]
    keys = _keys(parts, cut, positions, extent)
    progress.report(0.8)
    return _joined([part for _, part in parts], keys)


def _keys(parts, cut, positions, extent):
    """Keys of the points of parts above (1), below (-1) and off (0) a cut.

    An old point has its number as key; those on the cut get others on each side, which is noted.
    """
    height_of = height_function(cut)
    keys, edges = [], []
    for side, part in parts:
        x, point = _positions(part), _values(part, _POINT)
        on_cut = np.flatnonzero(np.abs(_values(part, _HEIGHT)) <= _ON_CUT * extent)
        normal = _normals(height_of, x[on_cut], extent)
        foot = -height_of(x[on_cut])[:, None] * normal
        ahead, behind = (x[on_cut] + foot + t * _ON_CUT * extent * normal for t in (10, -10))
        parted = (side != 0) & (cut.void_distance(ahead, behind) < 0)
        for name, offset in ((_FOOT, foot), (_SIDE, side * normal)):
            values = _values(part, name).copy()
            values[on_cut[parted]] += offset[parted]
            _set_array(part, name, values)
        sides = np.zeros(len(x))
        sides[on_cut[parted]] = side % 3
        nearest = np.clip(np.rint(point), 0, len(positions) - 1).astype(np.int64)
        is_old = (point == nearest) & _same(positions[nearest], x)
        keys.append(np.where(is_old, nearest + len(positions) * sides, -1))
        # new points are the same if they are on the same edge, at the same point
        edges.append(np.column_stack([x / extent * 1e10, point * 1e6, sides])[~is_old])
    _, number = np.unique(np.rint(np.concatenate(edges)), axis=0, return_inverse=True)
    counts = np.cumsum([len(rows) for rows in edges])
    for key, some in zip(keys, np.split(number.reshape(-1), counts)):
        key[key < 0] = 3 * len(positions) + some
    return keys


def _same(x, y):
    """Which rows are equal; NaN equals NaN."""
    return ((x == y) | (np.isnan(x) & np.isnan(y))).all(axis=1)


def _joined(parts, keys):
    """The parts as one mesh in which points with the same key are one."""
    grid = _appended(parts)
    keys = np.concatenate(keys).astype(np.int64)
    _set_array(grid, _POSITION, _positions(grid))
    coordinates = np.column_stack([keys & 0x1FFFF, keys >> 17 & 0x1FFFF, keys >> 34])
    set_positions(grid, coordinates, VTK_DOUBLE)
    clean = vtkStaticCleanUnstructuredGrid()
    clean.SetInputData(grid)
    clean.SetTolerance(0)
    clean.Update()
    grid = clean.GetOutput()
    set_positions(grid, _values(grid, _POSITION), VTK_DOUBLE)
    return grid


def _heights(grid, cut, tolerance):
    """Signed distances of points from the cut or what continues it, and their range in each cell.

    Distances up to `tolerance` are 0; points far from a bounded cut or nowhere, and cells with one,
    have infinite ones.
    """
    positions, (corners, starts) = _positions(grid), _corners(grid)
    near = np.ones(len(positions), bool)
    lowest, highest = cut.bounds
    if np.isfinite([lowest, highest]).all():
        touching = np.ones(len(starts) - 1, bool)
        for axis in range(3):
            low, high = _range(positions[:, axis], corners, starts)
            touching &= (low <= highest[axis]) & (high >= lowest[axis])
        near = np.zeros(len(positions), bool)
        near[corners[np.repeat(touching, np.diff(starts))]] = True
    height = np.full(len(positions), np.inf)
    height[near] = height_function(cut)(positions[near])
    height[~np.isfinite(height)] = np.inf
    height[np.abs(height) <= tolerance] = 0
    low, high = _range(height, corners, starts)
    low[np.isinf(high)] = np.inf
    return height, low, high


def height_function(cut):
    """The signed distance from a cut as a function of points (n, 3)."""
    plane = cut.plane
    if plane is not None:
        return plane.height
    oriented, distance = vtkPolyDataNormals(), vtkImplicitPolyDataDistance()
    oriented.SetInputData(_surface(cut))
    oriented.SplittingOff()
    oriented.Update()
    distance.SetInput(oriented.GetOutput())

    def height(positions):
        result = arrays.from_numpy(np.empty(len(positions)), VTK_DOUBLE)
        vtkImplicitFunction.EvaluateFunction(
            distance, arrays.from_numpy(positions, VTK_DOUBLE), result
        )
        return arrays.to_numpy(result).copy()

    return height


def _normals(height_of, positions, extent):
    """Directions (n, 3) in which the signed distance grows."""
    steps = _ON_CUT * extent * np.eye(3)
    slopes = [height_of(positions + step) - height_of(positions - step) for step in steps]
    normals = np.stack(slopes, axis=1)
    return normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)


def _clipped(grid):
    """The cells of `grid` above and below height 0, and those of which clipping makes nothing.

    Of tetrahedra only tetrahedra are made: VTK's mappers of unstructured volumes want them. Pieces
    that have no size, which clipping makes of corners on the cut, are left out, but for those of
    cells that have none themselves.
    """
    if grid.GetNumberOfCells() == 0:
        return grid, grid, grid
    numbers, types = np.arange(grid.GetNumberOfCells()), arrays.cell_types(grid)
    arrays.add(grid.GetCellData(), _CELL, numbers)
    straight = np.isin(types, _STRAIGHT)
    steps = [(straight, _clip), (~straight, _clip_apart)]
    pairs = [clip(_extracted(grid, cells)) for cells, clip in steps if cells.any()]
    pieces = [_appended(parts) for parts in zip(*pairs)]
    if (types == VTK_TETRA).all():
        inside_out = _signed_volumes(grid) < 0
        pieces = [_tetrahedra(piece, inside_out) for piece in pieces]
    flat = ~_has_size(grid)
    pieces = [_extracted(piece, _has_size(piece) | flat[_cells(piece)]) for piece in pieces]
    divided = np.isin(numbers, np.concatenate([_cells(piece) for piece in pieces]))
    results = [*pieces, _extracted(grid, ~divided)]
    for result in results:
        result.GetCellData().RemoveArray(_CELL)
    return results


def _clip(grid):
    """The cells of `grid` above and below height 0."""
    clip = vtkTableBasedClipDataSet()
    clip.SetInputData(grid)
    clip.SetInputArrayToProcess(0, 0, 0, vtkDataObject.FIELD_ASSOCIATION_POINTS, _HEIGHT)
    clip.SetValue(0)
    clip.GenerateClippedOutputOn()
    clip.Update()
    return [clip.GetOutput(), clip.GetClippedOutput()]


def _clip_apart(grid):
    """As `_clip`, for cells of which VTK mixes up the data: type 33, 37, 73 and 80 in VTK 9.7.

    Cells get points of their own, which know the number of the cell, and for the time of clipping
    lie on a lattice, so that none are merged.
    """
    corners, starts = _corners(grid)
    cell = np.repeat(np.arange(len(starts) - 1), np.diff(starts))
    positions = _positions(grid)
    _set_array(grid, _POSITION, positions)
    apart = vtkUnstructuredGrid()
    arrays.set_rows(apart.GetPointData(), grid.GetPointData(), corners)
    _set_array(apart, _CELL, cell)
    side = int(np.ceil(np.cbrt(len(starts))))
    room = 2 * max(np.ptp(positions, axis=0).max(), np.finfo(float).tiny)
    node = np.stack(np.unravel_index(cell, (side, side, side)), axis=1)
    set_positions(apart, (positions - positions[0])[corners] / room + node, VTK_DOUBLE)
    own = np.arange(len(corners))
    apart.SetCells(
        arrays.from_numpy(arrays.cell_types(grid).astype(np.uint8), VTK_UNSIGNED_CHAR),
        _cell_array(own, starts, np.ones(len(starts) - 1, bool)),
    )
    pieces = _clip(apart)
    for piece in pieces:
        if piece.GetNumberOfCells() == 0:  # it has no arrays
            continue
        set_positions(piece, _values(piece, _POSITION), VTK_DOUBLE)
        corners, starts = _corners(piece)
        number = np.rint(_values(piece, _CELL)[corners[starts[:-1]]]).astype(np.int64)
        arrays.set_rows(piece.GetCellData(), grid.GetCellData(), number)
        for name in (_POSITION, _CELL):
            piece.GetPointData().RemoveArray(name)
    return pieces


def _tetrahedra(grid, inside_out):
    """`grid` of tetrahedra and wedges, all as tetrahedra.

    `inside_out` says of which cells, by their number, the pieces are to have negative volumes.
    """
    solid = _has_size(grid)
    steps = [(solid, partial(_solid_tetrahedra, inside_out)), (~solid, _flat_tetrahedra)]
    parts = [divided(_extracted(grid, cells)) for cells, divided in steps if cells.any()]
    return _appended(parts) if len(parts) > 1 else [*parts, grid][0]


def _solid_tetrahedra(inside_out, grid):
    triangulate = vtkDataSetTriangleFilter()
    triangulate.SetInputData(grid)
    triangulate.Update()
    grid = triangulate.GetOutput()
    corners, starts = _corners(grid)
    corners = corners.reshape(-1, 4).copy()
    wrong = (_signed_volumes(grid) < 0) != inside_out[_cells(grid)]
    corners[wrong, :2] = corners[wrong, 1::-1]
    grid.SetCells(VTK_TETRA, _cell_array(corners.ravel(), starts, np.ones(len(corners), bool)))
    return grid


def _signed_volumes(grid):
    """Of tetrahedra, times 6: below 0 where one is inside out."""
    a, b, c, d = _positions(grid)[_corners(grid)[0].reshape(-1, 4).T]
    return np.sum(np.cross(b - a, c - a) * (d - a), axis=1)


def _flat_tetrahedra(grid):
    """Of those without volume vtkDataSetTriangleFilter makes nothing."""
    types, (corners, starts) = arrays.cell_types(grid), _corners(grid)
    made, rows = [], []
    for kind in (VTK_TETRA, VTK_WEDGE):
        cells = np.flatnonzero(types == kind)
        for four in TETRAHEDRA[kind]:
            made.append(corners[starts[cells][:, None] + four])
            rows.append(cells)
    made, rows = np.concatenate(made), np.concatenate(rows)
    flat = vtkUnstructuredGrid()
    flat.SetPoints(grid.GetPoints())
    flat.GetPointData().ShallowCopy(grid.GetPointData())
    starts = 4 * np.arange(len(made) + 1)
    flat.SetCells(VTK_TETRA, _cell_array(made.ravel(), starts, np.ones(len(made), bool)))
    arrays.set_rows(flat.GetCellData(), grid.GetCellData(), rows)
    return flat


def _has_size(grid):
    """Which cells have a length, area or volume."""
    if grid.GetNumberOfCells() == 0:
        return np.zeros(0, bool)
    size = vtkCellSizeFilter()
    size.SetInputData(grid)
    size.Update()
    data = size.GetOutput().GetCellData()
    sizes = [arrays.to_numpy(data.GetArray(n)) for n in ("Length", "Area", "Volume")]
    return np.any(sizes, axis=0)


def _without_cells(grid):
    """The points of `grid` that no cell has, without cells."""
    used = np.zeros(grid.GetNumberOfPoints(), bool)
    used[_corners(grid)[0]] = True
    rows = np.flatnonzero(~used)
    loose = vtkUnstructuredGrid()
    set_positions(loose, _positions(grid)[rows], VTK_DOUBLE)
    arrays.set_rows(loose.GetPointData(), grid.GetPointData(), rows)
    # vtkAppendFilter keeps the arrays that all have
    arrays.set_rows(loose.GetCellData(), grid.GetCellData(), rows[:0])
    return loose


def _extracted(grid, cells):
    """The cells of `grid` for which `cells` (n,) is true, with their points."""
    extract = vtkExtractCells()
    extract.SetInputData(grid)
    numbers = np.flatnonzero(cells)
    extract.SetCellIds(numbers, len(numbers))
    always_numbered = not hasattr(extract, "SetPassThroughCellIds")  # in the releases of VTK 9.2
    if not always_numbered:
        extract.SetPassThroughCellIds(False)
    extract.Update()
    if always_numbered and not grid.GetCellData().HasArray(_NUMBERS):
        extract.GetOutput().GetCellData().RemoveArray(_NUMBERS)
    return extract.GetOutput()


def _appended(parts):
    append = vtkAppendFilter()
    append.SetOutputPointsPrecision(vtkAlgorithm.DOUBLE_PRECISION)
    for part in parts:
        append.AddInputData(part)
    append.Update()
    return append.GetOutput()


def _range(values, corners, starts):
    """Least and greatest of the points' values in each cell; no cell without points has any."""
    low, high = np.full((2, len(starts) - 1), np.inf)
    filled = np.diff(starts) > 0
    if filled.any():
        of_corners, first = values[corners], starts[:-1][filled]
        low[filled] = np.minimum.reduceat(of_corners, first)
        high[filled] = np.maximum.reduceat(of_corners, first)
    return low, high


def _corners(grid):
    """Points of all cells one after the other, and where each cell's begin (and the last ends)."""
    cells = grid.GetCells()
    return [arrays.to_numpy(a) for a in (cells.GetConnectivityArray(), cells.GetOffsetsArray())]


def _positions(grid):
    return arrays.to_numpy(grid.GetPoints().GetData())


def _values(grid, name):
    return arrays.to_numpy(grid.GetPointData().GetArray(name))


def _cells(grid):
    """The number in `_CELL` of each cell."""
    array = grid.GetCellData().GetArray(_CELL)
    return np.zeros(0, np.int64) if array is None else arrays.to_numpy(array)


def _set_array(grid, name, values):
    arrays.add(grid.GetPointData(), name, values.astype(np.float64, copy=False))


def _cell_array(corners, starts, chosen):
    sizes = np.diff(starts)
    offsets = np.concatenate([[0], np.cumsum(sizes[chosen])])
    cells = vtkCellArray()
    cells.SetData(arrays.ids(offsets), arrays.ids(corners[np.repeat(chosen, sizes)]))
    return cells


def _surface(cut):
    """The triangles of a cut as vtkPolyData."""
    polydata, points = vtkPolyData(), vtkPoints()
    points.SetData(arrays.from_numpy(cut.points, VTK_DOUBLE))
    polydata.SetPoints(points)
    count = len(cut.triangles)
    polydata.SetPolys(
        _cell_array(cut.triangles.ravel(), 3 * np.arange(count + 1), np.ones(count, bool))
    )
    return polydata


def _polydata(grid):
    """A grid of vertices, lines, polygons and strips as vtkPolyData."""
    polydata = vtkPolyData()
    polydata.SetPoints(grid.GetPoints())
    polydata.GetPointData().ShallowCopy(grid.GetPointData())
    types = arrays.cell_types(grid)
    order = []
    for set_cells, members in (
        (polydata.SetVerts, (VTK_VERTEX, VTK_POLY_VERTEX)),
        (polydata.SetLines, (VTK_LINE, VTK_POLY_LINE)),
        (polydata.SetPolys, (VTK_TRIANGLE, VTK_QUAD, VTK_POLYGON)),
        (polydata.SetStrips, (VTK_TRIANGLE_STRIP,)),
    ):
        chosen = np.isin(types, members)
        set_cells(_cell_array(*_corners(grid), chosen))
        order.append(np.flatnonzero(chosen))
    arrays.set_rows(polydata.GetCellData(), grid.GetCellData(), np.concatenate(order))
    return polydata
