"""The void of cells of images and of their parts."""

import numpy as np
import pytest
from pipelines import connect, control_points
from vtk_fixtures import FAST, make_image

from vtk_mls import Deformation, HalfPlane
from vtk_mls.filters import MLSDeform
from vtk_mls.vtk import arrays
from vtk_mls.vtk.arrays import ImageGeometry


@pytest.mark.parametrize("last", [10, 11, 19])
def test_a_thin_part_has_the_void_of_the_whole(last):
    x, y, z = (axis.ravel() for axis in np.meshgrid(*[np.linspace(-1, 20, 6)] * 3))
    rest = np.stack([x, y, z], axis=1)
    deformed = rest + np.where(rest[:, 2:] > 9.5, 0.2, -0.2) * [0, 0, 1]
    cut = HalfPlane((9.5, -9, 9.5), (0, 0, 1), (0, 1, 0))
    image = make_image((20, 20, 20), origin=(0, 0, 0))
    image.SetSpacing(1, 1, 1)
    arrays.add(image.GetPointData(), "values", np.zeros(8000, np.float32))
    image.GetPointData().SetActiveScalars("values")
    deform = connect(MLSDeform(), image, control_points(rest, deformed))
    deform.SetDevice(FAST)
    deform.AddCut(cut)
    deform.UpdateInformation()
    deform.UpdateExtent((0, 19, 0, 19, 9, last))
    output = deform.GetOutputDataObject(0)
    cells = ImageGeometry.of_image(output).grid.cells
    expected = Deformation(rest, deformed, cuts=[cut], device=FAST).void(cells.points())
    assert expected.sum() == 361
    found = arrays.to_numpy(output.GetCellData().GetArray("Void"))
    np.testing.assert_array_equal(found, expected)
