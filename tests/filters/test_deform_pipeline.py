"""MLSDeform behaves in a pipeline as VTK's own filters do."""

import gc

import numpy as np
import pytest
from pipelines import Executions, connect, control_points, update, values_of
from smooth_images import assert_holds, expected, smooth_image
from vtk_fixtures import DEFORMED, REST, add_array, add_scalars, make_image
from vtkmodules.vtkCommonDataModel import (
    vtkDataObject,
    vtkDataSetAttributes,
    vtkImageData,
    vtkMultiBlockDataSet,
)
from vtkmodules.vtkCommonExecutionModel import vtkTrivialProducer
from vtkmodules.vtkImagingCore import vtkRTAnalyticSource

from vtk_mls import Deformation, HalfPlane
from vtk_mls.filters import MLSDeform
from vtk_mls.vtk import arrays
from vtk_mls.vtk.objects import configured


@pytest.fixture
def device():
    """Numbers are not the point here."""
    return "reference"


def test_nothing_is_done_twice(deform):
    source, handles = vtkRTAnalyticSource(), control_points()
    source.SetWholeExtent(0, 8, 0, 8, 0, 8)
    runs = [Executions(algorithm) for algorithm in (source, handles, deform)]
    connect(deform, source, handles)

    def counts():
        update(deform)
        return [run.count for run in runs]

    assert counts() == counts() == [1, 1, 1]
    for _ in range(2):
        deform.SetAlpha(1)
        assert counts() == [1, 1, 2]
    handles.SetRestPoint(0, 1.0, 1.0, 1.5)
    assert counts() == counts() == [1, 2, 3]
    source.SetStandardDeviation(0.4)
    assert counts() == counts() == [2, 2, 4]


def test_changed_data_are_noticed(deform):
    image, polydata = smooth_image(), update(control_points())
    connect(deform, image, polydata)
    first = values_of(update(deform), "values").copy()
    arrays.to_numpy(polydata.GetPointData().GetArray("Displacement"))[:] += 0.5
    polydata.GetPointData().GetArray("Displacement").Modified()
    polydata.GetPointData().Modified()
    second = values_of(update(deform), "values").copy()
    assert not np.array_equal(first, second)
    arrays.to_numpy(image.GetPointData().GetArray("values"))[:] *= 2
    image.GetPointData().GetArray("values").Modified()
    third = values_of(update(deform), "values")
    np.testing.assert_allclose(third, 2 * second, atol=1e-12)


def test_a_piece_that_is_there_is_not_made_again(deform):
    connect(deform, smooth_image(), control_points())
    for piece in range(3):
        deform.UpdatePiece(piece, 3, 0)
        runs = Executions(deform)
        deform.UpdatePiece(piece, 3, 0)
        assert runs.count == 0
    deform.UpdateWholeExtent()
    assert runs.count == 1


def test_the_input_may_be_only_a_part_of_what_it_could_be(deform, device):
    producer, image = vtkTrivialProducer(), smooth_image()
    producer.SetOutput(image)
    producer.SetWholeExtent(0, 8, 0, 7, 0, 6)
    output = update(connect(deform, producer, control_points()))
    assert_holds(output, *expected(image, Deformation(REST, DEFORMED, device=device)))


def test_the_output_outlives_the_filter(deform):
    image, handles = smooth_image(), control_points()
    output = update(connect(deform, image, handles))
    wanted = values_of(output, "values").copy()
    copy = output.NewInstance()
    copy.ShallowCopy(output)
    del deform, handles, image, output
    gc.collect()
    rubbish = [np.full(wanted.shape, np.nan) for _ in range(50)]
    np.testing.assert_array_equal(values_of(copy, "values"), wanted)
    del rubbish


def test_the_same_output_object_is_refilled(deform):
    connect(deform, smooth_image(), control_points())
    output = update(deform)
    deform.SetKind("affine")
    assert update(deform) is output


def test_another_displacement_array(deform, device):
    image, polydata = smooth_image(), update(control_points())
    half = (DEFORMED - REST) / 2
    add_array(polydata.GetPointData(), "half", half)
    connect(deform, image, polydata)
    points = vtkDataObject.FIELD_ASSOCIATION_POINTS
    deform.SetInputArrayToProcess(0, 1, 0, points, "half")
    value = Deformation(REST, REST + half, device=device)
    assert_holds(update(deform), *expected(image, value))
    polydata.GetPointData().SetActiveVectors("Displacement")
    deform.SetInputArrayToProcess(0, 1, 0, points, vtkDataSetAttributes.VECTORS)
    value = Deformation(REST, REST + (DEFORMED - REST), device=device)
    assert_holds(update(deform), *expected(image, value))
    # "Weight" may be named although it is absent
    deform.SetInputArrayToProcess(1, 1, 0, points, "Weight")
    assert_holds(update(deform), *expected(image, value))


def test_blocks_do_not_keep_scalars_of_other_blocks(deform, messages):
    """VTK leaves them in the output of an algorithm that runs on several."""
    blocks = vtkMultiBlockDataSet()
    for number, name in enumerate("abc"):
        image = make_image((5 - number, 4, 3))
        blocks.SetBlock(number, add_scalars(image, name, np.arange(image.GetNumberOfPoints())))
    output = update(connect(deform, blocks, control_points()))
    messages.assert_one("what crosses a border between them is lost")
    for number, name in enumerate("abc"):
        data = output.GetBlock(number).GetPointData()
        assert (data.GetNumberOfArrays(), data.GetArrayName(0)) == (1, name)


# Outputs that are in use keep their memory (buffer_pool.py)


def test_outputs_that_are_held_stay_as_they_are(rng):
    image = make_image((104,) * 3, origin=(0, 0, 0), spacing=(1, 1, 1))
    arrays.add(image.GetPointData(), "values", rng.random(104**3, np.float32))
    rest, held = rng.uniform(0, 100, (6, 3)), []
    deform = configured(MLSDeform(), InputData=image, RestPoints=rest)
    deform.AddCut(HalfPlane((35, 35, 35), (0, 0, 1), (1, 0, 0)))
    for _ in range(4):
        deform.SetDeformedPoints(rest + rng.normal(size=(6, 3)))
        deform.Update()
        output, in_use = vtkImageData(), []
        output.ShallowCopy(deform.GetOutput())
        for data in (output.GetPointData(), output.GetCellData()):
            in_use += [data.GetArray(number) for number in range(data.GetNumberOfArrays())]
        del output, data
        held.append([(array, np.array(array)) for array in in_use])
        if len(held) == 3:
            del held[1]
        assert len(in_use) >= 4
    del deform, in_use
    for pairs in held:
        for array, copy in pairs:
            np.testing.assert_array_equal(np.array(array), copy)
