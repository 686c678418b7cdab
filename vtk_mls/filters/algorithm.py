"""Base of the filters: errors, aborts, progress and composite inputs."""

from weakref import ref

import numpy as np
from vtkmodules.util.vtkAlgorithm import VTKPythonAlgorithmBase
from vtkmodules.vtkCommonCore import (
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
from vtk_mls.base.errors import InputError
from vtk_mls.base.messages import message_handlers
from vtk_mls.base.progress import whole
from vtk_mls.base.validation import short_repr
from vtk_mls.filters import pipeline

# Methods of VTKPythonAlgorithmBase by request.
_METHODS = {
    vtkDemandDrivenPipeline.REQUEST_DATA_OBJECT(): "RequestDataObject",
    vtkDemandDrivenPipeline.REQUEST_INFORMATION(): "RequestInformation",
    vtkStreamingDemandDrivenPipeline.REQUEST_TIME_DEPENDENT_INFORMATION(): "RequestInformation",
    vtkStreamingDemandDrivenPipeline.REQUEST_UPDATE_EXTENT(): "RequestUpdateExtent",
    vtkDemandDrivenPipeline.REQUEST_DATA(): "RequestData",
}


class CachedValue:
    """The last value of a function, valid while the state that it depends on stays equal."""

    def __init__(self):
        self._entry = None

    def of(self, state, make):
        """The value for `state`; `make()` is called for another state than the last."""
        if self._entry is None or self._entry[0] != state:
            self._entry = state, make()
        return self._entry[1]


class Algorithm(VTKPythonAlgorithmBase):
    """Base of the filters.

    An execution that raises ValueError, TypeError, MemoryError or DeviceError fails as VTK's own
    filters do: it invokes one ErrorEvent (or, without an observer, prints one message in the output
    window) with the text of the exception, and `GetExecutive().Update()` returns 0. In addition the
    output is empty, also if an upstream filter failed, and is marked as not generated, so that
    every later Update tries again. After an abort it is the same without an error.

    VTK runs the filter on each block of a composite input. RequestInformation is called for blocks
    only. Blocks that fail are empty, the first one reports its error for all, and every later
    Update tries again. Update still returns 1; scripts can observe ErrorEvent.
    """

    PROPERTIES = ()  # by `with_properties`
    last_error = None  # an InputError that was reported
    _silencer = None  # tag of the observer of the executive's errors
    _has_reported = False  # an error, since VTK began with the blocks of a composite input
    _has_discarded = False  # an output, since then
    _time = None  # requested when it last ran
    _warnings_of_blocks = frozenset()  # since then
    _blocks_since = None  # GetPipelineMTime when an input was found to be composite

    def __init__(self, **keywords):
        super().__init__(**keywords)
        for row in self.PROPERTIES:
            setattr(self, row.attribute, row.initial)
        self.AddObserver("EndEvent", _finish)

    def __str__(self):
        """As VTK prints an algorithm, with the values of all properties."""
        text = super().__str__().replace("vtkPythonAlgorithm", type(self).__name__, 1).rstrip()
        values = ((row.name, short_repr(getattr(self, row.attribute))) for row in self.PROPERTIES)
        return "\n".join([text, *(f"  {name}: {value}" for name, value in values), ""])

    def ProcessRequest(self, request, inInfo, outInfo):
        name = _METHODS.get(request.GetRequest())
        if name is None:
            return 1
        # points may be NaN or far away
        with message_handlers(self._show, self._warn), np.errstate(all="ignore"):
            return self._answer(name, request, inInfo, outInfo)

    def _answer(self, name, request, inInfo, outInfo):
        method = getattr(self, name)
        if name == "RequestInformation":
            pipeline.publish_times(*self._information())
            if self._has_composite():
                self._blocks_since = self.GetExecutive().GetPipelineMTime()
                return 1
        if name == "RequestUpdateExtent":
            for info in self._information()[0]:
                pipeline.request_time(info, pipeline.requested_time(info), info)
            self._empty_outdated_outputs(outInfo)
            if self._has_composite():
                self._has_reported = self._has_discarded = False
                self._warnings_of_blocks = set()
        if name != "RequestData":
            return method(request, inInfo, outInfo)
        self._restore_executive_errors()
        try:
            return method(request, inInfo, outInfo)
        except Aborted:
            self._discard(outInfo)
            return 1
        except (DeviceError, MemoryError, TypeError, ValueError) as error:
            return self._fail(outInfo, error)
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
            executive.GetInputInformation(port, index)
            for port in range(self.GetNumberOfInputPorts())
            for index in range(self.GetNumberOfInputConnections(port))
        ]
        ports = range(self.GetNumberOfOutputPorts())
        return inputs, [executive.GetOutputInformation(port) for port in ports]

    def _set(self, name, value):
        """Set an attribute; a change makes the filter run again, and so does one of its value."""
        if getattr(self, name) != value:
            setattr(self, name, value)
            self.Modified()
            if isinstance(value, vtkObject):
                _follow(ref(self), name, value)

    def _update_input(self, port, index=0, time=None, request=pipeline.request_all):
        """An input, updated at a time or as it is; `request` requests a part in a vtkInformation.

        For RequestInformation and RequestUpdateExtent, if requests depend on data. While VTK goes
        through blocks, all inputs are up to date and a block replaces the producer's output: the
        producer must not run.
        """
        if self.is_among_blocks():
            return self.GetInputDataObject(port, index)
        connection = self.GetInputConnection(port, index)
        producer, output_port = connection.GetProducer(), connection.GetIndex()
        requests = vtkInformationVector()
        requests.SetNumberOfInformationObjects(producer.GetNumberOfOutputPorts())
        info = vtkInformation()
        request(info)
        pipeline.request_time(info, time, self.GetExecutive().GetInputInformation(port, index))
        requests.SetInformationObject(output_port, info)
        displays_warnings = vtkObject.GetGlobalWarningDisplay()
        if isinstance(producer, Algorithm):  # it reports the same error when data are requested
            vtkObject.SetGlobalWarningDisplay(0)
        is_updated = producer.Update(output_port, requests)
        vtkObject.SetGlobalWarningDisplay(displays_warnings)
        if not is_updated:
            raise ValueError(f"{producer.GetClassName()} on input port {port} has failed")
        return producer.GetOutputDataObject(output_port)

    def is_among_blocks(self):
        """Whether VTK is running the filter on blocks of a composite input."""
        is_current = self._blocks_since == self.GetExecutive().GetPipelineMTime()
        return is_current and not self._has_composite()

    def _has_composite(self):
        return any(
            isinstance(vtkDataObject.GetData(info), vtkCompositeDataSet)
            for info in self._information()[0]
        )

    def _end_blocks(self):
        """Called when VTK has run the filter on all blocks."""

    def _run(self, tasks):
        """Call functions of a Progress, and report it to VTK."""
        check_abort = getattr(self, "CheckAbort", self.GetAbortExecute)  # VTK 9.3

        def report(fraction):
            if self.GetProgressText():
                self.SetProgressText(None)
            if fraction < 1:  # VTK itself reports the end
                self.UpdateProgress(fraction)
            return check_abort()

        with whole(report) as progress:
            run_all(tasks, progress)

    def _show(self, sentence):
        """Show a sentence beside the progress bar."""
        self.SetProgressText(sentence)
        # the same progress as before, which VTK shifts and scales for one of several blocks
        fraction = (self.GetProgress() - self.GetProgressShift()) / self.GetProgressScale()
        self.UpdateProgress(fraction % 1)

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

    def _empty_outdated_outputs(self, out_info):
        for info in _items(out_info):
            output = info.Get(vtkDataObject.DATA_OBJECT())
            has_changed = self.GetExecutive().GetPipelineMTime() > output.GetUpdateTime()
            if has_changed or pipeline.is_outdated(info, self._time):
                output.Initialize()

    def _fail(self, out_info, error):
        """Report an error; the return value for VTK's executive."""
        self._discard(out_info)
        self._report(error)
        if vtkObject.GetGlobalWarningDisplay():  # the executive's own error says nothing more
            self._silencer = self.GetExecutive().AddObserver("ErrorEvent", _ignore_error)
        return 0

    def _discard(self, out_info):
        """Empty the output, and have the next Update generate it."""
        self._has_discarded = True
        self._empty(out_info)
        for info in _items(out_info):
            info.Set(vtkDemandDrivenPipeline.DATA_NOT_GENERATED(), 1)

    def _empty(self, out_info):
        for info in _items(out_info):
            output = info.Get(vtkDataObject.DATA_OBJECT())
            # Initialize() alone would keep the origin and spacing of an image
            empty = output.NewInstance()
            empty.Initialize()  # sets the extent of a vtkExplicitStructuredGrid
            output.ShallowCopy(empty)
            pipeline.reset_invalid_request(info)

    def _report(self, error):
        if not vtkObject.GetGlobalWarningDisplay():
            return
        if self._has_reported and self.is_among_blocks():
            return
        self._has_reported = True
        # a copy, which holds no frame of the execution
        self.last_error = error.renamed({}) if isinstance(error, InputError) else None
        text = f"{type(self).__name__}: {str(error) or 'there is not enough memory'}"
        if self.HasObserver("ErrorEvent"):
            self.InvokeEvent("ErrorEvent", text)
        else:
            vtkOutputWindow.GetInstance().DisplayErrorText(f"ERROR: {text}\n")

    def _restore_executive_errors(self):
        if self._silencer is not None:
            self.GetExecutive().RemoveObserver(self._silencer)
            self._silencer = None


