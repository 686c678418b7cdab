"""NRRD files, with their directions and compression, which VTK's reader leaves out."""

from __future__ import annotations

import bz2
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
        axes = _axes(fields, len(sizes))
        if "data file" in fields:
            data = (path.parent / fields["data file"]).read_bytes()
        values = _decoded(fields, data, int(np.prod(sizes))).reshape(sizes[::-1])
        origin = _vector(fields["space origin"]) if "space origin" in fields else np.zeros(3)
        other = [i for i, step in enumerate(axes) if step is None]
        steps = np.transpose([step for step in axes if step is not None])
        if steps.shape != (3, 3) or len(origin) != 3 or len(other) > 1:
            raise ValueError("it must have three axes in space and at most one of components")
    except KeyError as error:
        raise ValueError(f"`{path}` is no NRRD volume: it has no field {error}") from None
    except (EOFError, ValueError, zlib.error) as error:
        raise ValueError(f"`{path}` is no NRRD volume that can be read: {error}") from None
    if other:
        values = np.moveaxis(values, len(sizes) - 1 - other[0], -1)
    return np.ascontiguousarray(values), origin, steps


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
    for _ in range(int(fields.get("line skip", 0))):
        data = data.partition(b"\n")[2]
    encoding = fields["encoding"].lower()
    if encoding in ("txt", "text", "ascii"):
        values = np.array(data.split(), dtype=dtype)
    elif encoding in ("raw", "gz", "gzip", "bz2", "bzip2"):
        if encoding.startswith("g"):
            data = zlib.decompress(data, wbits=47)
        elif encoding.startswith("b"):
            data = bz2.decompress(data)
        skip = int(fields.get("byte skip", 0))
        data = data[-count * dtype.itemsize :] if skip == -1 else data[skip:]
        order = {"little": "<", "big": ">"}[fields.get("endian", "little")]
        values = np.frombuffer(
            data[: len(data) // dtype.itemsize * dtype.itemsize], order + dtype.str[1:]
        )
        values = values.astype(dtype)
    else:
        raise ValueError(f"the encoding `{fields['encoding']}` is not known")
    if len(values) < count:
        raise ValueError(f"expected {count} values, got {len(values)}")
    return values[:count]


def _vector(text):
    return np.array([float(number) for number in text.strip("() ").split(",")])
