"""Time in the pipeline: the steps that inputs have, and the time that is requested."""

from __future__ import annotations

from vtkmodules.vtkCommonDataModel import vtkDataObject
from vtkmodules.vtkCommonExecutionModel import vtkStreamingDemandDrivenPipeline

_STEPS = vtkStreamingDemandDrivenPipeline.TIME_STEPS()
_RANGE = vtkStreamingDemandDrivenPipeline.TIME_RANGE()
_REQUESTED = vtkStreamingDemandDrivenPipeline.UPDATE_TIME_STEP()
_DEPENDENT = vtkStreamingDemandDrivenPipeline.TIME_DEPENDENT_INFORMATION()
_WHOLE_EXTENT = vtkStreamingDemandDrivenPipeline.WHOLE_EXTENT()
_EXTENT = vtkStreamingDemandDrivenPipeline.UPDATE_EXTENT()
_EXTENT_REQUESTED = vtkStreamingDemandDrivenPipeline.UPDATE_EXTENT_INITIALIZED()
_OF_DATA = vtkDataObject.DATA_TIME_STEP()


def announce(inputs, outputs):
    """Announce the times of all inputs; VTK itself passes on those of the first input only.

    Every input is asked for the time that is requested of the output, and chooses its own step.

    Parameters
    ----------
    inputs, outputs : list of vtkInformation
        Of all connections of all ports.
    """
    steps, ends = set(), []
    for info in inputs:
        own = info.Get(_STEPS) or ()
        steps.update(own)
        ends += [*own, *(info.Get(_RANGE) or ())]
    if not ends:
        return
    for info in outputs:
        if steps:
            info.Set(_STEPS, sorted(steps), len(steps))
        info.Set(_RANGE, (min(ends), max(ends)), 2)


def announce_changing_extent(info):
    """Have VTK ask for the whole extent anew at each time, if there are times.

    For an output whose extent depends on data. VTK requests all of it by default, but would go on
    to request what was all of it at the time before.
    """
    if info.Has(_RANGE):
        info.Set(_DEPENDENT, 1)
        if not info.Get(_EXTENT_REQUESTED):
            info.Set(_EXTENT, info.Get(_WHOLE_EXTENT), 6)


def requested(info):
    """The time that is requested of an output; None without."""
    return info.Get(_REQUESTED) if info is not None and info.Has(_REQUESTED) else None


def is_outdated(info, previous):
    """Whether VTK makes an output anew, after the time `previous`, for the time now requested."""
    time = requested(info)
    return info.Has(_RANGE) and time not in (None, previous, _time_of(info))


def stamp(inputs, outputs):
    """Set the time of the outputs' data.

    It is that of the inputs' data where these agree. Otherwise it is the requested time: VTK would
    take the first input's, and find the output up to date when that time is requested later.
    """
    found = {_time_of(info) for info in inputs if info.Has(_RANGE) or info.Has(_STEPS)}
    for info in outputs:
        time = next(iter(found)) if len(found) == 1 else requested(info)
        if found and time is not None:
            info.Get(vtkDataObject.DATA_OBJECT()).GetInformation().Set(_OF_DATA, time)


def _time_of(info):
    """The time of the data; None if it is unknown."""
    own = info.Get(vtkDataObject.DATA_OBJECT()).GetInformation()
    return own.Get(_OF_DATA) if own.Has(_OF_DATA) else None
