"""NIfTI files, version 1 and 2. nibabel knows their headers.

Frame. The file's coordinates are RAS; here they are LPS. The sform places the image if its code is
not 0, else the qform if its code is not 0. Otherwise the spacing counts alone, with the middle of
the image at the origin and x to the left. nibabel does the same. ITK prefers the qform in many
files that have both, so a warning is given if the two forms differ. An image on the grid of its
file is written with the file's codes, sform and qform. On another grid the qform moves with the
sform. If the file has no qform, the sform is also written as the qform, if its axes are orthogonal.

Units. Lengths are millimeters here, as in ITK, and are written in the unit of the file (meters,
millimeters or micrometers). A file without a unit is in millimeters. Times are seconds here if the
file has a unit of time, and are written in the unit of the file, or else in seconds if their unit
is known.

Values are scaled if the slope is a finite number other than 0.

Components are colors (RGB24, RGBA32) or the fifth dimension. Displacements (intent 1006) are
vectors in RAS and become LPS, as in ITK. Vectors of another intent are not turned, also as in ITK.

Labels are integers with the intent 1002 (label) or 1003 (name of an anatomical structure).

The values are read by `volumes` because nibabel allocates what the header claims before it looks
at the size of a compressed file, and does not check the checksum of gzip.
"""

import contextlib

import numpy as np

from vtk_mls.base.messages import warn
from vtk_mls.files import frames, paths, volumes
from vtk_mls.files.volumes import Series, Volume

TO_RAS = frames.signs("RAS")  # and back
_COLORS = {n: np.dtype([(name, "u1") for name in "RGBA"[:n]]) for n in (3, 4)}
_LABELS, _DISPLACEMENT, _VECTOR = (1002, 1003), 1006, 1007  # intents
_GEOMETRY = {  # lines that a `Volume` keeps: the header's fields
    **{name: (name,) for name in ("dim", "qform_code", "sform_code", "pixdim")},
    "quatern": ("quatern_b", "quatern_c", "quatern_d"),
    "qoffset": ("qoffset_x", "qoffset_y", "qoffset_z"),
    "srow": ("srow_x", "srow_y", "srow_z"),
}
_LINES = {name: (name,) for name in ("intent_code", "intent_name", "xyzt_units", "toffset")}
_LINES |= {"intent_p": ("intent_p1", "intent_p2", "intent_p3"), **_GEOMETRY}
_SCANNER, _MILLIMETERS, _MICROMETERS = 1, 2, 3
_SPATIAL_UNIT, _TIME_UNIT = 7, 56  # masks of xyzt_units
_TIME_UNITS = {8: "s", 16: "ms", 24: "us", 32: "Hz", 40: "ppm", 48: "rad/s"}
_LENGTHS = {1: 1000.0, 3: 0.001}  # millimeters per unit; other codes mean millimeters
_MAX_SHEAR = 1e-4  # axes closer to orthogonal than this are orthogonal for ITK
_MAX_SHIFT = 0.01  # voxels between two placements of a vertex without a warning
_MAX_HEADER = 540  # bytes, of version 2
_QUATERNION_ERROR = 1e-6  # rounding of its squared length


def open_file(path):
    """The `Series` of a .nii or .nii.gz file, or of the .hdr of two files, whose .img is in the
    same folder. Headers of its volumes have lines `field: value`.
    """
    encoding = "gzip" if path.suffix.lower() == ".gz" else "raw"
    with path.open("rb") as file, volumes.unpacked(file, encoding, _MAX_HEADER) as start:
        header = _read_header(start)
    shape = _shape(header)
    data = paths.named_file(path, path.with_suffix(".img").name) if _is_pair(header, path) else path
    with data.open("rb") as file:
        skip = max(int(header["vox_offset"]), 0)
        values = volumes.read_values(file, _dtype(header), shape, encoding, skip)
    affine = _affine(header)
    _warn_if_itk_differs(path, header, affine)
    values = np.moveaxis(values, 0, -1) if len(values) > 1 else values[0]
    times = _times(header) if shape[1] > 1 else ()
    return Series(times, lambda index: _volume(header, affine, values[index]))


def _volume(header, affine, values):
    if values.dtype.names:
        values = values.view(np.uint8).reshape(*values.shape, len(values.dtype))
    intent = int(header["intent_code"])
    values = _scaled(values, float(header["scl_slope"]), float(header["scl_inter"]))
    is_label = intent in _LABELS and values.dtype.kind in "iu"
    is_vector = intent == _DISPLACEMENT and values.shape[3:] == (3,) and values.dtype.kind == "f"
    if is_vector:
        values = values * TO_RAS.astype(values.dtype)
    return Volume(
        np.ascontiguousarray(values),
        TO_RAS * affine[:, 3],
        TO_RAS[:, None] * affine[:, :3],
        is_label=is_label,
        is_vector=is_vector,
        header=_to_lines(header),
        time_unit=_in_seconds(header)[1] * bool(header["dim"][4] > 1),
    )


