"""NRRD files, with their directions and compression, which VTK's reader leaves out."""

from __future__ import annotations

import bz2
import io
import math
import re
import zlib

import numpy as np

_TYPES = {
    "i1": ("signed char", "int8", "int8_t"),
    "u1": ("uchar", "unsigned char", "uint8", "uint8_t"),
    "i2": ("short", "short int", "signed short", "signed short int", "int16", "int16_t"),
    "u2": ("ushort", "unsigned short", "unsigned short int", "uint16", "uint16_t"),
    "i4": ("int", "signed int", "int32", "int32_t"),
    "u4": ("uint", "unsigned int", "uint32", "uint32_t"),
    "i8": ("longlong", "long long", "long long int", "signed long long", "int64", "int64_t"),
    "u8": ("ulonglong", "unsigned long long", "unsigned long long int", "uint64", "uint64_t"),
    "f4": ("float",),
    "f8": ("double",),
}
_ORDERS = {"little": "<", "big": ">"}
_DTYPES = {name: dtype for dtype, names in _TYPES.items() for name in names}


def read(path):
    """Read a volume.

    Parameters
    ----------
    path : Path
        A .nrrd file, or a .nhdr header with its data in one other file.

    Returns
    -------
    values : (nz, ny, nx) or (nz, ny, nx, components) array
    origin : (3,) float64, world coordinates
        Of the first value.
    steps : (3, 3) float64, world units
        Columns are the steps between neighbours along the three axes.

    Raises
    ------
    OSError, ValueError
        Naming the file.
    """
    content = path.read_bytes()
    try:
        fields, data = _split(content)
        sizes = [int(size) for size in fields["sizes"].split()]
        if min(sizes, default=0) < 1:
            raise ValueError(f"its sizes must be positive, got `{fields['sizes']:.60}`")
        axes = _axes(fields, len(sizes))
        origin = _vector(fields["space origin"]) if "space origin" in fields else np.zeros(3)
        other = [i for i, step in enumerate(axes) if step is None]
        steps = [step for step in axes if step is not None]
        shapes = {step.shape for step in [origin, *steps]}
        if len(axes) != len(sizes) or len(steps) != 3 or shapes != {(3,)} or len(other) > 1:
            raise ValueError("it must have three axes in space and at most one of components")
        if "data file" in fields:
            data = _data_file(path.parent / fields["data file"])
        values = _decoded(fields, data, math.prod(sizes)).reshape(sizes[::-1])
    except KeyError as error:
        raise ValueError(f"`{path}` is no NRRD volume: it has no field {error}") from None
    except (EOFError, OSError, OverflowError, ValueError, zlib.error) as error:
        raise ValueError(f"`{path}` is no NRRD volume that can be read: {error!s:.160}") from None
    if other:
        values = np.moveaxis(values, len(sizes) - 1 - other[0], -1)
    return np.ascontiguousarray(values), origin, np.transpose(steps)


def _split(content):
    """The header's fields and the bytes after it."""
    if not content.startswith(b"NRRD"):
        raise ValueError("it does not begin with NRRD")
    end = re.search(rb"\r?\n\r?\n", content)
    header = content[: end.start()] if end else content
    fields = {}
    for line in header.decode("latin-1").splitlines()[1:]:
        key, colon, value = line.partition(": ")
        if colon and not line.startswith("#"):
            fields[key.strip().lower().replace("datafile", "data file")] = value.strip()
    return fields, content[end.end() :] if end else b""


def _data_file(path):
    if not path.is_file():
        raise ValueError(f"there is no data file `{path}`")
    return path.read_bytes()


def _axes(fields, count):
    """The step in space along each axis, None along one of components."""
    if "space directions" in fields:
        found = re.findall(r"none|\([^)]*\)", fields["space directions"])
        return [None if text == "none" else _vector(text) for text in found]
    kinds = fields.get("kinds", "").split() or ["vector"] * (count - 3) + ["domain"] * 3
    spacings = [float(text) for text in fields.get("spacings", "nan " * count).split()]
    axes, unit = [], iter(np.eye(3))
    for kind, spacing in zip(kinds, spacings):
        in_space = kind in ("domain", "space", "???")
        axes.append(next(unit, None) if in_space else None)
        if in_space and np.isfinite(spacing) and axes[-1] is not None:
            axes[-1] = axes[-1] * spacing
    return axes


def _decoded(fields, data, count):
    """`count` values in this machine's byte order."""
    if fields["type"] not in _DTYPES:
        raise ValueError(f"values of type `{fields['type']}` are not known")
    dtype = np.dtype(_DTYPES[fields["type"]])
    lines = min(max(int(fields.get("line skip", 0)), 0), len(data))
    data = b"".join(data.split(b"\n", lines)[lines:])
    encoding = fields["encoding"].lower()
    if encoding in ("txt", "text", "ascii"):
        values = _from_text(data.split(), dtype)
    elif encoding in ("raw", "gz", "gzip", "bz2", "bzip2"):
        skip, size = int(fields.get("byte skip", 0)), count * dtype.itemsize
        if encoding != "raw":  # no more than is wanted: a few bytes can become gigabytes
            data = _unpacked(encoding, data, size + skip if skip >= 0 else -1)
        data = data[-size:] if skip == -1 else data[skip : skip + size]
        order = fields.get("endian", "little")
        if order not in _ORDERS:
            raise ValueError(f"the endian `{order}` is not known")
        values = np.frombuffer(
            data[: len(data) // dtype.itemsize * dtype.itemsize], _ORDERS[order] + dtype.str[1:]
        )
        values = values.astype(dtype)
    else:
        raise ValueError(f"the encoding `{fields['encoding']}` is not known")
    if len(values) < count:
        raise ValueError(f"expected {count} values, got {len(values)}")
    return values[:count]


def _from_text(words, dtype):
    if dtype.kind == "f" or dtype == np.uint64:
        return np.array(words, dtype=dtype)
    values, limits = np.array(words, dtype=np.int64), np.iinfo(dtype)
    wrong = values[(values < limits.min) | (values > limits.max)]
    if len(wrong):
        raise ValueError(f"values must be from {limits.min} to {limits.max}, got {wrong[0]}")
    return values.astype(dtype)


def _unpacked(encoding, data, size):
    """The first `size` bytes, or all if it is negative."""
    if encoding.startswith("b"):
        with bz2.open(io.BytesIO(data)) as file:
            return file.read(size)
    return zlib.decompressobj(wbits=47).decompress(data, max(size, 0))


def _vector(text):
    return np.array([float(number) for number in text.strip("() ").split(",")])
