"""What a dataset from a file must be before anything computes with it.

VTK's readers hand on what a broken file says: corners that are no points, arrays of other lengths,
types of cells that do not exist. VTK's filters take such data at their word and read or write
memory that is not theirs.
"""

from __future__ import annotations

import math

import numpy as np
from vtkmodules.vtkCommonDataModel import (
    vtkGenericCell,
    vtkImageData,
    vtkPointSet,
    vtkPolyData,
    vtkRectilinearGrid,
    vtkStructuredGrid,
    vtkUnstructuredGrid,
)

from vtk_mls.vtk import arrays
from vtk_mls.vtk.arrays import ImageGeometry

_HIGHER_ORDER = 60  # cells of this type and above have any number of points from a least one on


def check(dataset):
    """Raise ValueError with what is wrong with a vtkDataSet, if something is."""
    if isinstance(dataset, vtkImageData) and dataset.GetNumberOfPoints():
        ImageGeometry.of_image(dataset).grid  # noqa: B018  raises what is wrong
    if isinstance(dataset, vtkRectilinearGrid):
        _check_axes(dataset)
    if isinstance(dataset, vtkPointSet):
        _check_points(dataset)
    if isinstance(dataset, vtkPolyData):
        for cells in (dataset.GetVerts(), dataset.GetLines(), dataset.GetPolys()):
            _check_corners(cells, dataset.GetNumberOfPoints())
        _check_corners(dataset.GetStrips(), dataset.GetNumberOfPoints())
    if isinstance(dataset, vtkUnstructuredGrid):
        _check_grid(dataset)
    for data, count in (
        (dataset.GetPointData(), dataset.GetNumberOfPoints()),
        (dataset.GetCellData(), dataset.GetNumberOfCells()),
    ):
        for i in range(data.GetNumberOfArrays()):
            found = data.GetAbstractArray(i).GetNumberOfTuples()
            if found != count:
                raise ValueError(
                    f"array `{data.GetArrayName(i)}` must have {count} tuples, got {found}"
                )


def _check_axes(grid):
    axes = grid.GetXCoordinates(), grid.GetYCoordinates(), grid.GetZCoordinates()
    found = tuple(0 if axis is None else axis.GetNumberOfTuples() for axis in axes)
    if found != _dimensions(grid):
        raise ValueError(f"it must have {_dimensions(grid)} coordinates, got {found}")


def _check_points(mesh):
    points = mesh.GetPoints()
    if points is not None and points.GetData().GetNumberOfComponents() != 3:
        raise ValueError("its points must have three coordinates")
    found = 0 if points is None else points.GetNumberOfPoints()
    if isinstance(mesh, vtkStructuredGrid) and math.prod(_dimensions(mesh)) != found:
        raise ValueError(f"it must have {_dimensions(mesh)} points, got {found} in all")


def _dimensions(grid):
    first, last = grid.GetExtent()[::2], grid.GetExtent()[1::2]
    dimensions = tuple(end - start + 1 for start, end in zip(first, last))
    if min(dimensions) < 1:
        raise ValueError(f"its dimensions must be positive, got {dimensions}")
    return dimensions


def _check_grid(grid):
    """Check the cells of a vtkUnstructuredGrid, with the faces of its polyhedra."""
    if grid.GetNumberOfCells() == 0:
        return
    sizes = _check_corners(grid.GetCells(), grid.GetNumberOfPoints())
    types = arrays.cell_types(grid)
    if len(types) != len(sizes):
        raise ValueError(f"it must have a type for each of the {len(sizes)} cells")
    for kind in np.unique(types).tolist():
        cell = vtkGenericCell.InstantiateCell(kind)
        if cell is None:
            raise ValueError(f"it has a cell of the type {kind}, which is not known")
        needed, found = cell.GetNumberOfPoints(), sizes[types == kind]
        wrong = found < needed if kind >= _HIGHER_ORDER else (found != needed) & (needed > 0)
        if wrong.any():
            raise ValueError(
                f"a {cell.GetClassName()} has {needed} points, got one with {found[wrong][0]}"
            )
    faces = getattr(grid, "GetPolyhedronFaces", lambda: None)()  # VTK 9.4
    if faces is not None and faces.GetNumberOfCells():
        _check_corners(faces, grid.GetNumberOfPoints())
        _check_corners(grid.GetPolyhedronFaceLocations(), faces.GetNumberOfCells())


def _check_corners(cells, count):
    """Numbers of corners of the cells (n,), if all of them are among `count` points."""
    if cells is None or cells.GetNumberOfCells() == 0:
        return np.zeros(0, int)
    offsets = arrays.to_numpy(cells.GetOffsetsArray())
    corners = arrays.to_numpy(cells.GetConnectivityArray())
    sizes = np.diff(offsets)
    if offsets[0] != 0 or offsets[-1] != len(corners) or (sizes < 0).any():
        raise ValueError("its cells do not fit the list of their corners")
    if len(corners) and not 0 <= corners.min() <= corners.max() < count:
        raise ValueError(
            f"its cells must have corners among {count} points, got corners from "
            f"{corners.min()} to {corners.max()}"
        )
    return sizes
