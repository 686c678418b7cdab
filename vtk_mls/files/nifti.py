"""NIfTI files, version 1 and 2, as nibabel reads them.

Space. The file's world is RAS; here it is LPS. Where the image lies says the sform if its code is
not 0, else the qform if its code is not 0, else the spacings alone, with the middle of the image
at the origin and x to the left. nibabel does the same; ITK takes the qform of many files that have
both, and a warning says so if the two lie apart. An image on the grid of its file is written with
the file's codes, sform and qform. On another grid the qform moves with the sform. Without a qform
in the file the sform is written as one if its axes are at right angles.

Units. Lengths are millimeters here, as in ITK, and are written in the unit of the file (meters,
millimeters or micrometers; a file without a unit has millimeters).

Values are those after the scaling, which counts if its slope is a number other than 0.

Components: colours (RGB24, RGBA32), and the fifth dimension. Displacements (intent 1006) are
vectors in RAS and are taken to LPS, as in ITK; those of another intent stay as they are, also as in
ITK.

Labels are integers with the intent 1002 (label) or 1003 (name of an anatomical structure).
"""

from __future__ import annotations

import contextlib

import numpy as np

from vtk_mls.base.messages import warn
from vtk_mls.files import frames, volumes
from vtk_mls.files.volumes import Volume

_RAS = frames.signs("RAS")
_SIZES = {1: 348, 2: 540}  # of the header, bytes
_FIELDS = {  # version: field: (type, offset)
    1: {
        "sizeof_hdr": ("i4", 0),
        "dim": ("8i2", 40),
        "intent_code": ("i2", 68),
        "datatype": ("i2", 70),
        "bitpix": ("i2", 72),
        "pixdim": ("8f4", 76),
        "vox_offset": ("f4", 108),
        "scl_slope": ("f4", 112),
        "scl_inter": ("f4", 116),
        "xyzt_units": ("u1", 123),
        "qform_code": ("i2", 252),
        "sform_code": ("i2", 254),
        "quatern": ("3f4", 256),
        "qoffset": ("3f4", 268),
        "srow": ("(3,4)f4", 280),
        "intent_name": ("S16", 328),
        "magic": ("S4", 344),
    },
    2: {
        "sizeof_hdr": ("i4", 0),
        "magic": ("S8", 4),
        "datatype": ("i2", 12),
        "bitpix": ("i2", 14),
        "dim": ("8i8", 16),
        "pixdim": ("8f8", 104),
        "vox_offset": ("i8", 168),
        "scl_slope": ("f8", 176),
        "scl_inter": ("f8", 184),
        "qform_code": ("i4", 344),
        "sform_code": ("i4", 348),
        "quatern": ("3f8", 352),
        "qoffset": ("3f8", 376),
        "srow": ("(3,4)f8", 400),
        "xyzt_units": ("i4", 500),
        "intent_code": ("i4", 504),
        "intent_name": ("S16", 508),
    },
}
_DTYPES = {  # by datatype
    **{2: "u1", 4: "i2", 8: "i4", 16: "f4", 64: "f8", 256: "i1", 512: "u2", 768: "u4"},
    **{1024: "i8", 1280: "u8"},
}
_COLOURS = {128: 3, 2304: 4}  # components, by datatype
_LABELS, _DISPLACEMENT, _VECTOR = (1002, 1003), 1006, 1007
_PLACE = ("qform_code", "sform_code", "pixdim", "quatern", "qoffset", "srow")
_KEPT = ("intent_code", "intent_name", "xyzt_units", "dim", *_PLACE)
_SCANNER, _MILLIMETERS = 1, 2
_SPATIAL_UNIT = 7  # mask of xyzt_units
_LENGTHS = {1: 1000.0, 3: 0.001}  # millimeters, by unit; others are taken for millimeters
_SHEAR = 1e-4  # the greatest that ITK takes for right angles
_APART = 0.01  # voxels between two places of a corner, from which on a warning says so
_MAGIC = {1: b"n+1\0", 2: b"n+2\0\r\n\x1a\n"}


