"""An image with smooth arrays, and what `MLSDeform` makes of it."""

import numpy as np
import pytest
from pipelines import values_of
from vtk_fixtures import TURNED, TYPES, add_array, add_scalars, make_image

from vtk_mls import Sampling
from vtk_mls.filters import MLSDeform
from vtk_mls.vtk import arrays
from vtk_mls.vtk.arrays import ImageGeometry
from vtk_mls.vtk.objects import configured

PLACES = {
    "plain": {},
    "shifted": {"start": (3, -2, 5), "origin": (-2.7, 2.0, -5.5)},
    "turned": {"direction": TURNED, "origin": (2.0, -1.0, 0.5)},
    "slice": {"dimensions": (9, 8, 1), "origin": (0.5, 0.25, 4.0)},
}


@pytest.fixture
def deform(device):
    return configured(MLSDeform(), Device=device)


def smooth_image(**place):
    """Point array "values" (float64), cell array "cells" (two components, float32)."""
    image = make_image(**place)
    grid = ImageGeometry.of_image(image).grid
    x, y, z = grid.points().T
    add_scalars(image, "values", np.sin(x) + y * z)
    x, y, z = grid.cells.points().T
    add_array(image.GetCellData(), "cells", np.stack([x * y, z], axis=1), TYPES["float"])
    return image


def expected(image, deformation, target=None, **options):
    """The arrays of `smooth_image`, deformed without VTK's pipeline."""
    grid = ImageGeometry.of_image(image).grid
    target = target or grid
    sampling = Sampling(grid, target, **options)
    (values,) = deformation.resample([values_of(image, "values")], sampling)
    cells = grid.cells
    old = arrays.to_numpy(image.GetCellData().GetArray("cells")).reshape(*cells.shape, 2)
    sampling = Sampling(cells, target.cells, **options)
    (new,) = deformation.resample([old], sampling)
    return values, new.reshape(-1, 2)


def assert_holds(output, values, cells):
    np.testing.assert_array_equal(values_of(output, "values"), values)
    np.testing.assert_array_equal(arrays.to_numpy(output.GetCellData().GetArray("cells")), cells)
