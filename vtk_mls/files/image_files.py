"""Images from files of every format, and to them.

World coordinates are LPS: MetaImage is that, NIfTI and NRRD are taken to it, and back to the frame
of the file when they are written. Formats of VTK's own say nothing of a frame, and are taken as
they are.
"""

from __future__ import annotations

import errno
import math
import os
import re

import numpy as np
from vtkmodules.util.numpy_support import get_vtk_array_type
from vtkmodules.vtkCommonDataModel import vtkImageData
from vtkmodules.vtkCommonMisc import vtkErrorCode
from vtkmodules.vtkIOLegacy import vtkDataSetReader, vtkDataSetWriter
from vtkmodules.vtkIOXML import vtkXMLImageDataReader, vtkXMLImageDataWriter

from vtk_mls import arrays
from vtk_mls.arrays import ImageGeometry
from vtk_mls.files import meta_image, nifti, nrrd, provenance
from vtk_mls.files.volumes import Volume

_HEAD = 1 << 20  # bytes of a .vti file in which its extents are
# values (of a bit each) that one byte of a .vti file can become, by its compressor
_MOST = {None: 8, "ZLib": 8 * 1032, "LZ4": 8 * 255, "LZMA": 8 * 10_000}


def read(reader, path):
    """What a reader of VTK's makes of a file."""
    reader.SetFileName(str(path))
    reader.Update()
    return reader.GetOutputDataObject(0)


def write(writer, dataset, path):
    """Write a file with a writer of VTK's."""
    writer.SetInputData(dataset)
    writer.SetFileName(str(path))
    writer.Write()
    code = writer.GetErrorCode()
    if code == vtkErrorCode.OutOfDiskSpaceError:
        raise _disk_full()
    if code:
        raise OSError(vtkErrorCode.GetStringFromErrorCode(code))


def check_size(path, size):
    """Raise OSError if a file has not the bytes that it must have.

    For writers of VTK's that do not notice it when the disk is full.
    """
    if path.stat().st_size != size:
        raise _disk_full()


def _disk_full():
    return OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


def _place(image, origin, steps):
    """Put an image's first point at `origin`, its axes along the columns `steps` (3, 3)."""
    spacing = np.linalg.norm(steps, axis=0)
    if not (np.isfinite(spacing) & (spacing > 0)).all():
        raise ValueError(f"its steps between voxels must be positive, got {spacing.tolist()}")
    direction = tuple((steps / spacing).ravel().tolist())
    ImageGeometry(image.GetExtent(), tuple(origin), tuple(spacing.tolist()), direction).place(image)


def _read_xml(path):
    _check_extents(path)
    return read(vtkXMLImageDataReader(), path)


def _check_extents(path):
    """Raise ValueError if a .vti file promises arrays that it cannot hold; VTK would end here."""
    with path.open("rb") as file:
        head = file.read(_HEAD).decode("latin-1")
    if not re.search(r"<(Point|Cell)Data[^>]*>\s*<DataArray", head):
        return
    compressor = re.search(r'compressor="vtk(\w+)DataCompressor"', head)
    most = _MOST.get(compressor and compressor[1], max(_MOST.values())) * path.stat().st_size
    for extent in re.findall(r'Extent="([-+\d\s]*)"', head):
        ends = [int(text) for text in extent.split()]
        count = math.prod(max(b - a, 1) for a, b in zip(ends[::2], ends[1::2]))  # of cells
        if count > most:
            raise ValueError(
                f"its extent must hold no more than its bytes can, got {extent:.80} for "
                f"{path.stat().st_size} bytes"
            )


def _write_xml(image, path):
    writer = vtkXMLImageDataWriter()
    writer.SetHeaderTypeToUInt64()
    write(writer, image, path)


def _read_legacy(path):
    return read(vtkDataSetReader(), path)


def _write_legacy(image, path):
    if not np.array_equal(ImageGeometry.of_image(image).grid.direction, np.eye(3)):
        raise ValueError(
            f"`{path}` cannot hold the image's direction matrix; write .vti, .mha or .nii instead"
        )
    copy = vtkImageData()
    copy.ShallowCopy(image)
    ImageGeometry.of_grid(ImageGeometry.of_image(image).grid).place(copy)
    writer = vtkDataSetWriter()
    writer.SetFileTypeToBinary()
    write(writer, copy, path)


def _read_with(read_volume, name):
    """A reader of images, by one of volumes that has no names for arrays."""

    def read_image(path):
        volume = read_volume(path)
        flat = volume.values.reshape(-1, *volume.values.shape[3:])
        image = vtkImageData()
        image.SetDimensions(volume.values.shape[2::-1])
        array = arrays.from_numpy(flat, get_vtk_array_type(flat.dtype))
        array.SetName(name)
        image.GetPointData().SetScalars(array)
        if volume.is_vector:
            image.GetPointData().SetVectors(array)
        _place(image, volume.origin.tolist(), volume.steps)
        provenance.keep(image, provenance.FILE_SPACE, [volume.space] * bool(volume.space))
        provenance.keep(image, provenance.LABEL_ARRAYS, [name] * volume.is_label)
        if name in _HEADERS:
            provenance.keep(image, _HEADERS[name], volume.header)
        return image

    return read_image


def _write_with(write_volume, name):
    """A writer of images, by one of volumes."""

    def write_image(image, path):
        grid = ImageGeometry.of_image(image).grid
        array = _the_array(image, path)
        values = arrays.to_numpy(array)
        space = provenance.kept(image, provenance.FILE_SPACE)
        is_label = array.GetName() in provenance.kept(image, provenance.LABEL_ARRAYS)
        write_volume(
            path,
            Volume(
                values.reshape(grid.shape + values.shape[1:]),
                grid.origin,
                grid.index_to_world,
                is_label=is_label and values.dtype.kind in "iu",
                is_vector=image.GetPointData().GetVectors() is array and values.dtype.kind == "f",
                space=space[0] if space else "",
                header=provenance.kept(image, _HEADERS[name]) if name in _HEADERS else (),
            ),
        )

    return write_image


def _the_array(image, path):
    """The one point array that a format with one array gets."""
    data = image.GetPointData()
    array = data.GetScalars() or (data.GetArray(0) if data.GetNumberOfArrays() == 1 else None)
    if array is None:
        names = ", ".join(f"`{data.GetArrayName(i)}`" for i in range(data.GetNumberOfArrays()))
        raise ValueError(
            f"`{path}` can hold one array, and none of {names or 'no arrays'} is the image's "
            "active scalars; write .vti instead"
        )
    return array


_HEADERS = {"NRRD": provenance.NRRD_HEADER, "NIFTI": provenance.NIFTI_HEADER}
_FORMATS = {  # names of the arrays, and suffixes
    "MetaImage": (meta_image, (".mha", ".mhd")),
    "NRRD": (nrrd, (".nrrd", ".nhdr")),
    "NIFTI": (nifti, (".nii", ".nii.gz")),
}
READERS = {".vti": _read_xml, ".vtk": _read_legacy} | {
    suffix: _read_with(module.read, name)
    for name, (module, suffixes) in _FORMATS.items()
    for suffix in suffixes
}
READERS[".hdr"] = READERS[".nii"]
WRITERS = {".vti": _write_xml, ".vtk": _write_legacy} | {
    suffix: _write_with(module.write, name)
    for name, (module, suffixes) in _FORMATS.items()
    for suffix in suffixes
}