def read(path):
    """Read a volume.

    Parameters
    ----------
    path : Path
        A .nii or .nii.gz file, or the .hdr of two files, whose .img is beside it.

    Returns
    -------
    Volume
        Its header has lines `field: value`.

    Raises
    ------
    OSError, ValueError
    """
    encoding = "gzip" if path.suffix.lower() == ".gz" else "raw"
    with contextlib.ExitStack() as stack:
        file = volumes.unpacked(stack.enter_context(path.open("rb")), encoding)
        header, used = _header(file)
        shape, dtype = _shape(path, header), _dtype(header)
        data, start = path, int(header["vox_offset"])
        if _is_pair(header, path):
            data, used = volumes.named_file(path, path.with_suffix(".img").name), 0
            file = stack.enter_context(data.open("rb"))
        volumes.skip(file, start - used)
        room = data.stat().st_size - (start if encoding == "raw" else 0)
        values = volumes.read_values(file, dtype, shape, max(room, 0), encoding)
    if int(header["datatype"]) not in _COLOURS:
        values = np.moveaxis(values, 0, -1) if len(values) > 1 else values[0]
    else:
        values = values[0]
    affine = _affine(header)
    _warn_if_itk_differs(path, header, affine)
    intent = int(header["intent_code"])
    scaled = _scaled(values, float(header["scl_slope"]), float(header["scl_inter"]))
    is_label = intent in _LABELS and scaled.dtype.kind in "iu"
    is_vector = intent == _DISPLACEMENT and scaled.shape[3:] == (3,) and scaled.dtype.kind == "f"
    if is_vector:
        scaled = scaled * _RAS.astype(scaled.dtype)
    return Volume(
        np.ascontiguousarray(scaled),
        _RAS * affine[:, 3],
        _RAS[:, None] * affine[:, :3],
        is_label=is_label,
        is_vector=is_vector,
        header=_kept(header),
    )


def write(path, volume):
    """Write a volume.

    Parameters
    ----------
    path : Path
        A .nii or .nii.gz file.
    volume : Volume
    """
    values = volume.values
    version = 1 if max(values.shape) < 1 << 15 else 2
    header = np.zeros((), _layout(version, "<"))
    header["sizeof_hdr"], header["magic"] = _SIZES[version], _MAGIC[version]
    header["vox_offset"] = _SIZES[version] + 4
    header["scl_slope"] = 1
    _say_values(header, volume)
    source = _source(volume.header)
    header["intent_name"], header["xyzt_units"] = source["intent_name"], source["xyzt_units"]
    if not header["xyzt_units"] & _SPATIAL_UNIT:
        header["xyzt_units"] |= _MILLIMETERS
    _place(header, source, _RAS[:, None] * np.column_stack([volume.steps, volume.origin]))
    is_colour = int(header["datatype"]) in _COLOURS
    if values.ndim == 4 and not is_colour:
        signs = _RAS.astype(values.dtype) if header["intent_code"] == _DISPLACEMENT else 1
        values = np.moveaxis(values * signs, -1, 0)
    with contextlib.ExitStack() as stack:
        file = stack.enter_context(path.open("wb"))
        if path.suffix.lower() == ".gz":
            file = stack.enter_context(volumes.packing(file))
        file.write(header.tobytes() + bytes(4))
        volumes.write_values(file, values)


def place_lines(lines):
    """Those of a `Volume`'s lines that say where it is."""
    names = ("xyzt_units", "dim", *_PLACE)
    return tuple(line for line in lines if line.partition(": ")[0] in names)


def in_millimeters(lines):
    """A `Volume`'s lines that say where it is, for a file in millimeters."""
    source = _source(lines)
    _convert_lengths(source, _length(source))
    source["xyzt_units"] = source["xyzt_units"] & ~_SPATIAL_UNIT | _MILLIMETERS
    return place_lines(_kept(source))


