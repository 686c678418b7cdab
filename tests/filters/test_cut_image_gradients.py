"""Gradients, normals and Jacobians of deformed and cut images."""

import numpy as np
from opened_images import APART, BOTH, HALF, REST, grid_of, numbers_of, scene, set_half_plane
from pipelines import connect, control_points, update
from vtk_fixtures import add_array, make_image

from vtk_mls import Deformation, HalfPlane
from vtk_mls.filters import MLSDeform


def test_normals_and_gradients_of_the_input_are_turned(device):
    image = make_image()
    count = image.GetNumberOfPoints()
    normals = np.tile([0.6, 0.0, 0.8], (count, 1))
    add_array(image.GetPointData(), "n", normals)
    image.GetPointData().SetActiveNormals("n")
    add_array(image.GetPointData(), "g", 3 * normals)
    add_array(image.GetPointData(), "plain", 3 * normals)
    deforming = scene(MLSDeform, device, image)
    deforming.AddGradientVectorArray("g")
    output = update(deforming)
    value = Deformation(REST, APART, device="reference")
    expected = np.einsum("nij,ni->nj", value.jacobian(grid_of(image).points()), 3 * normals)
    turned = numbers_of(output.GetPointData(), "g")
    inside = numbers_of(output.GetPointData(), "plain")[:, 0] > 1.7
    np.testing.assert_allclose(turned[inside], expected[inside], atol=1e-3)
    assert np.abs(expected - 3 * normals).max() > 0.1
    unit = expected / np.linalg.norm(expected, axis=1, keepdims=True)
    data = output.GetPointData()
    assert data.GetNormals().GetName() == "n"
    np.testing.assert_allclose(numbers_of(data, "n")[inside], unit[inside], atol=1e-3)
    assert np.ptp(numbers_of(data, "plain")[inside], axis=0).max() < 1e-6
    deforming.ClearGradientVectorArrays()
    assert deforming.GetGradientVectorArrays() == ()
    np.testing.assert_allclose(
        numbers_of(update(deforming).GetPointData(), "g")[inside], 3 * normals[inside], atol=1e-6
    )


@BOTH
def test_jacobians(kind, device):
    deforming = scene(kind, device)
    set_half_plane(deforming)
    deforming.SetGenerateJacobian(True)
    deforming.SetGenerateJacobianDeterminant(True)
    output = update(deforming)
    value = Deformation(REST, APART, cuts=[HalfPlane(*HALF)], device="reference")
    expected = value.jacobian(grid_of(output).points())
    data = output.GetPointData()
    jacobian = numbers_of(data, "Jacobian").reshape(-1, 3, 3)
    np.testing.assert_allclose(jacobian, expected.swapaxes(-1, -2), atol=1e-3)
    determinant = numbers_of(data, "JacobianDeterminant")
    np.testing.assert_allclose(determinant, np.linalg.det(expected), atol=1e-3)
    folded = (determinant <= 0) & (numbers_of(data, "Void") == 0)
    assert output.GetFieldData().GetArray("FoldedVoxels").GetValue(0) == folded.sum()


def test_folds_are_counted():
    deforming = scene(MLSDeform)
    # one control point is dragged past its neighbor
    rest = [(2.0, 3, 3), (4.0, 3, 3), (6.0, 3, 3)]
    deformed = [(2.0, 3, 3), (6.5, 3, 3), (6.0, 3, 3)]
    connect(deforming, make_image(), control_points(rest, deformed))
    deforming.SetKind("affine")
    deforming.SetGenerateJacobianDeterminant(True)
    output = update(deforming)
    folded = (numbers_of(output.GetPointData(), "JacobianDeterminant") <= 0).sum()
    assert output.GetFieldData().GetArray("FoldedVoxels").GetValue(0) == folded > 0
    connect(deforming, make_image(), control_points(REST, REST))
    assert update(deforming).GetFieldData().GetArray("FoldedVoxels").GetValue(0) == 0
