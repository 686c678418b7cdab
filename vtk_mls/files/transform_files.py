"""Transforms from files, and to files."""

from __future__ import annotations

from functools import partial, reduce
from os import PathLike
from pathlib import Path
from typing import cast

import numpy as np
from numpy.typing import NDArray

from vtk_mls.base.grid import Grid, checked_grid
from vtk_mls.files import field_files, formats, itk_transforms
from vtk_mls.files.field_files import FieldContent
from vtk_mls.files.paths import existing_file, replacing
from vtk_mls.files.vtk_io import failures_named
from vtk_mls.queries.transform import Transform
from vtk_mls.transforms.affine import Affine
from vtk_mls.transforms.chain import Chain, members_of
from vtk_mls.transforms.field import Field


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
    field_files.check_convention(convention)
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
        write = partial(itk_transforms.write, [product])
    elif is_itk and grid is None and all(isinstance(member, (Affine, Field)) for member in members):
        write = partial(itk_transforms.write, members)
    else:
        displacement, grid = _sampled(transform, grid)
        content = FieldContent(displacement, grid, convention=convention)
        write = partial(line.write, content)
    with replacing(path) as new, failures_named(new):
        write(new)


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
