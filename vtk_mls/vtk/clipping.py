"""Cells clipped at height 0, with their data and without flat pieces."""

from functools import partial

import numpy as np
from vtkmodules.vtkCommonCore import VTK_DOUBLE, VTK_UNSIGNED_CHAR
from vtkmodules.vtkCommonDataModel import (
    VTK_CONVEX_POINT_SET,
    VTK_HEXAGONAL_PRISM,
    VTK_POLYHEDRON,
    VTK_TETRA,
    VTK_TRIQUADRATIC_PYRAMID,
    VTK_VERTEX,
    VTK_WEDGE,
    vtkDataObject,
    vtkUnstructuredGrid,
)
from vtkmodules.vtkFiltersGeneral import vtkDataSetTriangleFilter, vtkTableBasedClipDataSet
from vtkmodules.vtkFiltersVerdict import vtkCellSizeFilter

from vtk_mls.vtk import arrays
from vtk_mls.vtk.cells import (
    append_meshes,
    cell_array,
    connectivity_of,
    extract_cells,
    positions_of,
    row_array,
    set_positions,
)
from vtk_mls.vtk.objects import configured, output_of
from vtk_mls.vtk.orientation import TETRAHEDRA

HEIGHT = "_Height"  # point array: signed distance from the cut
_CELL, _POSITION = "_Cell", "_Position"

# Cells with straight edges: VTK's clipping gives their pieces the right cell data.
_STRAIGHT_TYPES = (
    *range(VTK_VERTEX, VTK_HEXAGONAL_PRISM + 1),
    VTK_CONVEX_POINT_SET,
    VTK_POLYHEDRON,
)


def clip_cells(grid):
    """The cells above and below height 0, and those that clipping cannot divide: three grids.

    The vtkUnstructuredGrid `grid` has the point array `HEIGHT`. Tetrahedra are divided into
    tetrahedra, which VTK's mappers of unstructured volumes need. Pieces without a size, which
    clipping makes of corners on the cut, are left out unless the whole cell has no size.
    """
    if grid.GetNumberOfCells() == 0:
        return grid, grid, grid
    indices, types = np.arange(grid.GetNumberOfCells()), arrays.cell_types(grid)
    arrays.add(grid.GetCellData(), _CELL, indices)
    is_straight = np.isin(types, _STRAIGHT_TYPES)
    is_alone = types == VTK_TRIQUADRATIC_PYRAMID
    steps = [
        (is_straight, _clip),
        (~is_straight & ~is_alone, _clip_separately),
        (is_alone, _clip_one_by_one),
    ]
    pairs = [clip(extract_cells(grid, mask)) for mask, clip in steps if mask.any()]
    pieces = [append_meshes(parts) for parts in zip(*pairs)]
    if (types == VTK_TETRA).all():
        inside_out = _signed_volumes(grid) < 0
        pieces = [_tetrahedra(piece, inside_out) for piece in pieces]
    is_flat = ~_has_size(grid)
    pieces = [extract_cells(p, _has_size(p) | is_flat[row_array(p, _CELL)]) for p in pieces]
    is_divided = np.isin(indices, np.concatenate([row_array(p, _CELL) for p in pieces]))
    results = [*pieces, extract_cells(grid, ~is_divided)]
    for result in results:
        result.GetCellData().RemoveArray(_CELL)
    return results


def _clip(grid):
    """The cells of `grid` above and below height 0."""
    clip = configured(vtkTableBasedClipDataSet(), Value=0, GenerateClippedOutput=True)
    clip.SetInputArrayToProcess(0, 0, 0, vtkDataObject.FIELD_ASSOCIATION_POINTS, HEIGHT)
    return [output_of(clip, InputData=grid), clip.GetClippedOutput()]


