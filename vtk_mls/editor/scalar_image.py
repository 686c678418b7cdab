"""An image as it can be drawn: one number for each point, and axes along those of the world.

VTK 9.7 lights volumes with a direction matrix as if they had none: where it mirrors axes, as in
most NIfTI files, what faces the light is dark.
"""

from __future__ import annotations

import numpy as np
from vtkmodules.vtkCommonCore import VTK_BIT, VTK_DOUBLE, VTK_UNSIGNED_CHAR
from vtkmodules.vtkCommonDataModel import vtkImageData

from vtk_mls import Grid
from vtk_mls.base.linear_algebra import unit
from vtk_mls.vtk import arrays
from vtk_mls.vtk.arrays import ImageGeometry


def scalar_image(image):
    """Another vtkImageData with the active scalars of one, or its first array.

    Of arrays of several components the mean is taken. Axes are permuted and mirrored so that each
    points along one of the world as well as it can.

    Raises
    ------
    ValueError
        If the image has no numbers at its points.
    """
    name, values, vtk_type = _values(image)
    grid, values = _along_axes(ImageGeometry.of_image(image).grid, values)
    shown = vtkImageData()
    ImageGeometry.of_grid(grid).apply_to(shown)
    scalars = arrays.from_numpy(np.ascontiguousarray(values).ravel(), vtk_type)
    scalars.SetName(name)
    shown.GetPointData().SetScalars(scalars)
    return shown


def _values(image):
    """The name of an array, its values (nz, ny, nx), and their type of VTK."""
    data = image.GetPointData()
    every = [data.GetScalars(), *map(data.GetArray, range(data.GetNumberOfArrays()))]
    numbers = [each for each in every if each is not None and arrays.is_numeric(each)]
    if not numbers:
        raise ValueError("the image has no values at its points to show; only those of cells")
    values, vtk_type = arrays.to_numpy(numbers[0]), numbers[0].GetDataType()
    if values.ndim > 1:
        values, vtk_type = values.mean(axis=1, dtype=float), VTK_DOUBLE
    elif vtk_type == VTK_BIT:
        vtk_type = VTK_UNSIGNED_CHAR
    name = numbers[0].GetName() or "values"
    return name, values.reshape(image.GetDimensions()[::-1]), vtk_type


def _along_axes(grid, values):
    """The same points in rows along the world's axes, and their values."""
    steps = grid.index_to_world
    directions = np.abs(unit(steps.T).T)
    axes, left = [], [0, 1, 2]
    for world in range(3):
        axes.append(max(left, key=lambda axis: directions[world, axis]))
        left.remove(axes[-1])
    is_mirrored = [steps[world, axis] < 0 for world, axis in enumerate(axes)]
    first = np.zeros(3)
    for axis, mirrored in zip(axes, is_mirrored):
        first[axis] = (grid.dimensions[axis] - 1) * mirrored
    signs = np.where(is_mirrored, -1, 1)
    steps = steps[:, axes] * signs
    spacing = np.linalg.norm(steps, axis=0)
    dimensions = [grid.dimensions[axis] for axis in axes]
    # of values the axes are z, y, x
    values = values.transpose([2 - axis for axis in axes[::-1]])
    values = values[tuple(slice(None, None, sign) for sign in signs[::-1])]
    return Grid(dimensions, grid.at(first[None])[0], spacing, steps / spacing), values
