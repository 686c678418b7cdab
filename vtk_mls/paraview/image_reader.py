"""A reader of medical images for ParaView."""

from __future__ import annotations

from contextlib import suppress

from vtkmodules.vtkCommonDataModel import vtkImageData

from vtk_mls import io
from vtk_mls.base.time_steps import step_at
from vtk_mls.filters import pipeline
from vtk_mls.filters.algorithm import Algorithm, CachedValue
from vtk_mls.vtk import arrays
from vtk_mls.vtk.arrays import ImageGeometry


class MLSImageReader(Algorithm):
    """Reads medical images in LPS, unlike ParaView's own readers.

    ParaView's outlines ignore the directions of an image, and those of NIfTI usually point
    backwards in LPS: so voxels are reordered along the axes of the world as far as possible.
    """

    def __init__(self):
        super().__init__(nInputPorts=0, nOutputPorts=1, outputType="vtkImageData")
        self._file_name, self._series, self._cached_image = "", None, CachedValue()

    def SetFileName(self, name):
        """An image, as of `io.read_dataset`; also one with a time axis."""
        self._series, self._cached_image = None, CachedValue()
        self._set("_file_name", name or "")

    def GetFileName(self):
        """ParaView names the data after it."""
        return self._file_name

    def RequestInformation(self, request, inInfo, outInfo):
        info = outInfo.GetInformationObject(0)
        with suppress(ValueError):  # RequestData reports it
            times, _ = self._opened()
            pipeline.announce_times(info, times)
            ImageGeometry.of_image(self._image(info)).set_information(info)
        return 1

    def RequestData(self, request, inInfo, outInfo):
        info = outInfo.GetInformationObject(0)
        vtkImageData.GetData(outInfo).ShallowCopy(self._image(info))
        pipeline.stamp_step(info, pipeline.requested_time(info))
        return 1

    def _opened(self):
        """Times, and a function that reads one by its index."""
        if self._series is None:
            try:
                self._series = io.open_dataset(self._file_name)
            except OSError as error:
                raise ValueError(f"`FileName`: {error}") from error
        return self._series

    def _image(self, info):
        times, read = self._opened()
        index = step_at(times, pipeline.requested_time(info))
        return self._cached_image.of(index, lambda: along_world_axes(read(index)))


def along_world_axes(image):
    """An image with its axes in the order and the direction of x, y and z.

    Voxels stay in place; they are stored in another order. The direction matrix is then the
    identity, or for oblique axes the smallest possible rotation. An image with its axes in order is
    returned itself. Cell data are dropped.
    """
    grid = ImageGeometry.of_image(image).grid
    reordered, reorder = arrays.along_world_axes(grid)
    if reordered is grid:
        return image
    result = vtkImageData()
    ImageGeometry.of_grid(reordered).apply_to(result)
    values = [reorder(array) for array in arrays.image_values(image.GetPointData(), grid)]
    arrays.set_image_values(result.GetPointData(), values, image.GetPointData())
    result.GetFieldData().ShallowCopy(image.GetFieldData())
    return result