def _follow(algorithm, name, value):
    """Modify an algorithm, a weak reference, whenever the value of its attribute is modified."""

    def modified(caller, _):
        if algorithm() is not None and getattr(algorithm(), name) is caller:
            algorithm().Modified()

    value.AddObserver("ModifiedEvent", modified)


def _finish(algorithm, event):
    """Set the times of the output, which VTK takes from the first input after it ran on blocks.

    An output with failed blocks is marked as not generated.
    """
    inputs, outputs = algorithm._information()
    pipeline.publish_times(inputs, outputs)
    pipeline.stamp_times(inputs, outputs)
    algorithm._time = pipeline.requested_time(outputs[0])
    if isinstance(outputs[0].Get(vtkDataObject.DATA_OBJECT()), vtkCompositeDataSet):
        algorithm._end_blocks()
        for info in outputs if algorithm._has_discarded else ():
            info.Set(vtkDemandDrivenPipeline.DATA_NOT_GENERATED(), 1)


def _ignore_error(executive, event):
    """Ignore the executive's error after its algorithm has reported one."""
    executive.GetAlgorithm()._restore_executive_errors()


def run_all(tasks, progress):
    """Call functions of a Progress, each with its part of the one given."""
    for task, part in progress.parts(tasks):
        part.report(0)
        task(part)


def inputs(in_info, port):
    """The data objects on an input port."""
    return [vtkDataObject.GetData(info) for info in _items(in_info[port])]


def _items(information):
    """The information objects of a vtkInformationVector."""
    count = information.GetNumberOfInformationObjects()
    return [information.GetInformationObject(index) for index in range(count)]
