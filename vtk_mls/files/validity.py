"""Checks of datasets from files.

VTK's readers return the contents of a broken file unchecked: point ids out of range, arrays of
wrong lengths, unknown cell types. VTK's filters do not check them either, and access memory out of
bounds.
"""

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
from vtk_mls.vtk.cells import connectivity_of, polydata_cells

_HIGHER_ORDER = 60  # cells of this type and above have a minimum number of points


def check(dataset):
    """Raise ValueError if a vtkDataSet is broken."""
    if isinstance(dataset, vtkImageData) and dataset.GetNumberOfPoints():
        ImageGeometry.of_image(dataset).grid  # noqa: B018  raises if broken
    if isinstance(dataset, vtkRectilinearGrid):
        _check_axes(dataset)
    if isinstance(dataset, vtkPointSet):
        _check_points(dataset)
    if isinstance(dataset, vtkPolyData):
        for _, cells in polydata_cells(dataset):
            _check_connectivity(cells, dataset.GetNumberOfPoints())
    if isinstance(dataset, vtkUnstructuredGrid):
        _check_grid(dataset)
    arrays.check_lengths(dataset, are_exact=True)


def _check_axes(grid):
    axes = grid.GetXCoordinates(), grid.GetYCoordinates(), grid.GetZCoordinates()
    sizes = tuple(0 if axis is None else axis.GetNumberOfTuples() for axis in axes)
    if sizes != _dimensions(grid):
        raise ValueError(f"it must have {_dimensions(grid)} coordinates, got {sizes}")


def _check_points(mesh):
    points = mesh.GetPoints()
    if points is not None and points.GetData().GetNumberOfComponents() != 3:
        raise ValueError("its points must have three coordinates")
    count = 0 if points is None else points.GetNumberOfPoints()
    if isinstance(mesh, vtkStructuredGrid) and math.prod(_dimensions(mesh)) != count:
        raise ValueError(f"it must have {_dimensions(mesh)} points, got {count} in all")


def _dimensions(grid):
    first, last = grid.GetExtent()[::2], grid.GetExtent()[1::2]
    dimensions = tuple(end - start + 1 for start, end in zip(first, last))
    if min(dimensions) < 1:
        raise ValueError(f"its dimensions must be positive, got {dimensions}")
    return dimensions


def _check_grid(grid):
    """Check the cells of a vtkUnstructuredGrid and the faces of its polyhedra."""
    if grid.GetNumberOfCells() == 0:
        return
    sizes = _check_connectivity(grid.GetCells(), grid.GetNumberOfPoints())
    types = arrays.cell_types(grid)
    if len(types) != len(sizes):
        raise ValueError(f"it must have a type for each of the {len(sizes)} cells")
    for kind in np.unique(types).tolist():
        cell = vtkGenericCell.InstantiateCell(kind)
        if cell is None:
            raise ValueError(f"it has a cell of the type {kind}, which VTK does not have")
        count, counts = cell.GetNumberOfPoints(), sizes[types == kind]
        wrong = counts < count if kind >= _HIGHER_ORDER else (counts != count) & (count > 0)
        if wrong.any():
            raise ValueError(
                f"a {cell.GetClassName()} has {count} points, got one with {counts[wrong][0]}"
            )
    faces = getattr(grid, "GetPolyhedronFaces", lambda: None)()  # VTK 9.4
    if faces is not None and faces.GetNumberOfCells():
        _check_connectivity(faces, grid.GetNumberOfPoints())
        _check_connectivity(grid.GetPolyhedronFaceLocations(), faces.GetNumberOfCells())


def _check_connectivity(cells, count):
    """Number of points of each cell (n,), if all point ids are below `count`."""
    connectivity, offsets = connectivity_of(cells)
    sizes = np.diff(offsets)
    if offsets[0] != 0 or offsets[-1] != len(connectivity) or (sizes < 0).any():
        raise ValueError("its cell offsets do not fit its connectivity")
    if len(connectivity) and not 0 <= connectivity.min() <= connectivity.max() < count:
        raise ValueError(
            f"the point ids of its cells must be from 0 to {count - 1}, got "
            f"{connectivity.min()} to {connectivity.max()}"
        )
    return sizes
