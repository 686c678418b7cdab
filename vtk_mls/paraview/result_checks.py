"""Lines about results that look right at first: frames that differ, folds, and lost material.

Control points of files are in LPS, and so are the images of MLS Image Reader. ParaView's own
readers of medical images do not convert: NIfTI stays in RAS, and NRRD loses directions and space.
"""

import os
from functools import lru_cache

import numpy as np
from paraview.modules.vtkRemotingSettings import vtkPVGeneralSettings
from vtkmodules.vtkCommonCore import vtkOutputWindow
from vtkmodules.vtkCommonDataModel import vtkDataSet, vtkImageData

from vtk_mls import io
from vtk_mls.filters import parallel, pipeline
from vtk_mls.filters.deforming_filter import input_dataset
from vtk_mls.queries import arrival
from vtk_mls.vtk import arrays
from vtk_mls.vtk.arrays import ImageGeometry

_READERS = ("vtkNIfTIReader", "vtkNrrdReader", "vtkPNrrdReader", "vtkMetaImageReader")
_MIN_CONTRAST = 0.1  # of material to the background, as a fraction of the range of values
_MIN_SHARE = 0.02  # of the material
_SAMPLES = 24  # along each axis of an image; their third power of a mesh


class ChecksResults:
    """A deforming filter that warns if image and control points are in different frames.

    It says once that the map folds, or that an image loses material, but not in an animation.
    """

    _noted, _noted_time = frozenset(), None  # what it said last, and the time of the last update

    def RequestData(self, request, inInfo, outInfo):
        self._check_frames(inInfo)
        result = super().RequestData(request, inInfo, outInfo)
        output = vtkDataSet.GetData(outInfo)
        time = pipeline.requested_time(outInfo.GetInformationObject(0))
        is_playing = self._noted_time not in (None, time)
        self._noted_time = time
        is_part = parallel.is_parallel() or self.is_among_blocks()
        if not is_playing and not is_part and output.GetNumberOfPoints() > 0:
            notes = dict(self._notes(inInfo, output))
            for kind, sentence in notes.items():
                if kind not in self._noted:
                    _display(f"{type(self).__name__}: {sentence}\n")
            self._noted = notes.keys()
        return result

    def _check_frames(self, in_info):
        """Warn if the frames certainly differ.

        They differ if the image on port 0 comes directly from a reader of ParaView that places it
        elsewhere than its file says, and the control points on port 1 come directly from a file.
        """
        reader, handles = _single_producer(self, 0), _single_producer(self, 1)
        if hasattr(reader, "GetCurrentFileName"):  # of a series of files
            reader = reader.GetReader()
        is_read = getattr(reader, "GetClassName", str)() in _READERS
        if not is_read or getattr(handles, "GetMode", str)() != "file":
            return
        geometry = ImageGeometry.of_information(in_info[0].GetInformationObject(0))
        if _is_misplaced(geometry, reader.GetFileName()):
            self._warn(
                f"`Input`: ParaView's own reader does not place {reader.GetFileName()} in LPS, "
                "where `ControlPoints` are; open it with MLS Image Reader"
            )

    def _notes(self, in_info, output):
        transform, data = self._requested_deformation(in_info), input_dataset(in_info)
        if not isinstance(output, vtkImageData):
            points = arrays.to_numpy(output.GetPoints().GetData())
            places = points[:: -(-len(points) // _SAMPLES**3)]
        else:
            target = ImageGeometry.of_image(output).grid
            grid = arrival.coarse(target, _SAMPLES)
            places = grid.points()[arrival.has_material(transform, grid, None)]
        if isinstance(data, vtkImageData) and hasattr(self, "used_backgrounds"):
            name = getattr(data.GetPointData().GetScalars(), "GetName", str)()
            material = _Material(data, dict(self.used_backgrounds).get(name, self.GetBackground()))
            share = arrival.lost_share(transform, material.samples(), target)
            if share >= _MIN_SHARE:
                sentence = "of the material leaves the image; set Output Grid (advanced) to fitted"
                yield "loses", f"{share:.0%} {sentence}"
            places = places[material.contains(transform.backward(places))]
        if self.GetSteps() > 0 and (np.linalg.det(transform.jacobian(places)) <= 0).any():
            yield "folds", "the map folds; set Steps to 0, or drag less"


def _display(text):
    """Show a line; with Auto Apply without the window of warnings, which covers the view."""
    window = vtkOutputWindow.GetInstance()
    is_quiet = vtkPVGeneralSettings.GetInstance().GetAutoApply()
    (window.DisplayText if is_quiet else window.DisplayWarningText)(text)


class _Material:
    """The points of a vtkImageData whose scalars differ from the background."""

    def __init__(self, image, background):
        self._grid, array = ImageGeometry.of_image(image).grid, image.GetPointData().GetScalars()
        self._background, self._values, self._limit = 0, np.ones(self._grid.shape), 0
        if array is not None and array.GetNumberOfComponents() == 1:
            self._background = background
            self._values = arrays.to_numpy(array).reshape(self._grid.shape)
            self._limit = _MIN_CONTRAST * np.nanmax(self._contrast(self._lattice()), initial=0)

    def samples(self):
        """Positions (n, 3) of the material."""
        index = self._lattice()
        return self._grid.at(index[self._contrast(index) > self._limit])

    def contains(self, places):
        """Whether the material is at places (n, 3): (n,) bool."""
        index = self._grid.index_of(places)
        is_inside, nearest = self._grid.covers(index), np.zeros(index.shape, int)
        nearest[is_inside] = index[is_inside].round()
        nearest = nearest.clip(0, np.subtract(self._grid.dimensions, 1))
        return is_inside & (self._contrast(nearest) > self._limit)

    def _lattice(self):
        """Indices (n, 3) all over the image."""
        axes = [
            np.linspace(0, size - 1, min(size, _SAMPLES)).round().astype(int)
            for size in self._grid.dimensions
        ]
        return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)

    def _contrast(self, index):
        x, y, z = index.T
        return np.abs(self._values[z, y, x].astype(float) - self._background)


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
