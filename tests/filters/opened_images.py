"""Filters on an image that is cut and pulled apart."""

import numpy as np
import pytest
from pipelines import connect, control_points
from vtk_fixtures import FAST, add_array, make_image

from vtk_mls.filters import MLSDeform, MLSDisplacementField
from vtk_mls.vtk import arrays
from vtk_mls.vtk.arrays import ImageGeometry

# Pulled apart across x = 3.9, held below.
REST = np.array([(2.0, 3.0, 5.0), (6.0, 3.0, 5.0), (2.0, 3.0, 1.0), (6.0, 3.0, 1.0)])
APART = REST + [(-1.2, 0, 0), (1.2, 0, 0), (0, 0, 0), (0, 0, 0)]
HALF = (3.9, 3.0, 2.6), (1.0, 0.0, 0.0), (0.0, 0.0, 1.0)
BOTH = pytest.mark.parametrize("kind", [MLSDeform, MLSDisplacementField])


def scene(kind, device=FAST, image=None):
    """A filter on an image with the point array "values"."""
    image = image or make_image()
    if not image.GetPointData().HasArray("values"):
        x, y, z = ImageGeometry.of_image(image).grid.points().T
        add_array(image.GetPointData(), "values", 5 + np.sin(0.3 * x) + 0.2 * y * z)
        add_array(image.GetCellData(), "cells", np.ones(image.GetNumberOfCells()))
        image.GetPointData().SetActiveScalars("values")
    deforming = kind()
    deforming.SetDevice(device)
    return connect(deforming, image, control_points(REST, APART))


def set_half_plane(deforming):
    deforming.SetCutType("half-plane")
    deforming.SetCutOrigin(HALF[0])
    deforming.SetCutNormal(HALF[1])
    deforming.SetCutInward(HALF[2])


def grid_of(image):
    return ImageGeometry.of_image(image).grid


def numbers_of(attributes, name):
    return arrays.to_numpy(attributes.GetArray(name))