def _clip_separately(grid):
    """As `_clip`, for cell types whose data VTK mixes up: 33, 37, 73 and 80 in VTK 9.7.

    Each cell gets its own points, with the index of the cell. While they are clipped, the cells lie
    on a lattice, so that no points are merged.
    """
    connectivity, offsets = connectivity_of(grid.GetCells())
    cell = np.repeat(np.arange(len(offsets) - 1), np.diff(offsets))
    positions = positions_of(grid)
    arrays.add(grid.GetPointData(), _POSITION, positions)
    separate = vtkUnstructuredGrid()
    arrays.set_rows(separate.GetPointData(), grid.GetPointData(), connectivity)
    arrays.add(separate.GetPointData(), _CELL, cell.astype(np.float64))
    side = int(np.ceil(np.cbrt(len(offsets))))
    pitch = 2 * max(np.ptp(positions, axis=0).max(), np.finfo(float).tiny)
    node = np.stack(np.unravel_index(cell, (side, side, side)), axis=1)
    set_positions(separate, (positions - positions[0])[connectivity] / pitch + node, VTK_DOUBLE)
    separate.SetCells(
        arrays.from_numpy(arrays.cell_types(grid).astype(np.uint8), VTK_UNSIGNED_CHAR),
        cell_array(np.arange(len(connectivity)), offsets.copy()),
    )
    pieces = _clip(separate)
    for piece in pieces:
        if piece.GetNumberOfCells() == 0:  # without arrays
            continue
        data = piece.GetPointData()
        set_positions(piece, arrays.to_numpy(data.GetArray(_POSITION)), VTK_DOUBLE)
        connectivity, offsets = connectivity_of(piece.GetCells())
        cell = arrays.to_numpy(data.GetArray(_CELL))[connectivity[offsets[:-1]]]
        arrays.set_rows(piece.GetCellData(), grid.GetCellData(), np.rint(cell).astype(np.int64))
        for name in (_POSITION, _CELL):
            data.RemoveArray(name)
    return pieces


def _clip_one_by_one(grid):
    """As `_clip_separately`; VTK 9.7 divides the first pyramid of type 37 for all others, too."""
    rows = np.arange(grid.GetNumberOfCells())
    pairs = [_clip_separately(extract_cells(grid, rows == row)) for row in rows]
    return [append_meshes(parts) for parts in zip(*pairs)]


def _tetrahedra(grid, inside_out):
    """Tetrahedra and wedges divided into tetrahedra.

    Pieces of cells, by the array `_CELL`, that `inside_out` (n,) marks get negative volumes.
    """
    is_solid = _has_size(grid)
    steps = [(is_solid, partial(_divide_solid, inside_out)), (~is_solid, _divide_flat)]
    parts = [divide(extract_cells(grid, mask)) for mask, divide in steps if mask.any()]
    return append_meshes(parts) if len(parts) > 1 else [*parts, grid][0]


def _divide_solid(inside_out, grid):
    grid = output_of(vtkDataSetTriangleFilter(), InputData=grid)
    tetrahedra = connectivity_of(grid.GetCells())[0].reshape(-1, 4).copy()
    is_wrong = (_signed_volumes(grid) < 0) != inside_out[row_array(grid, _CELL)]
    tetrahedra[is_wrong, :2] = tetrahedra[is_wrong, 1::-1]
    _set_tetrahedra(grid, tetrahedra)
    return grid


def _divide_flat(grid):
    """Tetrahedra without volume, which vtkDataSetTriangleFilter drops."""
    types, (connectivity, offsets) = arrays.cell_types(grid), connectivity_of(grid.GetCells())
    tetrahedra, rows = [], []
    for cell_type in (VTK_TETRA, VTK_WEDGE):
        cells = np.flatnonzero(types == cell_type)
        for four in TETRAHEDRA[cell_type]:
            tetrahedra.append(connectivity[offsets[cells][:, None] + four])
            rows.append(cells)
    flat = configured(vtkUnstructuredGrid(), Points=grid.GetPoints())
    flat.GetPointData().ShallowCopy(grid.GetPointData())
    _set_tetrahedra(flat, np.concatenate(tetrahedra))
    arrays.set_rows(flat.GetCellData(), grid.GetCellData(), np.concatenate(rows))
    return flat


def _set_tetrahedra(grid, tetrahedra):
    """Set the cells (n, 4) of a vtkUnstructuredGrid."""
    grid.SetCells(VTK_TETRA, cell_array(tetrahedra.ravel(), 4 * np.arange(len(tetrahedra) + 1)))


def _signed_volumes(grid):
    """Volumes of tetrahedra, times 6; negative where one is inside out."""
    a, b, c, d = positions_of(grid)[connectivity_of(grid.GetCells())[0].reshape(-1, 4).T]
    return np.sum(np.cross(b - a, c - a) * (d - a), axis=1)


def _has_size(grid):
    """Whether cells have a length, area or volume: (n,) bool."""
    if grid.GetNumberOfCells() == 0:
        return np.zeros(0, bool)
    data = output_of(vtkCellSizeFilter(), InputData=grid).GetCellData()
    sizes = [arrays.to_numpy(data.GetArray(n)) for n in ("Length", "Area", "Volume")]
    return np.any(sizes, axis=0)
