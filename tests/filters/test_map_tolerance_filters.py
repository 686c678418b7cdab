"""MapTolerance of the filters is `map_tolerance` of the deformation."""

import numpy as np
from vtkmodules.vtkImagingCore import vtkRTAnalyticSource

from vtk_mls import Deformation, Grid
from vtk_mls.filters import MLSDisplacementField
from vtk_mls.vtk.arrays import to_numpy

REST, DEFORMED = [(-10, 3, 1), (14, -8, 5), (2, 9, -12)], [(-7, 5, 1), (12, -8, 9), (2, 6, -12)]


def field(tolerance, inverse=False):
    source, filter_ = vtkRTAnalyticSource(), MLSDisplacementField()
    filter_.SetInverse(inverse)
    source.SetWholeExtent(-20, 20, -18, 18, -17, 17)
    filter_.SetInputConnection(source.GetOutputPort())
    filter_.SetRestPoints(REST)
    filter_.SetDeformedPoints(DEFORMED)
    filter_.SetMapTolerance(tolerance)
    filter_.Update()
    return to_numpy(filter_.GetOutput().GetPointData().GetScalars())


def test_it_is_that_of_the_deformation():
    grid = Grid((41, 37, 35), (-20, -18, -17))
    coarse, exact = (
        Deformation(REST, DEFORMED, map_tolerance=tolerance).displacement_field(grid).displacement
        for tolerance in (0.1, 0)
    )
    assert 1e-4 < np.linalg.norm(coarse - exact, axis=-1).max() < 0.1
    np.testing.assert_array_equal(field(0.1), coarse.reshape(-1, 3))
    np.testing.assert_array_equal(field(0), exact.reshape(-1, 3))
