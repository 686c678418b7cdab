"""A later output must not take the memory of an output that is still in use (buffer_pool.py)."""

import numpy as np
from vtkmodules.vtkCommonDataModel import vtkImageData

from vtk_mls import HalfPlane
from vtk_mls.filters import MLSDeform


def test_outputs_that_are_held_stay_as_they_are(rng):
    image = vtkImageData()
    image.SetDimensions(104, 104, 104)
    image.AllocateScalars(10, 1)
    values = np.frombuffer(image.GetPointData().GetScalars(), np.float32)
    values[:] = rng.random(values.size)
    deform, held = MLSDeform(), []
    deform.SetInputData(image)
    deform.AddCut(HalfPlane((35, 35, 35), (0, 0, 1), (1, 0, 0)))
    rest = rng.uniform(0, 100, (6, 3))
    deform.SetRestPoints(rest)
    for _ in range(4):
        deform.SetDeformedPoints(rest + rng.normal(size=(6, 3)))
        deform.Update()
        output, arrays = vtkImageData(), []
        output.ShallowCopy(deform.GetOutput())
        for data in (output.GetPointData(), output.GetCellData()):
            arrays += [data.GetArray(number) for number in range(data.GetNumberOfArrays())]
        del output, data
        held.append([(array, np.array(array)) for array in arrays])
        if len(held) == 3:
            del held[1]
        assert len(arrays) >= 4
    del deform, arrays
    for pairs in held:
        for array, copy in pairs:
            np.testing.assert_array_equal(np.array(array), copy)
