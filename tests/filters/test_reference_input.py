"""The output of MLSDeform on the grid of another image."""

import numpy as np
import pytest
from pipelines import Executions, assert_fails, connect, control_points, update, values_of
from smooth_images import PLACES, assert_holds, expected, smooth_image
from vtk_fixtures import DEFORMED, REST, TURNED, make_image
from vtkmodules.vtkCommonDataModel import vtkDataObject, vtkMultiBlockDataSet
from vtkmodules.vtkCommonExecutionModel import vtkTrivialProducer
from vtkmodules.vtkFiltersSources import vtkSphereSource
from vtkmodules.vtkImagingCore import vtkRTAnalyticSource

from vtk_mls import Deformation, Grid, Plane, Sampling
from vtk_mls.filters import MLSDeform
from vtk_mls.vtk import arrays
from vtk_mls.vtk.arrays import ImageGeometry
from vtk_mls.vtk.objects import configured

FAR = [300.0, -200, 100]


def reference(shift=(0, 0, 0)):
    """An oblique image whose first index is not 0."""
    origin = np.add((1, 2, 0.5), shift)
    return make_image((7, 6, 5), (2, 0, -1), TURNED, origin, (0.6, 0.7, 0.8))


def deforming(dataset, grid=None, deformed=DEFORMED, port=True):
    deform = configured(MLSDeform(), Device="reference")
    if port:
        deform.SetInputData(5, grid)
    else:
        deform.SetReference(grid)
    return connect(deform, dataset, control_points(deformed=deformed))


@pytest.mark.parametrize("kind", ["input", "image", "grid"])
def test_the_output_has_the_grid_of_the_reference(kind):
    """Also with another grid chosen, and where it is far from the input."""
    image, target = smooth_image(**PLACES["shifted"]), reference(FAR)
    geometry = ImageGeometry.of_image(target)
    given = geometry.grid if kind == "grid" else target
    deform = deforming(image, given, DEFORMED + FAR, port=kind == "input")
    deform.SetOutputGrid("fitted")
    output = update(deform)
    found = ImageGeometry.of_image(output)
    assert kind == "grid" or found == geometry
    np.testing.assert_allclose(found.grid.points(), geometry.grid.points(), atol=1e-12)
    value = Deformation(REST, DEFORMED + FAR, device="reference")
    values, cells = expected(image, value, found.grid)
    assert_holds(output, values, cells)
    assert np.ptp(values) > 1
    deform.SetReference(None)
    deform.DisconnectReference()
    deform.SetOutputGrid("input")
    deform.SetDeformedPoints(())
    assert ImageGeometry.of_image(update(deform)) == ImageGeometry.of_image(image)


def test_gradients_jacobians_and_voids_are_those_of_its_points():
    image, cut = smooth_image(), Plane((4, 4, 3), (1, 0, 0))
    deform = deforming(image, reference())
    configured(deform, GradientArray="values", GenerateJacobian=True).AddCut(cut)
    output = update(deform)
    points = ImageGeometry.of_image(output).grid.points()
    value = Deformation(REST, DEFORMED, cuts=[cut], device="reference")
    void = value.void(points)
    np.testing.assert_array_equal(values_of(output, "Void").ravel() > 0, void)
    jacobian = arrays.to_numpy(output.GetPointData().GetArray("Jacobian")).reshape(-1, 3, 3)
    wanted = value.jacobian(points).swapaxes(1, 2)
    np.testing.assert_allclose(jacobian[~void], wanted[~void], atol=1e-4)
    grids = (ImageGeometry.of_image(dataset).grid for dataset in (image, output))
    wanted = value.corrected_gradient(values_of(image, "values"), Sampling(*grids))
    np.testing.assert_allclose(values_of(output, "Gradient"), wanted, atol=1e-3)
    assert np.abs(wanted).max() > 1


def test_little_of_the_reference_is_requested_and_its_changes_count():
    source = vtkRTAnalyticSource()
    source.SetWholeExtent(0, 9, 0, 8, 0, 7)
    deform = deforming(smooth_image())
    deform.SetInputConnection(5, source.GetOutputPort())
    assert update(deform).GetDimensions() == (10, 9, 8)
    assert source.GetOutput().GetDimensions() == (2, 2, 2)
    run = Executions(deform)
    source.SetWholeExtent(0, 4, 0, 4, 0, 4)
    assert update(deform).GetDimensions() == (5, 5, 5)
    assert run.count == 1


def test_directions_that_come_with_the_data_count():
    """As in ParaView 5.11, whose post filter leaves them out of the pipeline's information."""
    target, producer = reference(), vtkTrivialProducer()
    producer.SetOutput(target)
    deform = deforming(smooth_image())
    deform.SetInputConnection(5, producer.GetOutputPort())
    deform.AddObserver(
        "StartEvent", lambda *_: deform.GetInputInformation(5, 0).Remove(vtkDataObject.DIRECTION())
    )
    output = update(deform)
    np.testing.assert_array_equal(
        values_of(output, "values"), values_of(update(deforming(smooth_image(), target)), "values")
    )


def test_each_block_comes_to_the_reference():
    blocks, target = vtkMultiBlockDataSet(), reference()
    blocks.SetBlock(0, smooth_image())
    blocks.SetBlock(1, smooth_image())
    output = update(deforming(blocks, target))
    single = values_of(update(deforming(smooth_image(), target)), "values")
    for i in range(2):
        np.testing.assert_array_equal(values_of(output.GetBlock(i), "values"), single)


def test_a_warning_names_both_boxes(messages):
    """Once, until something changes."""
    deform = deforming(smooth_image(), reference(FAR))
    update(deform)
    messages.assert_one(
        "nothing of the input arrives on the grid of the reference: deformed, the input is in x "
        "-?[.0-9]+ to [.0-9]+, y .*, z .*; the grid is in x 30[0-9.]+ to 30[0-9.]+, y -19"
    )
    deform.SetBackground(1.0)
    update(deform)
    messages.assert_none()
    deform.SetBlend(0.5)
    update(deform)
    messages.assert_one("nothing of the input arrives")


def test_a_mesh_with_a_reference_is_an_error(messages):
    deform = deforming(vtkSphereSource(), Grid((2, 2, 2)), port=False)
    assert_fails(
        deform,
        messages,
        "`Reference` is the grid of .* the input is a vtkPolyData, which keeps its own",
    )
