"""Data of some processes of a parallel program, gathered on all of them."""

import pickle

import numpy as np
from vtkmodules.vtkCommonCore import vtkCharArray
from vtkmodules.vtkCommonDataModel import vtkPolyData
from vtkmodules.vtkCommonExecutionModel import vtkStreamingDemandDrivenPipeline
from vtkmodules.vtkFiltersCore import vtkAppendPolyData
from vtkmodules.vtkParallelCore import vtkCommunicator, vtkMultiProcessController

from vtk_mls.filters import pipeline
from vtk_mls.vtk.objects import configured, output_of


def is_parallel():
    """Whether this process is one of several."""
    controller = vtkMultiProcessController.GetGlobalController()
    return controller is not None and controller.GetNumberOfProcesses() > 1


def all_gather(value):
    """A list of the values of all processes, by rank, pickled. Every process must call this."""
    controller = vtkMultiProcessController.GetGlobalController()
    own = pickle.dumps(value)
    lengths = _gather(controller, np.array([len(own)], np.int64).tobytes())
    ends = np.cumsum(np.frombuffer(lengths, np.int64)).tolist()
    everything = _gather(controller, own)
    return [pickle.loads(everything[start:end]) for start, end in zip([0, *ends], ends)]


def gather_results(make):
    """`all_gather` of the results of `make()`. If it fails on one process, it fails on all.

    ValueError has the message of any exception that `make` raised on a process.
    """
    try:
        share, problem = make(), None
    except Exception as error:  # the other processes must not wait
        share, problem = None, str(error) or type(error).__name__
    answers = all_gather((share, problem))
    for rank, (_, problem) in enumerate(answers):
        if problem is not None:
            raise ValueError(f"{problem} (on process {rank} of {len(answers)})")
    return [share for share, _ in answers]


def gather_polydata(make):
    """The vtkPolyData of all processes, merged. Every process must call this.

    `make()` returns a list of the same length on every process, and may fail as that of
    `gather_results`. Each result has the points and cells of all processes, in the order of ranks.
    Data that are equal on all processes with points count once.
    """
    shares = gather_results(lambda: [_pack(polydata) for polydata in make()])
    return [_merge(parts) for parts in zip(*shares)]


def request_share(info):
    """Request this process's piece of an input."""
    controller = vtkMultiProcessController.GetGlobalController()
    keys = vtkStreamingDemandDrivenPipeline
    pipeline.request_all(info)
    info.Set(keys.UPDATE_PIECE_NUMBER(), controller.GetLocalProcessId())
    info.Set(keys.UPDATE_NUMBER_OF_PIECES(), controller.GetNumberOfProcesses())


def _gather(controller, own):
    """The bytes of all processes, one after the other."""
    gathered = vtkCharArray()
    controller.AllGatherV(_char_array(own), gathered)
    return np.frombuffer(gathered, np.uint8).tobytes()


def _char_array(data):
    array = configured(vtkCharArray(), NumberOfValues=len(data))
    np.frombuffer(array, np.uint8)[:] = np.frombuffer(data, np.uint8)
    return array


def _pack(polydata):
    """Bytes, or None without points."""
    if polydata.GetNumberOfPoints() == 0:
        return None
    packed = vtkCharArray()
    vtkCommunicator.MarshalDataObject(polydata, packed)
    return np.frombuffer(packed, np.uint8).tobytes()


def _merge(parts):
    parts = [part for part in parts if part is not None]
    if len(set(parts)) < 2:  # all processes have the same, or one has some
        return _unpack(parts[0]) if parts else vtkPolyData()
    join = vtkAppendPolyData()
    for part in parts:
        join.AddInputData(_unpack(part))
    return output_of(join)


def _unpack(part):
    polydata = vtkPolyData()
    vtkCommunicator.UnMarshalDataObject(_char_array(part), polydata)
    return polydata
