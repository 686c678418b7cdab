"""`vtk-mls deform --reference`: the output on the grid of the target, as ITK resamples it."""

import numpy as np
import pytest
import SimpleITK as sitk
from vtk_fixtures import DEFORMED, REST, TURNED

from vtk_mls import io
from vtk_mls.commands.cli import main
from vtk_mls.vtk.arrays import ImageGeometry

FAR = np.array([0, 0, 800.0])


def _image(values, origin, spacing, direction):
    image = sitk.GetImageFromArray(np.asarray(values, np.float32))
    image.SetOrigin([float(x) for x in origin])
    image.SetSpacing(spacing)
    image.SetDirection(np.ravel(direction).tolist())
    return image


@pytest.fixture
def scans(files, rng):
    """moving.nii.gz, target.nii.gz on an oblique grid elsewhere, and h.csv between them."""
    moving = _image(rng.normal(size=(9, 10, 11)), (-1, -1, -1), (0.9, 1, 1.1), np.eye(3))
    target = _image(np.ones((6, 7, 8)), (2, 1, 1) + FAR, (0.5, 0.6, 0.7), TURNED)
    sitk.WriteImage(moving, "moving.nii.gz")
    sitk.WriteImage(target, "target.nii.gz")
    np.savetxt("h.csv", np.hstack([REST, DEFORMED + FAR]), delimiter=",", fmt="%.17g")
    return moving, target


@pytest.mark.parametrize("output", ["out.nii.gz", "out.nrrd", "out.vti"])
def test_it_is_what_itk_resamples_with_the_field(scans, output, capsys):
    moving, target = scans
    assert main(["field", "target.nii.gz", "h.csv", "warp.nii.gz"]) == 0
    arguments = ["deform", "moving.nii.gz", "h.csv", output, "--reference", "target.nii.gz"]
    assert main([*arguments]) == 0
    printed = capsys.readouterr()
    assert "far from" not in printed.out
    assert printed.err == ""
    warp = sitk.DisplacementFieldTransform(sitk.ReadImage("warp.nii.gz", sitk.sitkVectorFloat64))
    expected = sitk.GetArrayFromImage(sitk.Resample(moving, target, warp, sitk.sitkLinear))
    image = io.read_dataset(output)
    values = np.reshape(image.GetPointData().GetScalars(), expected.shape)
    is_inside = (expected != 0) & (values != 0)  # ITK's images end half a voxel further
    assert is_inside.mean() > 0.5
    np.testing.assert_allclose(values[is_inside], expected[is_inside], atol=2e-4)
    grid = ImageGeometry.of_image(image).grid
    corner = target.TransformIndexToPhysicalPoint([n - 1 for n in target.GetSize()])
    np.testing.assert_allclose(grid.direction, TURNED, atol=1e-6)
    np.testing.assert_allclose(grid.corners()[-1], corner, atol=1e-4)


def test_one_sentence_if_nothing_arrives(scans, capsys, caplog):
    arguments = ["deform", "moving.nii.gz", "h.csv", "out.vti", "--reference", "moving.nii.gz"]
    assert main([*arguments]) == 0
    printed = capsys.readouterr()
    assert printed.err == ""
    (sentence,) = caplog.messages
    assert sentence.startswith(
        "nothing of the input arrives on the grid of the reference: deformed, the input is in x "
    )
    assert sentence.endswith("; the grid is in x -1 to 8, y -1 to 8, z -1 to 7.8")


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        (["--reference", "target.nii.gz", "--grid", "fitted"], "leave `--grid fitted` out"),
        (["--reference", "mesh.vtp"], "`--reference` must be an image, got a vtkPolyData in `mesh"),
        (["--reference", "no.nii"], "there is no file `no.nii`"),
    ],
)
def test_errors(scans, options, sentence, refused):
    io.write_handles("mesh.vtp", REST, DEFORMED)
    assert sentence in refused("deform", "moving.nii.gz", "h.csv", "out.vti", *options)
