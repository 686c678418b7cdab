"""MetaImage files (.mha, .mhd), as ITK reads them.

Frame. ITK's MetaImages are in LPS. `AnatomicalOrientation` repeats the direction matrix and is
ignored.

Other keys (`Modality`, `Comment`, those of SimpleITK's dictionary) are written again, and so is
`AnatomicalOrientation` if the direction has not changed.

Labels. MetaImage has no key for them. ITK writes NIfTI labels with `intent_code = 1002`.
"""

import re

import numpy as np

from vtk_mls.files import paths, volumes
from vtk_mls.files.volumes import Series, Volume

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
_MAX_FILES = 1 << 16
_DIRECTIONS = ("TransformMatrix", "Rotation", "Orientation")
_ORIGINS, _SPACINGS = ("Offset", "Position", "Origin"), ("ElementSpacing", "ElementSize")
_ORIENTATION = "AnatomicalOrientation"
_OWN_KEYS = (  # of values and geometry; not copied
    *("ObjectType", "NDims", "BinaryData", "BinaryDataByteOrderMSB", "ElementByteOrderMSB"),
    *("CompressedData", "CompressedDataSize", "CompressionLevel", "HeaderSize"),
    *("HeaderSizePerSlice", "CenterOfRotation", *_DIRECTIONS, *_ORIGINS, *_SPACINGS, _ORIENTATION),
    *("DimSize", "ElementMin", "ElementMax", "intent_code", "ElementNumberOfChannels"),
    *("ElementType", "ElementDataFile", "ITK_original_direction", "ITK_original_spacing"),
)
_MAX_LINE = 1 << 16  # bytes


def open_file(path):
    """The `Series` of a .mha file, or of a .mhd header with its data in other files of its folder.

    A fourth axis is time, in seconds as in ITK.
    """
    with path.open("rb") as file:
        header = _header(file)
        count = int(header.get("NDims", 3))
        if not 1 <= count <= 4:
            raise ValueError(f"it must have up to four dimensions, got {count}")
        sizes = [int(text) for text in header["DimSize"].split()]
        if len(sizes) != count or min(sizes) < 1:
            raise ValueError(f"its DimSize must be {count} positive numbers, got {sizes!s:.60}")
        components = int(header.get("ElementNumberOfChannels", 1))
        if components < 1:
            raise ValueError(f"its ElementNumberOfChannels must be positive, got {components}")
        shape = [*[1] * (3 - count), *sizes[::-1], *[components] * (components > 1)]
        origin, spacing, direction = _geometry(header, count)
        values = _values(header, file, path, shape)
    place = origin[:3], spacing[:3], direction
    if count < 4:
        return Series((), lambda index: _volume(header, *place, values))
    times = tuple((origin[3] + spacing[3] * np.arange(sizes[3])).tolist())
    return Series(times, lambda index: _volume(header, *place, values[index]))


def _volume(header, origin, spacing, direction, values):
    is_label = header.get("intent_code") == _LABEL_INTENT and values.dtype.kind in "iu"
    copied = {key: text for key, text in header.items() if key not in _OWN_KEYS}
    if _ORIENTATION in header:
        copied[_ORIENTATION] = header[_ORIENTATION]
        copied[_DIRECTIONS[0]] = _format(direction.T.ravel())
    lines = tuple(f"{key} = {text}" for key, text in copied.items())
    unit = "s" * (int(header.get("NDims", 3)) == 4)
    steps = direction * spacing
    return Volume(values, origin, steps, is_label=is_label, header=lines, time_unit=unit)


def write(path, series, times):
    """Write a list of `Volume` to a .mha file, or to a .mhd header and a .raw file in its folder;
    `times` are () for one without.
    """
    is_local = path.suffix.lower() == ".mha"
    time_axis = (*volumes.steps_of(times), len(times)) if times else None
    content = _text(series[0], "LOCAL" if is_local else f"{path.stem}.raw", time_axis)
    if not is_local:
        path.write_bytes(content)
        path, content = path.with_suffix(".raw"), b""
    with path.open("wb") as file:
        file.write(content)
        for volume in series:
            volumes.write_values(file, volume.values)


def _text(volume, data_file, time_axis):
    """The header; `time_axis` is the first time, the step and the number of times, or None."""
    values = volume.values
    spacing = np.linalg.norm(volume.steps, axis=0)
    direction = volume.steps / spacing
    start, step, count = time_axis or (0.0, 1.0, 1)
    n = 4 if time_axis else 3
    matrix = np.eye(n)
    matrix[:3, :3] = direction
    header = {
        "ObjectType": "Image",
        "NDims": str(n),
        "BinaryData": "True",
        "BinaryDataByteOrderMSB": "False",
        "CompressedData": "False",
        "TransformMatrix": _format(matrix.T.ravel()),
        "Offset": _format([*volume.origin, start][:n]),
        "CenterOfRotation": " ".join("0" * n),
        "ElementSpacing": _format([*spacing, step][:n]),
        "DimSize": " ".join(map(str, [*values.shape[2::-1], count][:n])),
        **_copied(volume.header, direction),
        **({"intent_code": _LABEL_INTENT} if volume.is_label else {}),
        "ElementNumberOfChannels": str(values.shape[3] if values.ndim == 4 else 1),
        "ElementType": _TYPES[values.dtype.name],
        "ElementDataFile": data_file,
    }
    return "".join(f"{key} = {value}\n" for key, value in header.items()).encode()


