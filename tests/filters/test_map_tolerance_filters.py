"""MapTolerance of the filters is `map_tolerance` of the deformation."""

import numpy as np
import pytest
from vtkmodules.vtkFiltersSources import vtkSphereSource
from vtkmodules.vtkImagingCore import vtkRTAnalyticSource

from vtk_mls import Deformation, Grid, HalfPlane
from vtk_mls.filters import MLSDeform, MLSDisplacementField
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


def test_the_inverse_is_exact_with_any():
    np.testing.assert_array_equal(field(0.1, inverse=True), field(0, inverse=True))


@pytest.mark.parametrize("cuts", [(), (HalfPlane((0, 0, 0), (1, 0.1, 0), (0, 0, 1)),)])
def test_meshes_are_exact_with_any(cuts):
    sphere, moved = vtkSphereSource(), []
    sphere.SetRadius(15)
    sphere.SetThetaResolution(60)
    sphere.SetPhiResolution(60)
    for tolerance in (0.1, 0):
        filter_ = MLSDeform()
        filter_.SetInputConnection(sphere.GetOutputPort())
        filter_.SetRestPoints(REST)
        filter_.SetDeformedPoints(DEFORMED)
        for cut in cuts:
            filter_.AddCut(cut)
        filter_.SetMapTolerance(tolerance)
        filter_.Update()
        moved.append(to_numpy(filter_.GetOutput().GetPoints().GetData()))
    assert len(moved[0]) > 3000
    np.testing.assert_array_equal(*moved)
