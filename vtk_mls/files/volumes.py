"""The content of an image file: its values, raw or compressed, and units of length and of time."""

import bz2
import contextlib
import gzip
import io
import math
import re
import zlib
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

_CHUNK = 1 << 20  # bytes
_LEVEL = 1  # of compression: a third of the default level's time, files some percent larger
_MAX_RATIO = {"raw": 1, "gzip": 1032, "bzip2": 1_500_000}  # bytes per byte of the file
_POWERS = {"k": 12, "": 9, "d": 8, "c": 7, "m": 6, "u": 3, "n": 0, "p": -3}  # of ten, to billionths
NANOMETERS = {
    **{f"{prefix}m": 10.0**power for prefix, power in _POWERS.items()},
    **{"angstrom": 0.1, "in": 2.54e7, "ft": 3.048e8, "yd": 9.144e8},
}
_NANOSECONDS = {
    **{f"{prefix}s": 10.0**power for prefix, power in _POWERS.items()},
    **{"min": 6e10, "h": 3.6e12, "d": 8.64e13},
}
_WORDS = {"": "", "kilo": "k", "centi": "c", "milli": "m", "micro": "u", "nano": "n", "pico": "p"}
_SYMBOLS = {
    **{
        f"{word}{unit}": word_symbol + unit[0]
        for word, word_symbol in _WORDS.items()
        for unit in ("meter", "metre", "second")
    },
    **{"micron": "um", "inch": "in", "inche": "in", "foot": "ft", "yard": "yd"},
    **{"\u00e5": "angstrom", "sec": "s", "msec": "ms", "usec": "us"},
    **{"minute": "min", "hour": "h", "day": "d"},
}


@dataclass(frozen=True, eq=False)
class Volume:
    """The content of an image file.

    `steps` are those between neighbors along the three axes. `time_unit` is "s" if the unit of
    times is stated, which then are in seconds; a unit that is not of time, such as "Hz", or "" for
    times as in the file.
    """

    values: np.ndarray  # (nz, ny, nx) or (nz, ny, nx, components)
    origin: np.ndarray  # (3,) float64, world coordinates of the first value: LPS for any file
    steps: np.ndarray  # (3, 3) float64, world units, in columns
    is_label: bool = False  # whether values are labels, which must not be mixed
    is_vector: bool = False  # whether the components are a vector in world coordinates
    space: str = ""  # name of the file's frame, if its format knows several
    header: tuple = ()  # lines of the header that a file of the same format gets again
    unit: str = ""  # of `NANOMETERS`: of lengths, if it is not that of the format
    time_unit: str = ""


def decoded(line):
    """Text from UTF-8 or, if that fails, Latin-1."""
    try:
        return line.decode()
    except UnicodeDecodeError:
        return line.decode("latin-1")


def full_steps(steps, dimensions):
    """Steps (3, 3), columns along the axes, with orthogonal unit steps for axes of one point whose
    step is 0; `dimensions` are the numbers of points along them.
    """
    steps = np.array(steps, dtype=float)
    is_missing = (np.asarray(dimensions) <= 1) & ~steps.any(axis=0)
    if is_missing.any() and np.isfinite(steps).all():
        complement = np.linalg.svd(steps)[0][:, 3 - is_missing.sum() :]
        for axis, step in zip(np.flatnonzero(is_missing), complement.T):
            steps[:, axis] = step * np.sign(step[np.abs(step).argmax()])
    return steps


class Series(NamedTuple):
    """The volumes of a file: `times`, in seconds if the file states a unit of time, () without a
    time axis; and `read`, which returns the `Volume` of a time by its index.
    """

    times: tuple
    read: Callable[[int], Volume]


def steps_of(times):
    """The first time and the step of times; ValueError unless the steps are equal."""
    steps = np.diff(times)
    step = float(np.mean(steps)) if len(steps) else 1.0
    if not np.allclose(steps, step, rtol=1e-4, atol=0):
        raise ValueError(
            f"its time steps must be equal, got times {', '.join(f'{t:g}' for t in times[:5])}"
            f"{' ...' * (len(times) > 5)}; write .pvd, which takes any times"
        )
    return float(times[0]), step