def _header(file):
    """Keys and values, up to the key before the data."""
    header = {}
    while line := file.readline(_MAX_LINE):
        key, equals, value = volumes.decoded(line).partition("=")
        if equals:
            header[key.strip()] = value.strip()
        if key.strip() == "ElementDataFile":
            break
    for name in ("DimSize", "ElementType", "ElementDataFile"):
        if name not in header:
            raise ValueError(f"it is not a MetaImage: it has no {name}")
    return header


def _copied(lines, direction):
    """Keys and values of a source file that are true of an image with this direction."""
    source = dict(" ".join(line.splitlines()).split(" = ", 1) for line in lines if " = " in line)
    copied = {key: text for key, text in source.items() if key not in _OWN_KEYS}
    if _ORIENTATION in source and _DIRECTIONS[0] in source:
        old = np.array(source[_DIRECTIONS[0]].split(), float)
        if len(old) == 9 and np.allclose(old, direction.T.ravel(), rtol=0, atol=1e-9):
            copied[_ORIENTATION] = source[_ORIENTATION]
    return copied


def _geometry(header, count):
    """Origin and spacing along all axes, at least 3, and direction (3, 3)."""
    n = max(count, 3)
    origin, spacing, direction = np.zeros(n), np.ones(n), np.eye(3)
    for target, names in ((origin, _ORIGINS), (spacing, _SPACINGS)):
        name = next((name for name in names if name in header), None)
        if name is not None:
            numbers = _numbers(header[name], count, name)
            if not np.isfinite(numbers).all():
                raise ValueError(f"its {name} must be finite numbers")
            target[:count] = numbers
    text = next((header[name] for name in _DIRECTIONS if name in header), "")
    if text:
        matrix = _numbers(text, count * count, "direction").reshape(count, count).T
        if count == 4 and not np.array_equal([*matrix[3], *matrix[:3, 3]], [0, 0, 0, 1, 0, 0, 0]):
            raise ValueError("its fourth axis must be time, and not turned into space")
        direction[:count, :count] = matrix[:3, :3]
    return origin, spacing, direction


def _numbers(text, count, name):
    numbers = np.array(text.split(), dtype=float)
    if len(numbers) != count:
        raise ValueError(f"its {name} must have {count} numbers, got {len(numbers)}")
    return numbers


def _storage(header):
    kind = header["ElementType"].removesuffix("_ARRAY")
    if kind not in _DTYPES:
        raise ValueError(f"values of type `{kind:.40}` are not supported")
    order = header.get("BinaryDataByteOrderMSB", header.get("ElementByteOrderMSB", "False"))
    dtype = np.dtype(_DTYPES[kind]).newbyteorder(">" if _is_true(order) else "<")
    encoding = "gzip" if _is_true(header.get("CompressedData", "False")) else "raw"
    if not _is_true(header.get("BinaryData", "True")):
        if encoding != "raw":
            raise ValueError("its values cannot be both text and compressed")
        encoding = "text"
    return dtype, encoding


def _values(header, file, path, shape):
    """Values in one file, or along the slowest axis in several of one size."""
    (dtype, encoding), skip = _storage(header), int(header.get("HeaderSize", 0))
    names = _data_files(header["ElementDataFile"], file)
    if names is None:
        return volumes.read_values(file, dtype, shape, encoding)
    if not names or shape[0] % len(names):
        raise ValueError(f"its {shape[0]} slices are not in {len(names)} files of one size")
    shape, parts = [shape[0] // len(names), *shape[1:]], []
    for name in names:
        with paths.named_file(path, name).open("rb") as data:
            data.seek(max(skip, 0))
            parts.append(volumes.read_values(data, dtype, shape, encoding, -(skip == -1)))
    return parts[0] if len(parts) == 1 else np.concatenate(parts)


def _data_files(text, file):
    """Names of the files with values; None if they follow the header."""
    if text.upper() == "LOCAL":
        return None
    if text.split()[:1] == ["LIST"]:
        return [volumes.decoded(line).strip() for line in file.readlines() if line.strip()]
    pattern = re.fullmatch(r"([^%]*%\d{0,2}d[^%\s]*)\s+(\d+)\s+(\d+)(?:\s+(\d+))?", text)
    if pattern:
        first, last, step = int(pattern[2]), int(pattern[3]), int(pattern[4] or 1)
        indices = range(first, last + 1, max(step, 1))
        if len(indices) > _MAX_FILES:
            raise ValueError(
                f"its values must be in {_MAX_FILES} files at most, got {len(indices)}"
            )
        return [pattern[1] % index for index in indices]
    return [text]


def _is_true(text):
    return text[:1] in ("T", "t", "1")


def _format(numbers):
    return " ".join(repr(float(number)) for number in numbers)
