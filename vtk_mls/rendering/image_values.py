"""One scalar, or one color, at each point of an image, along the axes of the world."""

import numpy as np
from vtkmodules.vtkCommonCore import VTK_BIT, VTK_DOUBLE, VTK_UNSIGNED_CHAR
from vtkmodules.vtkCommonDataModel import vtkImageData

from vtk_mls.vtk import arrays
from vtk_mls.vtk.arrays import ImageGeometry


def colors_of(image):
    """Colors (nz, ny, nx, 3), 0 to 255, along axes of the world; None for other values."""
    values = arrays.to_numpy(_numeric_array(image))
    if values.ndim == 1 or values.dtype != np.uint8 or values.shape[1] not in (3, 4):
        return None
    _, reorder = arrays.along_world_axes(ImageGeometry.of_image(image).grid)
    return reorder(values[:, :3].reshape(*image.GetDimensions()[::-1], 3))


def scalar_image(image):
    """A copy of a vtkImageData with one scalar per point and axes along those of the world.

    The scalars are the active ones, or the first array; the mean of several components. Axes are
    permuted and mirrored, as VTK 9.7 lights volumes without their direction matrix: if that mirrors
    axes, as in most NIfTI files, surfaces towards the light are dark. Without numbers at its
    points, ValueError.
    """
    array = _numeric_array(image)
    values, vtk_type = arrays.to_numpy(array), array.GetDataType()
    if values.ndim > 1:
        values, vtk_type = values.mean(axis=1, dtype=float), VTK_DOUBLE
    elif vtk_type == VTK_BIT:
        vtk_type = VTK_UNSIGNED_CHAR
    values = values.reshape(image.GetDimensions()[::-1])
    grid, reorder = arrays.along_world_axes(ImageGeometry.of_image(image).grid)
    copy = vtkImageData()
    ImageGeometry.of_grid(grid).apply_to(copy)
    scalars = arrays.from_numpy(np.ascontiguousarray(reorder(values)).ravel(), vtk_type)
    scalars.SetName(array.GetName() or "values")
    copy.GetPointData().SetScalars(scalars)
    return copy


def _numeric_array(image):
    """The active scalars, or the first array of numbers."""
    data = image.GetPointData()
    candidates = [data.GetScalars(), *map(data.GetArray, range(data.GetNumberOfArrays()))]
    numeric = [array for array in candidates if array is not None and arrays.is_numeric(array)]
    if not numeric:
        raise ValueError("the image has no values at its points to show; only those of cells")
    return numeric[0]