def _layout(version, order):
    names, fields = zip(*_FIELDS[version].items())
    formats = [np.dtype(kind).newbyteorder(order) for kind, _ in fields]
    return np.dtype(
        {
            "names": names,
            "formats": formats,
            "offsets": [offset for _, offset in fields],
            "itemsize": _SIZES[version],
        }
    )


def _header(file):
    """The header, and how many bytes have been read."""
    start = file.read(4)
    for version, size in _SIZES.items():
        for order in "<>":
            if start == np.array(size, f"{order}i4").tobytes():
                content = start + file.read(size - 4)
                if len(content) < size:
                    raise ValueError(f"its header must have {size} bytes, got {len(content)}")
                return np.frombuffer(content, _layout(version, order))[0], size
    raise ValueError("it is no NIfTI file: it does not begin with the size of such a header")


def _is_pair(header, path):
    """Whether the values are in a file of their own."""
    magic, is_header = bytes(header["magic"][:3]), path.suffix.lower() == ".hdr"
    if magic not in (b"n+1", b"n+2", b"ni1", b"ni2"):
        raise ValueError("it is no NIfTI file: Analyze 7.5 does not say where left and right are")
    if is_header != magic.startswith(b"ni"):
        raise ValueError("of NIfTI in two files give the one whose name ends in .hdr")
    return is_header


def _shape(path, header):
    """Shape of the values in the file, the slowest axis first: (components, nz, ny, nx)."""
    count, *dimensions = header["dim"].tolist()
    if not 1 <= count <= 7 or min(dimensions[:count]) < 1:
        raise ValueError(
            f"its dimensions must be 1 to 7 positive numbers, got {dimensions[:count]}"
        )
    nx, ny, nz, times, components, *others = dimensions[:count] + [1] * (7 - count)
    if times > 1:
        raise ValueError(f"`{path}` is a series of {times} volumes; give one volume")
    colours = _COLOURS.get(int(header["datatype"]))
    if others != [1, 1] or (colours and components > 1):
        raise ValueError(f"it has more than one axis of components, got {dimensions[:count]}")
    return (1, nz, ny, nx, colours) if colours else (components, nz, ny, nx)


def _dtype(header):
    code = int(header["datatype"])
    if code not in _DTYPES and code not in _COLOURS:
        raise ValueError(f"values of the datatype {code} are not known")
    return np.dtype(_DTYPES.get(code, "u1")).newbyteorder(header.dtype["dim"].base.byteorder)


def _length(header):
    """Millimeters in the header's unit of length."""
    return _LENGTHS.get(int(header["xyzt_units"]) & _SPATIAL_UNIT, 1.0)


def _affine(header):
    """(3, 4) matrix from indices to RAS, in millimeters."""
    if header["sform_code"] != 0:
        return _sform(header)
    if header["qform_code"] != 0:
        return _qform(header)
    spacing = _spacing(header) * [-1, 1, 1]
    first = -(header["dim"][1:4].clip(1) - 1) / 2 * spacing
    return np.column_stack([np.diag(spacing), first])


def _spacing(header):
    return np.abs(header["pixdim"][1:4]).astype(float) * _length(header)


def _sform(header):
    affine = header["srow"].astype(float) * _length(header)
    affine[:, :3] = volumes.full_steps(affine[:, :3], header["dim"][1:4])
    return affine


def _qform(header):
    b, c, d = header["quatern"].astype(float).tolist()
    rest = 1 - b * b - c * c - d * d
    if not rest > -1e-6:
        raise ValueError(f"the quaternion of its qform must have length 1, got {[b, c, d]}")
    a = max(rest, 0.0) ** 0.5
    rotation = np.array(
        [
            [a * a + b * b - c * c - d * d, 2 * (b * c - a * d), 2 * (b * d + a * c)],
            [2 * (b * c + a * d), a * a + c * c - b * b - d * d, 2 * (c * d - a * b)],
            [2 * (b * d - a * c), 2 * (c * d + a * b), a * a + d * d - b * b - c * c],
        ]
    )
    handed = -1 if header["pixdim"][0] == -1 else 1
    steps = rotation * [1, 1, handed] * _spacing(header)
    steps = volumes.full_steps(steps, header["dim"][1:4])
    return np.column_stack([steps, header["qoffset"].astype(float) * _length(header)])


