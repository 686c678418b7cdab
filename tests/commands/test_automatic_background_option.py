"""`vtk-mls deform --background auto`, the default, against numpy's median of the corners."""

import nibabel
import numpy as np
import pytest
import SimpleITK

from vtk_mls.commands.cli import main


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    """The current folder, with handles that move all far away."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "handles.csv").write_text("0,0,0,900,0,0\n")
    return tmp_path


def deform(source, target, *options):
    return main(["deform", source, "handles.csv", target, *options])


@pytest.mark.parametrize("shape", [(5, 6, 7), (6, 7)], ids=["volume", "flat"])
def test_the_background_is_the_median_of_the_corners(shape, rng, capsys):
    values = rng.uniform(-1024, 3000, shape).astype("int16")
    corners = values[np.ix_(*[[0, -1]] * len(shape))]
    median = np.percentile(corners, 50, method="lower")
    SimpleITK.WriteImage(SimpleITK.GetImageFromArray(values), "in.mha")
    assert deform("in.mha", "out.mha") == 0
    found = SimpleITK.GetArrayFromImage(SimpleITK.ReadImage("out.mha"))
    assert (found == median).all()
    said = capsys.readouterr().out
    assert said.count("; background ") == 1
    assert f"; background {median:g}, the median of the corners" in said
    assert deform("in.mha", "out.mha", "--background", "3") == 0
    found = SimpleITK.GetArrayFromImage(SimpleITK.ReadImage("out.mha"))
    assert (found == 3).all()
    assert "median" not in capsys.readouterr().out


def test_labels_have_the_background_0_without_a_warning(capsys):
    SimpleITK.WriteImage(SimpleITK.Image([5, 6, 7], SimpleITK.sitkUInt8) + 4, "in.mha")
    assert deform("in.mha", "out.mha", "--label", "MetaImage") == 0
    assert not SimpleITK.GetArrayFromImage(SimpleITK.ReadImage("out.mha")).any()
    assert "median" not in capsys.readouterr().out


def test_a_series_has_the_background_of_its_first_step(capsys):
    values = np.full((6, 5, 4, 3), [-1000, 20, 30], np.int16)
    nibabel.save(nibabel.Nifti1Image(values, np.eye(4)), "in.nii.gz")
    assert deform("in.nii.gz", "out.nii.gz") == 0
    assert (np.asanyarray(nibabel.load("out.nii.gz").dataobj) == -1000).all()
    assert capsys.readouterr().out.count("background -1000, the median of the corners") == 1
