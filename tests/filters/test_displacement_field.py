"""MLSDisplacementField gives the value's map, as vtkGridTransform takes it."""

import numpy as np
import pytest
from mesh_fixtures import count
from pipelines import assert_fails, connect, control_points, update, values_of
from smooth_images import PLACES, smooth_image
from vtk_fixtures import DEFORMED, REST, add_scalars, make_image, polydata_of
from vtkmodules.vtkFiltersHybrid import vtkGridTransform
from vtkmodules.vtkFiltersSources import vtkPlaneSource, vtkSphereSource
from vtkmodules.vtkImagingCore import vtkImageReslice

from vtk_mls import Deformation, HalfPlane
from vtk_mls.filters import MLSDeform, MLSDisplacementField, displacement_field
from vtk_mls.vtk.arrays import ImageGeometry
from vtk_mls.vtk.objects import configured, output_of

NAME = "BackwardDisplacement"
INVERSE = {"Inverse": True, "GenerateJacobianDeterminant": True}


@pytest.fixture
def field(device):
    return configured(MLSDisplacementField(), Device=device)


@pytest.mark.parametrize("place", PLACES)
def test_an_image_gives_its_grid(field, device, place):
    image = smooth_image(**PLACES[place])
    output = update(connect(field, image, control_points()))
    assert ImageGeometry.of_image(output) == ImageGeometry.of_image(image)
    grid = ImageGeometry.of_image(image).grid
    value = Deformation(REST, DEFORMED, device=device)
    expected = value.displacement_field(
        grid.dimensions, grid.origin, grid.spacing, grid.direction
    ).displacement
    np.testing.assert_array_equal(values_of(output, NAME), expected)
    assert np.abs(expected).max() > 0.5
    data = output.GetPointData()
    assert data.GetNumberOfArrays() == 1
    assert data.GetScalars() is data.GetVectors() is data.GetArray(NAME)
    assert output.GetScalarTypeAsString() == "float"


def test_another_dataset_gives_its_bounds(field, device):
    sphere = configured(vtkSphereSource(), Radius=3, Center=(4, 4, 3))
    field.SetSampleDimensions(5, 6, 1)
    connect(field, sphere, control_points())
    field.UpdateInformation()
    announced = ImageGeometry.of_information(field.GetOutputInformation(0))
    output = update(field)
    assert ImageGeometry.of_image(output) == announced
    assert output.GetDimensions() == (5, 6, 1)
    bounds = sphere.GetOutput().GetBounds()
    middle = (bounds[4] + bounds[5]) / 2
    np.testing.assert_allclose(output.GetBounds(), (*bounds[:4], middle, middle))
    grid = announced.grid
    value = Deformation(REST, DEFORMED, device=device)
    expected = value.displacement_field(grid.dimensions, grid.origin, grid.spacing)
    np.testing.assert_array_equal(values_of(output, NAME), expected.displacement)
    sphere.SetRadius(2)
    assert update(field).GetBounds()[1] == pytest.approx(6, abs=0.1)


def test_a_flat_dataset_gives_a_flat_image(field):
    field.SetSampleDimensions(4, 5, 6)
    output = update(connect(field, vtkPlaneSource(), control_points()))
    assert output.GetDimensions() == (4, 5, 1)


@pytest.mark.parametrize("start", [(0, 0, 0), (3, -2, 5)])
def test_vtk_grid_transform_deforms_alike(field, device, start):
    origin = -np.multiply(start, (0.9, 1.0, 1.1))
    image, handles = make_image((12, 11, 10), start, origin=origin), control_points()
    x, y, z = ImageGeometry.of_image(image).grid.points().T
    add_scalars(image, "values", np.sin(x) + np.cos(y * 0.8) + z)
    deform = configured(MLSDeform(), Device=device, Background=-5)
    for algorithm in (deform, field):
        connect(algorithm, image, handles)
    transform = configured(vtkGridTransform(), DisplacementGridConnection=field.GetOutputPort())
    transform.SetInterpolationModeToLinear()
    reslice = configured(vtkImageReslice(), InputData=image, ResliceTransform=transform)
    configured(reslice, BackgroundLevel=-5).SetInterpolationModeToLinear()
    for deformed in (DEFORMED, DEFORMED[::-1]):
        handles.SetDeformedPoints(deformed)
        ours = values_of(update(deform), "values")
        theirs = update(reslice)
        theirs = values_of(theirs, theirs.GetPointData().GetScalars().GetName())
        # VTK's border ends earlier than half a voxel outside
        both = (ours != -5) & (theirs != -5)
        assert both.mean() > 0.3
        np.testing.assert_allclose(ours[both], theirs[both], atol=2e-5)
        assert np.abs(ours - values_of(image, "values")).max() > 0.5


