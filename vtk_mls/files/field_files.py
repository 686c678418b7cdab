"""Files of transforms: displacement fields, and others that `itk_transforms` reads and writes.

A field, which ITK, ANTs and 3D Slicer read as a transform, has for each point of a resampled image
the displacement, in LPS, to the source of its value. The intent "displacement", in formats that
have it, makes ITK (5.4 and later) convert the vectors of NIfTI from RAS to LPS, and marks a
transform for Slicer. ANTs writes vectors in LPS to NIfTI, with the intent "vector". So do NiftyReg
and SPM, in RAS, and name the intent.
"""

from __future__ import annotations

from functools import partial, reduce
from os import PathLike
from pathlib import Path
from typing import NamedTuple, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vtk_mls.base.errors import InputError
from vtk_mls.base.grid import Grid, checked_grid
from vtk_mls.files import formats, itk_transforms, meta_image, nifti, nrrd, volumes
from vtk_mls.files.paths import existing_file, replacing
from vtk_mls.files.volumes import Volume
from vtk_mls.files.vtk_io import failures_named
from vtk_mls.queries.transform import Transform
from vtk_mls.transforms.affine import Affine
from vtk_mls.transforms.chain import Chain, members_of
from vtk_mls.transforms.field import Field

_FORMATS = {  # module, and lines of the header
    "NIFTI": (nifti, ()),
    "NRRD": (nrrd, ("intent_code:=1006",)),
    "MetaImage": (meta_image, ()),
}
_INTENTS = {"itk": "intent_code: 1006", "ants": "intent_code: 1007"}  # of NIfTI
_SPM, _NIFTYREG = "Mapping", "NREG_TRANS"  # names of intents
_POSITIONS, _DISPLACEMENTS = "positions", "displacements"
_NIFTYREG_CONTENTS = {  # by the first parameter of the intent
    **{0: _POSITIONS, 1: _DISPLACEMENTS, 2: "control points of a cubic B-spline"},
    **{3: "velocities as positions", 4: "velocities", 5: "control points of velocities"},
    6: "control points of a linear spline",
}
_FSL_INTENTS = (2006, 2007, 2008, 2009, 2016, 2017, 2018)  # the first are displacements
_PURPOSE = "displacement field type:="


class FieldContent(NamedTuple):
    """A displacement field, and what formats say about it."""

    displacement: ArrayLike  # (nz, ny, nx, 3), world units, LPS
    grid: Grid
    is_forward: bool = False  # whether it moves points
    nifti_header: tuple[str, ...] = ()  # lines `NIFTI_HEADER` of the image with this grid
    convention: str = "itk"  # or "ants": of NIfTI
    unit: str = ""  # of `volumes.NANOMETERS`: of lengths, if it is not that of the format


def write(
    displacement: ArrayLike,
    grid: Grid,
    path: str | PathLike[str],
    is_forward: bool = False,
    convention: str = "itk",
) -> None:
    """Write a displacement field.

    Parameters
    ----------
    displacement : (nz, ny, nx, 3) array_like, world units, LPS
        It is written as float32.
    grid : Grid
        Points of the displacements.
    path : path
        Of NIfTI, NRRD or MetaImage; or of ITK (.h5, .hdf5, .tfm, .txt), for a composite of the best
        affine transform and the rest of the field, which needs SimpleITK. An old file is
        overwritten.
    is_forward : bool
        Whether the field is forward, so that it moves points. NRRD calls such a field "modeling",
        a backward field "resampling"; the other formats make no difference.
    convention : {"itk", "ants"}
        Of NIfTI. "itk": intent code 1006 (displacement), vectors in RAS, as ITK 5.4 reads them.
        "ants": intent code 1007 (vector), vectors in LPS, as ANTs, nitransforms and any ITK read
        them. In other formats vectors are in LPS.
    """
    path = Path(path)
    line = formats.choose(path, "write a displacement field to", writes=(formats.FIELD,))
    check_convention(convention)
    line.write(FieldContent(displacement, grid, is_forward, (), convention), path)


def check_convention(name: str) -> None:
    """Raise ValueError for an unknown convention of NIfTI fields."""
    if name not in _INTENTS:
        raise ValueError(f"`convention` must be itk or ants, got `{name!s:.40}`")


def read_volume(name: str, path: Path) -> Field:
    """Read a displacement field in the format of this name.

    Other images, and fields that move points, are a ValueError.
    """
    module, _ = _FORMATS[name]
    series = module.open_file(path)
    volume = series.read(0)
    content, values = _content_in_ras(volume.header) if module is nifti else "", volume.values
    if len(series.times) > 1:
        raise InputError(f"is a series of {len(series.times)} volumes; give one volume")
    if values.shape[3:] != (3,) or values.dtype.kind != "f":
        raise ValueError(
            "a displacement field has 3 floating-point components, "
            f"got {values.shape[3] if values.ndim == 4 else 1} of {values.dtype}"
        )
    if f"{_PURPOSE}modeling" in volume.header:
        raise ValueError(
            "its field moves points (displacement field type modeling); expected one that "
            "resamples images"
        )
    dimensions = values.shape[2::-1]
    steps = volumes.full_steps(volume.steps, dimensions)
    spacing = np.linalg.norm(steps, axis=0)
    grid = Grid(dimensions, volume.origin, spacing, steps / spacing)
    if content and not volume.is_vector:  # not yet converted
        values = values * nifti.TO_RAS.astype(values.dtype)
    if content == _POSITIONS:
        values = values - grid.points().reshape(values.shape)
    return Field(values, grid)


