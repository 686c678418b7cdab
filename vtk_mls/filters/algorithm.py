"""What VTK's own algorithms do and those in Python do not: fail, stop, and try again."""

from __future__ import annotations

import numpy as np
from vtkmodules.util.misc import calldata_type
from vtkmodules.util.vtkAlgorithm import VTKPythonAlgorithmBase
from vtkmodules.vtkCommonCore import (
    VTK_STRING,
    vtkInformation,
    vtkInformationVector,
    vtkObject,
    vtkOutputWindow,
)
from vtkmodules.vtkCommonDataModel import vtkCompositeDataSet, vtkDataObject
from vtkmodules.vtkCommonExecutionModel import (
    vtkDemandDrivenPipeline,
    vtkStreamingDemandDrivenPipeline,
)

from vtk_mls import Aborted, DeviceError
from vtk_mls.base.messages import listening
from vtk_mls.base.progress import whole
from vtk_mls.filters import times
from vtk_mls.filters.requests import ask_for_all, ask_within_the_whole

# The requests that filters answer, by methods of VTKPythonAlgorithmBase.
_ANSWERS = {
    vtkDemandDrivenPipeline.REQUEST_DATA_OBJECT(): "RequestDataObject",
    vtkDemandDrivenPipeline.REQUEST_INFORMATION(): "RequestInformation",
    vtkStreamingDemandDrivenPipeline.REQUEST_TIME_DEPENDENT_INFORMATION(): "RequestInformation",
    vtkStreamingDemandDrivenPipeline.REQUEST_UPDATE_EXTENT(): "RequestUpdateExtent",
    vtkDemandDrivenPipeline.REQUEST_DATA(): "RequestData",
}