def test_after_a_failure_a_smaller_grid_is_requested(messages):
    """VTK keeps the extent that was asked for last."""
    field = configured(MLSDisplacementField(), Device="reference")
    connect(field, output_of(vtkSphereSource()), polydata_of([(0, 0, 0)]))
    for _ in range(3):
        assert_fails(field, messages, "no numeric point array `Displacement`")
        field.SetSampleDimensions(5, 1, 3)
    field.RemoveAllInputConnections(1)
    assert update(field).GetDimensions() == (5, 1, 3)


def test_the_inverse_leads_where_forward_does(field, device):
    image = smooth_image(**PLACES["turned"])
    output = update(connect(configured(field, **INVERSE), image, control_points()))
    x = ImageGeometry.of_image(image).grid.points()
    value = Deformation(REST, DEFORMED, device="reference")
    expected = value.forward(x)
    found = np.isfinite(expected).all(axis=1)
    assert found.mean() > 0.9
    forward = values_of(output, "ForwardDisplacement").reshape(-1, 3)
    np.testing.assert_allclose((x + forward)[found], expected[found], atol=2e-4)
    assert output.GetPointData().GetScalars().GetName() == "ForwardDisplacement"
    np.testing.assert_array_equal(values_of(output, "NoInverse").ravel() > 0, ~found)
    assert count(output, "FailedInverses") == (~found).sum()
    # the chain rule: dF/dx at x is the inverse of dG/dv at F(x)
    determinant = values_of(output, "JacobianDeterminant").ravel()
    of_backward = np.linalg.det(value.jacobian(expected[found]))
    np.testing.assert_allclose(determinant[found] * of_backward, 1, atol=1e-3)


def test_points_without_a_forward_image_are_counted_and_finite(field):
    rest = np.array([(1.0, y, z) for y in (1, 7) for z in (1, 5)] + [(7.0, 4, 3)])
    # the left half is pushed through the cut
    through = rest + np.where(rest[:, :1] < 4, (5, 0, 0), (0, 0, 0))
    field.AddCut(HalfPlane((4.2, 4, 0), (1, 0, 0), (0, 1, 0)))
    configured(field, CutFrame="deformed", **INVERSE)
    image = make_image((5, 4, 4), spacing=(1.8, 2.0, 2.2))
    output = update(connect(field, image, control_points(rest, through)))
    lost = values_of(output, "NoInverse") > 0
    assert count(output, "FailedInverses") == lost.sum() > 0
    assert np.isfinite(values_of(output, "ForwardDisplacement")).all()
    determinant = values_of(output, "JacobianDeterminant")
    assert (determinant[lost] == 0).all()
    assert (determinant[~lost] > 0).any()


def test_pieces_of_the_inverse_are_the_whole_to_its_tolerance(field, monkeypatch):
    field.SetInverse(True)
    connect(field, make_image(), control_points())
    whole = values_of(update(field), "ForwardDisplacement").copy()
    monkeypatch.setattr(displacement_field, "_CHUNK", 100)
    field.Modified()
    chunked = values_of(update(field), "ForwardDisplacement")
    np.testing.assert_allclose(chunked, whole, atol=2e-4)
    field.UpdatePiece(1, 2, 0)
    part = field.GetOutputDataObject(0)
    e = part.GetExtent()
    where = np.s_[e[4] : e[5] + 1, e[2] : e[3] + 1, e[0] : e[1] + 1]
    assert part.GetNumberOfPoints() < whole[..., 0].size
    np.testing.assert_allclose(values_of(part, "ForwardDisplacement"), whole[where], atol=2e-4)
