"""Segments of a label image: the label on a ray, and the connected voxels that have it."""

import numpy as np
from vtkmodules.vtkCommonCore import vtkPoints

from vtk_mls import Labels
from vtk_mls.base.interpolation import sample
from vtk_mls.rendering.surfaces import material_at
from vtk_mls.vtk import arrays
from vtk_mls.vtk.objects import configured, output_of

_STEP = 0.5  # between samples along a ray, in voxels
_MAX_SAMPLES = 4096
_MAX_SEEN = 1 << 20  # samples of an image that may have labels
_MIN_REGION, _MIN_SAME = 32, 0.6  # voxels; share of neighbors along x with the same label
_MAX_VALUES = 64  # of an image of integers that are labels though its file does not declare it


def are_labels(values):
    """Whether the values of an image may be labels: few different integers."""
    return values.dtype.kind in "biu" and len(np.unique(values)) <= _MAX_VALUES


def are_regions(values):
    """Whether an image (nz, ny, nx) has few integers, most of them in regions, as labels are."""
    rows = values.reshape(-1, values.shape[-1])
    rows = rows[:: max(1, values.size // _MAX_SEEN)]
    if values.size < 2 * _MIN_REGION or rows.shape[1] < 2 or not are_labels(rows):
        return False
    _, label = np.unique(rows, return_inverse=True)
    label = label.reshape(rows.shape)
    is_same = label[:, 1:] == label[:, :-1]
    counts = np.bincount(label[:, :-1].ravel())
    same = np.bincount(label[:, :-1][is_same], minlength=len(counts))
    return len(counts) > 1 and np.median(same / np.maximum(counts, 1)) > _MIN_SAME


def label_on_ray(grid, values, deformation, near, far):
    """The first voxel on a ray that is not 0: its fraction of the ray and its index; None without.

    The ray goes from `near` to `far` (3,) through values (nz, ny, nx) on a grid, which are drawn
    after a Deformation or None.
    """
    length = np.linalg.norm(far - near) / (_STEP * np.abs(grid.spacing).min())
    fractions = np.linspace(0, 1, int(np.clip(length, 2, _MAX_SAMPLES)))
    origins, has_material = material_at(deformation, near + fractions[:, None] * (far - near))
    index = grid.index_of(origins)
    labels = sample(values, index, "nearest", 0, grid)
    rows = np.flatnonzero(grid.covers(index) & (labels != 0) & has_material)
    if len(rows) == 0:
        return None
    voxel = np.clip(np.rint(index[rows[0]]), 0, np.array(grid.dimensions) - 1)
    return float(fractions[rows[0]]), voxel.astype(int)


def connected_label(image, grid, index):
    """Labels: the voxels of a vtkImageData with the value of a voxel, index (3,), that touch it."""
    # ParaView's VTK does not have this module, and does not need this function
    from vtkmodules.vtkImagingMorphological import vtkImageThresholdConnectivity

    seed, fill = vtkPoints(), vtkImageThresholdConnectivity()
    position = np.array(image.GetOrigin()) + index * np.array(image.GetSpacing())
    seed.InsertNextPoint(image.GetExtent()[::2] * np.array(image.GetSpacing()) + position)
    values = arrays.to_numpy(image.GetPointData().GetScalars()).reshape(grid.shape)
    value = float(values[tuple(index[::-1])])
    configured(fill, InputData=image, SeedPoints=seed, InValue=1, OutValue=0)
    configured(fill, ReplaceIn=True, ReplaceOut=True).ThresholdBetween(value, value)
    filled = arrays.to_numpy(output_of(fill).GetPointData().GetScalars())
    return Labels(filled.reshape(grid.shape), grid)
