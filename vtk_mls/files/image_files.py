"""Image files as vtkImageData in LPS.

MetaImage is in LPS. NIfTI and NRRD are converted to LPS, and back to the frame of the file when
they are written. VTK's own formats do not say their frame and are not converted.
"""

import contextlib
import math
import re

import numpy as np
from vtkmodules.util.numpy_support import get_vtk_array_type
from vtkmodules.vtkCommonDataModel import vtkImageData
from vtkmodules.vtkIOLegacy import vtkDataSetWriter
from vtkmodules.vtkIOXML import vtkXMLImageDataReader, vtkXMLImageDataWriter

from vtk_mls.base.errors import InputError
from vtk_mls.files import frames, meta_image, metadata, nifti, nrrd, ome_zarr, volumes, vtk_io
from vtk_mls.files.volumes import NANOMETERS, Volume, symbol
from vtk_mls.vtk import arrays
from vtk_mls.vtk.arrays import ImageGeometry
from vtk_mls.vtk.objects import configured

_FORMATS = {  # by the name of the array: module, and where the dataset keeps the header
    "MetaImage": (meta_image, metadata.METAIMAGE_HEADER),
    "NRRD": (nrrd, metadata.NRRD_HEADER),
    "NIFTI": (nifti, metadata.NIFTI_HEADER),
}
_MAX_SHIFT = 1e-3  # voxels between images of one grid
# lines about the grid of a file: DICOM's and NIfTI's, which ITK keeps in other formats
_OF_GRID = re.compile(
    r"(0018\|(0050|0088)|0020\|(0032|0037|1041)|0028\|(0008|0010|0011|0030)"
    r"|ITK_original_\w+|q(fac|offset_.|to_...)|quatern_.|srow_.|(dim|pixdim)\[\d\]) ?:?="
)
_HEAD = 1 << 20  # bytes of a .vti file that include its extents
# bits per byte of a .vti file, by its compressor
_MAX_RATIO = {None: 8, "ZLib": 8 * 1032, "LZ4": 8 * 255, "LZMA": 8 * 10_000}


def _set_geometry(image, origin, steps):
    """Put an image's first point at `origin`, its axes along the columns `steps` (3, 3)."""
    steps = volumes.full_steps(steps, image.GetDimensions())
    spacing = np.linalg.norm(steps, axis=0)
    if not (np.isfinite(spacing) & (spacing > 0)).all():
        raise ValueError(f"its steps between voxels must be positive, got {spacing.tolist()}")
    direction = tuple((steps / spacing).ravel().tolist())
    geometry = ImageGeometry(image.GetExtent(), tuple(origin), tuple(spacing.tolist()), direction)
    geometry.apply_to(image)


def read_xml(path):
    """A .vti file."""
    _check_extents(path)
    return vtk_io.read(vtkXMLImageDataReader(), path)


def _check_extents(path):
    """Raise ValueError if a .vti file is too small for its extents, with which VTK would crash."""
    with path.open("rb") as file:
        head = file.read(_HEAD).decode("latin-1")
    if not re.search(r"<(Point|Cell)Data[^>]*>\s*<DataArray", head):
        return
    compressor = re.search(r'compressor="vtk(\w+)DataCompressor"', head)
    max_ratio = _MAX_RATIO.get(compressor and compressor[1], max(_MAX_RATIO.values()))
    max_count = max_ratio * path.stat().st_size
    for extent in re.findall(r'Extent="([-+\d\s]*)"', head):
        ends = [int(text) for text in extent.split()]
        count = math.prod(max(b - a, 1) for a, b in zip(ends[::2], ends[1::2]))  # of cells
        if count > max_count:
            raise ValueError(
                f"it is too short for its extent, got {path.stat().st_size} bytes for {extent:.80}"
            )


def write_xml(image, path):
    """Write a .vti file."""
    writer = vtkXMLImageDataWriter()
    writer.SetHeaderTypeToUInt64()
    vtk_io.write(writer, image, path)


