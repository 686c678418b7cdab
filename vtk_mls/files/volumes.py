"""A volume as a file has it, and the values of files that are raw or compressed."""

from __future__ import annotations

import bz2
import gzip
import io
import zlib
from dataclasses import dataclass
from pathlib import PurePosixPath, PureWindowsPath
from typing import NamedTuple

import numpy as np

_PIECE = 1 << 20  # bytes
_FAST = 1  # level of compression: a third of the time of the usual one, files some percent larger
_MOST = {"raw": 1, "gzip": 1032, "bzip2": 1_500_000}  # bytes that one byte of the file can become


@dataclass(frozen=True, eq=False)
class Volume:
    """What a file of one image says.

    Parameters
    ----------
    values : (nz, ny, nx) or (nz, ny, nx, components) array
    origin : (3,) float64, world coordinates
        Of the first value; LPS, whatever the file's own frame is.
    steps : (3, 3) float64, world units
        Columns are the steps between neighbours along the three axes.
    is_label : bool
        Whether values are labels, which must not be mixed.
    is_vector : bool
        Whether the components are a vector in the world.
    space : str
        Name of the file's own frame, if it can have several.
    header : tuple of str
        Lines of the file's header that a file of the same format is to have again.
    """

    values: np.ndarray
    origin: np.ndarray
    steps: np.ndarray
    is_label: bool = False
    is_vector: bool = False
    space: str = ""
    header: tuple = ()


def decoded(line):
    """Text of bytes, which are Latin-1 if they are not UTF-8."""
    try:
        return line.decode()
    except UnicodeDecodeError:
        return line.decode("latin-1")


def full_steps(steps, dimensions):
    """Steps (3, 3) with unit ones, at right angles, for axes of one point whose own are 0.

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
        rest = np.linalg.svd(steps)[0][:, 3 - is_missing.sum() :]
        for axis, step in zip(np.flatnonzero(is_missing), rest.T):
            steps[:, axis] = step * np.sign(step[np.abs(step).argmax()])
    return steps


class Stored(NamedTuple):
    """How a file stores values: `encoding` is "text", or as of `unpacked`."""

    dtype: np.dtype
    shape: tuple
    encoding: str


def unpacked(file, encoding):
    """A binary file with what an open one holds from where it stands.

    Parameters
    ----------
    file : binary file
    encoding : {"raw", "gzip", "bzip2"}
        "gzip" is also for zlib's own streams.
    """
    if encoding == "bzip2":
        return bz2.BZ2File(file)
    return io.BufferedReader(_Inflated(file), _PIECE) if encoding == "gzip" else file


def read_values(file, dtype, shape, size, encoding="raw"):
    """Values from a binary file, in this machine's byte order.

    No more memory is taken, and no more is unpacked, than the values need, and none for values
    that the file cannot hold.

    Parameters
    ----------
    file : binary file
        As `unpacked` gives it.
    dtype : dtype
        With the byte order of the file.
    shape : ints
    size : int
        Bytes of the file before it is unpacked.
    encoding : str
        As for `unpacked`.

    Raises
    ------
    ValueError
        If there are less, or a checksum behind them is wrong.
    """
    dtype, count = np.dtype(dtype), 1
    for n in shape:
        count *= int(n)
    most = _MOST[encoding] * size // dtype.itemsize
    if count > most:
        at_most = "" if encoding == "raw" else "at most "
        raise ValueError(f"expected {count} values, got {at_most}{most}")
    values = np.empty(count, dtype)
    room, done = values.view(np.uint8), 0
    while done < len(room):
        read = file.readinto(room[done : done + _PIECE])
        if not read:
            raise ValueError(f"expected {count} values, got {done // dtype.itemsize}")
        done += read
    if encoding == "gzip":
        file.read(1)  # the checksum comes after the values
    if not dtype.isnative:
        values = values.byteswap(inplace=True).view(dtype.newbyteorder("="))
    return values.reshape(shape)


def skip(file, size):
    """Read on over some bytes of a binary file."""
    while size > 0 and (read := len(file.read(min(size, _PIECE)))):
        size -= read


def packing(file):
    """A binary file that is packed, as gzip does, into an open one."""
    return gzip.GzipFile("", "wb", _FAST, file, mtime=0)


def write_values(file, values):
    """Write values to a binary file, the last axis fastest, with their lowest bytes first."""
    data = np.ascontiguousarray(values, values.dtype.newbyteorder("<")).reshape(-1).view(np.uint8)
    for start in range(0, len(data), _PIECE):
        file.write(data[start : start + _PIECE])


def named_file(path, name):
    """The file that a header names.

    Parameters
    ----------
    path : Path
        Of the header.
    name : str
        As the header has it, from the header's folder on.

    Raises
    ------
    ValueError
        If it leads out of that folder, or to no file.
    """
    check_within(name)
    found = path.parent / name
    if not found.is_file():
        raise ValueError(f"there is no data file `{found}`")
    return found


def check_within(name):
    """Raise ValueError if a file that a header names is not in the header's folder."""
    paths = PurePosixPath(name), PureWindowsPath(name)
    if any(path.is_absolute() or path.drive or ".." in path.parts for path in paths):
        raise ValueError(f"its data file `{name:.80}` is not in its own folder")


class _Inflated(io.RawIOBase):
    """What a stream of zlib's, or the members of a gzip file, hold."""

    def __init__(self, file):
        self._file, self._packed = file, b""
        self._inflater = zlib.decompressobj(wbits=47)  # by itself finds out which of the two

    def readable(self):
        return True

    def readinto(self, room):
        while True:
            packed = self._packed or self._file.read(_PIECE)
            if self._inflater.eof:
                if not packed.startswith(b"\x1f\x8b"):
                    return 0
                self._inflater = zlib.decompressobj(wbits=47)
            try:
                values = self._inflater.decompress(packed, len(room))
            except zlib.error as error:
                raise ValueError(f"its values cannot be unpacked: {error}") from None
            self._packed = self._inflater.unconsumed_tail or self._inflater.unused_data
            if values:
                room[: len(values)] = values
                return len(values)
            if not packed:  # cut off
                return 0