def write(path, series, times):
    """Write a list of `Volume` to a .nii or .nii.gz file; `times` are () for one without."""
    header, values = _header_of(series[0], times or (0.0,)), [volume.values for volume in series]
    if header["dim"][0] == 5:  # all times of one component, then those of the next
        if header["intent_code"] == _DISPLACEMENT:
            values = [array * TO_RAS.astype(array.dtype) for array in values]
        values = [array[..., n] for n in range(values[0].shape[3]) for array in values]
    with contextlib.ExitStack() as stack:
        file = stack.enter_context(path.open("wb"))
        if path.suffix.lower() == ".gz":
            file = stack.enter_context(volumes.packing(file))
        file.write(header.binaryblock + bytes(4))  # no extensions
        for array in values:
            volumes.write_values(file, array)


def _header_of(volume, times):
    source, count = _from_lines(volume.header), len(times)
    version = 1 if max(*volume.values.shape, count) < 1 << 15 else 2
    header = _header_types()[version](endianness="<")
    header["vox_offset"] = header.sizeof_hdr + 4
    _describe_values(header, volume, count, int(source["intent_code"]))
    for name in ("intent_name", *_LINES["intent_p"], "xyzt_units"):
        header[name] = source[name]
    if not header["xyzt_units"] & _SPATIAL_UNIT:
        header["xyzt_units"] |= _MILLIMETERS
    millimeters = volumes.NANOMETERS.get(volume.unit, 1e6) / 1e6
    if millimeters <= 1e-3:
        header["xyzt_units"] = header["xyzt_units"] & _TIME_UNIT | _MICROMETERS
    affine = np.column_stack([volume.steps, volume.origin]) * millimeters
    _place(header, source, TO_RAS[:, None] * affine)
    header["toffset"] = source["toffset"]
    if count > 1 and times != _times(source):  # times of another file
        codes = {name: code for code, name in _TIME_UNITS.items()}
        unit = _time_unit(header) or volume.time_unit
        header["xyzt_units"] = header["xyzt_units"] & _SPATIAL_UNIT | codes.get(unit, 0)
        times = volumes.from_seconds(unit, *volumes.steps_of(times))
        header["toffset"], header["pixdim"][4] = times
    return header


def _times(header):
    """The times of the volumes of a file; without a step they are counted."""
    (start, step), _ = _in_seconds(header)
    return tuple(start + step * index for index in range(max(int(header["dim"][4]), 1)))


def _in_seconds(header):
    """First time and time step, in seconds if the header has a unit of time, and their unit."""
    start, step = (float(str(number)) for number in (header["toffset"], header["pixdim"][4]))
    step = step if np.isfinite(step) and step > 0 else 1.0
    return volumes.in_seconds(_time_unit(header), start, step)


def _time_unit(header):
    return _TIME_UNITS.get(int(header["xyzt_units"]) & _TIME_UNIT, "")


def geometry_lines(lines):
    """The lines of a `Volume`'s header that place the image."""
    names = ("xyzt_units", *_GEOMETRY)
    return tuple(line for line in lines if line.partition(": ")[0] in names)


def in_millimeters(lines):
    """The lines that place the image, converted to millimeters."""
    source = _from_lines(lines)
    _scale_lengths(source, _unit_length(source))
    source["xyzt_units"] = source["xyzt_units"] & ~_SPATIAL_UNIT | _MILLIMETERS
    return geometry_lines(_to_lines(source))


def _header_types():
    """nibabel's headers, by version."""
    try:
        import nibabel
    except ImportError:
        raise ValueError(
            "NIfTI needs the package nibabel: pip install nibabel; in ParaView, "
            "`vtk-mls paraview --setup`, or apt install python3-nibabel"
        ) from None
    return {1: nibabel.Nifti1Header, 2: nibabel.Nifti2Header}


def _read_header(file):
    start = file.read(4)
    for header_type in _header_types().values():
        size = header_type.sizeof_hdr
        for order in "<>":
            if start == np.array(size, f"{order}i4").tobytes():
                content = start + file.read(size - 4)
                if len(content) < size:
                    raise ValueError(f"its header must have {size} bytes, got {len(content)}")
                return header_type(content, order, check=False)
    raise ValueError("it is not a NIfTI file: it does not begin with the size of such a header")


def _is_pair(header, path):
    """Whether the values are in a second file."""
    magic, is_header = header["magic"].item()[:3], path.suffix.lower() == ".hdr"
    if magic not in (b"n+1", b"n+2", b"ni1", b"ni2"):
        raise ValueError(
            "it is not a NIfTI file: Analyze 7.5 does not say where left and right are"
        )
    if is_header != magic.startswith(b"ni"):
        raise ValueError("of NIfTI in two files, give the one whose name ends in .hdr")
    return is_header