def _qform_of(header):
    """The qform of a header; None without one, or if it is broken."""
    if header["qform_code"] != 0:
        with contextlib.suppress(ValueError):
            return _qform(header)
    return None


def _has_right_angles(affine, tolerance):
    directions = affine[:, :3] / np.linalg.norm(affine[:, :3], axis=0)
    return np.allclose(directions.T @ directions, np.eye(3), rtol=0, atol=tolerance)


def _itk_affine(header):
    """(3, 4) matrix to RAS by which ITK places the image; None if it refuses to."""
    has_sform, has_qform = header["sform_code"] != 0, header["qform_code"] != 0
    if not has_sform and not has_qform:
        return np.column_stack([np.diag(_spacing(header) * _RAS), np.zeros(3)])
    is_preferred = header["sform_code"] == _SCANNER or not has_qform
    if has_sform and is_preferred and _has_right_angles(_sform(header), _SHEAR):
        return _sform(header)
    return _qform(header) if has_qform else None


def _warn_if_itk_differs(path, header, affine):
    """Say it if ITK places the image elsewhere than here."""
    try:
        other = _itk_affine(header)
    except ValueError:  # a broken qform, which does not count here
        return
    if other is None:
        return
    ends = np.array([*np.ndindex(2, 2, 2)]) * (header["dim"][1:4].clip(1) - 1)
    shifts = np.linalg.norm((affine - other) @ np.column_stack([ends, np.ones(8)]).T, axis=0)
    if shifts.max() <= _APART * np.linalg.norm(affine[:, :3], axis=0).min():
        return
    if header["sform_code"] != 0:
        reason = "its sform counts here, as in nibabel, but ITK (SimpleITK, ANTs) takes its qform"
    else:
        reason = (
            "its header says no place, and its middle is at the origin here, as in nibabel, but "
            "ITK (SimpleITK, ANTs) has its first voxel there"
        )
    warn(
        f"`{path}`: {reason}: the two lie up to {shifts.max():.3g} mm apart, and programs will not "
        "agree about the result either; give both forms the same place"
    )


def _place(header, source, affine):
    """Set the fields that say where an image is.

    Parameters
    ----------
    header : record
        Its `dim` and `xyzt_units` are set.
    source : record
        What the image's file said, if it has one.
    affine : (3, 4) array
        From indices to RAS, in millimeters.
    """
    header["pixdim"][0] = 1
    header["pixdim"][4:] = source["pixdim"][4:]
    is_placed = source["dim"][0] > 0
    old = _affine(source) if is_placed else affine
    is_centered = is_placed and not source["sform_code"] and not source["qform_code"]
    is_same_size = np.array_equal(source["dim"][1:4].clip(1), header["dim"][1:4])
    if is_placed and _is_close(old, affine) and (is_same_size or not is_centered):
        for name in _PLACE:
            header[name] = source[name]
        _convert_lengths(header, _length(source) / _length(header))
        return
    code = source["sform_code"] or source["qform_code"] or _SCANNER
    header["sform_code"], header["srow"] = code, affine / _length(header)
    header["pixdim"][1:4] = np.linalg.norm(affine[:, :3], axis=0) / _length(header)
    qform, placed = affine, _qform_of(source)
    if placed is not None:
        code = source["qform_code"]
        moved = np.vstack([affine, [0, 0, 0, 1]])
        qform = placed @ np.linalg.solve(np.vstack([old, [0, 0, 0, 1]]), moved)
    if _has_right_angles(qform, 1e-6):
        _set_qform(header, code, qform)


def _is_close(affine, other):
    """Whether two affines are the same but for rounding."""
    size = np.abs(affine).max()
    return np.allclose(affine, other, rtol=0, atol=1e-9 * size)


def _convert_lengths(header, factor):
    """Multiply the lengths in a header."""
    if factor != 1:
        for lengths in (header["pixdim"][1:4], header["qoffset"], header["srow"]):
            lengths *= factor


