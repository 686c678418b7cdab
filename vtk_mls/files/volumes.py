"""The content of an image file, and its values, raw or compressed."""

from __future__ import annotations

import bz2
import contextlib
import gzip
import io
import math
import weakref
import zlib
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

_CHUNK = 1 << 20  # bytes
_LEVEL = 1  # of compression: a third of the default level's time, files some percent larger
_MAX_RATIO = {"raw": 1, "gzip": 1032, "bzip2": 1_500_000}  # bytes per byte of the file


@dataclass(frozen=True, eq=False)
class Volume:
    """The content of an image file.

    Parameters
    ----------
    values : (nz, ny, nx) or (nz, ny, nx, components) array
    origin : (3,) float64, world coordinates
        Of the first value; LPS for any frame of the file.
    steps : (3, 3) float64, world units
        Columns are the steps between neighbors along the three axes.
    is_label : bool
        Whether values are labels, which must not be mixed.
    is_vector : bool
        Whether the components are a vector in world coordinates.
    space : str
        Name of the file's frame, if its format knows several.
    header : tuple of str
        Lines of the header that a file of the same format gets again.
    unit : str
        Of lengths, if it is not the unit of the format: one of `units.NANOMETERS`.
    time_unit : str
        "s" if the unit of times is stated, which then are in seconds. A unit that is not of time,
        such as "Hz", or "" for times as in the file.
    """

    values: np.ndarray
    origin: np.ndarray
    steps: np.ndarray
    is_label: bool = False
    is_vector: bool = False
    space: str = ""
    header: tuple = ()
    unit: str = ""
    time_unit: str = ""


def decoded(line):
    """Text from UTF-8 or, if that fails, Latin-1."""
    try:
        return line.decode()
    except UnicodeDecodeError:
        return line.decode("latin-1")


def full_steps(steps, dimensions):
    """Steps (3, 3), with orthogonal unit steps for axes of one point whose step is 0.

    Parameters
    ----------
    steps : (3, 3) array
        Columns are the steps along the three axes.
    dimensions : (3,) ints
        Numbers of points along them.
    """
    steps = np.array(steps, dtype=float)
    is_missing = (np.asarray(dimensions) <= 1) & ~steps.any(axis=0)
    if is_missing.any() and np.isfinite(steps).all():
        complement = np.linalg.svd(steps)[0][:, 3 - is_missing.sum() :]
        for axis, step in zip(np.flatnonzero(is_missing), complement.T):
            steps[:, axis] = step * np.sign(step[np.abs(step).argmax()])
    return steps


class Series(NamedTuple):
    """The volumes of a file.

    Attributes
    ----------
    times : tuple of float
        In seconds if the file states a unit of time; empty for a file without a time axis.
    read : callable
        Returns the `Volume` of a time by its index.
    """

    times: tuple
    read: Callable[[int], Volume]


def single(series, path):
    """The volume of a file that must have one."""
    if len(series.times) > 1:
        raise ValueError(f"`{path}` is a series of {len(series.times)} volumes; give one volume")
    return series.read(0)


def steps_of(times):
    """The first time and the step of times, if the steps are equal.

    Raises
    ------
    ValueError
    """
    steps = np.diff(times)
    step = float(np.mean(steps)) if len(steps) else 1.0
    if not np.allclose(steps, step, rtol=1e-4, atol=0):
        raise ValueError(
            f"its time steps must be equal, got times {', '.join(f'{t:g}' for t in times[:5])}"
            f"{' ...' * (len(times) > 5)}; write .pvd, which takes any times"
        )
    return float(times[0]), step


class Storage(NamedTuple):
    """Storage of values; `encoding` is "text", "hex" or as in `unpacked`."""

    dtype: np.dtype
    shape: tuple
    encoding: str


def unpacked(file, encoding):
    """A binary file of the decompressed rest of an open file.

    Parameters
    ----------
    file : binary file
    encoding : {"raw", "gzip", "bzip2"}
        "gzip" is also zlib's format.
    """
    if encoding == "bzip2":
        return bz2.BZ2File(file)
    return io.BufferedReader(_Inflated(file), _CHUNK) if encoding == "gzip" else file


