"""A reader of medical images for ParaView."""

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
        self._file_names, self._series, self._cached_image = (), None, CachedValue()

    def AddFileName(self, name):
        """An image, as of `io.read_dataset`; also one with a time axis.

        Several images, as of a group of files in ParaView's file dialog, are time steps.
        """
        self._series, self._cached_image = None, CachedValue()
        self._set("_file_names", (*self._file_names, name or ""))

    def ClearFileNames(self):
        """Remove all images."""
        self._set("_file_names", ())

    def GetFileName(self):
        """ParaView names the data after it."""
        return self._file_names[0] if self._file_names else ""

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
                files = [io.open_dataset(name) for name in self._file_names or ("",)]
            except OSError as error:
                raise ValueError(f"`FileName`: {error}") from error
            self._series = files[0] if len(files) == 1 else _as_steps(files)
        return self._series

    def _image(self, info):
        times, read = self._opened()
        index = step_at(times, pipeline.requested_time(info))
        return self._cached_image.of(index, lambda: along_world_axes(read(index)))


def _as_steps(files):
    """Files of one time step each as one of several, at the times 0, 1, ..."""
    if any(len(times) > 1 for times, _ in files):
        raise ValueError(
            "`FileName`: files that are opened together are the steps of a series, and one of them "
            "has several steps itself; open it alone"
        )
    return tuple(range(len(files))), lambda index: files[index][1](0)


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
    result = ImageGeometry.of_grid(reordered).apply_to(vtkImageData())
    values = [reorder(array) for array in arrays.image_values(image.GetPointData(), grid)]
    arrays.set_values(result.GetPointData(), values, image.GetPointData())
    result.GetFieldData().ShallowCopy(image.GetFieldData())
    return result
