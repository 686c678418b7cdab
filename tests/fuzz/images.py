"""Random image files of other programs, held against SimpleITK: units of NIfTI, 4-D NRRD."""

from __future__ import annotations

import tempfile
from importlib.util import find_spec
from pathlib import Path

import numpy as np

from vtk_mls import io
from vtk_mls.vtk import arrays
from vtk_mls.vtk.arrays import ImageGeometry

_UNITS = ("unknown", "mm", "micron", "meter")
_DTYPES = (np.uint8, np.int16, np.float32, np.float64)


def check_image_file(rng):
    """An image lies where SimpleITK sees it, and comes back the same."""
    if not all(map(find_spec, ("SimpleITK", "nibabel", "nrrd"))):
        return
    with tempfile.TemporaryDirectory() as folder:
        write = _write_nifti if rng.random() < 0.5 else _write_nrrd
        path, values, case = write(rng, Path(folder))
        image = io.read_dataset(path)
        _check_place(image, path, case)
        found = arrays.to_numpy(image.GetPointData().GetScalars()).reshape(values.shape)
        np.testing.assert_array_equal(found, values, err_msg=case)
        again = path.with_name(f"again{''.join(path.suffixes)}")
        io.write_dataset(image, again)
        _check_place(image, again, case)


def _check_place(image, path, case):
    import SimpleITK as sitk

    peer = sitk.ReadImage(str(path))
    size = peer.GetSize()[:3]
    assert size == image.GetDimensions(), f"{size} is read as {image.GetDimensions()}: {case}"
    grid = ImageGeometry.of_image(image).grid
    last = [n - 1 for n in peer.GetSize()]
    ends = [peer.TransformIndexToPhysicalPoint(i)[:3] for i in ([0] * len(last), last)]
    extent = np.abs(np.subtract(*ends)).max() + np.abs(ends).max()
    error = np.abs(grid.points()[[0, -1]] - ends).max()
    assert error <= 1e-5 * extent, f"off by {error:g} of {extent:g}: {case}"


def _write_nifti(rng, folder):
    import nibabel

    values = (100 * rng.random(rng.integers(2, 7, 3))).astype(rng.choice(_DTYPES))
    affine = np.eye(4)
    turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    affine[:3, :3] = turn * rng.uniform(0.5, 3, 3)
    affine[:3, 3] = rng.normal(0, 50, 3)
    unit, codes = str(rng.choice(_UNITS)), rng.integers(0, 5, 2)
    rotation = turn * (1, 1, np.linalg.det(turn))
    if 1 + np.trace(rotation) < 0.01:  # near half turns, float32 do not tell the quaternion
        codes[:] = 0, 1
    if not codes.any():
        codes[0] = 1  # without a code ITK and nibabel do not agree
    image = nibabel.Nifti1Image(values, None)
    image.header.set_xyzt_units(unit)
    image.set_qform(affine, int(codes[0]))
    image.set_sform(affine, int(codes[1]))
    path = folder / str(rng.choice(["x.nii", "x.nii.gz"]))
    nibabel.save(image, path)
    return path, values.T, f"{path.name} of {values.dtype} in {unit}, codes {codes.tolist()}"


def _write_nrrd(rng, folder):
    import nrrd

    count = int(rng.integers(3, 5))
    values = (100 * rng.random(rng.integers(2, 7, count))).astype(rng.choice(_DTYPES))
    header = {"encoding": str(rng.choice(["raw", "gzip", "text"]))}
    if count == 3 and rng.random() < 0.5:  # a fourth axis with a spacing is time
        header["spacings"] = rng.uniform(0.5, 3, count)
    path = folder / "x.nrrd"
    nrrd.write(str(path), values, header)
    axes = (2, 1, 0, 3)[:count]
    return path, values.transpose(axes), f"{values.shape} of {values.dtype}, {header}"
