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

from vtk_mls.base.grid import Grid
from vtk_mls.files import formats, meta_image, nifti, nrrd
from vtk_mls.files.volumes import Volume

_FORMATS = {  # what writes it, and lines of its header
    "NIFTI": (nifti, ("intent_code: 1006",)),
    "NRRD": (nrrd, ("intent_code:=1006",)),
    "MetaImage": (meta_image, ()),
}


def write(
    displacement: ArrayLike, grid: Grid, path: str | PathLike[str], is_forward: bool = False
) -> None:
    """Write a displacement field.

    Parameters
    ----------
    displacement : (nz, ny, nx, 3) array_like, world units, LPS
        It is written as float32.
    grid : Grid
        Where the displacements are.
    path : path
        Of NIfTI, NRRD or MetaImage. What is there is written over.
    is_forward : bool
        Whether the displacements say where the material goes, which moves points. NRRD calls such a
        field "modeling", else "resampling"; the other formats do not tell.

    Raises
    ------
    OSError, ValueError
    """
    path = Path(path)
    found = formats.choose(path, "write a displacement field to", writes=(formats.FIELD,))
    found.write((displacement, is_forward, ()), grid, path)


def write_volume(
    name: str, field: tuple[ArrayLike, bool, tuple[str, ...]], grid: Grid, path: Path
) -> None:
    """Write a displacement field in the format of this name.

    `field` has the displacements, whether they are forward, and the lines `NIFTI_HEADER` of the
    image whose grid it is.
    """
    displacement, is_forward, nifti_header = field
    module, header = _FORMATS[name]
    if module is nrrd:
        purpose = "modeling" if is_forward else "resampling"
        header = (*header, f"displacement field type:={purpose}")
    elif module is nifti:
        header = (*header, *nifti.in_millimeters(nifti_header))
    values = np.asarray(displacement, np.float32)
    steps = grid.index_to_world
    module.write(path, Volume(values, grid.origin, steps, is_vector=True, header=header))
