"""Series of DICOM, written slice by slice by SimpleITK, are placed as SimpleITK's reader does.

Slices with other rescaling, and broken ones, are written byte by byte, as the standard says.
"""

import struct

import numpy as np
import pytest
import SimpleITK
from vtk_fixtures import DEFORMED, FAST, REST

from vtk_mls import io
from vtk_mls.commands.cli import main
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


MR, REPORT = "1.2.840.10008.5.1.4.1.1.4", "1.2.840.10008.5.1.4.1.1.88.11"
LITTLE, BIG = "1.2.840.10008.1.2.1", "1.2.840.10008.1.2.2"


def elements(values, order):
    """Data elements, explicit VR."""
    content = b""
    for (group, element, kind), value in sorted(values.items()):
        if kind == "US":
            value = struct.pack(f"{order}H", value)
        elif kind != "OW":
            value = str(value).encode()
            value += (b"\0" if kind == "UI" else b" ") * (len(value) % 2)
        size = struct.pack(f"{order}xxI" if kind == "OW" else f"{order}H", len(value))
        content += struct.pack(f"{order}HH", group, element) + kind.encode() + size + value
    return content


def file_of(values, syntax=LITTLE, storage=MR):
    head = elements({(2, 2, "UI"): storage, (2, 3, "UI"): f"{UID}.3", (2, 16, "UI"): syntax}, "<")
    return bytes(128) + b"DICM" + head + elements(values, ">" if syntax == BIG else "<")


def slice_of(k, pixels, slope=1, intercept=0, syntax=LITTLE):
    """A slice, whose pixels (ny, nx) are 16-bit."""
    text = {(0x8, 0x16, "UI"): MR, (0x8, 0x18, "UI"): f"{UID}.8.{k}", (0x8, 0x60, "CS"): "MR"}
    text |= {(0x20, 0xD, "UI"): f"{UID}.9", (0x20, 0xE, "UI"): f"{UID}.1", (0x20, 0x13, "IS"): k}
    text |= {(0x20, 0x32, "DS"): f"0\\0\\{2 * k}", (0x20, 0x37, "DS"): "1\\0\\0\\0\\1\\0"}
    text |= {(0x28, 4, "CS"): "MONOCHROME2", (0x28, 0x30, "DS"): "1\\1"}
    text |= {(0x28, 0x1052, "DS"): intercept, (0x28, 0x1053, "DS"): slope}
    sizes = {
        2: 1,
        0x10: len(pixels),
        0x11: len(pixels[0]),
        0x100: 16,
        0x101: 16,
        0x102: 15,
        0x103: 0,
    }
    values = text | {(0x28, element, "US"): value for element, value in sizes.items()}
    order = ">" if syntax == BIG else "<"
    return file_of(values | {(0x7FE0, 0x10, "OW"): pixels.astype(f"{order}u2").tobytes()}, syntax)


@pytest.mark.parametrize(
    ("slopes", "intercepts", "dtype"),
    [
        ([1, 0.5, 0.25, 0.3], [0] * 4, float),
        ([1, 1e-3, 1e-3, 2], [0] * 4, float),
        ([1, 1, 1, 1], [0, 0, 0, -0.5], float),
        ([1, 1, 1, 1], [0, -1024, -1024, -1024], np.int32),
        ([1, 1, 1, 3], [0, 0, 0, 0], np.uint32),
        ([1, 1, 1, 1], [0, 0, 0, 0], np.uint16),
    ],
)
def test_each_slice_has_its_own_rescaling(tmp_path, slopes, intercepts, dtype):
    pixels = np.random.default_rng(7).integers(0, 65536, (4, 12, 16))
    for k in range(4):
        (tmp_path / f"{k}").write_bytes(slice_of(k, pixels[k], slopes[k], intercepts[k]))
    scalars = arrays.to_numpy(io.read_dataset(tmp_path).GetPointData().GetScalars())
    expected = pixels * np.reshape(slopes, (4, 1, 1)) + np.reshape(intercepts, (4, 1, 1))
    np.testing.assert_array_equal(scalars, expected.ravel())
    assert scalars.dtype.kind == np.dtype(dtype).kind
    assert scalars.dtype.itemsize >= np.dtype(dtype).itemsize


@pytest.mark.parametrize("syntax", [LITTLE, BIG])
@pytest.mark.parametrize("place", [2, 5])
def test_a_slice_cut_off_anywhere_is_an_error(tmp_path, syntax, place):
    pixels = np.ones((12, 16), int)
    for k in range(6):
        (tmp_path / f"{k}.dcm").write_bytes(slice_of(k, pixels, syntax=syntax))
    cut = tmp_path / f"{place}.dcm"
    content = cut.read_bytes()
    assert io.read_dataset(tmp_path).GetDimensions() == (16, 12, 6)
    for size in [0, 100, *range(133, len(content), 37), len(content) - 1]:
        cut.write_bytes(content[:size])
        with pytest.raises(
            ValueError, match=rf"its file `{place}\.dcm` is broken, and may be a sl"
        ):
            io.read_dataset(tmp_path)


def test_other_files_in_the_folder_do_not_matter(tmp_path):
    write_series(tmp_path)
    expected = by_itk(tmp_path)
    report = {(0x8, 0x16, "UI"): REPORT, (0x20, 0xE, "UI"): f"{UID}.1", (0x40, 0xA160, "LO"): "ok"}
    (tmp_path / "report.dcm").write_bytes(file_of(report, storage=REPORT))
    directory = file_of({(0x28, 0x10, "US"): 64}, storage="1.2.840.10008.1.3.10")
    (tmp_path / "dicomdir").write_bytes(directory)
    for name in ("scan.jpg", "notes.txt", ".DS_Store", "._1.dcm", "VERSION"):
        (tmp_path / name).write_bytes(b"anything")
    assert_as_itk(io.read_dataset(tmp_path), expected)


def test_slices_of_colors_and_of_gray_do_not_mix(tmp_path):
    names = write_series(tmp_path)
    color = SimpleITK.ReadImage(str(names[1]))
    metadata = {key: color.GetMetaData(key) for key in color.GetMetaDataKeys()}
    color = SimpleITK.Compose(*[SimpleITK.Cast(color, SimpleITK.sitkUInt8)] * 3)
    for key in ("0008|0060", "0020|000e", "0020|000d", "0020|0037", "0020|0032"):
        color.SetMetaData(key, metadata[key])
    writer = SimpleITK.ImageFileWriter()
    writer.KeepOriginalImageUIDOn()
    writer.SetFileName(str(names[1]))
    writer.Execute(color)
    with pytest.raises(
        ValueError, match="the slices must have one number of components, got [13] in"
    ):
        io.read_dataset(tmp_path)
