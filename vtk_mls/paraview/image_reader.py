"""A reader of medical images for ParaView."""

from __future__ import annotations

from contextlib import suppress

from vtkmodules.vtkCommonDataModel import vtkImageData

from vtk_mls import io
from vtk_mls.filters.algorithm import Algorithm
from vtk_mls.paraview.image_axes import along_world
from vtk_mls.vtk.arrays import ImageGeometry


class MLSImageReader(Algorithm):
    """Reads medical images to where they lie in the world, LPS, as ParaView's own readers do not.

    ParaView's outlines leave out an image's directions, and NIfTI's are backwards in LPS as a rule:
    so voxels are stored along the axes of the world, as far as these are not oblique.
    """

    def __init__(self):
        super().__init__(nInputPorts=0, nOutputPorts=1, outputType="vtkImageData")
        self._file_name, self._read = "", None

    def SetFileName(self, name):
        """An image, as of `io.read_dataset`."""
        self._read = None
        self._set("_file_name", name or "")

    def GetFileName(self):
        """For ParaView, which names the data after it."""
        return self._file_name

    def RequestInformation(self, request, inInfo, outInfo):
        with suppress(ValueError):  # RequestData says it
            ImageGeometry.of_image(self._image()).set_information(outInfo.GetInformationObject(0))
        return 1

    def RequestData(self, request, inInfo, outInfo):
        vtkImageData.GetData(outInfo).ShallowCopy(self._image())
        return 1

    def _image(self):
        if self._read is None:
            try:
                self._read = along_world(io.read_dataset(self._file_name))
            except OSError as error:
                raise ValueError(f"`FileName`: {error}") from error
        return self._read
