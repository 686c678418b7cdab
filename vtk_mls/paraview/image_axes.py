"""Images whose axes run as those of the world do, for programs that do not look at directions."""

from __future__ import annotations

from itertools import permutations

import numpy as np
from vtkmodules.vtkCommonDataModel import vtkImageData

from vtk_mls import Grid
from vtk_mls.vtk import arrays
from vtk_mls.vtk.arrays import ImageGeometry


def along_world(image):
    """An image with its axes in the order and the sense of x, y and z, to which they are nearest.

    No voxel moves: rows of them are stored in another order. The direction matrix is then the
    identity, or where axes are oblique a turn by less than it was.

    Parameters
    ----------
    image : vtkImageData
        With point data; no cell data.

    Returns
    -------
    vtkImageData
        The image itself if there is nothing to change.
    """
    grid = ImageGeometry.of_image(image).grid
    order = list(max(permutations(range(3)), key=lambda axes: _likeness(grid.direction, axes)))
    senses = np.where(np.diagonal(grid.direction[:, order]) < 0, -1, 1)
    if order == [0, 1, 2] and (senses > 0).all():
        return image
    dimensions = np.array(grid.dimensions)[order]
    first = np.zeros(3)
    first[order] = np.where(senses < 0, dimensions - 1, 0)
    along = Grid(
        dimensions,
        grid.at(first[None])[0],
        np.array(grid.spacing)[order],
        grid.direction[:, order] * senses + 0.0,
    )
    result = vtkImageData()
    ImageGeometry.of_grid(along).apply_to(result)
    backwards = tuple(2 - np.flatnonzero(senses < 0))
    values = [
        np.flip(np.transpose(old, [*(2 - np.array(order[::-1])), *range(3, old.ndim)]), backwards)
        for old in arrays.image_values(image.GetPointData(), grid)
    ]
    arrays.set_image_values(result.GetPointData(), values, image.GetPointData())
    result.GetFieldData().ShallowCopy(image.GetFieldData())
    return result


def _likeness(direction, axes):
    """How well these axes, in this order, follow x, y and z."""
    return np.abs(np.diagonal(direction[:, axes])).sum()