def check_size(count, dtype, size, encoding):
    """Raise ValueError if a file of `size` bytes cannot hold `count` values."""
    max_count = _MAX_RATIO[encoding] * size // np.dtype(dtype).itemsize
    if count > max_count:
        at_most = "" if encoding == "raw" else "at most "
        raise ValueError(f"expected {count} values, got {at_most}{max_count}")


def read_values(file, dtype, shape, size, encoding="raw", is_end=True):
    """Values from a binary file, in this machine's byte order.

    Memory is allocated only if the file can hold so many values. Nothing after them is unpacked.

    Parameters
    ----------
    file : binary file
        As returned by `unpacked`.
    dtype : dtype
        With the byte order of the file.
    shape : ints
    size : int
        Bytes of the packed file.
    encoding : str
        As in `unpacked`.
    is_end : bool
        Whether no other values follow.

    Raises
    ------
    ValueError
        If values are missing, or the checksum behind them is wrong.
    """
    dtype, count = np.dtype(dtype), math.prod(map(int, shape))
    check_size(count, dtype, size, encoding)
    values = np.empty(count, dtype)
    content, start = values.view(np.uint8), 0
    while start < len(content):
        size = file.readinto(content[start : start + _CHUNK])
        if not size:
            raise ValueError(f"expected {count} values, got {start // dtype.itemsize}")
        start += size
    if encoding == "gzip" and is_end:
        file.read(1)  # the checksum comes after the values
    if not dtype.isnative:
        values = values.byteswap(inplace=True).view(dtype.newbyteorder("="))
    return values.reshape(shape)


class Slabs:
    """Slabs of values, one after another in a file. Reading them in order unpacks the file once.

    Parameters
    ----------
    open_file : callable
        Called with an ExitStack; returns an unpacked file, at the first value.
    storage : Storage
        Of one slab.
    count : int
        Number of slabs.
    size : int
        Bytes of the packed file.

    Raises
    ------
    ValueError
        If the file is too small.
    """

    def __init__(self, open_file, storage, count, size):
        check_size(math.prod(storage.shape) * count, storage.dtype, size, storage.encoding)
        self._open_file, self._storage, self._count, self._size = open_file, storage, count, size
        self._file, self._next = None, 0
        self._stack = contextlib.ExitStack()
        weakref.finalize(self, self._stack.close)

    def read(self, index):
        """The values of a slab."""
        dtype, shape, encoding = self._storage
        if self._file is None or index < self._next:
            self._stack.close()
            self._file, self._next = self._open_file(self._stack), 0
        skip(self._file, (index - self._next) * math.prod(shape) * np.dtype(dtype).itemsize)
        self._next, is_end = index + 1, index + 1 == self._count
        values = read_values(self._file, dtype, shape, self._size, encoding, is_end)
        if is_end:
            self._stack.close()
            self._file = None
        return values


def skip(file, size):
    """Read and drop some bytes of a binary file."""
    while size > 0 and (dropped := len(file.read(min(size, _CHUNK)))):
        size -= dropped


def packing(file):
    """A binary file that is written to an open one in gzip's format."""
    return gzip.GzipFile("", "wb", _LEVEL, file, mtime=0)


def write_values(file, values):
    """Write values to a binary file, last axis fastest, little-endian."""
    data = np.ascontiguousarray(values, values.dtype.newbyteorder("<")).reshape(-1).view(np.uint8)
    for start in range(0, len(data), _CHUNK):
        file.write(data[start : start + _CHUNK])


class _Inflated(io.RawIOBase):
    """The content of a zlib stream, or of all members of a gzip file."""

    def __init__(self, file):
        self._file, self._packed = file, b""
        self._inflater = zlib.decompressobj(wbits=47)  # detects which of the two

    def readable(self):
        return True

    def readinto(self, buffer):
        while True:
            packed = self._packed or self._file.read(_CHUNK)
            if self._inflater.eof:
                if not packed.startswith(b"\x1f\x8b"):
                    return 0
                self._inflater = zlib.decompressobj(wbits=47)
            try:
                values = self._inflater.decompress(packed, len(buffer))
            except zlib.error as error:
                raise ValueError(f"its values cannot be unpacked: {error}") from None
            self._packed = self._inflater.unconsumed_tail or self._inflater.unused_data
            if values:
                buffer[: len(values)] = values
                return len(values)
            if not packed:  # cut off
                return 0