def write_legacy(image, path):
    """Write a .vtk file, which has no direction matrix."""
    if not np.array_equal(ImageGeometry.of_image(image).grid.direction, np.eye(3)):
        raise InputError("cannot hold the image's direction matrix; write .vti, .mha or .nii")
    copy = vtkImageData()
    copy.ShallowCopy(image)
    ImageGeometry.of_grid(ImageGeometry.of_image(image).grid).apply_to(copy)
    copy.SetSpacing(image.GetSpacing())  # 0, too
    writer = vtkDataSetWriter()
    writer.SetFileTypeToBinary()
    vtk_io.write(writer, copy, path)
    _write_all_digits(copy, path)


def _write_all_digits(image, path):
    """Replace the spacing and origin of a .vtk file, for which VTK writes six digits."""
    content = path.read_bytes()
    with path.open("wb") as file:
        start = content.index(b"\nSPACING ") + 1
        file.write(content[:start])
        for name, lengths in (("SPACING", image.GetSpacing()), ("ORIGIN", image.GetOrigin())):
            file.write(f"{name} {' '.join(map(repr, lengths))}\n".encode())
            start = content.index(b"\n", start) + 1
        file.write(memoryview(content)[start:])


def open_volumes(name, path):
    """The times of a file, () without a time axis, and a function that reads one by its index.

    The array of an image is named after the format.
    """
    module, header = _FORMATS[name]
    series = module.open_file(path)
    return series.times, lambda index: image_of(series.read(index), name, header)


def image_of(volume, name, header=""):
    """The vtkImageData of a `Volume`; `name` is that of its array, `header` of the metadata that
    keep the header.
    """
    flat = volume.values.reshape(-1, *volume.values.shape[3:])
    image = configured(vtkImageData(), Dimensions=volume.values.shape[2::-1])
    array = configured(arrays.from_numpy(flat, get_vtk_array_type(flat.dtype)), Name=name)
    image.GetPointData().SetScalars(array)
    if volume.is_vector:
        image.GetPointData().SetVectors(array)
    _set_geometry(image, volume.origin.tolist(), volume.steps)
    metadata.store(image, metadata.FILE_SPACE, [volume.space] * bool(volume.space))
    metadata.store(image, metadata.LABEL_ARRAYS, [name] * volume.is_label)
    metadata.store(image, metadata.LENGTH_UNIT, [volume.unit] * bool(volume.unit))
    metadata.store(image, metadata.TIME_UNIT, [volume.time_unit] * bool(volume.time_unit))
    if header:
        metadata.store(image, header, volume.header)
        numbers = _grid_numbers(ImageGeometry.of_image(image).grid)
        metadata.store(image, metadata.FILE_GRID, [" ".join(map(str, numbers.tolist()))])
    return image


def _grid_numbers(grid):
    return np.concatenate([grid.dimensions, grid.origin, grid.index_to_world.ravel()])


def _true_lines(lines, image, grid):
    """The lines of a header that are true of an image on `grid`, which may not be the file's."""
    file_grid = np.array(" ".join(metadata.load(image, metadata.FILE_GRID)).split(), float)
    if not len(file_grid) or np.allclose(file_grid, _grid_numbers(grid), rtol=1e-9, atol=1e-9):
        return lines
    to_ras = np.column_stack([grid.index_to_world, grid.origin]) * frames.signs("RAS")[:, None]
    extent = np.column_stack([np.zeros(3), np.array(grid.dimensions) - 1])
    numbers = [*to_ras.ravel(), 0, 0, 0, 1, *extent.ravel()]
    geometry = "".join(f"{number + 0.0:.15g};" for number in numbers)
    for pattern, text in (  # of the segmentations of 3D Slicer
        (r"(Reference image geometry\|)[^|]*", geometry),
        (r"^(Segmentation_ReferenceImageExtentOffset:=).*", "0 0 0"),
    ):
        lines = tuple(re.sub(pattern, rf"\g<1>{text}", line) for line in lines)
    return tuple(line for line in lines if not _OF_GRID.match(line))