@contextlib.contextmanager
def unpacked(file, encoding, max_size):
    """A context with a binary file of the decompressed rest of an open file.

    `encoding` is "raw", "gzip" (also zlib's format) or "bzip2"; `max_size` bytes are read at most.
    A broken stream is a ValueError.
    """
    start = file.tell()
    is_zlib = encoding == "gzip" and file.read(2) != b"\x1f\x8b"
    file.seek(start)
    try:
        if is_zlib:
            inflater = zlib.decompressobj()
            content = inflater.decompress(file.read(), max_size + _CHUNK)
            if not inflater.eof and len(content) < max_size + _CHUNK:
                raise EOFError("it is cut off")
            yield io.BytesIO(content)
        elif encoding == "gzip":
            yield gzip.GzipFile(fileobj=file)
        else:
            yield bz2.BZ2File(file) if encoding == "bzip2" else file
    except (EOFError, gzip.BadGzipFile, zlib.error) as error:
        raise ValueError(f"its values cannot be unpacked: {error}") from None


def read_values(file, dtype, shape, encoding="raw", skip=0):
    """Values from the rest of an open file, in this machine's byte order.

    `dtype` has the byte order of the file, `encoding` is as in `unpacked`, or "text" or "hex";
    `skip` bytes come before the values, -1: raw values are at the end. Memory is allocated only if
    the file can hold so many values, and nothing after them is unpacked. Missing values and a wrong
    checksum are a ValueError.
    """
    dtype, count, start = np.dtype(dtype), math.prod(map(int, shape)), file.tell()
    if encoding in ("text", "hex"):
        values = _decoded(file.read(), dtype, encoding)
        if len(values) < count:
            raise ValueError(f"expected {count} values, got {len(values)}")
        return values[:count].reshape(shape)
    end = file.seek(0, io.SEEK_END)
    if skip == -1:
        start, skip = max(end - count * dtype.itemsize, 0), 0
    size = end - start - skip * (encoding == "raw")
    file.seek(start)
    max_count = max(_MAX_RATIO[encoding] * size // dtype.itemsize, 0)
    if count > max_count:
        at_most = "" if encoding == "raw" else "at most "
        raise ValueError(f"expected {count} values, got {at_most}{max_count}")
    values = np.empty(count, dtype)
    content, start = values.view(np.uint8), 0
    with unpacked(file, encoding, skip + len(content)) as data:
        data.seek(skip, io.SEEK_CUR)
        while start < len(content):
            size = data.readinto(content[start : start + _CHUNK])
            if not size:
                raise ValueError(f"expected {count} values, got {start // dtype.itemsize}")
            start += size
        if encoding == "gzip":
            data.read(_CHUNK)  # the checksum comes after the values, and perhaps a few others
    if not dtype.isnative:
        values = values.byteswap(inplace=True).view(dtype.newbyteorder("="))
    return values.reshape(shape)


def _decoded(content, dtype, encoding):
    """Values (n,) from text or from hexadecimal digits."""
    native = dtype.newbyteorder("=")
    if encoding == "hex":
        content = bytes.fromhex(content.decode("ascii"))
        return np.frombuffer(content, dtype, len(content) // dtype.itemsize).astype(native)
    words = content.replace(b",", b" ").split()
    if native.kind == "f" or native == np.uint64:
        return np.array(words, native)
    values, limits = np.array(words, np.int64), np.iinfo(native)
    outside = values[(values < limits.min) | (values > limits.max)]
    if len(outside):
        raise ValueError(f"values must be from {limits.min} to {limits.max}, got {outside[0]}")
    return values.astype(native)


def packing(file):
    """A binary file that is written to an open one in gzip's format."""
    return gzip.GzipFile("", "wb", _LEVEL, file, mtime=0)


def write_values(file, values):
    """Write values to a binary file, last axis fastest, little-endian."""
    data = np.ascontiguousarray(values, values.dtype.newbyteorder("<")).reshape(-1).view(np.uint8)
    for start in range(0, len(data), _CHUNK):
        file.write(data[start : start + _CHUNK])


# Units of length and of time, by their names in files


def symbol(name):
    """The symbol of a unit of length or time; the name itself for another unit."""
    text = re.sub("\u00b5|\u03bc|\\\\u00b5", "u", name.strip())
    lower = text if text in ("Mm", "Pm") else text.lower()  # those are large
    names = text, lower, *(_SYMBOLS.get(word, "") for word in (lower, lower.removesuffix("s")))
    return next((known for known in names if known in NANOMETERS or known in _NANOSECONDS), name)


def in_seconds(name, *times):
    """Times in seconds, and "s"; unchanged, with the name, if it is not of a unit of time."""
    nanoseconds = _NANOSECONDS.get(symbol(name))
    if nanoseconds is None:
        return times, name
    return tuple(time * nanoseconds / 1e9 for time in times), "s"


def from_seconds(name, *times):
    """Times in a unit; unchanged if it is not of time."""
    nanoseconds = _NANOSECONDS.get(symbol(name), 1e9)
    return tuple(time * 1e9 / nanoseconds for time in times)
