"""Keys of pipeline information: requested pieces, extents and times."""

from dataclasses import replace

import numpy as np
from vtkmodules.vtkCommonDataModel import vtkDataObject
from vtkmodules.vtkCommonExecutionModel import vtkExtentTranslator, vtkStreamingDemandDrivenPipeline

from vtk_mls.base import interpolation
from vtk_mls.base.time_steps import step_at
from vtk_mls.vtk.arrays import ImageGeometry

_KEYS = vtkStreamingDemandDrivenPipeline
_STEPS, _RANGE = _KEYS.TIME_STEPS(), _KEYS.TIME_RANGE()
_REQUESTED_TIME, _DATA_TIME = _KEYS.UPDATE_TIME_STEP(), vtkDataObject.DATA_TIME_STEP()
_WHOLE_EXTENT, _EXTENT = _KEYS.WHOLE_EXTENT(), _KEYS.UPDATE_EXTENT()
_HAS_EXTENT = _KEYS.UPDATE_EXTENT_INITIALIZED()
_PIECE, _PIECES = _KEYS.UPDATE_PIECE_NUMBER(), _KEYS.UPDATE_NUMBER_OF_PIECES()
_GHOSTS = _KEYS.UPDATE_NUMBER_OF_GHOST_LEVELS()

GRADIENT_REACH = 2  # of differences, as `interpolation.REACH`


def request_all(info):
    """Request the whole of an input, on every process."""
    if info.Has(_WHOLE_EXTENT):
        info.Set(_EXTENT, info.Get(_WHOLE_EXTENT), 6)
    info.Set(_PIECE, 0)
    info.Set(_PIECES, 1)
    info.Set(_GHOSTS, 0)


def reset_invalid_request(info):
    """Replace a request that exceeds the whole extent: VTK keeps old requests, and fails."""
    whole, requested = info.Get(_WHOLE_EXTENT), info.Get(_EXTENT)
    if whole and requested and not ImageGeometry(whole).holds(requested):
        info.Set(_EXTENT, whole, 6)


def request_extent(info, extent):
    """Request a part of an image, another one on each process."""
    request_all(info)
    info.Set(_EXTENT, extent, 6)
    info.Set(_HAS_EXTENT, 1)


def requested_extent(info):
    """The requested extent of an image, or of a piece: VTK converts these in RequestData only."""
    if info.Get(_HAS_EXTENT) or info.Get(_PIECES) < 2:
        return info.Get(_EXTENT)
    translator, extent = vtkExtentTranslator(), [0] * 6
    split = translator.UPDATE_SPLIT_MODE()
    translator.PieceToExtentThreadSafe(
        info.Get(_PIECE),
        info.Get(_PIECES),
        info.Get(_GHOSTS),
        info.Get(_WHOLE_EXTENT),
        extent,
        info.Get(split) if info.Has(split) else translator.GetSplitMode(),
        0,
    )
    return tuple(extent)


def first_cell(geometry):
    """The smallest extent that can be requested of any image."""
    first, last = np.array(geometry.extent[::2]), np.array(geometry.extent[1::2])
    return tuple(np.stack([first, np.minimum(first + 1, last)], axis=1).ravel().tolist())


def cell_sampling(sampling):
    """The `Sampling` of the cells of two grids, given that of their points."""
    return replace(sampling, source=sampling.source.cells, target=sampling.target.cells)


def needed_extent(deformation, geometry, sampling, margin=0):
    """The extent of an image that determines all values of a part of the deformed image.

    `geometry` is that of the whole input, from whose grid `sampling` goes to the part of the
    output. `margin` points are added on every side. There is at least one cell.
    """
    low, high = np.full(3, np.inf), np.full(3, -np.inf)
    reach = interpolation.REACH[sampling.interpolation] + margin
    for is_cells, part in enumerate((sampling, cell_sampling(sampling))):
        lowest, highest = deformation.source_bounds(part)
        # a cell needs its last corner as well
        low, high = np.minimum(low, lowest), np.maximum(high, highest + is_cells)
    last = np.array(sampling.source.dimensions) - 1
    if not np.isfinite(low).all():
        low = high = np.zeros(3)
    low = np.clip(np.floor(low) - reach, 0, np.maximum(last - 1, 0))
    high = np.clip(np.ceil(high) + reach, np.minimum(low + 1, last), last)
    first = np.array(geometry.extent[::2])
    return tuple(np.stack([first + low, first + high], axis=1).astype(int).ravel().tolist())


def publish_times(inputs, outputs):
    """Set the time steps of the outputs to those of all inputs; VTK takes the first input's only.

    Every input is asked for the time requested of the output, and chooses its own step (see
    `request_time`). `inputs` and `outputs` are the vtkInformation of all connections of all ports.
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


def announce_times(info, times):
    """Set the time steps of a source; none remove those before."""
    for key in (_STEPS, _RANGE):
        info.Remove(key)
    if times:
        info.Set(_STEPS, times, len(times))
        info.Set(_RANGE, (times[0], times[-1]), 2)


def stamp_step(info, time):
    """Set the time of a source's data: that of the step that holds at `time`."""
    steps = info.Get(_STEPS)
    if steps:
        step = steps[step_at(steps, time)]
        info.Get(vtkDataObject.DATA_OBJECT()).GetInformation().Set(_DATA_TIME, step)


def request_time(info, time, input_info):
    """Request a time of an input, or its step that the time misses by rounding.

    VTK's readers would take the step before.
    """
    if time is not None:
        steps = input_info.Get(_STEPS)
        index = step_at(steps, time)
        info.Set(_REQUESTED_TIME, max(time, steps[index]) if index else time)


def publish_changing_extent(info):
    """Have VTK request the whole extent anew at each time, if there are times.

    For outputs whose extent depends on data: VTK would go on to request that of the time before.
    """
    if info.Has(_RANGE):
        info.Set(_KEYS.TIME_DEPENDENT_INFORMATION(), 1)
        if not info.Get(_HAS_EXTENT):
            info.Set(_EXTENT, info.Get(_WHOLE_EXTENT), 6)


def requested_time(info):
    """The time that is requested of an output, or None."""
    return info.Get(_REQUESTED_TIME) if info is not None and info.Has(_REQUESTED_TIME) else None


def first_time(info):
    """The first time of an input if a later one is requested; else None."""
    time, times = requested_time(info), info.Get(_STEPS) or info.Get(_RANGE)
    return times[0] if times and time is not None and time > times[0] else None


def restore_time(info, time):
    """Request a time again, or none."""
    if time is None:
        info.Remove(_REQUESTED_TIME)
    else:
        info.Set(_REQUESTED_TIME, time)


def is_outdated(info, previous):
    """Whether VTK updates an output of the time `previous` for the time now requested."""
    return info.Has(_RANGE) and requested_time(info) not in (None, previous, _data_time(info))


def stamp_times(inputs, outputs):
    """Set the time of the outputs' data.

    It is that of the inputs' data where these agree. Otherwise it is the requested time: VTK would
    take the first input's, and find the output up to date when that time is requested later.
    """
    times = {_data_time(info) for info in inputs if info.Has(_RANGE) or info.Has(_STEPS)}
    for info in outputs:
        time = next(iter(times)) if len(times) == 1 else requested_time(info)
        if times and time is not None:
            info.Get(vtkDataObject.DATA_OBJECT()).GetInformation().Set(_DATA_TIME, time)


def _data_time(info):
    """The time of the data, or None."""
    data = info.Get(vtkDataObject.DATA_OBJECT()).GetInformation()
    return data.Get(_DATA_TIME) if data.Has(_DATA_TIME) else None