class Algorithm(VTKPythonAlgorithmBase):
    """Base of the filters.

    An execution that raises ValueError, TypeError, MemoryError or DeviceError ends as a failed one
    of VTK's own does: one ErrorEvent (or, without an observer, one message in the output window)
    with the exception's sentence, and 0 from `GetExecutive().Update()`. Beyond that the output is
    empty, also if upstream failed to make data, and counts as not generated, so that every later
    Update tries again. After an abort it is the same without an error.

    VTK runs the filter on each block of a composite input. RequestInformation is called for blocks
    only. Blocks that fail are empty, the first one reports its error for all, and every later
    Update tries again. Update still returns 1; scripts can observe ErrorEvent.
    """

    PROPERTIES = ()  # by `with_properties`
    _muffled = None
    _has_reported = False  # an error, since VTK began with the blocks of a composite input
    _has_discarded = False  # an output, since then
    _time = None  # that was requested when it last ran
    _warnings_of_blocks = frozenset()  # since then
    _blocks_since = None  # GetPipelineMTime when an input was found to be composite

    def __init__(self, **keywords):
        super().__init__(**keywords)
        for each in self.PROPERTIES:
            setattr(self, each.attribute, each.initial)
        self.AddObserver("EndEvent", _finish)

    def ProcessRequest(self, request, inInfo, outInfo):
        name = _ANSWERS.get(request.GetRequest())
        if name is None:
            return 1
        # points may be NaN or far away
        with listening(self._show, self._warn), np.errstate(all="ignore"):
            return self._answer(name, request, inInfo, outInfo)

    def _answer(self, name, request, inInfo, outInfo):
        answer = getattr(self, name)
        if name == "RequestInformation":
            times.announce(*self._information())
            if _has_composite(inInfo):
                self._blocks_since = self.GetExecutive().GetPipelineMTime()
                return 1
        if name == "RequestUpdateExtent":
            self._empty_what_is_out_of_date(outInfo)
            if _has_composite(inInfo):
                self._has_reported = self._has_discarded = False
                self._warnings_of_blocks = set()
        if name != "RequestData":
            return answer(request, inInfo, outInfo)
        self._unmuffle()
        try:
            return answer(request, inInfo, outInfo)
        except Aborted:
            self._discard(outInfo)
            return 1
        except (DeviceError, MemoryError, TypeError, ValueError) as error:
            return self._fail(outInfo, str(error) or "there is not enough memory")
        except BaseException:
            self._discard(outInfo)
            raise

    def GetOutput(self):
        """The output, not updated."""
        return self.GetOutputDataObject(0)

    def _information(self):
        """The vtkInformation of all inputs and of all outputs, as two lists."""
        executive = self.GetExecutive()
        inputs = [
            executive.GetInputInformation(port, number)
            for port in range(self.GetNumberOfInputPorts())
            for number in range(self.GetNumberOfInputConnections(port))
        ]
        ports = range(self.GetNumberOfOutputPorts())
        return inputs, [executive.GetOutputInformation(port) for port in ports]

    def _set(self, name, value):
        """Set an attribute; a change makes the filter run again."""
        if getattr(self, name) != value:
            setattr(self, name, value)
            self.Modified()

    def _update_input(self, port, number=0, time=None, ask=None):
        """An input, brought up to date at a time.

        `ask` says of which part: `ask_for_all` if it is not given, or a function like this.

        For RequestInformation and RequestUpdateExtent, where what is asked for depends on data.
        While VTK goes through blocks, everything is up to date, and a block stands in for the
        producer's output: the producer must not run.
        """
        if self.is_among_blocks():
            return self.GetInputDataObject(port, number)
        connection = self.GetInputConnection(port, number)
        producer, index = connection.GetProducer(), connection.GetIndex()
        requests = vtkInformationVector()
        requests.SetNumberOfInformationObjects(producer.GetNumberOfOutputPorts())
        wanted = vtkInformation()
        (ask or ask_for_all)(wanted)
        if time is not None:
            wanted.Set(vtkStreamingDemandDrivenPipeline.UPDATE_TIME_STEP(), time)
        requests.SetInformationObject(index, wanted)
        shown = vtkObject.GetGlobalWarningDisplay()
        if isinstance(producer, Algorithm):  # it will say the same when data are asked for
            vtkObject.SetGlobalWarningDisplay(0)
        done = producer.Update(index, requests)
        vtkObject.SetGlobalWarningDisplay(shown)
        if not done:
            raise ValueError(f"{producer.GetClassName()} on input port {port} has failed")
        return producer.GetOutputDataObject(index)

    def is_among_blocks(self):
        """Whether VTK runs this on blocks of a composite input just now."""
        if self._blocks_since != self.GetExecutive().GetPipelineMTime():
            return False
        return not any(
            isinstance(self.GetInputDataObject(port, number), vtkCompositeDataSet)
            for port in range(self.GetNumberOfInputPorts())
            for number in range(self.GetNumberOfInputConnections(port))
        )

    def _run(self, tasks):
        """Call functions of a Progress, which is reported to VTK."""
        check_abort = getattr(self, "CheckAbort", self.GetAbortExecute)  # VTK 9.3

        def report(fraction):
            if self.GetProgressText():
                self.SetProgressText(None)
            if fraction < 1:  # VTK itself says that the whole is done
                self.UpdateProgress(fraction)
            return check_abort()

        with whole(report) as progress:
            run_all(tasks, progress)

    def _show(self, sentence):
        """Show beside the progress bar what is done just now."""
        self.SetProgressText(sentence)
        # as far as before; VTK shifts and scales what it is told of one of several blocks
        told = (self.GetProgress() - self.GetProgressShift()) / self.GetProgressScale()
        self.UpdateProgress(told % 1)

    def _warn(self, sentence):
        if self.is_among_blocks():
            if sentence in self._warnings_of_blocks:
                return
            self._warnings_of_blocks.add(sentence)
        text = f"{type(self).__name__}: {sentence}"
        if self.HasObserver("WarningEvent"):
            self.InvokeEvent("WarningEvent", text)
        else:
            vtkOutputWindow.GetInstance().DisplayWarningText(f"Warning: {text}\n")

    def _empty_what_is_out_of_date(self, out_info):
        for info in _each(out_info):
            output = info.Get(vtkDataObject.DATA_OBJECT())
            has_changed = self.GetExecutive().GetPipelineMTime() > output.GetUpdateTime()
            if has_changed or times.is_outdated(info, self._time):
                output.Initialize()

    def _fail(self, out_info, sentence):
        """Report an error; the answer to VTK's executive."""
        self._discard(out_info)
        self._report(sentence)
        self._muffle()
        return 0

    def _discard(self, out_info):
        """Leave the output empty, to be made by the next Update."""
        self._has_discarded = True
        self._empty(out_info)
        for info in _each(out_info):
            info.Set(vtkDemandDrivenPipeline.DATA_NOT_GENERATED(), 1)

    def _empty(self, out_info):
        for info in _each(out_info):
            info.Get(vtkDataObject.DATA_OBJECT()).Initialize()
            ask_within_the_whole(info)

    def _report(self, sentence):
        if not vtkObject.GetGlobalWarningDisplay():
            return
        if self._has_reported and self.is_among_blocks():
            return
        self._has_reported = True
        text = f"{type(self).__name__}: {sentence}"
        if self.HasObserver("ErrorEvent"):
            self.InvokeEvent("ErrorEvent", text)
        else:
            vtkOutputWindow.GetInstance().DisplayErrorText(f"ERROR: {text}\n")

    def _muffle(self):
        """Keep the executive from adding that its algorithm failed and how the request looked."""
        if vtkObject.GetGlobalWarningDisplay():
            self._muffled = self.GetExecutive().AddObserver("ErrorEvent", _swallow)

    def _unmuffle(self):
        if self._muffled is not None:
            self.GetExecutive().RemoveObserver(self._muffled)
            self._muffled = None


def _finish(algorithm, event):
    """Set the times of the output, which VTK takes from the first input after it ran on blocks.

    An output with failed blocks is marked as not generated.
    """
    inputs, outputs = algorithm._information()
    times.announce(inputs, outputs)
    times.stamp(inputs, outputs)
    algorithm._time = times.requested(outputs[0])
    has_blocks = isinstance(outputs[0].Get(vtkDataObject.DATA_OBJECT()), vtkCompositeDataSet)
    if has_blocks and algorithm._has_discarded:
        for info in outputs:
            info.Set(vtkDemandDrivenPipeline.DATA_NOT_GENERATED(), 1)


@calldata_type(VTK_STRING)
def _swallow(executive, event, text):
    """Take an error of an executive for the one that its algorithm has reported."""
    executive.GetAlgorithm()._unmuffle()


def run_all(tasks, progress):
    """Call functions of a Progress, each with its part of the one given."""
    for task, part in zip(tasks, progress.divided(*[1] * len(tasks))):
        part.report(0)
        task(part)


def inputs(in_info, port):
    """The data objects on an input port."""
    information = in_info[port]
    count = information.GetNumberOfInformationObjects()
    return [vtkDataObject.GetData(information, number) for number in range(count)]


def _each(information):
    """The information objects of a vector of them."""
    count = information.GetNumberOfInformationObjects()
    return [information.GetInformationObject(number) for number in range(count)]


def _has_composite(in_info):
    return any(
        isinstance(data, vtkCompositeDataSet)
        for port in range(len(in_info))
        for data in inputs(in_info, port)
    )
