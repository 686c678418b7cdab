"""Displacement fields as files that ITK, ANTs and 3D Slicer take as transforms.

Such a field says for each point of a resampled image how far away, in LPS, its value comes from.
Where a format has an intent, the file must have that of displacements: by it ITK (5.4 and later)
takes the vectors of NIfTI from RAS to LPS, and Slicer knows a transform.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from vtk_mls.files import meta_image, nifti, nrrd
from vtk_mls.files.volumes import Volume

_NIFTI = nifti, ("intent_code: 1006",)
_NRRD = nrrd, ("intent_code:=1006", "displacement field type:=resampling")
_META = meta_image, ()
_FORMATS = {
    **{".nii.gz": _NIFTI, ".nii": _NIFTI, ".nrrd": _NRRD, ".nhdr": _NRRD},
    **{".mha": _META, ".mhd": _META},
}
FORMATS = tuple(_FORMATS)


def write(displacement, grid, path):
    """Write a displacement field.

    Parameters
    ----------
    displacement : (nz, ny, nx, 3) array, world units, LPS
        It is written as float32.
    grid : Grid
        Where the displacements are.
    path : path
        Its name ends in one of `FORMATS`. What is there is written over.

    Raises
    ------
    OSError, ValueError
    """
    path = Path(path)
    suffix = next((each for each in FORMATS if path.name.lower().endswith(each)), None)
    if suffix is None:
        raise ValueError(f"`path` must end in one of {', '.join(FORMATS)}, got `{path}`")
    module, header = _FORMATS[suffix]
    values = np.asarray(displacement, np.float32)
    steps = grid.index_to_world
    module.write(path, Volume(values, grid.origin, steps, is_vector=True, header=header))