def _set_qform(header, code, affine):
    spacing = np.linalg.norm(affine[:, :3], axis=0)
    rotation = affine[:, :3] / spacing
    handed = np.sign(np.linalg.det(rotation))
    header["qform_code"], header["pixdim"][0] = code, handed
    header["pixdim"][1:4] = spacing / _length(header)
    header["quatern"] = _quaternion(rotation * [1, 1, handed])
    header["qoffset"] = affine[:, 3] / _length(header)


def _quaternion(rotation):
    """b, c and d of the quaternion, whose a is not negative, of a rotation matrix."""
    (xx, xy, xz), (yx, yy, yz), (zx, zy, zz) = rotation
    matrix = [
        [xx - yy - zz, yx + xy, zx + xz, zy - yz],
        [yx + xy, yy - xx - zz, zy + yz, xz - zx],
        [zx + xz, zy + yz, zz - xx - yy, yx - xy],
        [zy - yz, xz - zx, yx - xy, xx + yy + zz],
    ]
    *bcd, a = np.linalg.eigh(matrix)[1][:, -1]
    return np.array(bcd) * (-1 if a < 0 else 1)


def _scaled(values, slope, intercept):
    """Values after the scaling, as floats that hold them if there is any."""
    if slope == 0 or not np.isfinite(slope) or (slope == 1 and intercept == 0):
        return values
    if not np.isfinite(intercept):
        raise ValueError(f"its scaling must be finite, got {slope} and {intercept}")
    is_small = values.dtype.itemsize < 4 or values.dtype == np.float32
    scaled = np.empty(values.shape, np.float32 if is_small else np.float64)
    with np.errstate(over="ignore"):
        for raw, new in zip(values, scaled):  # slices: all in float64 can be too much
            new[...] = raw * slope + intercept
    return scaled


def _kept(header):
    """Lines for a file that is to be like this one."""
    lines = {name: " ".join(map(str, np.ravel(header[name]).tolist())) for name in _KEPT}
    lines["intent_name"] = bytes(header["intent_name"]).decode("latin-1")
    return tuple(f"{name}: {line}" for name, line in lines.items() if line)


def _source(lines):
    """The header, as of `_header`, of which `_kept` has made lines; zeros for what they lack."""
    header = np.zeros((), _layout(2, "<"))
    header["xyzt_units"], header["pixdim"] = _MILLIMETERS, 1
    for name, text in (line.split(": ", 1) for line in lines if ": " in line):
        if name == "intent_name":
            header[name] = text.encode("latin-1", "replace")[:16]
        elif name in _KEPT:
            field = header[name]
            numbers = np.array(text.split(), field.dtype)
            header[name] = numbers.reshape(field.shape)
    return header


def _say_values(header, volume):
    """Set what a header says of the values."""
    values, dimensions = volume.values, volume.values.shape[2::-1]
    components = values.shape[3] if values.ndim == 4 else 1
    codes = {name: code for code, name in _DTYPES.items()}
    code, bits = codes[values.dtype.str[1:]], 8 * values.dtype.itemsize
    if values.dtype == np.uint8 and components in _COLOURS.values() and not volume.is_label:
        code = {count: code for code, count in _COLOURS.items()}[components]
        bits, components = 8 * components, 1
    header["datatype"], header["bitpix"] = code, bits
    header["dim"] = (5 if components > 1 else 3, *dimensions, 1, components, 1, 1)
    header["intent_code"] = _intent(volume, components)


def _intent(volume, components):
    """What a file is to say that its values are: what it said before if that is still so."""
    kept = dict(line.split(": ", 1) for line in volume.header if ": " in line)
    intent = int(kept.get("intent_code", 0))
    if volume.is_label:
        return intent if intent in _LABELS else _LABELS[0]
    if components > 1:
        is_displacement = intent == _DISPLACEMENT and components == 3
        return _DISPLACEMENT if is_displacement else _VECTOR
    return 0 if intent in (*_LABELS, _DISPLACEMENT, _VECTOR) else intent
