"""TIFF stacks, by tifffile: those of ImageJ and Fiji, of OME (one file), and plain pages.

Coordinates are in the unit of the file along x, which the metadata of ImageJ or OME say; y grows
down the page. A size that OME metadata leave out is that of another axis, with a warning. Without
metadata voxels are cubes of size 1, for the resolution of a plain TIFF file says nothing about the
distance of its pages.
"""

import contextlib
import functools
import logging
from xml.etree import ElementTree

import numpy as np
import tifffile

from vtk_mls.base.messages import warn
from vtk_mls.files import image_files
from vtk_mls.files.volumes import NANOMETERS, Volume, in_seconds, symbol

_NAMES = str.maketrans("IQRS", "ZZZC")  # other axes of pages and of components
_ORDER = "TZYXC"
_ERRORS = AttributeError, LookupError, OverflowError, RuntimeError, TypeError, ValueError


def open_file(path):
    """The times of a stack, () without an axis of time, and a function that returns the
    vtkImageData of one by its index. All values are in memory then. Errors are ValueErrors.
    """
    try:
        with _opened(path) as file:
            axes, shape = _stack(file)
            sizes, names, interval, time_unit = _metadata(file)
    except ElementTree.ParseError as error:  # a SyntaxError
        raise ValueError(f"its OME metadata are not XML: {error}") from None
    count = _time_count(axes, shape)
    layers = dict(zip(axes.translate(_NAMES), shape)).get("Z", 1)
    spacing, unit = _in_one_unit(path, sizes, names, layers)
    whole = functools.cache(lambda: _values(path))
    (interval,), time_unit = in_seconds(time_unit, interval or 1.0)

    def read(index):
        values, place = whole()[index], (np.zeros(3), np.diag(spacing))
        values = np.ascontiguousarray(values, values.dtype.newbyteorder("="))
        return image_files.image_of(Volume(values, *place, unit=unit, time_unit=time_unit), "TIFF")

    return tuple(interval * n for n in range(count)) if count > 1 else (), read


def _stack(file):
    """Axes and shape of the values. Images of one page each are layers if they are alike."""
    first, count = file.series[0], len(file.series)
    if count == 1:
        return first.axes, first.shape
    is_page = {*first.axes} <= {*"YXS"} and not file.is_ome
    sizes = {(item.axes, item.shape, item.dtype) for item in file.series}
    if not is_page or len(sizes) > 1:
        different = " of different sizes or types" * (len(sizes) > 1)
        raise ValueError(f"it must be one stack, got {count} images{different}")
    return f"Z{first.axes}", (count, *first.shape)


@contextlib.contextmanager
def _opened(path):
    """tifffile's file. Errors that it only logs are raised, because it leaves out pages then."""
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
        if "imagecodecs" in text:
            text = f"it needs the package imagecodecs: pip install imagecodecs ({text})"
            raise ValueError(text) from None
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
    with _opened(path) as file:
        axes, shape = _stack(file)
        parts = [series.asarray() for series in file.series]
        values = parts[0] if len(parts) == 1 else np.stack(parts)
    values, axes = values.reshape(shape), _long_axes(axes, shape)
    values = tifffile.transpose_axes(np.squeeze(values), axes, _ORDER)
    if values.dtype == np.float16:
        values = values.astype(np.float32)
    if values.dtype == bool:
        values = values.astype(np.uint8)
    if values.dtype.kind not in "iuf":
        raise ValueError(f"values of type {values.dtype} are not supported")
    return values if "C" in axes else values[..., 0]


def _metadata(file):
    """Sizes along x, y and z (None is missing) and their units; the interval of times and its."""
    if file.is_ome and file.ome_metadata:
        return _of_ome(file.ome_metadata)
    if file.is_imagej and file.imagej_metadata:
        return _of_imagej(file)
    return [None] * 3, [""] * 3, None, ""


def _of_ome(text):
    root = ElementTree.fromstring(text)
    pixels = next((item for item in root.iter() if item.tag.endswith("}Pixels")), None)
    attributes = {} if pixels is None else pixels.attrib
    sizes = [_positive(attributes.get(f"PhysicalSize{axis}")) for axis in "XYZ"]
    units = [attributes.get(f"PhysicalSize{axis}Unit", "um") for axis in "XYZ"]
    interval = _positive(attributes.get("TimeIncrement"))
    return sizes, units, interval, attributes.get("TimeIncrementUnit", "s") if interval else ""


def _of_imagej(file):
    metadata, tags = file.imagej_metadata, file.pages[0].tags
    sizes = []
    for name in ("XResolution", "YResolution"):
        number, divisor = tags[name].value if name in tags else (1, 1)
        sizes.append(_positive(divisor / number if number else 1) or 1.0)
    unit = str(metadata.get("unit", ""))
    units = [unit, *(str(metadata.get(name, unit)) for name in ("yunit", "zunit"))]
    interval = _positive(metadata.get("finterval"))
    time_unit = str(metadata.get("tunit", "s")) if interval else ""
    return [*sizes, _positive(metadata.get("spacing")) or 1.0], units, interval, time_unit


def _in_one_unit(path, sizes, units, layers):
    """Spacing along x, y and z, and its unit: that of the first size."""
    known = [(size, symbol(unit)) for size, unit in zip(sizes, units) if size is not None]
    if not known:
        return [1.0] * 3, ""
    (first, unit), spacing = known[0], []
    for axis, size, name in zip("xyz", sizes, map(symbol, units)):
        ratio = NANOMETERS.get(name, np.nan) / NANOMETERS.get(unit, np.nan)
        if size is None or (np.isnan(ratio) and name != unit):
            if axis != "z" or layers > 1:
                warn(
                    f"`{path}` does not state the size of voxels along {axis}, or in no unit of "
                    f"length; that of another axis is used, {first:g} {unit}"
                )
            size, name = first, unit
        spacing.append(size if name == unit else size * ratio)
    return spacing, unit if unit in NANOMETERS else ""


def _positive(value):
    """A positive number; None for any other value."""
    try:
        number = float(value)
    except (TypeError, ValueError):
        return None
    return number if np.isfinite(number) and number > 0 else None
