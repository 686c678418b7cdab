"""Images stored along the axes of the world show the same values at the same places."""

from itertools import permutations, product

import numpy as np
import pytest
from vtk_fixtures import add_array
from vtkmodules.vtkCommonCore import VTK_FLOAT, VTK_SHORT
from vtkmodules.vtkCommonDataModel import vtkImageData

from vtk_mls import Grid
from vtk_mls.paraview.image_reader import along_world_axes
from vtk_mls.vtk import arrays
from vtk_mls.vtk.arrays import ImageGeometry

SIGNED = [
    np.eye(3)[:, order] * signs
    for order in permutations(range(3))
    for signs in product((1.0, -1.0), repeat=3)
]


def oriented(direction):
    """An image with int16 scalars and float vectors, its extent not from 0."""
    grid = Grid((3, 4, 5), (10, -20, 30), (1, 2, 0.5), direction)
    whole = ImageGeometry.of_grid(grid)
    shift = grid.at(np.array([[-2.0, 3, 1]]))[0]
    geometry = ImageGeometry((2, 4, -3, 0, -1, 3), tuple(shift), whole.spacing, whole.direction)
    image = vtkImageData()
    geometry.apply_to(image)
    data = image.GetPointData()
    data.SetScalars(add_array(data, "T1", np.arange(60), VTK_SHORT))
    add_array(data, "V", np.arange(180).reshape(60, 3), VTK_FLOAT)
    return image


def by_place(image):
    """The values of an image's arrays, in the order of their places: x, then y, then z."""
    places = np.array([image.GetPoint(i) for i in range(image.GetNumberOfPoints())])
    order = np.lexsort(places.round(6).T)
    data = image.GetPointData()
    values = [arrays.to_numpy(data.GetArray(name))[order] for name in ("T1", "V")]
    return places[order], *values


@pytest.mark.parametrize("direction", SIGNED, ids=range(len(SIGNED)))
def test_images_along_axes_get_the_identity_direction(direction):
    image = oriented(direction)
    result = along_world_axes(image)
    grid = ImageGeometry.of_image(result).grid
    np.testing.assert_array_equal(grid.direction, np.eye(3))
    for found, expected in zip(by_place(result), by_place(image)):
        np.testing.assert_allclose(found, expected, atol=1e-12)
    assert result.GetPointData().GetScalars().GetName() == "T1"
    assert result.GetPointData().GetScalars().GetDataType() == VTK_SHORT
    assert (result is image) == np.array_equal(direction, np.eye(3))


def test_oblique_axes_get_the_smallest_rotation():
    turn = np.array([[0.8, -0.6, 0], [0.6, 0.8, 0], [0, 0, 1]])
    for direction in (turn @ signed for signed in SIGNED):
        image = oriented(direction)
        result = along_world_axes(image)
        np.testing.assert_allclose(ImageGeometry.of_image(result).grid.direction, turn, atol=1e-12)
        for found, expected in zip(by_place(result), by_place(image)):
            np.testing.assert_allclose(found, expected, atol=1e-12)
