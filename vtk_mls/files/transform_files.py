"""Transforms from files, and to files."""

from __future__ import annotations

from os import PathLike
from typing import cast

from vtk_mls.files import formats
from vtk_mls.files.paths import existing_file
from vtk_mls.files.vtk_io import failures_named
from vtk_mls.transforms.affine import Affine
from vtk_mls.transforms.chain import Chain
from vtk_mls.transforms.field import Field


def read_transform(path: str | PathLike[str]) -> Affine | Field | Chain:
    """Read a transform that resamples images, such as a registration of ANTs or 3D Slicer.

    Parameters
    ----------
    path : path
        Of an ITK transform (.h5, .hdf5, .tfm, .txt, .mat), which needs SimpleITK: linear
        transforms, displacement fields and composites of them. Or of a displacement field (.nii,
        .nii.gz, .nrrd, .nhdr, .mha, .mhd), its vectors in LPS; in NIfTI with the intent code 1006
        in RAS.

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
