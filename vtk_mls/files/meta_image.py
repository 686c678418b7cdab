"""MetaImage files (.mha, .mhd), as ITK reads them.

Space. The world of ITK's MetaImages is LPS. `AnatomicalOrientation` says the same as the direction
matrix, or nothing, and does not count.

Other keys (`Modality`, `Comment`, those of SimpleITK's dictionary) stay with an image, and so does
`AnatomicalOrientation` while the direction is that of the file.

Labels. MetaImage has no word for them. `intent_code = 1002` is what ITK writes of NIfTI labels.
"""

from __future__ import annotations

import math
import re

import numpy as np

from vtk_mls.files import volumes
from vtk_mls.files.volumes import Stored, Volume

_TYPES = {
    **{"int8": "MET_CHAR", "uint8": "MET_UCHAR", "int16": "MET_SHORT", "uint16": "MET_USHORT"},
    **{"int32": "MET_INT", "uint32": "MET_UINT", "int64": "MET_LONG_LONG"},
    **{"uint64": "MET_ULONG_LONG", "float32": "MET_FLOAT", "float64": "MET_DOUBLE"},
}
_DTYPES = {
    **{name: dtype for dtype, name in _TYPES.items()},
    **{"MET_LONG": "int32", "MET_ULONG": "uint32"},
}
_LABEL_INTENT = "1002"
_DIRECTIONS = ("TransformMatrix", "Rotation", "Orientation")
_ORIENTATION = "AnatomicalOrientation"
_OWN_KEYS = (  # what a file says of its values and their place is written anew
    *("ObjectType", "NDims", "BinaryData", "BinaryDataByteOrderMSB", "ElementByteOrderMSB"),
    *("CompressedData", "CompressedDataSize", "CompressionLevel", "HeaderSize"),
    *("HeaderSizePerSlice", *_DIRECTIONS, "Offset", "Position", "Origin", "CenterOfRotation"),
    *("ElementSpacing", "ElementSize", "DimSize", "ElementMin", "ElementMax", "intent_code"),
    *("ElementNumberOfChannels", "ElementType", "ElementDataFile", _ORIENTATION),
    *("ITK_original_direction", "ITK_original_spacing"),
)
_LONGEST = 1 << 16  # bytes of a line


def read(path):
    """Read a volume.

    Parameters
    ----------
    path : Path
        A .mha file, or a .mhd header with its data in other files of its folder.

    Returns
    -------
    Volume

    Raises
    ------
    OSError, ValueError
    """
    with path.open("rb") as file:
        header = _header(file)
        count = int(header.get("NDims", 3))
        if not 1 <= count <= 3:
            raise ValueError(f"it must have up to three dimensions, got {count}; give one volume")
        sizes = [int(text) for text in header["DimSize"].split()]
        if len(sizes) != count or min(sizes) < 1:
            raise ValueError(f"its DimSize must be {count} positive numbers, got {sizes!s:.60}")
        components = int(header.get("ElementNumberOfChannels", 1))
        if components < 1:
            raise ValueError(f"its ElementNumberOfChannels must be positive, got {components}")
        shape = [*[1] * (3 - count), *sizes[::-1], *[components] * (components > 1)]
        values = _values(header, file, path, shape)
    origin, spacing, direction = _geometry(header, count)
    is_label = header.get("intent_code") == _LABEL_INTENT and values.dtype.kind in "iu"
    lines = [f"{key} = {text}" for key, text in header.items() if key not in _OWN_KEYS]
    if _ORIENTATION in header:
        lines += [
            f"{_ORIENTATION} = {header[_ORIENTATION]}",
            f"{_DIRECTIONS[0]} = {_text(direction.T.ravel())}",
        ]
    steps = direction * spacing
    return Volume(values, origin, steps, is_label=is_label, header=tuple(lines))


def write(path, volume):
    """Write a volume.

    Parameters
    ----------
    path : Path
        A .mha file; or a .mhd header, beside which a .raw file is made.
    volume : Volume
    """
    values = volume.values
    is_local = path.suffix.lower() == ".mha"
    spacing = np.linalg.norm(volume.steps, axis=0)
    direction = volume.steps / spacing
    header = {
        "ObjectType": "Image",
        "NDims": "3",
        "BinaryData": "True",
        "BinaryDataByteOrderMSB": "False",
        "CompressedData": "False",
        "TransformMatrix": _text(direction.T.ravel()),
        "Offset": _text(volume.origin),
        "CenterOfRotation": "0 0 0",
        "ElementSpacing": _text(spacing),
        "DimSize": " ".join(str(n) for n in values.shape[2::-1]),
        **_kept(volume.header, direction),
        **({"intent_code": _LABEL_INTENT} if volume.is_label else {}),
        "ElementNumberOfChannels": str(values.shape[3] if values.ndim == 4 else 1),
        "ElementType": _TYPES[values.dtype.name],
        "ElementDataFile": "LOCAL" if is_local else f"{path.stem}.raw",
    }
    text = "".join(f"{key} = {value}\n" for key, value in header.items())
    with path.open("wb") as file:
        file.write(text.encode())
        if is_local:
            volumes.write_values(file, values)
    if not is_local:
        with path.with_suffix(".raw").open("wb") as file:
            volumes.write_values(file, values)


