"""Images with a time axis are deformed volume by volume into files of the same kind."""

import nibabel
import nrrd
import numpy as np
import pytest
import SimpleITK
from command_fixtures import write_collection, write_moving
from vtk_fixtures import DEFORMED, REST

from vtk_mls import io
from vtk_mls.commands import series
from vtk_mls.commands.cli import main
from vtk_mls.vtk import arrays

pytestmark = pytest.mark.usefixtures("folder")
COUNT, SIZE = 3, (9, 8, 7)
START, STEP = 2.0, 0.5


def itk_image(rng, components=1):
    """An image of ITK's in time, oblique, and its volumes."""
    shape = (*SIZE[::-1], *[components] * (components > 1))
    turn = [0.8, -0.6, 0, 0.6, 0.8, 0, 0, 0, 1]
    volumes = []
    for _ in range(COUNT):
        values = rng.integers(0, 1000, shape).astype(np.int16)
        volume = SimpleITK.GetImageFromArray(values, isVector=components > 1)
        volume.SetDirection(turn)
        volumes.append(volume)
    image = SimpleITK.JoinSeries(volumes, START, STEP)
    image.SetOrigin((-3, 1, 2, START))
    image.SetSpacing((1, 1.25, 0.75, STEP))
    return image


def deform(source, target, *options):
    options = ["--background", "0", *options]  # auto is that of the first step
    return main(["deform", source, "handles.csv", target, *options])


@pytest.mark.parametrize("ending", ["nii.gz", "nii", "nrrd", "nhdr", "mha", "mhd"])
def test_each_volume_is_what_it_is_alone(ending, rng, capsys):
    source = itk_image(rng)
    SimpleITK.WriteImage(source, f"in.{ending}", useCompression=ending in ("nrrd", "mha"))
    assert deform(f"in.{ending}", f"out.{ending}") == 0
    assert f"out.{ending}: 3 time steps" in capsys.readouterr().out
    found = SimpleITK.ReadImage(f"out.{ending}")
    assert found.GetSize() == source.GetSize()
    for get in ("GetSpacing", "GetOrigin", "GetDirection"):
        np.testing.assert_allclose(getattr(found, get)(), getattr(source, get)(), atol=1e-6)
    assert found.GetPixelID() == source.GetPixelID()
    for number in range(COUNT):
        SimpleITK.WriteImage(source[:, :, :, number], f"one.{ending}")
        assert deform(f"one.{ending}", f"alone.{ending}") == 0
        alone = SimpleITK.GetArrayFromImage(SimpleITK.ReadImage(f"alone.{ending}"))
        np.testing.assert_array_equal(SimpleITK.GetArrayFromImage(found)[number], alone)
        assert (alone != SimpleITK.GetArrayFromImage(source)[number]).any()


@pytest.mark.parametrize("ending", ["nii.gz", "nrrd", "mha"])
def test_components_in_time(ending, rng):
    source = itk_image(rng, 2)
    if ending == "nii.gz":  # ITK writes no components in time
        values = np.moveaxis(SimpleITK.GetArrayFromImage(source), -1, 0).T
        nibabel.save(nibabel.Nifti1Image(values, np.eye(4)), "in.nii.gz")
    else:
        SimpleITK.WriteImage(source, f"in.{ending}")
    for target in ("out.pvd", f"out.{ending}"):
        assert deform(f"in.{ending}", target) == 0
    expected, found = (
        [arrays.to_numpy(read().GetPointData().GetScalars()) for _, read in series.read_steps(path)]
        for path in ("out.pvd", f"out.{ending}")
    )
    np.testing.assert_array_equal(found, expected)
    assert np.shape(found) == (COUNT, np.prod(SIZE), 2)


def test_units_and_forms_of_nifti_stay(rng):
    values = rng.normal(size=(*SIZE, COUNT)).astype(np.float32)
    image = nibabel.Nifti1Image(values, np.diag([0.5, 0.5, 2, 1]))
    image.header.set_xyzt_units("micron", "msec")
    image.header["pixdim"][4], image.header["toffset"] = 40, 7
    nibabel.save(image, "in.nii")
    times = [time for time, _ in series.read_steps("in.nii")]
    np.testing.assert_allclose(times, [0.007, 0.047, 0.087])
    assert deform("in.nii", "out.nii", "--allow-identity") == 0
    found = nibabel.load("out.nii")
    for name in ("pixdim", "toffset", "xyzt_units", "dim", "sform_code", "qform_code"):
        np.testing.assert_array_equal(found.header[name], image.header[name], name)
    np.testing.assert_array_equal(found.affine, image.affine)


