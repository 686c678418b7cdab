"""Series of DICOM, written slice by slice by SimpleITK, are placed as SimpleITK's reader does."""

import numpy as np
import pytest
import SimpleITK
from vtk_fixtures import DEFORMED, FAST, REST

from vtk_mls import io
from vtk_mls.cli import main
from vtk_mls.vtk import arrays
from vtk_mls.vtk.arrays import ImageGeometry

UID = "1.2.826.0.1.3680043.2.1125"
TURN = np.array([[0.8, -0.6, 0], [0.6, 0.8, 0], [0, 0, 1]])


def write_series(folder, number=1, count=6, spacing=(0.7, 0.8, 2.5), size=(9, 8), tags=(), at=None):
    """Write slices whose names are not in the order of places; `at` are heights."""
    folder.mkdir(exist_ok=True)
    writer = SimpleITK.ImageFileWriter()
    writer.KeepOriginalImageUIDOn()
    values = np.random.default_rng(number).integers(-1000, 1000, (count, *size[::-1]))
    heights = np.arange(count) * spacing[2] if at is None else at
    for i, layer in enumerate(values.astype(np.int16)):
        image = SimpleITK.GetImageFromArray(layer)
        image.SetSpacing(spacing[:2])
        place = np.array([-10, -20, 30]) + heights[i] * TURN[:, 2]
        for key, value in {
            "0008|0060": "CT",
            "0020|000e": f"{UID}.{number}",
            "0020|000d": f"{UID}.9",
            "0008|103e": f"axial {number}",
            "0020|0037": "\\".join(map(str, [*TURN[:, 0], *TURN[:, 1]])),
            "0020|0032": "\\".join(map(str, place)),
            "0020|0013": str(i),
            "0028|1052": "-1024",
            "0028|1053": "1",
            **dict(tags),
        }.items():
            image.SetMetaData(key, value)
        writer.SetFileName(str(folder / f"{number}_{(5 * i + 3) % 7}_{i}.dcm"))
        writer.Execute(image)
    return sorted(folder.glob(f"{number}_*"), key=lambda path: int(path.stem.split("_")[-1]))


def by_itk(folder, number=1):
    reader = SimpleITK.ImageSeriesReader()
    reader.SetFileNames(reader.GetGDCMSeriesFileNames(str(folder), f"{UID}.{number}"))
    return reader.Execute()


def assert_as_itk(image, expected):
    grid = ImageGeometry.of_image(image).grid
    assert grid.dimensions == expected.GetSize()
    np.testing.assert_allclose(grid.origin, expected.GetOrigin(), atol=1e-9)
    np.testing.assert_allclose(grid.spacing, expected.GetSpacing(), rtol=1e-9)
    np.testing.assert_allclose(grid.direction.ravel(), expected.GetDirection(), atol=1e-9)
    scalars = arrays.to_numpy(image.GetPointData().GetScalars())
    itk_values = SimpleITK.GetArrayFromImage(expected)
    np.testing.assert_array_equal(scalars, itk_values.reshape(-1))
    assert scalars.dtype == itk_values.dtype


def test_a_folder_a_file_and_a_file_without_an_ending(tmp_path):
    names = write_series(tmp_path / "scan")
    expected = by_itk(tmp_path / "scan")
    assert_as_itk(io.read_dataset(tmp_path / "scan"), expected)
    assert_as_itk(io.read_dataset(names[2]), expected)
    names[1].rename(tmp_path / "scan" / "IM_0001")
    assert_as_itk(io.read_dataset(tmp_path / "scan" / "IM_0001"), expected)


def test_the_command_deforms_a_folder(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    write_series(tmp_path / "scan")
    SimpleITK.WriteImage(by_itk("scan"), "scan.nii.gz")
    places = np.array(by_itk("scan").GetOrigin()) + REST
    np.savetxt("handles.csv", np.hstack([places, places + DEFORMED - REST]), "%.17g", ",")
    for source, target in (("scan", "out.nii.gz"), ("scan.nii.gz", "same.nii.gz")):
        assert main(["deform", source, "handles.csv", target, "--device", FAST]) == 0
    found, expected = (SimpleITK.ReadImage(name) for name in ("out.nii.gz", "same.nii.gz"))
    np.testing.assert_allclose(found.GetOrigin(), expected.GetOrigin(), atol=1e-5)
    values = [SimpleITK.GetArrayFromImage(image) for image in (found, expected)]
    assert np.abs(values[0] - values[1].astype(float)).max() <= 1  # float32 places of NIfTI
    capsys.readouterr()


def test_several_series_are_listed(tmp_path):
    write_series(tmp_path / "scan")
    first = write_series(tmp_path / "scan", 2, count=3)[0]
    with pytest.raises(ValueError, match=r"has 2 series: .*axial 1 \(6 slices, "):
        io.read_dataset(tmp_path / "scan")
    assert_as_itk(io.read_dataset(first), by_itk(tmp_path / "scan", 2))


def missing(folder):
    write_series(folder)[2].unlink()


def two_missing(folder):
    for name in write_series(folder, count=9)[4:6]:
        name.unlink()


def uneven(folder):
    write_series(folder, at=[0, 2.5, 5, 8.6, 11, 13.5])


def same_place(folder):
    write_series(folder, at=[0, 2.5, 5, 5, 7.5, 10])


def other_spacing(folder):
    before = [(name, name.read_bytes()) for name in write_series(folder)[:3]]
    write_series(folder, spacing=(0.9, 0.8, 2.5))
    for name, content in before:
        name.write_bytes(content)


def other_size(folder):
    names = write_series(folder)
    image = SimpleITK.ReadImage(str(names[1]))
    metadata = {key: image.GetMetaData(key) for key in image.GetMetaDataKeys()}
    smaller = image[:7]
    for key, value in metadata.items():
        smaller.SetMetaData(key, value)
    writer = SimpleITK.ImageFileWriter()
    writer.KeepOriginalImageUIDOn()
    writer.SetFileName(str(names[1]))
    writer.Execute(smaller)


def truncated(folder):
    name = write_series(folder)[2]
    name.write_bytes(name.read_bytes()[:-60])


def multi_frame(folder):
    folder.mkdir()
    SimpleITK.WriteImage(SimpleITK.Image(5, 6, 7, SimpleITK.sitkUInt16), str(folder / "x.dcm"))


def nothing(folder):
    folder.mkdir()
    (folder / "notes.txt").write_text("no image")


@pytest.mark.parametrize(
    ("make", "sentence"),
    [
        (missing, r"a slice is missing between `\w*_1\.dcm` and `\w*_3\.dcm`: 5 apart, others 2.5"),
        (two_missing, "2 slices are missing between"),
        (uneven, "distances differ between"),
        (same_place, "are slices of the same place"),
        (other_spacing, "the slices must have one spacing, got 0.[79], 0.8"),
        (other_size, "the slices must have one size, got [79], 8"),
        (truncated, r"its file `\w*_2\.dcm` is broken, and may be a slice"),
        (multi_frame, "several images in one file .enhanced DICOM."),
        (nothing, "is a folder; expected a file, or a folder of DICOM images"),
    ],
)
def test_series_that_are_refused(tmp_path, make, sentence, capsys):
    make(tmp_path / "scan")
    assert main(["deform", str(tmp_path / "scan"), "none.csv", str(tmp_path / "out.mha")]) == 1
    with pytest.raises((OSError, ValueError), match=sentence):
        io.read_dataset(tmp_path / "scan")
    assert capsys.readouterr().err.count("\n") == 1
