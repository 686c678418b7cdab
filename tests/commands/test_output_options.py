"""`vtk-mls deform`: the output on the grid of a `--reference`, and its `--background`.

By ITK, which resamples it, and numpy's median of the corners.
"""

import nibabel
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


# --background auto, the default


@pytest.fixture
def far(folder):
    """handles.csv moves all far away."""
    (folder / "handles.csv").write_text("0,0,0,900,0,0\n")


def deform(source, target, *options):
    return main(["deform", source, "handles.csv", target, *options])


@pytest.mark.parametrize("shape", [(5, 6, 7), (6, 7)], ids=["volume", "flat"])
def test_the_background_is_the_median_of_the_corners(far, shape, rng, capsys):
    values = rng.uniform(-1024, 3000, shape).astype("int16")
    corners = values[np.ix_(*[[0, -1]] * len(shape))]
    median = np.percentile(corners, 50, method="lower")
    sitk.WriteImage(sitk.GetImageFromArray(values), "in.mha")
    assert deform("in.mha", "out.mha") == 0
    found = sitk.GetArrayFromImage(sitk.ReadImage("out.mha"))
    assert (found == median).all()
    said = capsys.readouterr().out
    assert said.count("; background ") == 1
    assert f"; background {median:g}, the median of the corners" in said
    assert deform("in.mha", "out.mha", "--background", "3") == 0
    found = sitk.GetArrayFromImage(sitk.ReadImage("out.mha"))
    assert (found == 3).all()
    assert "median" not in capsys.readouterr().out


def test_labels_have_the_background_0_without_a_warning(far, capsys):
    sitk.WriteImage(sitk.Image([5, 6, 7], sitk.sitkUInt8) + 4, "in.mha")
    assert deform("in.mha", "out.mha", "--label", "MetaImage") == 0
    assert not sitk.GetArrayFromImage(sitk.ReadImage("out.mha")).any()
    assert "median" not in capsys.readouterr().out


def test_a_series_has_the_background_of_its_first_step(far, capsys):
    values = np.full((6, 5, 4, 3), [-1000, 20, 30], np.int16)
    nibabel.save(nibabel.Nifti1Image(values, np.eye(4)), "in.nii.gz")
    assert deform("in.nii.gz", "out.nii.gz") == 0
    assert (np.asanyarray(nibabel.load("out.nii.gz").dataobj) == -1000).all()
    assert capsys.readouterr().out.count("background -1000, the median of the corners") == 1
