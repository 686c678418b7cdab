"""TIFF stacks, by tifffile: those of ImageJ and Fiji, of OME (one file), and plain pages.

Coordinates are in the unit of the file, which the metadata of ImageJ or OME say; y grows down the
page. Without such metadata voxels are cubes of size 1, for the resolution of a plain TIFF file says
nothing about the distance of its pages.
"""

from __future__ import annotations

import functools
import logging
from contextlib import contextmanager
from xml.etree import ElementTree

import numpy as np

from vtk_mls.files import image_files
from vtk_mls.files.volumes import Volume

_NAMES = str.maketrans("IQRS", "ZZZC")  # other axes of pages and of components
# names of units in files: the unit, and nanometers in it
_UNITS = {
    **dict.fromkeys(("nm", "nanometer"), ("nm", 1.0)),
    **dict.fromkeys(("um", "\u00b5m", "\u03bcm", "micron", "microns", "micrometer"), ("um", 1e3)),
    **dict.fromkeys(("mm", "millimeter"), ("mm", 1e6)),
    **dict.fromkeys(("cm", "centimeter"), ("cm", 1e7)),
    **dict.fromkeys(("m", "meter"), ("m", 1e9)),
}
_ORDER = "TZYXC"
_ERRORS = AttributeError, LookupError, OverflowError, RuntimeError, TypeError, ValueError


def open_file(path):
    """Open a stack.

    Parameters
    ----------
    path : Path

    Returns
    -------
    times : tuple of float
        () without an axis of time.
    read : callable
        Returns the vtkImageData of a time by its index. All values are in memory then.

    Raises
    ------
    ValueError
    """
    try:
        with _opened(path) as file:
            series_count, series = len(file.series), file.series[0]
            axes, shape = series.axes, series.shape
            (*spacing, interval), unit = _metadata(file)
    except ElementTree.ParseError as error:  # a SyntaxError
        raise ValueError(f"its OME metadata are not XML: {error}") from None
    if series_count != 1:
        raise ValueError(f"it must be one stack, got {series_count} images of different sizes")
    count = _time_count(axes, shape)
    whole = functools.cache(lambda: _values(path))

    def read(index):
        return image_files.image_of(_volume(whole()[index], spacing, unit), "TIFF")

    return tuple(interval * n for n in range(count)) if count > 1 else (), read


@contextmanager
def _opened(path):
    """tifffile's file. Errors that it only logs are raised, because it leaves out pages then."""
    import tifffile

    problems = []
    handler = logging.Handler(logging.ERROR)
    handler.emit = lambda record: problems.append(record.getMessage())
    logger = logging.getLogger("tifffile")
    logger.addHandler(handler)
    propagates, logger.propagate = logger.propagate, False
    try:
        with tifffile.TiffFile(path) as file:
            yield file
    except (*_ERRORS, tifffile.TiffFileError) as error:
        text = str(error) or type(error).__name__
        raise ValueError(f"it is not a readable TIFF file: {text}") from None
    finally:
        logger.removeHandler(handler)
        logger.propagate = propagates
    if problems:
        raise ValueError(f"it is not a readable TIFF file: {problems[0]}")


def _time_count(axes, shape):
    """The number of times, of axes that make a volume."""
    sizes = dict(zip(axes, shape))
    names = _long_axes(axes, shape)
    has_page = "Y" in sizes and "X" in sizes and len(sizes) == len(axes)
    if not has_page or not {*names} <= {*_ORDER} or len({*names}) < len(names):
        raise ValueError(
            "its axes must be rows, columns and at most one of layers, of times and of channels, "
            f"got {axes} of {' x '.join(map(str, shape))}"
        )
    return sizes.get("T", 1)


def _long_axes(axes, shape):
    """Names in `_ORDER` of the axes of more than one point."""
    return "".join(axis for axis, n in zip(axes, shape) if n > 1).translate(_NAMES)


def _values(path):
    """Values (times, nz, ny, nx) or with components behind."""
    import tifffile

    with _opened(path) as file:
        series = file.series[0]
        values, axes = series.asarray(), _long_axes(series.axes, series.shape)
    values = tifffile.transpose_axes(np.squeeze(values), axes, _ORDER)
    if values.dtype == np.float16:
        values = values.astype(np.float32)
    if values.dtype == bool:
        values = values.astype(np.uint8)
    if values.dtype.kind not in "iuf":
        raise ValueError(f"values of type {values.dtype} are not supported")
    return values if "C" in axes else values[..., 0]


def _volume(values, spacing, unit):
    values = np.ascontiguousarray(values, values.dtype.newbyteorder("="))
    return Volume(values, np.zeros(3), np.diag(spacing), unit=unit)


def _metadata(file):
    """Spacing along x, y and z and the interval of times; the unit of lengths."""
    if file.is_ome and file.ome_metadata:
        return _of_ome(file.ome_metadata)
    if file.is_imagej and file.imagej_metadata:
        return _of_imagej(file)
    return (1.0, 1.0, 1.0, 1.0), ""


def _of_ome(text):
    root = ElementTree.fromstring(text)
    pixels = next((item for item in root.iter() if item.tag.endswith("}Pixels")), None)
    attributes = {} if pixels is None else pixels.attrib
    unit, nanometers = _UNITS.get(attributes.get("PhysicalSizeXUnit", "um"), ("", 1.0))
    spacing = []
    for axis in "XYZ":
        name = attributes.get(f"PhysicalSize{axis}Unit", "um")
        own_nanometers = _UNITS.get(name, (unit, nanometers))[1]
        size = _positive(attributes.get(f"PhysicalSize{axis}"))
        spacing.append(size * own_nanometers / nanometers)
    if "PhysicalSizeX" not in attributes:
        unit = ""
    return (*spacing, _positive(attributes.get("TimeIncrement"))), unit


def _of_imagej(file):
    metadata, tags = file.imagej_metadata, file.pages[0].tags
    name = str(metadata.get("unit", "")).strip().lower().replace("\\u00b5", "\u00b5")
    unit, _ = _UNITS.get(name, ("", 1.0))
    spacing = []
    for name in ("XResolution", "YResolution"):
        number, divisor = tags[name].value if name in tags else (1, 1)
        spacing.append(_positive(divisor / number if number else 1))
    z, interval = _positive(metadata.get("spacing")), _positive(metadata.get("finterval"))
    return (*spacing, z, interval), unit


def _positive(value):
    """A positive number; 1 for any other value."""
    try:
        number = float(value)
    except (TypeError, ValueError):
        return 1.0
    return number if np.isfinite(number) and number > 0 else 1.0