def _shape(header):
    """Shape of the values in the file, slowest axis first: (components, times, nz, ny, nx)."""
    count, *dimensions = header["dim"].tolist()
    if not 1 <= count <= 7 or min(dimensions[:count]) < 1:
        raise ValueError(
            f"its dimensions must be 1 to 7 positive numbers, got {dimensions[:count]}"
        )
    nx, ny, nz, times, components, *others = dimensions[:count] + [1] * (7 - count)
    if others != [1, 1] or (components > 1 and _dtype(header).names):
        raise ValueError(f"it has more than one axis of components, got {dimensions[:count]}")
    return components, times, nz, ny, nx


def _dtype(header):
    """Type of the values, with the file's byte order; structured for colors."""
    from nibabel.spatialimages import HeaderDataError

    with contextlib.suppress(HeaderDataError, KeyError):
        dtype = header.get_data_dtype()
        if (dtype.kind in "iuf" and dtype.itemsize <= 8) or dtype in _COLORS.values():
            return dtype
    raise ValueError(f"values of the datatype {int(header['datatype'])} are not supported")


def _unit_length(header):
    """Millimeters in the header's unit of length."""
    return _LENGTHS.get(int(header["xyzt_units"]) & _SPATIAL_UNIT, 1.0)


def _affine(header):
    """(3, 4) matrix from indices to RAS, in millimeters."""
    if header["sform_code"] != 0:
        return _in_millimeters(header, header.get_sform())
    if header["qform_code"] != 0:
        return _qform(header)
    spacing = _spacing(header) * [-1, 1, 1]
    first = -(header["dim"][1:4].clip(1) - 1) / 2 * spacing
    return np.column_stack([np.diag(spacing), first])


def _in_millimeters(header, affine):
    """(3, 4) matrix in millimeters, with steps for axes of one voxel that have none."""
    affine = affine[:3] * _unit_length(header)
    affine[:, :3] = volumes.full_steps(affine[:, :3], header["dim"][1:4])
    return affine


def _spacing(header):
    return np.abs(header["pixdim"][1:4]).astype(float) * _unit_length(header)


def _qform(header):
    quaternion = [float(header[f"quatern_{axis}"]) for axis in "bcd"]
    if not np.square(quaternion).sum() <= 1 + _QUATERNION_ERROR:
        raise ValueError(f"the quaternion of its qform must have length 1, got {quaternion}")
    valid = header.copy()  # nibabel takes no other signs
    valid.quaternion_threshold = 2 * _QUATERNION_ERROR
    valid["pixdim"][0] = -1 if header["pixdim"][0] == -1 else 1
    valid["pixdim"][1:4] = np.abs(header["pixdim"][1:4])
    return _in_millimeters(header, valid.get_qform())


def _has_right_angles(affine, tolerance):
    directions = affine[:, :3] / np.linalg.norm(affine[:, :3], axis=0)
    return np.allclose(directions.T @ directions, np.eye(3), rtol=0, atol=tolerance)


def _itk_affine(header):
    """(3, 4) matrix to RAS by which ITK places the image; None if ITK refuses the file."""
    has_sform, has_qform = header["sform_code"] != 0, header["qform_code"] != 0
    if not has_sform and not has_qform:
        return np.column_stack([np.diag(_spacing(header) * TO_RAS), np.zeros(3)])
    is_preferred = header["sform_code"] == _SCANNER or not has_qform
    if has_sform and is_preferred and _has_right_angles(_affine(header), _MAX_SHEAR):
        return _affine(header)
    return _qform(header) if has_qform else None


def _warn_if_itk_differs(path, header, affine):
    itk_affine = None
    with contextlib.suppress(ValueError):  # a broken qform beside an sform
        itk_affine = _itk_affine(header)
    if itk_affine is None:
        return
    vertices = np.array([*np.ndindex(2, 2, 2)]) * (header["dim"][1:4].clip(1) - 1)
    homogeneous = np.column_stack([vertices, np.ones(8)])
    shift = np.linalg.norm((affine - itk_affine) @ homogeneous.T, axis=0).max()
    if shift <= _MAX_SHIFT * np.linalg.norm(affine[:, :3], axis=0).min():
        return
    if header["sform_code"] != 0:
        reason = "its sform counts here, as in nibabel, but ITK (SimpleITK, ANTs) uses its qform"
    else:
        reason = (
            "its header has neither sform nor qform, so its middle is at the origin here, as in "
            "nibabel, but ITK (SimpleITK, ANTs) has its first voxel there"
        )
    warn(
        f"`{path}`: {reason}: they differ by up to {shift:.3g} mm, and so will programs that read "
        "the result; set both forms to the same position"
    )