@pytest.mark.parametrize(
    "header",
    [
        {"spacings": [1.0, 1.0, 1.0, 2.0]},
        {"spacings": [1.0, 1.0, 1.0, 2.0], "kinds": ["domain"] * 3 + ["time"]},
        {"kinds": ["time"] + ["domain"] * 3, "spacings": [2.0, 1.0, 1.0, 1.0]},
    ],
)
def test_axes_of_pynrrd(header, rng):
    """A time axis without a word about it, and one that is the fastest."""
    is_first = header.get("kinds", [""])[0] == "time"
    values = rng.normal(size=(*SIZE, COUNT)).astype(np.float32)
    nrrd.write("in.nrrd", np.moveaxis(values, -1, 0) if is_first else values, header)
    assert [time for time, _ in series.read_steps("in.nrrd")] == [0, 2, 4]
    assert deform("in.nrrd", "out.nrrd") == 0
    found, fields = nrrd.read("out.nrrd")
    np.testing.assert_array_equal(np.diag(fields["space directions"]), [1, 1, 1, 2])
    nrrd.write("one.nrrd", values[..., 1], {"spacings": [1.0] * 3})
    assert deform("one.nrrd", "alone.nrrd") == 0
    np.testing.assert_array_equal(found[..., 1], nrrd.read("alone.nrrd")[0])


def test_a_series_of_files_becomes_one_file(rng, refused):
    source = itk_image(rng)
    for number in range(COUNT):
        SimpleITK.WriteImage(source[:, :, :, number], f"in_{number + 8}.nii.gz")
    assert deform("in_*.nii.gz", "out.nii.gz") == 0
    found = nibabel.load("out.nii.gz")
    assert found.shape == (*SIZE, COUNT)
    assert found.header["pixdim"][4] == 1
    for number in range(COUNT):
        assert deform(f"in_{number + 8}.nii.gz", "alone.nii.gz") == 0
        expected = np.asarray(nibabel.load("alone.nii.gz").dataobj)
        np.testing.assert_array_equal(np.asarray(found.dataobj)[..., number], expected)
    SimpleITK.WriteImage(source[:8, :, :, 0], "in_99.nii.gz")
    error = refused("deform", "in_*.nii.gz", "handles.csv", "other.nii.gz")
    assert error.startswith("`other.nii.gz` must get images of one grid")
    error = refused("deform", "in_*.nii.gz", "handles.csv", "out.vti")
    assert "only these files can hold: .pvd .mha .mhd" in error


def test_uneven_times_need_a_collection(rng, refused):
    source = itk_image(rng)
    for number in range(COUNT):
        SimpleITK.WriteImage(source[:, :, :, number], f"{number}.mha")
    write_collection([(0, "0.mha"), (1, "1.mha"), (5, "2.mha")])
    error = refused("deform", "in.pvd", "handles.csv", "out.mha")
    assert "its time steps must be equal, got times 0, 1, 5" in error


@pytest.mark.parametrize("step", [0.7, 1.05, 2.1, 1 / 3])
@pytest.mark.parametrize("ending", ["nii.gz", "pvd"])
def test_a_volume_takes_the_handles_of_its_time_however_it_is_rounded(step, ending, rng):
    """Steps are float32 in NIfTI, and have three digits in the collection."""
    volume = rng.integers(0, 99, (*SIZE, 1)).astype(np.int16)
    image = nibabel.Nifti1Image(np.tile(volume, COUNT), np.eye(4))
    image.header["pixdim"][4] = step
    nibabel.save(image, "in.nii.gz")
    nibabel.save(nibabel.Nifti1Image(volume[..., 0], np.eye(4)), "one.nii.gz")
    write_collection([(f"{n * step:.3f}", "one.nii.gz") for n in range(COUNT)])
    rows = [
        [n * step, *p, *(p + n * (q - p))] for n in range(COUNT) for p, q in zip(REST, DEFORMED)
    ]
    write_moving("moving.csv", rows)
    options = ["--background", "0"]
    assert main(["deform", f"in.{ending}", "moving.csv", "out.pvd", *options]) == 0
    for n, (_, read) in enumerate(series.read_steps("out.pvd")):
        np.savetxt("handles.csv", np.hstack([REST, REST + n * (DEFORMED - REST)]), "%.17g", ",")
        assert deform("one.nii.gz", "alone.vti", "--allow-identity") == 0
        alone = io.read_dataset("alone.vti")
        found, expected = (data.GetPointData().GetScalars() for data in (read(), alone))
        np.testing.assert_array_equal(arrays.to_numpy(found), arrays.to_numpy(expected))


def test_one_volume_is_requested_where_one_is_needed(rng, refused):
    SimpleITK.WriteImage(itk_image(rng), "in.nii.gz")
    sentence = "`in.nii.gz` has 3 time steps, expected one; write one of them to a file, for only"
    arguments = "in.nii.gz", "handles.csv", "out.nii.gz"
    assert refused("field", *arguments).startswith(sentence)
    for option in ("--reference", "--mask"):
        assert refused("deform", *arguments, option, "in.nii.gz").startswith(sentence)
