"""Gradients, normals and Jacobians of deformed and cut images."""

import numpy as np
import pytest
from opened_images import APART, BOTH, HALF, REST, grid_of, numbers_of, scene, set_half_plane
from pipelines import connect, control_points, update
from vtk_fixtures import TURNED, add_array, make_image

from vtk_mls import Deformation, HalfPlane
from vtk_mls.filters import MLSDeform


@pytest.mark.parametrize("direction", [None, TURNED], ids=["straight", "turned"])
def test_gradient_is_that_of_the_deformed_function(device, direction):
    image = make_image((30, 28, 26), direction=direction)
    grid = grid_of(image)
    wave = np.array([0.05, -0.04, 0.06])
    add_array(image.GetPointData(), "values", np.sin(grid.points() @ wave))
    deforming = scene(MLSDeform, device, image)
    middle = grid.points().mean(axis=0)
    rest = middle + 3 * (np.random.default_rng(1).uniform(-1, 1, (6, 3)))
    deformed = rest + np.random.default_rng(2).normal(0, 0.4, (6, 3))
    connect(deforming, image, control_points(rest, deformed))
    deforming.SetGradientArray("values")
    deforming.SetInterpolation("cubic")
    output = update(deforming)
    value = Deformation(rest, deformed, device="reference")
    places = grid.points()
    origins, jacobian = value.backward(places), value.jacobian(places)
    expected = np.einsum("nij,ni->nj", jacobian, np.cos(origins @ wave)[:, None] * wave)
    index = grid.index_of(origins)
    inside = ((index > 3) & (index < np.array(grid.dimensions) - 4)).all(axis=1)
    assert inside.mean() > 0.3
    gradient = numbers_of(output.GetPointData(), "Gradient")
    error = np.abs(gradient - expected)[inside].max()
    assert error < 1e-3 * np.abs(expected).max()
    # it is not the gradient of the undeformed function
    plain = np.cos(places @ wave)[:, None] * wave
    assert np.abs(plain - expected)[inside].max() > 0.05 * np.abs(expected).max()
    deforming.SetNormalizeGradient(True)
    gradient = numbers_of(update(deforming).GetPointData(), "Gradient")
    np.testing.assert_allclose(np.linalg.norm(gradient[inside], axis=1), 1, atol=1e-5)


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
