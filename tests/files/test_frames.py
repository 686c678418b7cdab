"""Images of every format lie in one physical world, as SimpleITK, nibabel and 3D Slicer see it."""

import gzip

import nibabel
import numpy as np
import pytest
import SimpleITK
import slicer_peer
from slicer_peer import needs_slicer
from test_io import scalars
from vtk_fixtures import TURNED, messages  # noqa: F401

from vtk_mls import io
from vtk_mls.cli import main
from vtk_mls.files import control_point_files, frames
from vtk_mls.vtk.arrays import ImageGeometry

RIGHT, LEFT = TURNED, TURNED * [1, 1, -1]
ORIGIN, SPACING = np.array([19.25, -34.5, 45.125]), np.array([0.75, 1.5, 2.25])
VALUES = np.arange(7 * 8 * 9, dtype=np.int16).reshape(7, 8, 9) * 17 % 991
HANDLES = ORIGIN + [(2, 3, 4), (8, 1, 5), (3, 9, 2), (6, 6, 12)]
DRAGGED = HANDLES + [(1.5, 0, 0), (0, -1, 0.5), (0, 0, 0), (0.25, 0.5, -2)]


def as_itk(direction, values=VALUES):
    image = SimpleITK.GetImageFromArray(values)
    image.SetOrigin(ORIGIN.tolist())
    image.SetSpacing(SPACING.tolist())
    image.SetDirection(direction.ravel().tolist())
    return image


def nrrd_bytes(space, direction, values=VALUES, more=""):
    """A NRRD file of the same image, in a space of eight."""
    signs = frames.signs(space)
    steps = (direction * SPACING).T * signs
    vectors = [f"({','.join(map(repr, each.tolist()))})" for each in (*steps, ORIGIN * signs)]
    header = (
        f"NRRD0005\ntype: {values.dtype.name}\ndimension: 3\nspace: {space}\nsizes: 9 8 7\n"
        f"space directions: {' '.join(vectors[:3])}\nkinds: domain domain domain\n"
        f"endian: little\nencoding: gzip\nspace origin: {vectors[3]}\n{more}\n"
    )
    return header.encode() + gzip.compress(values.tobytes())


def as_nifti(direction, values=VALUES, kind=nibabel.Nifti1Image):
    affine = np.eye(4)
    affine[:3] = np.diag([-1, -1, 1]) @ np.column_stack([direction * SPACING, ORIGIN])
    return kind(values.T, affine)


def write_source(path, maker, direction):
    if maker == "SimpleITK":
        SimpleITK.WriteImage(as_itk(direction), str(path))
    elif maker == "nibabel":
        nibabel.save(as_nifti(direction), path)
    else:
        path.write_bytes(nrrd_bytes(maker, direction))


SOURCES = [
    *[(suffix, "SimpleITK") for suffix in (".mha", ".mhd", ".nrrd", ".nhdr", ".nii", ".nii.gz")],
    *[(suffix, "nibabel") for suffix in (".nii", ".nii.gz")],
    *[(".nrrd", space) for space in ("LPS", "ras", "left-anterior-superior")],
]


@pytest.fixture(params=SOURCES, ids=lambda source: f"{source[1]}{source[0]}")
def source(request):
    return request.param


@pytest.fixture(params=[RIGHT, LEFT], ids=["right", "left"])
def direction(request):
    return request.param


def assert_same_in_itk(path, other, atol=1e-5, rounding=0):
    """Two files have the same values at the same places, and the same grid, for SimpleITK."""
    first, second = (SimpleITK.ReadImage(str(each)) for each in (path, other))
    np.testing.assert_allclose(first.GetOrigin(), second.GetOrigin(), atol=atol)
    np.testing.assert_allclose(first.GetSpacing(), second.GetSpacing(), atol=atol)
    np.testing.assert_allclose(first.GetDirection(), second.GetDirection(), atol=atol)
    values = [SimpleITK.GetArrayFromImage(each).astype(float) for each in (first, second)]
    assert values[0].shape == values[1].shape
    assert np.abs(values[0] - values[1]).max() <= rounding


def test_every_format_is_read_into_lps(tmp_path, source, direction):
    path = tmp_path / f"x{source[0]}"
    write_source(path, source[1], direction)
    image = io.read_dataset(path)
    np.testing.assert_array_equal(scalars(image), VALUES.ravel())
    grid = ImageGeometry.of_image(image).grid
    itk = as_itk(direction)
    indices = [(0, 0, 0), (8, 0, 0), (0, 7, 0), (0, 0, 6), (3, 4, 5)]
    expected = [itk.TransformIndexToPhysicalPoint(index) for index in indices]
    np.testing.assert_allclose(grid.at(indices), expected, atol=1e-5)


def test_every_format_goes_back_as_it_came(tmp_path, source, direction):
    path, back = tmp_path / f"x{source[0]}", tmp_path / f"back{source[0]}"
    write_source(path, source[1], direction)
    io.write_dataset(io.read_dataset(path), back)
    assert_same_in_itk(path, back)
    if ".nii" in source[0]:
        before, after = nibabel.load(path), nibabel.load(back)
        np.testing.assert_allclose(after.affine, before.affine, atol=1e-5)
        np.testing.assert_allclose(after.get_qform(), before.affine, atol=1e-5)
        assert after.header.get_xyzt_units()[0] == "mm"
    if source[1] not in ("SimpleITK", "nibabel"):
        assert f"\nspace: {source[1]}\n".encode() in back.read_bytes()


@pytest.mark.parametrize("suffix", [".mha", ".mhd", ".nrrd", ".nhdr", ".nii", ".nii.gz"])
def test_every_format_becomes_every_other(tmp_path, source, direction, suffix):
    path, other = tmp_path / f"x{source[0]}", tmp_path / f"other{suffix}"
    write_source(path, source[1], direction)
    io.write_dataset(io.read_dataset(path), other)
    assert_same_in_itk(path, other)


def test_the_same_handles_deform_all_alike(tmp_path, source, direction):
    path, reference = tmp_path / f"x{source[0]}", tmp_path / "reference.mha"
    write_source(path, source[1], direction)
    SimpleITK.WriteImage(as_itk(direction), str(reference))
    control_point_files.write(tmp_path / "h.csv", HANDLES, DRAGGED)
    outputs = []
    for name in (path, reference):
        outputs.append(tmp_path / f"out-{name.name}")
        arguments = ["deform", name, tmp_path / "h.csv", outputs[-1], "--device", "reference"]
        assert main([str(each) for each in arguments]) == 0
    if source[1] not in ("SimpleITK", "nibabel"):
        assert f"\nspace: {source[1]}\n".encode() in outputs[0].read_bytes()
    assert np.ptp(scalars(io.read_dataset(outputs[1])) - VALUES.ravel()) > 100
    assert_same_in_itk(*outputs, rounding=1)  # places of NIfTI are float32


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
