"""Displacement fields as files that ITK, ANTs and 3D Slicer take as transforms.

Such a field says for each point of a resampled image how far away, in LPS, its value comes from.
Where a format has an intent, the file must have that of displacements: by it ITK (5.4 and later)
takes the vectors of NIfTI from RAS to LPS, and Slicer knows a transform.
"""

from __future__ import annotations

from os import PathLike
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from vtk_mls.files import formats, meta_image, nifti, nrrd
from vtk_mls.files.volumes import Volume
from vtk_mls.grid import Grid

_FORMATS = {  # what writes it, and lines of its header
    "NIFTI": (nifti, ("intent_code: 1006",)),
    "NRRD": (nrrd, ("intent_code:=1006", "displacement field type:=resampling")),
    "MetaImage": (meta_image, ()),
}


def write(displacement: ArrayLike, grid: Grid, path: str | PathLike[str]) -> None:
    """Write a displacement field.

    Parameters
    ----------
    displacement : (nz, ny, nx, 3) array_like, world units, LPS
        It is written as float32.
    grid : Grid
        Where the displacements are.
    path : path
        Of NIfTI, NRRD or MetaImage. What is there is written over.

    Raises
    ------
    OSError, ValueError
    """
    path = Path(path)
    found = formats.choose(path, "write a displacement field to", writes=(formats.FIELD,))
    found.write(displacement, grid, path)


def write_volume(name: str, displacement: ArrayLike, grid: Grid, path: Path) -> None:
    """Write a displacement field in the format of this name."""
    module, header = _FORMATS[name]
    values = np.asarray(displacement, np.float32)
    steps = grid.index_to_world
    module.write(path, Volume(values, grid.origin, steps, is_vector=True, header=header))
