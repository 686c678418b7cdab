"""Formats of images: how each tells where the image lies.

World coordinates are those of the file, whichever anatomical convention it follows (NIfTI points
+x to the right and +y to the front, MetaImage and NRRD as a rule to the left and the back).
"""

from __future__ import annotations

import errno
import gzip
import os
import sys

import numpy as np
from vtkmodules.util.numpy_support import get_vtk_array_type
from vtkmodules.vtkCommonCore import VTK_DOUBLE, VTK_FLOAT
from vtkmodules.vtkCommonDataModel import vtkImageData
from vtkmodules.vtkCommonMath import vtkMatrix4x4
from vtkmodules.vtkCommonMisc import vtkErrorCode
from vtkmodules.vtkIOImage import vtkMetaImageReader, vtkNIFTIImageReader, vtkNIFTIImageWriter
from vtkmodules.vtkIOLegacy import vtkDataSetReader, vtkDataSetWriter
from vtkmodules.vtkIOXML import vtkXMLImageDataReader, vtkXMLImageDataWriter

from vtk_mls import arrays, nrrd
from vtk_mls.arrays import Lattice

_META_TYPES = {
    **{"int8": "MET_CHAR", "uint8": "MET_UCHAR", "int16": "MET_SHORT", "uint16": "MET_USHORT"},
    **{"int32": "MET_INT", "uint32": "MET_UINT", "int64": "MET_LONG_LONG"},
    **{"uint64": "MET_ULONG_LONG", "float32": "MET_FLOAT", "float64": "MET_DOUBLE"},
}


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
    Lattice(image.GetExtent(), tuple(origin), tuple(spacing.tolist()), direction).place(image)


def _read_xml(path):
    return read(vtkXMLImageDataReader(), path)


def _write_xml(image, path):
    writer = vtkXMLImageDataWriter()
    writer.SetHeaderTypeToUInt64()
    write(writer, image, path)


def _read_legacy(path):
    return read(vtkDataSetReader(), path)


def _write_legacy(image, path):
    if not np.array_equal(Lattice.of_image(image).grid.direction, np.eye(3)):
        raise ValueError(
            f"`{path}` cannot hold the image's direction matrix; write .vti, .mha or .nii instead"
        )
    copy = vtkImageData()
    copy.ShallowCopy(image)
    Lattice.of_grid(Lattice.of_image(image).grid).place(copy)
    writer = vtkDataSetWriter()
    writer.SetFileTypeToBinary()
    write(writer, copy, path)


# MetaImage: VTK reads and writes the direction matrix transposed, or not at all before 9.5.


def _read_meta(path):
    image = read(vtkMetaImageReader(), path)
    header = {}
    with path.open("rb") as file:
        for line in file:
            key, _, value = line.decode("latin-1").partition("=")
            header[key.strip()] = value.strip()
            if key.strip() == "ElementDataFile":
                break
    for key in ("Offset", "Position", "Origin", "ElementSpacing"):  # VTK takes bad ones for 0
        if not np.isfinite(np.array(header.get(key, "").split(), dtype=float)).all():
            raise ValueError(f"its {key} must be finite numbers")
    rows = header.get("TransformMatrix") or header.get("Rotation") or header.get("Orientation")
    if rows and image.GetNumberOfPoints() > 0:
        rows = np.array(rows.split(), dtype=float)
        count = int(header.get("NDims", 3))
        if not 1 <= count <= 3 or len(rows) != count**2:
            raise ValueError(f"its direction must have {count} x {count} numbers, got {len(rows)}")
        direction = np.eye(3)
        direction[:count, :count] = rows.reshape(count, count).T
        _place(image, image.GetOrigin(), direction * image.GetSpacing())
    return image


def _write_meta(image, path):
    grid = Lattice.of_image(image).grid
    values = arrays.to_numpy(_the_array(image, path))
    components = 1 if values.ndim == 1 else values.shape[1]
    local = path.suffix.lower() == ".mha"
    header = {
        "ObjectType": "Image",
        "NDims": "3",
        "BinaryData": "True",
        "BinaryDataByteOrderMSB": "False",
        "CompressedData": "False",
        "TransformMatrix": _text(grid.direction.T.ravel()),
        "Offset": _text(grid.origin),
        "CenterOfRotation": "0 0 0",
        "ElementSpacing": _text(grid.spacing),
        "DimSize": " ".join(str(n) for n in grid.dimensions),
        "ElementNumberOfChannels": str(components),
        "ElementType": _META_TYPES[values.dtype.name],
        "ElementDataFile": "LOCAL" if local else f"{path.stem}.raw",
    }
    text = "".join(f"{key} = {value}\n" for key, value in header.items())
    data = values.astype(values.dtype.newbyteorder("<"), copy=False)
    with path.open("wb") as file:
        file.write(text.encode())
        if local:
            file.write(data)
    if not local:
        path.with_suffix(".raw").write_bytes(data)


