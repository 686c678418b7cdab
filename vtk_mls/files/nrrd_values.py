"""The values of NRRD files, by the fields of their headers."""

import contextlib
import io
import math
import re

import numpy as np

from vtk_mls.files import paths, volumes

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


def read(fields, file, path, sizes):
    """The values, slowest axis first, from the file of the header or from the one that it names."""
    dtype, encoding = _storage(fields)
    count, shape = math.prod(sizes), sizes[::-1]
    with contextlib.ExitStack() as stack:
        if "data file" in fields:
            file = stack.enter_context(_data_file(fields["data file"], path).open("rb"))
        for _ in range(max(int(fields.get("line skip", 0)), 0)):
            if not file.readline():
                break
        if encoding in ("text", "hex"):
            values = _decoded(file.read(), dtype, encoding)
            if len(values) < count:
                raise ValueError(f"expected {count} values, got {len(values)}")
            return values[:count].reshape(shape)
        skip = int(fields.get("byte skip", 0))
        if skip < -1 or (skip == -1 and encoding != "raw"):
            raise ValueError(f"byte skip {skip} must not be negative here")
        if skip == -1:  # the values are at the end
            skip = 0
            file.seek(max(file.seek(0, io.SEEK_END) - count * dtype.itemsize, 0))
        return volumes.read_values(file, dtype, shape, encoding, skip)


def _storage(fields):
    """The dtype and the encoding of the values."""
    kind = " ".join(fields["type"].lower().split())
    if kind not in _DTYPES:
        raise ValueError(f"values of type `{fields['type']}` are not supported")
    encoding = _ENCODINGS.get(fields["encoding"].lower())
    if encoding is None:
        raise ValueError(f"the encoding `{fields['encoding']}` is not supported")
    dtype = np.dtype(_DTYPES[kind])
    if "endian" not in fields and dtype.itemsize > 1 and encoding != "text":
        raise ValueError(f"its values of type `{kind}` need a field `endian`")
    order = fields.get("endian", "little").lower()
    if order not in _ORDERS:
        raise ValueError(f"`endian` must be little or big, got `{order}`")
    return dtype.newbyteorder(_ORDERS[order]), encoding


def _data_file(name, path):
    """The file that a header at `path` names."""
    if name.split()[:1] == ["LIST"] or re.search(r"%\d*d.* ", name):
        raise ValueError("its values are in several files; give one file")
    return paths.named_file(path, name)


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
