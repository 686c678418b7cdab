"""Whether an image and control points in ParaView are in one frame.

Control points of files are in LPS, and so are the images of MLS Image Reader. ParaView's own
readers of medical images do not convert: NIfTI stays in RAS, and NRRD loses directions and space.
"""

import os
from functools import lru_cache

import numpy as np

from vtk_mls import io
from vtk_mls.vtk.arrays import ImageGeometry

_READERS = ("vtkNIfTIReader", "vtkNrrdReader", "vtkPNrrdReader", "vtkMetaImageReader")


def frame_mismatch(algorithm, in_info):
    """A warning if the frames certainly differ, else "".

    The frames differ if the image on port 0 comes directly from a reader of ParaView that places
    it elsewhere than its file says, and the control points on port 1 come directly from a file.
    `in_info` is the argument of RequestData.
    """
    reader, handles = _single_producer(algorithm, 0), _single_producer(algorithm, 1)
    if hasattr(reader, "GetCurrentFileName"):  # of a series of files
        reader = reader.GetReader()
    if getattr(reader, "GetClassName", str)() not in _READERS:
        return ""
    if getattr(handles, "GetMode", str)() != "file":
        return ""
    file = reader.GetFileName()
    geometry = ImageGeometry.of_information(in_info[0].GetInformationObject(0))
    if not _is_misplaced(geometry, file):
        return ""
    return (
        f"`Input`: ParaView's own reader does not place {file} in LPS, where `ControlPoints` are; "
        "open it with MLS Image Reader"
    )


def producers(algorithm, ports=None):
    """The algorithms that a user connected to input ports of another, by default to all ports."""
    found = []
    for port in range(algorithm.GetNumberOfInputPorts()) if ports is None else ports:
        for index in range(algorithm.GetNumberOfInputConnections(port)):
            producer = algorithm.GetInputAlgorithm(port, index)
            while producer is not None and producer.GetClassName() == "vtkPVPostFilter":
                producer = producer.GetInputAlgorithm(0, 0)
            found.append(producer)
    return found


def _single_producer(algorithm, port):
    found = producers(algorithm, (port,))
    return found[0] if len(found) == 1 else None


def _is_misplaced(geometry, file):
    """Whether an ImageGeometry certainly differs from that of the image in a file."""
    try:
        expected = _file_geometry(file, os.path.getmtime(file)).grid
    except (OSError, ValueError):  # a file that only ParaView can read
        return False
    grid = geometry.grid
    if grid.dimensions != expected.dimensions:
        return True
    distance = np.abs(grid.corners() - expected.corners()).max()
    return bool(distance > 1e-3 * np.min(expected.spacing))


@lru_cache(maxsize=8)
def _file_geometry(file, modified):
    """The ImageGeometry of an image file with this time of modification."""
    return ImageGeometry.of_image(io.read_dataset(file))