def _content_in_ras(lines: tuple[str, ...]) -> str:
    """The content of a NIfTI file of NiftyReg or SPM; "" for displacements as of ITK and ANTs.

    ValueError, which says what it is, if it is not displacements or positions.
    """
    header = dict(line.split(": ", 1) for line in lines)
    intent, name = int(header["intent_code"]), header.get("intent_name", "").strip()
    if name == _SPM:
        return _POSITIONS
    if name == _NIFTYREG:
        number = int(float(header["intent_p"].split()[0]))
        content = _NIFTYREG_CONTENTS.get(number, f"the unknown content {number}")
        if content in (_POSITIONS, _DISPLACEMENTS):
            return content
        raise ValueError(
            f"it has {content} of NiftyReg; expected displacements or positions, which "
            "`reg_transform -def` makes of it"
        )
    if intent in _FSL_INTENTS:
        content = _DISPLACEMENTS if intent == _FSL_INTENTS[0] else "coefficients or a field map"
        raise ValueError(
            f"it has {content} of FSL, in coordinates of FSL's images; expected displacements in "
            "mm, which `wb_command -convert-warpfield` makes of FSL's warps"
        )
    if f"intent_code: {intent}" not in _INTENTS.values():
        raise ValueError(f"a displacement field has the intent code 1006 or 1007, got {intent}")
    return ""


def write_volume(name: str, content: FieldContent, path: Path) -> None:
    """Write a displacement field in the format of this name."""
    module, header = _FORMATS[name]
    grid, unit, length = content.grid, content.unit, 1.0
    if module is nrrd:
        header = (*header, f"{_PURPOSE}{'modeling' if content.is_forward else 'resampling'}")
    elif module is nifti:
        header = (_INTENTS[content.convention], *nifti.in_millimeters(content.nifti_header))
        # ITK converts the grid of a file in micrometers to millimeters, but not its vectors
        length, unit = volumes.NANOMETERS.get(unit, 1e6) / 1e6, ""
    values = np.asarray(content.displacement, np.float32)
    place = length * grid.origin, length * grid.index_to_world
    values = values if length == 1 else length * values
    module.write(path, [Volume(values, *place, is_vector=True, header=header, unit=unit)], ())


def read_transform(path: str | PathLike[str]) -> Affine | Field | Chain:
    """Read a transform that resamples images, such as a registration of ANTs or 3D Slicer.

    Parameters
    ----------
    path : path
        Of an ITK transform (.h5, .hdf5, .tfm, .txt, .mat): linear transforms, displacement fields
        and composites of them. It needs SimpleITK, unless it is text with matrices alone. Or of a
        displacement field (.nii, .nii.gz, .nrrd, .nhdr, .mha, .mhd), its vectors in LPS; in NIfTI
        with the intent code 1006 in RAS. Also displacements and positions of NiftyReg, positions of
        SPM (`y_*.nii`).

    Returns
    -------
    Affine, Field or Chain
        In LPS. Its backward map moves points as ITK's transform does. Composites with anything
        that is not linear are chains, in the order of the file.

    Raises
    ------
    OSError, ValueError
        Naming the file.
    """
    path = existing_file(path)
    line = formats.choose(path, "read a transform from", reads=(formats.FIELD,))
    with failures_named(path):
        return cast("Affine | Field | Chain", line.read(path))


def write_transform(
    transform: Transform,
    path: str | PathLike[str],
    grid: Grid | None = None,
    convention: str = "itk",
) -> None:
    """Write a transform that resamples images as `transform` does, for ITK, ANTs or 3D Slicer.

    An `Affine`, or a chain of them, is written exactly to a file of ITK.

    Parameters
    ----------
    transform : Deformation, Affine, Field or Chain
        Its backward map is written.
    path : path
        Of ITK (.h5, .hdf5, .tfm, .txt; .mat for an `Affine`), which needs SimpleITK. Or of a
        displacement field (.nii, .nii.gz, .nrrd, .nhdr, .mha, .mhd).
    grid : Grid, optional
        Where displacements are sampled; ITK interpolates them linearly. ITK's files get the best
        affine transform and the rest of the displacements, so that the map goes on affinely outside
        of the grid; in others it ends there. Without a grid, `Affine` and `Field` are written as
        they are, and their chains to ITK's files.
    convention : {"itk", "ants"}
        Of NIfTI, as of `field_files.write`.

    Raises
    ------
    OSError, TypeError, ValueError
        Naming the argument or the file.
    """
    path = Path(path)
    check_convention(convention)
    members = members_of(transform)
    affines = [member for member in members if isinstance(member, Affine)]
    is_affine = len(affines) == len(members)
    line = formats.choose(
        path,
        "write a transform to" if is_affine else "write a displacement field to",
        writes=(formats.AFFINE, formats.FIELD) if is_affine else (formats.FIELD,),
    )
    is_itk = formats.AFFINE in line.writes
    if is_itk and is_affine:
        product = Affine(reduce(lambda matrix, member: member.matrix @ matrix, affines, np.eye(4)))
        write_to = partial(itk_transforms.write, [product])
    elif is_itk and grid is None and all(isinstance(member, (Affine, Field)) for member in members):
        write_to = partial(itk_transforms.write, members)
    else:
        displacement, grid = _sampled(transform, grid)
        write_to = partial(line.write, FieldContent(displacement, grid, convention=convention))
    with replacing(path) as new, failures_named(new):
        write_to(new)


def _sampled(transform: Transform, grid: Grid | None) -> tuple[NDArray[np.float32], Grid]:
    """Displacements on a grid: by default a field's own."""
    if grid is not None:
        return transform.displacement_field(checked_grid("grid", grid)).displacement, grid
    if isinstance(transform, Field):
        return transform.displacement, transform.grid
    raise ValueError(
        f"`grid` must be given to write this {type(transform).__name__}, for the file holds "
        "displacements at the points of a grid"
    )