def _text(numbers):
    return " ".join(repr(float(number)) for number in numbers)


def _read_nrrd(path):
    values, origin, steps = nrrd.read(path)
    flat = values.reshape(-1, *values.shape[3:])
    image = vtkImageData()
    image.SetDimensions(values.shape[2::-1])
    array = arrays.from_numpy(flat, get_vtk_array_type(flat.dtype))
    array.SetName("NRRD")
    image.GetPointData().SetScalars(array)
    _place(image, origin.tolist(), steps)
    return image


def _read_nifti(path):
    reader = vtkNIFTIImageReader()
    image = read(reader, path)
    if reader.GetTimeDimension() > 1:
        raise ValueError(
            f"`{path}` is a series of {reader.GetTimeDimension()} volumes; give one volume"
        )
    matrix = reader.GetSFormMatrix() or reader.GetQFormMatrix()
    if matrix is not None:
        matrix = np.reshape([matrix.GetElement(i, j) for i in range(4) for j in range(4)], (4, 4))
        _place(image, matrix[:3, 3].tolist(), matrix[:3, :3] * image.GetSpacing())
    slope, intercept = reader.GetRescaleSlope(), reader.GetRescaleIntercept()
    is_scaled = slope not in (0, 1) or (slope and intercept)
    if is_scaled and not np.isfinite([slope, intercept]).all():
        raise ValueError(f"its scaling must be finite, got {slope} and {intercept}")
    if is_scaled:
        raw = image.GetPointData().GetScalars()
        small = raw.GetDataTypeSize() < 4 or raw.GetDataType() == VTK_FLOAT
        dtype, vtk_type = ("f4", VTK_FLOAT) if small else ("f8", VTK_DOUBLE)
        with np.errstate(over="ignore"):
            values = (arrays.to_numpy(raw) * slope + intercept).astype(dtype)
        scaled = arrays.from_numpy(values, vtk_type)
        scaled.SetName(raw.GetName())
        image.GetPointData().SetScalars(scaled)
    return image


def _write_nifti(image, path):
    grid = Lattice.of_image(image).grid
    copy = vtkImageData()
    # the matrix alone says where the image lies: the writer would add the image's origin
    Lattice(Lattice.of_grid(grid).extent, spacing=tuple(grid.spacing.tolist())).place(copy)
    copy.GetPointData().SetScalars(_the_array(image, path))
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = grid.direction, grid.origin
    vtk_matrix = vtkMatrix4x4()
    vtk_matrix.DeepCopy(matrix.ravel().tolist())
    writer = vtkNIFTIImageWriter()
    writer.SetSFormMatrix(vtk_matrix)
    is_rotation = np.allclose(grid.direction.T @ grid.direction, np.eye(3), atol=1e-6)
    if is_rotation and np.linalg.det(grid.direction) > 0:
        writer.SetQFormMatrix(vtk_matrix)
    write(writer, copy, path)
    _check_nifti(path, arrays.to_numpy(copy.GetPointData().GetScalars()).nbytes)


def _check_nifti(path, size):
    """Raise OSError if a file without an end was left by VTK's writer of `size` bytes of values."""
    is_packed = path.suffix.lower() == ".gz"
    with (gzip.open if is_packed else open)(path, "rb") as file:
        header = int.from_bytes(file.read(4), sys.byteorder)
    size += header + 4  # no extensions
    if not is_packed:
        check_size(path, size)
        return
    with path.open("rb") as file:
        file.seek(-4, os.SEEK_END)
        if int.from_bytes(file.read(), "little") != size % 2**32:
            raise _disk_full()


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


READERS = {
    ".vti": _read_xml,
    ".vtk": _read_legacy,
    ".mha": _read_meta,
    ".mhd": _read_meta,
    ".nrrd": _read_nrrd,
    ".nhdr": _read_nrrd,
    ".nii": _read_nifti,
    ".nii.gz": _read_nifti,
}
WRITERS = {
    ".vti": _write_xml,
    ".vtk": _write_legacy,
    ".mha": _write_meta,
    ".mhd": _write_meta,
    ".nii": _write_nifti,
    ".nii.gz": _write_nifti,
}
