"""Data with time steps."""

from __future__ import annotations

from vtkmodules.util.vtkAlgorithm import VTKPythonAlgorithmBase
from vtkmodules.vtkCommonDataModel import vtkDataObject
from vtkmodules.vtkCommonExecutionModel import vtkStreamingDemandDrivenPipeline, vtkTrivialProducer

_KEYS = vtkStreamingDemandDrivenPipeline
TIMES = 0.0, 0.5, 1.0, 2.0, 3.0


class Series(VTKPythonAlgorithmBase):
    """Source of the data of the last step up to the requested time.

    Parameters
    ----------
    data : list of vtkDataObject
        All of the same type.
    steps : list of float
    """

    def __init__(self, data, steps):
        super().__init__(nInputPorts=0, nOutputPorts=1, outputType=data[0].GetClassName())
        self.data, self.steps = data, steps

    def RequestInformation(self, request, in_info, out_info):
        info = out_info.GetInformationObject(0)
        vtkTrivialProducer.FillOutputDataInformation(self.data[0], info)
        info.Set(_KEYS.TIME_STEPS(), self.steps, len(self.steps))
        info.Set(_KEYS.TIME_RANGE(), (self.steps[0], self.steps[-1]), 2)
        return 1

    def RequestData(self, request, in_info, out_info):
        info, output = out_info.GetInformationObject(0), vtkDataObject.GetData(out_info)
        time = info.Get(_KEYS.UPDATE_TIME_STEP())
        index = max([i for i, step in enumerate(self.steps) if step <= time], default=0)
        output.ShallowCopy(self.data[index])
        output.GetInformation().Set(output.DATA_TIME_STEP(), self.steps[index])
        return 1


def series(rng, make):
    """A Series of results of `make` at random times."""
    steps = sorted(rng.choice(TIMES, rng.integers(1, 4), replace=False).tolist())
    return Series([make() for _ in steps], steps)
