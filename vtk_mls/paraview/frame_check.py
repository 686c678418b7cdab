"""Whether an image and control points in ParaView are in one world.

Control points of files are in LPS, and so is what MLS Image Reader reads. ParaView's own readers of
medical images do not convert: NIfTI stays in RAS, directions and the space of NRRD are left out.
"""

from __future__ import annotations

import os
from functools import lru_cache

import numpy as np

from vtk_mls import io
from vtk_mls.vtk.arrays import ImageGeometry

_READERS = ("vtkNIfTIReader", "vtkNrrdReader", "vtkPNrrdReader", "vtkMetaImageReader")


def mixed(algorithm, in_info):
    """What is wrong, in a sentence, where that is certain; "" if nothing is, or who knows.

    Certain it is if an image comes straight from a reader of ParaView's, in another place than the
    one that its file says, and control points straight from a file.

    Parameters
    ----------
    algorithm : vtkAlgorithm
        With the image on port 0, and the control points on port 1.
    in_info : what RequestData gets
    """
    reader, handles = _producer(algorithm, 0), _producer(algorithm, 1)
    if hasattr(reader, "GetCurrentFileName"):  # of a series of files
        reader = reader.GetReader()
    if getattr(reader, "GetClassName", str)() not in _READERS:
        return ""
    if getattr(handles, "GetMode", str)() != "file":
        return ""
    file, here = (
        reader.GetFileName(),
        ImageGeometry.of_information(in_info[0].GetInformationObject(0)),
    )
    if not _is_elsewhere(here, file):
        return ""
    return (
        f"`Input`: ParaView's own reader does not place {file} in LPS, where `ControlPoints` are; "
        "open it with MLS Image Reader"
    )


def producers(algorithm, ports=None):
    """The algorithms that a user connected to input ports of another, or to all of them."""
    found = []
    for port in range(algorithm.GetNumberOfInputPorts()) if ports is None else ports:
        for number in range(algorithm.GetNumberOfInputConnections(port)):
            producer = algorithm.GetInputAlgorithm(port, number)
            while producer is not None and producer.GetClassName() == "vtkPVPostFilter":
                producer = producer.GetInputAlgorithm(0, 0)
            found.append(producer)
    return found


def _producer(algorithm, port):
    """What a user connected to an input port, if it is one thing."""
    found = producers(algorithm, (port,))
    return found[0] if len(found) == 1 else None


def _is_elsewhere(here, file):
    """Whether an ImageGeometry is certainly not that of an image in a file."""
    try:
        there = _geometry(file, os.path.getmtime(file))
    except (OSError, ValueError):  # not ours to judge
        return False
    if here.grid.dimensions != there.grid.dimensions:
        return True
    apart = np.abs(here.grid.corners() - there.grid.corners()).max()
    return bool(apart > 1e-3 * np.min(there.grid.spacing))


@lru_cache(maxsize=8)
def _geometry(file, time):
    """The ImageGeometry of an image in a file that was last changed at this time."""
    return ImageGeometry.of_image(io.read_dataset(file))
