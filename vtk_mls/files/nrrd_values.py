"""The values of NRRD files, by the fields of their headers."""

from __future__ import annotations

import contextlib
import math
import re

import numpy as np

from vtk_mls.files import paths, volumes
from vtk_mls.files.volumes import Storage

TYPES = {
    "i1": ("signed char", "int8", "int8_t"),
    "u1": ("unsigned char", "uchar", "uint8", "uint8_t"),
    "i2": ("short", "short int", "signed short", "signed short int", "int16", "int16_t"),
    "u2": ("unsigned short", "ushort", "unsigned short int", "uint16", "uint16_t"),
    "i4": ("int", "signed int", "int32", "int32_t"),
    "u4": ("unsigned int", "uint", "uint32", "uint32_t"),
    "i8": ("long long", "longlong", "long long int", "signed long long", "signed long long int")
    + ("int64", "int64_t"),
    "u8": ("unsigned long long", "ulonglong", "unsigned long long int", "uint64", "uint64_t"),
    "f4": ("float",),
    "f8": ("double",),
}
_DTYPES = {name: dtype for dtype, names in TYPES.items() for name in names}
_ORDERS = {"little": "<", "big": ">"}
_ENCODINGS = {
    **dict.fromkeys(("txt", "text", "ascii"), "text"),
    "hex": "hex",
    **{"raw": "raw", "gz": "gzip", "gzip": "gzip", "bz2": "bzip2", "bzip2": "bzip2"},
}


def _storage(fields, sizes):
    """How the values are stored."""
    kind = " ".join(fields["type"].lower().split())
    if kind not in _DTYPES:
        raise ValueError(f"values of type `{fields['type']}` are not supported")
    encoding = _ENCODINGS.get(fields["encoding"].lower())
    if encoding is None:
        raise ValueError(f"the encoding `{fields['encoding']}` is not supported")
    dtype, shape = np.dtype(_DTYPES[kind]), sizes[::-1]
    if "endian" not in fields and dtype.itemsize > 1 and encoding != "text":
        raise ValueError(f"its values of type `{kind}` need a field `endian`")
    order = fields.get("endian", "little").lower()
    if order not in _ORDERS:
        raise ValueError(f"`endian` must be little or big, got `{order}`")
    return Storage(dtype.newbyteorder(_ORDERS[order]), tuple(shape), encoding)


def _data_file(fields, path):
    """The file that a header names, or None."""
    if "data file" not in fields:
        return None
    name = fields["data file"]
    if name.split()[:1] == ["LIST"] or re.search(r"%\d*d.* ", name):
        raise ValueError("its values are in several files; give one file")
    return paths.named_file(path, name)


def read(fields, file, path, sizes):
    """The values, slowest axis first, from the file of the header or from the one that it names."""
    storage, data = _storage(fields, sizes), _data_file(fields, path)
    with contextlib.ExitStack() as stack:
        if data is not None:
            path, file = data, stack.enter_context(data.open("rb"))
        count, size = math.prod(storage.shape), path.stat().st_size
        if storage.encoding in ("text", "hex"):
            _skip_lines(file, fields)
            values = _decoded(file.read(), storage.dtype, storage.encoding)
            if len(values) < count:
                raise ValueError(f"expected {count} values, got {len(values)}")
            return values[:count].reshape(storage.shape)
        file, size = _at_values(file, fields, storage, count, size)
        return volumes.read_values(file, storage.dtype, storage.shape, size, storage.encoding)


class ValuesInTime:
    """The values of a file by their index in time; one volume at a time if time is slowest."""

    def __init__(self, fields, path, start, sizes, axis):
        self._whole, self._axis = None, len(sizes) - 1 - axis
        storage, data = _storage(fields, sizes), _data_file(fields, path)
        if self._axis > 0 or storage.encoding in ("text", "hex"):
            with path.open("rb") as file:
                file.seek(start)
                self._whole = read(fields, file, path, sizes)
            return
        path, start = (path, start) if data is None else (data, 0)
        count, size = math.prod(storage.shape), path.stat().st_size

        def open_values(stack):
            file = stack.enter_context(path.open("rb"))
            file.seek(start)
            return _at_values(file, fields, storage, count, size)[0]

        one = storage._replace(shape=storage.shape[1:])
        self._slabs = volumes.Slabs(open_values, one, storage.shape[0], size - start)

    def read(self, index):
        if self._whole is None:
            return self._slabs.read(index)
        return np.ascontiguousarray(np.take(self._whole, index, self._axis))


def _skip_lines(file, fields):
    for _ in range(max(int(fields.get("line skip", 0)), 0)):
        if not file.readline():
            break


def _at_values(file, fields, storage, count, size):
    """The unpacked file at its first value, and the number of bytes there, packed."""
    _skip_lines(file, fields)
    skip, encoding = int(fields.get("byte skip", 0)), storage.encoding
    if skip < 0:
        if skip < -1 or encoding != "raw":
            raise ValueError(f"byte skip {skip} must not be negative here")
        file.seek(max(size - count * storage.dtype.itemsize, 0))
    size -= file.tell()
    file = volumes.unpacked(file, encoding)
    volumes.skip(file, skip)
    return file, size - max(skip, 0) * (encoding == "raw")


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
