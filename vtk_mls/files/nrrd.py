"""NRRD files: volumes, and the segmentations of 3D Slicer (.seg.nrrd).

pynrrd does not read all that ITK writes or reads: not hex, skips, types and byte orders in capitals
or by their other names. It also allocates what the header claims, so this module does without it.

Frame. `space` can be any of the specification, in words or letters of any case. Those of a patient
(left-posterior-superior, LPS and the other seven) become LPS. scanner-xyz, 3D-right-handed,
3D-left-handed and a file without a space are read unchanged. Files are written in the space that
they came from.

Vectors. Arrays of a vector kind (vector, covariant-vector, 3-vector, 3-gradient, 3-normal) are
turned with the space if there is a `measurement frame`, for only that says what their components
mean. They are written in LPS with the identity as measurement frame, so that ITK, which ignores it,
reads the same vectors. Without a measurement frame they are not turned, as in ITK. Colors, lists
and other kinds are never turned; their measurement frame (of the gradients of diffusion-weighted
images) is written again.

Labels. A file has labels if its name ends in .seg.nrrd or .seg.nhdr, if it names segments, or if it
has `intent_code:=1002`, as files that ITK converts from NIfTI labels do.
"""

import contextlib
import re
from dataclasses import replace

import numpy as np

from vtk_mls.base.errors import InputError
from vtk_mls.files import frames, nrrd_axes, paths, volumes
from vtk_mls.files.volumes import NANOMETERS, Series, Volume, from_seconds, in_seconds, symbol