def _place(header, source, affine):
    """Set the fields that place an image in a header whose `dim` and `xyzt_units` are set.

    `source` is the header of the file that the image comes from, if any; `affine` (3, 4) leads from
    indices to RAS, in millimeters.
    """
    header["pixdim"][4:] = source["pixdim"][4:]
    has_source = source["dim"][0] > 0
    source_affine = _affine(source) if has_source else affine
    is_centered = has_source and not source["sform_code"] and not source["qform_code"]
    is_same_size = np.array_equal(source["dim"][1:4].clip(1), header["dim"][1:4])
    is_same_place = np.allclose(source_affine, affine, rtol=0, atol=1e-9 * np.abs(affine).max())
    if has_source and is_same_place and (is_same_size or not is_centered):
        for name in set(_GEOMETRY) - {"dim"}:
            for field in _GEOMETRY[name]:
                header[field] = source[field]
        _scale_lengths(header, _unit_length(source) / _unit_length(header))
        return
    code = source["sform_code"] or source["qform_code"] or _SCANNER
    header.set_sform(_in_unit_of(header, affine))
    header["sform_code"] = code
    header["pixdim"][1:4] = np.linalg.norm(affine[:, :3], axis=0) / _unit_length(header)
    qform, last_row = affine, [0, 0, 0, 1]
    if source["qform_code"] != 0:
        with contextlib.suppress(ValueError):  # a broken qform beside an sform
            source_qform = _qform(source)
            code = source["qform_code"]
            matrices = (np.vstack([matrix, last_row]) for matrix in (source_affine, affine))
            qform = source_qform @ np.linalg.solve(*matrices)
    if _has_right_angles(qform, 1e-6):
        header.set_qform(_in_unit_of(header, qform))
        header["qform_code"] = code


def _in_unit_of(header, affine):
    """(4, 4) matrix in the unit of a header, from (3, 4) in millimeters."""
    return np.vstack([affine / _unit_length(header), [0, 0, 0, 1]])


def _scale_lengths(header, factor):
    header["pixdim"][1:4] *= factor
    for field in (*_GEOMETRY["qoffset"], *_GEOMETRY["srow"]):
        header[field] *= factor


def _scaled(values, slope, intercept):
    """Values after the scaling: as floats that can hold them, or unchanged without scaling."""
    if slope == 0 or not np.isfinite(slope) or (slope == 1 and intercept == 0):
        return values
    if not np.isfinite(intercept):
        raise ValueError(f"its scaling must be finite, got {slope} and {intercept}")
    is_small = values.dtype.itemsize < 4 or values.dtype == np.float32
    scaled = np.empty(values.shape, np.float32 if is_small else np.float64)
    with np.errstate(over="ignore"):
        for raw, new in zip(values, scaled):  # by slices, for all in float64 can be too much memory
            new[...] = raw * slope + intercept
    return scaled


def _to_lines(header):
    """Lines `name: values` of a header."""
    lines = {}
    for name, fields in _LINES.items():
        lines[name] = " ".join(map(str, np.ravel([header[field] for field in fields]).tolist()))
    lines["intent_name"] = header["intent_name"].item().decode("latin-1")
    return tuple(f"{name}: {line}" for name, line in lines.items() if line)


def _from_lines(lines):
    """The header of `_to_lines`; dim[0] is 0 without a line `dim`."""
    header = _header_types()[2](endianness="<")
    header["xyzt_units"] = _MILLIMETERS
    for name, text in (line.split(": ", 1) for line in lines if ": " in line):
        if name == "intent_name":
            header[name] = text.encode("latin-1", "replace")[:16]
        elif name in _LINES:
            fields = _LINES[name]
            for field, numbers in zip(fields, np.split(np.array(text.split()), len(fields))):
                header[field] = numbers.astype(header[field].dtype).reshape(header[field].shape)
    return header


def _describe_values(header, volume, count, source_intent):
    values, dimensions = volume.values, volume.values.shape[2::-1]
    components = values.shape[3] if values.ndim == 4 else 1
    dtype = values.dtype
    if dtype == np.uint8 and components in _COLORS and not volume.is_label:
        dtype, components = _COLORS[components], 1
    header.set_data_dtype(dtype)
    more = (count, components) if components > 1 else (count,) * (count > 1)
    header.set_data_shape((*dimensions, *more))
    header["intent_code"] = _intent(volume, components, source_intent)


def _intent(volume, components, intent):
    """The intent code of the source file, if it is still true, or another one."""
    if volume.is_label:
        return intent if intent in _LABELS else _LABELS[0]
    if components > 1:
        return _DISPLACEMENT if (intent, components) == (_DISPLACEMENT, 3) else _VECTOR
    return 0 if intent in (*_LABELS, _DISPLACEMENT, _VECTOR) else intent
