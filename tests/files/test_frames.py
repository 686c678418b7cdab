"""Images of every format lie in one physical world, as SimpleITK, nibabel and 3D Slicer see it."""

import nibabel
import numpy as np
import pytest
import SimpleITK
import slicer_peer
from file_fixtures import (
    IMAGES,
    LEFT,
    ORIGIN,
    RIGHT,
    SPACING,
    VALUES,
    as_itk,
    as_nifti,
    nrrd_bytes,
)
from slicer_peer import needs_slicer

from vtk_mls import io

SOURCES = [
    *[(suffix, "SimpleITK") for suffix in IMAGES],
    *[(suffix, "nibabel") for suffix in (".nii", ".nii.gz")],
    *[(".nrrd", space) for space in ("LPS", "ras", "left-anterior-superior")],
]


@pytest.fixture(params=[RIGHT, LEFT], ids=["right", "left"])
def direction(request):
    return request.param


@pytest.mark.parametrize(("old", "maker"), SOURCES)
@pytest.mark.parametrize("suffix", IMAGES)
def test_every_format_becomes_every_other(tmp_path, old, maker, direction, suffix):
    path, other = tmp_path / f"x{old}", tmp_path / f"other{suffix}"
    if maker == "SimpleITK":
        SimpleITK.WriteImage(as_itk(direction), str(path))
    elif maker == "nibabel":
        nibabel.save(as_nifti(direction), path)
    else:
        path.write_bytes(nrrd_bytes(maker, direction))
    io.write_dataset(io.read_dataset(path), other)
    first, second = (SimpleITK.ReadImage(str(file)) for file in (path, other))
    for get in ("GetOrigin", "GetSpacing", "GetDirection"):
        np.testing.assert_allclose(getattr(first, get)(), getattr(second, get)(), atol=1e-5)
    np.testing.assert_array_equal(*map(SimpleITK.GetArrayFromImage, (first, second)))


SLICER_VALUE = """
import sys, slicer, vtk
scene, node = slicer.vtkMRMLScene(), slicer.vtkMRMLScalarVolumeNode()
storage, matrix = slicer.vtkMRMLVolumeArchetypeStorageNode(), vtk.vtkMatrix4x4()
storage.SetFileName(sys.argv[1])
assert storage.ReadData(node)
node.GetRASToIJKMatrix(matrix)
index = matrix.MultiplyPoint([*map(float, sys.argv[2:5]), 1])[:3]
print(*index, node.GetImageData().GetScalarComponentAsDouble(*map(round, index), 0))
"""


@needs_slicer
@pytest.mark.parametrize("suffix", [".mha", ".nrrd", ".nii.gz"])
def test_slicer_sees_what_we_write_at_the_same_place(tmp_path, direction, suffix):
    SimpleITK.WriteImage(as_itk(direction), str(tmp_path / "x.mha"))
    io.write_dataset(io.read_dataset(tmp_path / "x.mha"), tmp_path / f"y{suffix}")
    place = (ORIGIN + direction * SPACING @ [3, 4, 5]) * [-1, -1, 1]  # Slicer's world is RAS
    printed = slicer_peer.run(SLICER_VALUE, tmp_path / f"y{suffix}", *place.tolist())
    *index, value = map(float, printed.split()[-4:])
    # Slicer makes images right-handed: the slices of left-handed ones are the other way round
    np.testing.assert_allclose(index, (3, 4, 5 if direction is RIGHT else 1), atol=1e-4)
    assert value == VALUES[5, 4, 3]