_TWO_WORDS = (  # fields that count here
    *("axis mins", "space directions", "line skip", "byte skip", "space units", "space origin"),
    *("measurement frame", "data file"),
)
_ALIASES = {**{name.replace(" ", ""): name for name in _TWO_WORDS}, "centerings": "centers"}
_UNCHANGED_SPACES = ("", "scanner-xyz", "3d-right-handed", "3d-left-handed")
_VECTORS = ("vector", "covariant-vector", "3-vector", "3-gradient", "3-normal")
_COPIED = ("content", "space units", "measurement frame")
_LABEL_INTENT = "intent_code:=1002"
_MAX_LINE = 1 << 20  # bytes
_LPS = "left-posterior-superior"
_TYPES = {
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
_DTYPES = {name: dtype for dtype, names in _TYPES.items() for name in names}
_ORDERS = {"little": "<", "big": ">"}
_ENCODINGS = {
    **dict.fromkeys(("txt", "text", "ascii"), "text"),
    "hex": "hex",
    **{"raw": "raw", "gz": "gzip", "gzip": "gzip", "bz2": "bzip2", "bzip2": "bzip2"},
}


def open_file(path):
    """The `Series` of a .nrrd file, or of a .nhdr header with its data in one other file of its
    folder. Headers of its volumes have key/value pairs and some fields. Errors are ValueErrors that
    name the file.
    """
    with _failures_named(), path.open("rb") as file:
        fields, pairs = _header(file)
        sizes = _sizes(fields)
        values = _values(fields, file, path, sizes)
        axes = nrrd_axes.read(fields, len(sizes))
        time = nrrd_axes.time_of(axes, fields)
        if time is None:
            times, time_unit, in_time = (), "", [values]
        else:
            index, *numbers = time
            unit = _time_unit(fields, index, len(sizes))
            (start, step), time_unit = in_seconds(unit, *numbers)
            times = tuple(float(start + step * n) for n in range(sizes[index]))
            in_time = np.moveaxis(values, len(sizes) - 1 - index, 0)
            del axes[index]

    def read_volume(index):
        with _failures_named():
            volume = _volume(path, fields, pairs, axes, in_time[index])
            return replace(volume, time_unit=time_unit)

    return Series(times, read_volume)


@contextlib.contextmanager
def _failures_named():
    try:
        yield
    except KeyError as error:
        raise InputError(f"is not a NRRD volume: it has no field {error}") from None
    except (EOFError, OSError, OverflowError, ValueError) as error:
        raise InputError(f"is not a readable NRRD volume: {error!s:.160}") from None


def _time_unit(fields, index, count):
    """The unit of time, which becomes the last of four `space units`."""
    units = re.findall(r'"[^"]*"', fields.get("units", ""))
    spatial = re.findall(r'"[^"]*"', fields.get("space units", ""))
    if len(spatial) != 4 and len(units) == count:
        if len(spatial) != 3:
            lengths = [unit for unit in np.delete(units, index) if unit != '""']
            spatial = lengths if len(lengths) == 3 else ['""'] * 3
        spatial = [*spatial, units[index]]
        fields["space units"] = " ".join(spatial)
    return spatial[3].strip('"') if len(spatial) == 4 else ""


def _volume(path, fields, pairs, axes, values):
    """The `Volume` of the values (slowest axis first) of a file; `axes` are those but time."""
    signs = _signs(fields.get("space", ""))
    origin, steps, axis = nrrd_axes.geometry(axes, fields)
    kind = "" if axis is None else axes[axis].kind
    kind = "" if kind.lower() in nrrd_axes.NOT_COMPONENTS else kind
    frame = _measurement_frame(fields)
    copied = {name: fields[name] for name in _COPIED if name in fields}
    if axis is not None:
        values = np.moveaxis(values, values.ndim - 1 - axis, -1)
    if values.ndim - (axis is not None) == 2:
        copied.pop("space units", None)  # of two axes
        values = values[None]
    if kind:
        copied["kinds"] = kind
    is_vector = (
        frame is not None
        and kind.lower() in _VECTORS
        and values.shape[3:] == (3,)
        and values.dtype.kind == "f"
    )
    if is_vector:
        values = (values @ (frame * signs)).astype(values.dtype)
        del copied["measurement frame"]
    units = re.findall(r'"([^"]*)"', copied.get("space units", ""))[:3]
    unit = symbol(units[0]) if len({*units}) == 1 else ""  # the same along all axes
    return Volume(
        np.ascontiguousarray(values),
        origin * signs,
        steps * signs[:, None],
        is_label=_is_segmentation(path) or _state_labels(pairs),
        is_vector=is_vector,
        space=fields.get("space", ""),
        header=(*(f"{name}: {value}" for name, value in copied.items()), *pairs),
        unit=unit if unit in NANOMETERS else "",
    )


def write(path, series, times):
    """Write a list of `Volume` to a .nrrd file, or to a .nhdr header and a .raw.gz file in its
    folder.

    With `times` they are written in LPS. One volume without a time keeps its space if NRRD has it,
    and is written in LPS otherwise.
    """
    content = _text(path, series[0], (*volumes.steps_of(times), len(times)) if times else None)
    if path.suffix.lower() == ".nhdr":
        path.write_bytes(content)
        path, content = path.with_name(f"{path.stem}.raw.gz"), b""
    with path.open("wb") as file:
        file.write(content)
        with volumes.packing(file) as packed:
            for volume in series:
                volumes.write_values(packed, volume.values)


def _text(path, volume, time_axis):
    """The header of a file; `time_axis` is the first time, the step and the count, or None.

    A time axis is written as by ITK: with `space dimension: 4`, which has no names of frames, in
    LPS.
    """
    if _is_segmentation(path) and volume.values.dtype.kind not in "iu":
        raise InputError(
            f"is for labels, which are integers, got {volume.values.dtype}; write .nrrd"
        )
    space, signs = _space_for(volume)
    copied = dict(line.split(": ", 1) for line in volume.header if _is_field(line))
    values, kinds = volume.values, ["domain"] * 3
    sizes = [*values.shape[3:], *values.shape[2::-1]]
    if volume.unit and "space units" not in copied:
        copied["space units"] = " ".join([f'"{volume.unit}"'] * 3)
    units = re.findall(r'"[^"]*"', copied.get("space units", ""))
    if time_axis is None:
        frame = {"space": space}
        steps, origin = (volume.steps * signs[:, None]).T, volume.origin * signs
        if volume.is_vector:
            copied["measurement frame"] = "(1,0,0) (0,1,0) (0,0,1)"
        if len(units) > 3:
            del copied["space units"]  # of a file with times
    else:
        start, step, count = time_axis
        unit = "".join(units[3:]).strip('"') or volume.time_unit
        start, step = from_seconds(unit, start, step)
        if unit or units:
            copied["space units"] = " ".join([*(units or ['""'] * 3)[:3], f'"{unit}"'])
        frame = {"space dimension": 4}
        steps, origin = np.zeros((4, 4)), [*volume.origin, start]
        steps[:3, :3], steps[3, 3] = volume.steps.T, step
        kinds, sizes = [*kinds, "time"], [*sizes, count]
        copied.pop("measurement frame", None)
    directions = list(map(_format, steps))
    if values.ndim == 4:
        kinds = [_kind(volume, copied.get("kinds", "")), *kinds]
        directions = ["none", *directions]
    fields = {
        "type": _TYPES[values.dtype.str[1:]][0],
        "dimension": len(sizes),
        **frame,
        "sizes": " ".join(map(str, sizes)),
        "space directions": " ".join(directions),
        **{name: copied[name] for name in _COPIED if name in copied},
        "kinds": " ".join(kinds),
        "endian": "little",
        "encoding": "gzip",
        "space origin": _format(origin),
    }
    if path.suffix.lower() == ".nhdr":
        fields["data file"] = f"{path.stem}.raw.gz"
    lines = [f"{name}: {value}" for name, value in fields.items()] + _pairs(volume)
    lines = [line.replace("\n", "\\n").replace("\r", "") for line in lines]
    return "\n".join(["NRRD0005", *lines, "", ""]).encode()


def _is_segmentation(path):
    return path.name.lower().endswith((".seg.nrrd", ".seg.nhdr"))


def _header(file):
    """Fields as a dictionary, and the lines of key/value pairs."""
    if file.read(4) != b"NRRD":
        raise ValueError("it does not begin with NRRD")
    fields, pairs = {}, []
    file.readline(_MAX_LINE)
    while line := file.readline(_MAX_LINE).rstrip(b"\r\n"):
        text = volumes.decoded(line)
        if text.startswith("#"):
            continue
        if _is_field(text):
            key, _, value = text.partition(": ")
            key = key.strip().lower()
            fields[_ALIASES.get(key, key)] = value.strip()
        elif ":=" in text:
            pairs.append(text)
    return fields, pairs


def _is_field(line):
    """Whether a line is `field: value`; otherwise it is `key:=value`."""
    return ": " in line.partition(":=")[0]


def _signs(space):
    """Factors between a space of NRRD and LPS."""
    if space.lower() in _UNCHANGED_SPACES:
        return np.ones(3)
    try:
        return frames.signs(space)
    except ValueError:
        raise ValueError(f"its space `{space:.60}` is not one of three dimensions") from None


def _sizes(fields):
    sizes = [int(size) for size in fields["sizes"].split()]
    if min(sizes, default=0) < 1:
        raise ValueError(f"its sizes must be positive, got `{fields['sizes']:.60}`")
    count = int(fields.get("dimension", len(sizes)))
    if count != len(sizes):
        raise ValueError(f"it must have as many sizes as dimensions, {count}, got {len(sizes)}")
    return sizes


def _values(fields, file, path, sizes):
    """The values, slowest axis first, from the file of the header or from the one that it names."""
    dtype, encoding = _storage(fields)
    skip = int(fields.get("byte skip", 0))
    if skip < -1 or (skip == -1 and encoding != "raw"):
        raise ValueError(f"byte skip {skip} must not be negative here")
    with contextlib.ExitStack() as stack:
        if "data file" in fields:
            name = fields["data file"]
            if name.split()[:1] == ["LIST"] or re.search(r"%\d*d.* ", name):
                raise ValueError("its values are in several files; give one file")
            file = stack.enter_context(paths.named_file(path, name).open("rb"))
        for _ in range(max(int(fields.get("line skip", 0)), 0)):
            if not file.readline():
                break
        return volumes.read_values(file, dtype, sizes[::-1], encoding, skip)


def _storage(fields):
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


def _measurement_frame(fields):
    """(3, 3); row i is the direction of component i in space. None without the field."""
    if "measurement frame" not in fields:
        return None
    texts = re.findall(r"\([^)]*\)", fields["measurement frame"])
    rows = [nrrd_axes.vector(text) for text in texts]
    if [row.shape for row in rows] != [(3,)] * 3:
        raise ValueError("its measurement frame must be three vectors of three numbers")
    return np.array(rows)


def _space_for(volume):
    """The space to write, and its signs. Vectors are written in LPS (see above)."""
    with contextlib.suppress(ValueError):
        signs = _signs(volume.space)
        if volume.space and not (volume.is_vector and (signs < 0).any()):
            return volume.space, signs
    return _LPS, np.ones(3)


def _state_labels(pairs):
    return any(line == _LABEL_INTENT or re.match(r"Segment\d+_ID:=", line) for line in pairs)


def _pairs(volume):
    """Key/value pairs. Those about labels are left out of other volumes; the extent of each segment
    becomes that of the volume.
    """
    lines = [line for line in volume.header if ":=" in line and not _is_field(line)]
    if not volume.is_label:
        about_labels = re.compile(r"Segment\w*_\w+:=")
        return [line for line in lines if line != _LABEL_INTENT and not about_labels.match(line)]
    extent = " ".join(f"0 {n - 1}" for n in volume.values.shape[2::-1])
    lines = [re.sub(r"^(Segment\d+_Extent):=.*", rf"\1:={extent}", line) for line in lines]
    return lines if _state_labels(lines) else [*lines, _LABEL_INTENT]


def _kind(volume, source_kind):
    """The kind of the axis of components, given that of the source file."""
    if volume.is_vector:
        return source_kind if source_kind.lower() in _VECTORS else "vector"
    if source_kind:
        return source_kind
    is_color = volume.values.dtype == np.uint8 and not volume.is_label
    names = {3: "RGB-color", 4: "RGBA-color"} if is_color else {}
    return names.get(volume.values.shape[3], "list")


def _format(vector):
    return f"({','.join(repr(float(number)) for number in vector)})"