def write_volume(name, image, path):
    """Write the active scalars of an image, or its only array."""
    with writing_volumes(name, path, ()) as add:
        add(image)


@contextlib.contextmanager
def writing_volumes(name, path, times):
    """A context with a function that adds an image to a file in time of the format `name`, written
    at the end. `times` are one for each image, with equal steps, or () for one image without a
    time. Images of different grids or types are a ValueError.
    """
    module, header = _FORMATS[name]
    volumes.steps_of(times or (0.0,))
    series = []

    def add(image):
        volume = _volume_of(image, header)
        first = series[0] if series else volume
        if not _is_alike(volume, first):
            raise InputError(
                f"must get images of one grid and one type of values, got {_summary(volume)} after "
                f"{_summary(first)}; write .pvd, which takes any"
            )
        series.append(volume)

    yield add
    module.write(path, series, times)


def _is_alike(volume, other):
    """Whether two volumes have one type of values, and one grid to a thousandth of a voxel."""
    if volume.values.shape != other.values.shape or volume.values.dtype != other.values.dtype:
        return False
    last = np.array(volume.values.shape[2::-1])
    shift = np.abs(volume.origin - other.origin) + np.abs(volume.steps - other.steps) @ last
    return shift.max() <= _MAX_SHIFT * np.linalg.norm(volume.steps, axis=0).min()


def _summary(volume):
    size = " x ".join(str(n) for n in volume.values.shape[2::-1])
    origin = ", ".join(f"{x:g}" for x in volume.origin)
    return f"{size} of {volume.values.dtype} at {origin}"


def _volume_of(image, header):
    """The `Volume` of the active scalars of an image, or of its only array."""
    grid, data = ImageGeometry.of_image(image).grid, image.GetPointData()
    array = data.GetScalars() or (data.GetArray(0) if data.GetNumberOfArrays() == 1 else None)
    if array is None:
        names = ", ".join(f"`{data.GetArrayName(i)}`" for i in range(data.GetNumberOfArrays()))
        raise InputError(
            f"can hold one array, and none of {names or 'no arrays'} is the image's active "
            "scalars; write .vti instead"
        )
    values = arrays.to_numpy(array)
    is_label = array.GetName() in metadata.load(image, metadata.LABEL_ARRAYS)
    return Volume(
        values.reshape(grid.shape + values.shape[1:]),
        grid.origin,
        grid.index_to_world,
        is_label=is_label and values.dtype.kind in "iu",
        is_vector=data.GetVectors() is array and values.dtype.kind == "f",
        space="".join(metadata.load(image, metadata.FILE_SPACE)[:1]),
        header=_true_lines(metadata.load(image, header), image, grid),
        unit="".join(metadata.load(image, metadata.LENGTH_UNIT)),
        time_unit="".join(metadata.load(image, metadata.TIME_UNIT)),
    )


def read_ome_zarr(path, max_points=math.inf):
    """An OME-Zarr of one time: the finest level, or the finest with at most so many points.

    Each channel is an array; without such a level it is the coarsest.
    """
    source = ome_zarr.open_input(path)
    fitting = [level for level in source.levels if level.grid.size <= max_points]
    level = fitting[0] if fitting else source.levels[-1]
    image = configured(vtkImageData(), Dimensions=level.grid.dimensions)
    _set_geometry(image, level.grid.origin.tolist(), level.grid.index_to_world)
    names = source.channel_names
    for name, values in source.channels(level):
        array = arrays.from_numpy(values.ravel(), get_vtk_array_type(values.dtype))
        image.GetPointData().AddArray(configured(array, Name=name))
    image.GetPointData().SetActiveScalars(names[0])
    metadata.store(image, metadata.LABEL_ARRAYS, names * source.is_label)
    unit = symbol(source.space[-1].get("unit") or "")
    metadata.store(image, metadata.LENGTH_UNIT, [unit] * (unit in NANOMETERS))
    return image
