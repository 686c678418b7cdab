"""Displacement fields as files that ITK, ANTs and 3D Slicer take as transforms.

Displacements and positions are in LPS (see `frames`). A NIfTI file is in RAS, its vectors too: by
the intent of displacements ITK (5.4 and later) knows that it has to take both to LPS. The
displacement of a point leads to where a resampled image has its value from.
"""

from __future__ import annotations

import gzip
import struct
import zlib

import numpy as np

from vtk_mls import frames

_DISPLACEMENTS = 1006  # NIfTI's intent code DISPVECT, which Slicer reads in NRRD too
_LONGEST_NIFTI_AXIS = 32767
_LEVEL = 1  # of compression: with more, displacements hardly become smaller


def write(displacement, grid, path):
    """Write a displacement field.

    Parameters
    ----------
    displacement : (nz, ny, nx, 3) array, world units
        It is written as float32.
    grid : Grid
        Where the displacements are.
    path : Path
        Its name ends in one of `FORMATS`.

    Raises
    ------
    ValueError, OSError
        Naming the file.
    """
    write_to = next(each for end, each in _WRITERS.items() if path.name.lower().endswith(end))
    write_to(np.asarray(displacement, "<f4"), grid, path)


def _write_nrrd(values, grid, path):
    steps = " ".join(_vector(step) for step in grid.index_to_world.T)
    header = (
        "NRRD0005\n"
        "type: float\n"
        "dimension: 4\n"
        "space: left-posterior-superior\n"
        f"sizes: 3 {' '.join(map(str, grid.dimensions))}\n"
        f"space directions: none {steps}\n"
        "kinds: vector domain domain domain\n"
        "endian: little\n"
        "encoding: gzip\n"
        f"space origin: {_vector(grid.origin)}\n"
        f"intent_code:={_DISPLACEMENTS}\n"
        "displacement field type:=resampling\n"
        "\n"
    )
    pack = zlib.compressobj(_LEVEL, wbits=31)  # as gzip does
    with path.open("wb") as file:
        file.write(header.encode())
        for plane in values:
            file.write(pack.compress(plane.tobytes()))
        file.write(pack.flush())


def _vector(numbers):
    return f"({','.join(repr(float(number)) for number in numbers)})"


def _write_nifti(values, grid, path):
    if max(grid.dimensions) > _LONGEST_NIFTI_AXIS:
        raise ValueError(
            f"`{path}` can have {_LONGEST_NIFTI_AXIS} points along an axis, got "
            f"{max(grid.dimensions)}; write .nrrd or .mha instead"
        )
    signs = frames.signs("RAS")
    steps, origin = signs[:, None] * grid.index_to_world, signs * grid.origin
    header = _nifti_header(grid.dimensions, steps, origin)
    is_packed = path.suffix.lower() == ".gz"
    with gzip.open(path, "wb", _LEVEL) if is_packed else path.open("wb") as file:
        file.write(header)
        for component, sign in enumerate(signs.tolist()):
            for plane in values[..., component]:
                file.write((plane * np.float32(sign)).astype("<f4").tobytes())


def _nifti_header(dimensions, steps, origin):
    """The 352 bytes before the values of a field, in RAS.

    Parameters
    ----------
    dimensions : (3,) ints
    steps : (3, 3) floats
        Columns are the steps between neighbours along the three axes.
    origin : (3,) floats
    """
    spacing = np.linalg.norm(steps, axis=0)
    direction = steps / spacing
    handedness = 1.0 if np.linalg.det(direction) > 0 else -1.0
    rotation = direction * [1, 1, handedness]
    is_rotation = np.allclose(rotation.T @ rotation, np.eye(3), atol=1e-6)
    quaternion = _quaternion(rotation) if is_rotation else np.zeros(3)
    header = bytearray(352)
    for place, form, values in (
        (0, "i", [348]),
        (40, "8h", [5, *dimensions, 1, 3, 1, 1]),
        (68, "h", [_DISPLACEMENTS]),
        (70, "2h", [16, 32]),  # float32
        (76, "8f", [handedness, *spacing, 1, 1, 1, 1]),
        (108, "f", [352]),
        (112, "2f", [1, 0]),  # no scaling
        (123, "B", [2]),  # millimetres
        (252, "2h", [int(is_rotation), 1]),  # qform and sform are in a scanner's frame
        (256, "6f", [*quaternion, *origin]),
        (280, "12f", np.column_stack([steps, origin]).ravel()),
        (344, "4s", [b"n+1"]),
    ):
        struct.pack_into(f"<{form}", header, place, *values)
    return bytes(header)


def _quaternion(rotation):
    """The last three components of the unit quaternion, whose first is not negative."""
    (xx, xy, xz), (yx, yy, yz), (zx, zy, zz) = rotation
    # the quaternion is the eigenvector of the largest eigenvalue (Bar-Itzhack 2000)
    matrix = [
        [xx + yy + zz, zy - yz, xz - zx, yx - xy],
        [zy - yz, xx - yy - zz, xy + yx, xz + zx],
        [xz - zx, xy + yx, yy - xx - zz, yz + zy],
        [yx - xy, xz + zx, yz + zy, zz - xx - yy],
    ]
    found = np.linalg.eigh(matrix)[1][:, -1]
    return found[1:] if found[0] >= 0 else -found[1:]


_WRITERS = {".nii.gz": _write_nifti, ".nii": _write_nifti, ".nrrd": _write_nrrd}
FORMATS = tuple(_WRITERS)