def _header(file):
    """The fields, and after them the names of files if there is a list of them."""
    header = {}
    while line := file.readline(_LONGEST):
        key, equals, value = volumes.decoded(line).partition("=")
        if equals:
            header[key.strip()] = value.strip()
        if key.strip() == "ElementDataFile":
            break
    for name in ("DimSize", "ElementType", "ElementDataFile"):
        if name not in header:
            raise ValueError(f"it is no MetaImage: it has no {name}")
    return header


def _kept(lines, direction):
    """Keys and values of a file that are true of an image with this direction."""
    found = dict(" ".join(line.splitlines()).split(" = ", 1) for line in lines if " = " in line)
    kept = {key: text for key, text in found.items() if key not in _OWN_KEYS}
    if _ORIENTATION in found and _DIRECTIONS[0] in found:
        before = np.array(found[_DIRECTIONS[0]].split(), float)
        if len(before) == 9 and np.allclose(before, direction.T.ravel(), rtol=0, atol=1e-9):
            kept[_ORIENTATION] = found[_ORIENTATION]
    return kept


def _geometry(header, count):
    """Origin (3,), spacing (3,) and direction (3, 3)."""
    found = [np.zeros(3), np.ones(3), np.eye(3)]
    for target, names in zip(
        found,
        (
            ("Offset", "Position", "Origin"),
            ("ElementSpacing", "ElementSize"),
            _DIRECTIONS,
        ),
    ):
        name = next((name for name in names if name in header), None)
        if name is None:
            continue
        numbers = np.array(header[name].split(), dtype=float)
        if not np.isfinite(numbers).all() and target.ndim == 1:
            raise ValueError(f"its {name} must be finite numbers")
        wanted = count**target.ndim
        if len(numbers) != wanted:
            what = "direction" if target.ndim == 2 else name
            of = f"{count} x {count}" if target.ndim == 2 else count
            raise ValueError(f"its {what} must have {of} numbers, got {len(numbers)}")
        if target.ndim == 2:
            target[:count, :count] = numbers.reshape(count, count).T
        else:
            target[:count] = numbers
    return found


def _values(header, file, path, shape):
    kind = header["ElementType"].removesuffix("_ARRAY")
    if kind not in _DTYPES:
        raise ValueError(f"values of type `{kind:.40}` are not known")
    order = header.get("BinaryDataByteOrderMSB", header.get("ElementByteOrderMSB", "False"))
    dtype = np.dtype(_DTYPES[kind]).newbyteorder(">" if _is_true(order) else "<")
    encoding = "gzip" if _is_true(header.get("CompressedData", "False")) else "raw"
    if not _is_true(header.get("BinaryData", "True")):
        if encoding != "raw":
            raise ValueError("its values cannot be both text and compressed")
        encoding = "text"
    skip = int(header.get("HeaderSize", 0))
    names = _data_files(header["ElementDataFile"], file)
    if names is None:
        return _read_values(file, path, Stored(dtype, shape, encoding), 0)
    slabs, rest = [], shape
    if len(names) > 1:
        if shape[0] % len(names):
            raise ValueError(f"its {shape[0]} slices are not in {len(names)} files of one size")
        rest = [shape[0] // len(names), *shape[1:]]
    for name in names:
        data = volumes.named_file(path, name)
        with data.open("rb") as each:
            slabs.append(_read_values(each, data, Stored(dtype, rest, encoding), skip))
    return slabs[0] if len(slabs) == 1 else np.concatenate(slabs)


def _data_files(text, file):
    """Names of the files with values, None for the header's own."""
    if text.upper() == "LOCAL":
        return None
    if text.split()[:1] == ["LIST"]:
        return [volumes.decoded(line).strip() for line in file.readlines() if line.strip()]
    pattern = re.fullmatch(r"([^%]*%\d{0,2}d[^%\s]*)\s+(\d+)\s+(\d+)(?:\s+(\d+))?", text)
    if pattern:
        first, last, step = int(pattern[2]), int(pattern[3]), int(pattern[4] or 1)
        numbers = range(first, last + 1, max(step, 1))
        if len(numbers) > 1 << 16:
            raise ValueError(f"its values must be in a few files, got {len(numbers)}")
        return [pattern[1] % number for number in numbers]
    return [text]


def _read_values(file, path, stored, skip):
    (dtype, shape, encoding), size = stored, path.stat().st_size
    if encoding == "text":
        count, words = math.prod(shape), file.read().split()
        if len(words) < count:
            raise ValueError(f"expected {count} values, got {len(words)}")
        return np.array(words[:count], dtype=float).astype(dtype.newbyteorder("=")).reshape(shape)
    if skip == -1:
        file.seek(max(size - math.prod(shape) * dtype.itemsize, 0))
    else:
        volumes.skip(file, skip)
    size -= file.tell()
    return volumes.read_values(volumes.unpacked(file, encoding), dtype, shape, size, encoding)


def _is_true(text):
    return text[:1] in ("T", "t", "1")


def _text(numbers):
    return " ".join(repr(float(number)) for number in numbers)
