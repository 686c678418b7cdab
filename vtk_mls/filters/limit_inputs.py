"""Masks and faces from properties and images."""

import numpy as np
from vtkmodules.vtkCommonDataModel import vtkImageData

from vtk_mls import BallMask, FixedFace, ImageMask, Plane, SlidingFace
from vtk_mls.base.validation import as_float, short_repr
from vtk_mls.filters.own_control_points import as_float_rows
from vtk_mls.vtk import arrays
from vtk_mls.vtk.arrays import ImageGeometry


def one_mask(ball, mask, images=()):
    """The mask of the properties MaskBall and Mask, and of the input Mask; None without."""
    names = ["`MaskBall`"] * bool(np.any(ball)) + ["`Mask`"] * (mask is not None)
    names += ["the input `Mask`"] * len(images)
    if len(names) > 1:
        raise ValueError(
            f"a deformation has one mask, got {' and '.join(names)}; multiply them to one image"
        )
    if images:
        return image_mask(images[0])
    return image_mask(mask) if isinstance(mask, vtkImageData) else mask or ball_mask(ball)


def ball_mask(row, name="`MaskBall`"):
    """The BallMask of five numbers x, y, z, radius, falloff; None for zeros."""
    values = as_float(name.strip("`"), row)
    if values.shape != (5,):
        raise ValueError(
            f"{name} must be five numbers: x, y, z, radius, falloff; got {short_repr(tuple(row))}"
        )
    if not values.any():
        return None
    try:
        return BallMask.of_numbers(values)
    except ValueError as error:
        raise ValueError(f"{name} is no ball: {error}") from error


def image_mask(image, name="`Mask`"):
    """The ImageMask of the scalars of a vtkImageData; errors have the `name`.

    Integers are labels: what is not 0 is inside. Other numbers go from 0 to 1.
    """
    data = image.GetPointData()
    array = data.GetScalars()
    if array is None and data.GetNumberOfArrays() == 1:
        array = data.GetArray(0)
    if array is None or array.GetNumberOfComponents() != 1:
        components = "none" if array is None else f"{array.GetNumberOfComponents()} in each point"
        raise ValueError(f"{name} must be an image with one number in each point, got {components}")
    grid = ImageGeometry.of_image(image).grid
    values = arrays.to_numpy(array).reshape(grid.shape)
    if values.dtype.kind in "biu":
        values = values != 0
    elif not ((values >= 0) & (values <= 1)).all():
        raise ValueError(
            f"{name} must have numbers from 0 to 1, got {values.min():g} to {values.max():g}; "
            "divide them by their largest value, or save labels as integers"
        )
    try:
        return ImageMask(values, grid)
    except ValueError as error:
        raise ValueError(f"{name} is no mask: {error}") from error


def faces(fixed, sliding):
    """The faces of the properties FixedPlanes and SlidingPlanes, a list."""
    kinds = ("FixedPlanes", fixed, FixedFace), ("SlidingPlanes", sliding, SlidingFace)
    return [
        face(kind, row, f"`{name}`, row {index},")
        for name, rows, kind in kinds
        for index, row in enumerate(as_float_rows(name, rows, (7,)))
    ]


def face(kind, row, where):
    """A FixedFace or SlidingFace of seven numbers x, y, z, nx, ny, nz, falloff."""
    try:
        return kind(Plane(row[:3], row[3:6]), row[6])
    except ValueError as error:
        raise ValueError(f"{where} is no plane with a fall-off: {error}") from error
