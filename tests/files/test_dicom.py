"""Series of DICOM, written byte by byte as the standard says, are placed as SimpleITK does."""

import re
import struct

import numpy as np
import pytest
import SimpleITK

from vtk_mls import io
from vtk_mls.commands.cli import main
from vtk_mls.vtk import arrays
from vtk_mls.vtk.arrays import ImageGeometry

UID = "1.2.826.0.1.3680043.2.1125"
MR, REPORT = "1.2.840.10008.5.1.4.1.1.4", "1.2.840.10008.5.1.4.1.1.88.11"
LITTLE, BIG = "1.2.840.10008.1.2.1", "1.2.840.10008.1.2.2"
TURN = np.array([[0.8, -0.6, 0], [0.6, 0.8, 0], [0, 0, 1]])


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


def listed(numbers):
    return "\\".join(map(str, numbers))


def slice_of(k, pixels, slope=1, intercept=0, syntax=LITTLE, series=1, height=None, more=()):
    """A slice with 16-bit pixels (ny, nx), turned, 2.5 above the one before."""
    place = (-10, -20, 30 + (2.5 * k if height is None else height))
    text = {(0x8, 0x16, "UI"): MR, (0x8, 0x18, "UI"): f"{UID}.8.{k}", (0x8, 0x60, "CS"): "MR"}
    text |= {(0x20, 0xD, "UI"): f"{UID}.9", (0x20, 0xE, "UI"): f"{UID}.{series}"}
    text |= {(0x20, 0x13, "IS"): k, (0x8, 0x103E, "LO"): f"axial {series}"}
    text |= {(0x20, 0x32, "DS"): listed(place), (0x20, 0x37, "DS"): listed(TURN.T[:2].ravel())}
    text |= {(0x28, 4, "CS"): "MONOCHROME2", (0x28, 0x30, "DS"): "0.8\\0.7"}
    text |= {(0x28, 0x1052, "DS"): intercept, (0x28, 0x1053, "DS"): slope}
    ny, nx = np.shape(pixels)[:2]
    sizes = {2: 1, 0x10: ny, 0x11: nx, 0x100: 16, 0x101: 16, 0x102: 15, 0x103: 0}
    values = text | {(0x28, element, "US"): value for element, value in sizes.items()}
    order = ">" if syntax == BIG else "<"
    values[0x7FE0, 0x10, "OW"] = np.asarray(pixels).astype(f"{order}u2").tobytes()
    return file_of(values | dict(more), syntax)


def pixels_of(count=6, size=(9, 8)):
    return np.random.default_rng(7).integers(0, 65536, (count, *size[::-1]))


def write_series(folder, series=1, count=6, heights=None):
    """Write slices whose names are not in the order of places; their names in that order."""
    folder.mkdir(exist_ok=True)
    names = [folder / f"{series}_{(5 * k + 3) % 7}_{k}.dcm" for k in range(count)]
    for k, (name, pixels) in enumerate(zip(names, pixels_of(count))):
        height = None if heights is None else heights[k]
        name.write_bytes(slice_of(k, pixels, intercept=-1024, series=series, height=height))
    return names


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
    np.testing.assert_allclose(expected.GetDirection(), TURN.ravel())
    assert_as_itk(io.read_dataset(tmp_path / "scan"), expected)
    assert_as_itk(io.read_dataset(names[2]), expected)
    names[1].rename(tmp_path / "scan" / "IM_0001")
    assert_as_itk(io.read_dataset(tmp_path / "scan" / "IM_0001"), expected)


def test_the_command_deforms_a_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    write_series(tmp_path / "scan")
    SimpleITK.WriteImage(by_itk("scan"), "scan.mha")
    (tmp_path / "handles.csv").write_text("-10,-20,30,-8,-20,30\n")
    for source, target in (("scan", "out.mha"), ("scan.mha", "same.mha")):
        assert main(["deform", source, "handles.csv", target]) == 0
    found, expected = (SimpleITK.ReadImage(name) for name in ("out.mha", "same.mha"))
    assert found.GetOrigin() == expected.GetOrigin()
    np.testing.assert_array_equal(*map(SimpleITK.GetArrayFromImage, (found, expected)))


def test_several_series_are_listed(tmp_path):
    write_series(tmp_path / "scan")
    first = write_series(tmp_path / "scan", 2, count=3)[0]
    with pytest.raises(ValueError, match=r"has 2 series: .*axial 1 \(6 slices, "):
        io.read_dataset(tmp_path / "scan")
    assert_as_itk(io.read_dataset(first), by_itk(tmp_path / "scan", 2))


def missing(folder, places=(2,), count=6):
    for name in [write_series(folder, count=count)[place] for place in places]:
        name.unlink()


def with_another(folder, size=(9, 8), **options):
    """A series whose second slice is another one."""
    pixels = pixels_of(6, size)[1]
    write_series(folder)[1].write_bytes(slice_of(1, pixels, intercept=-1024, **options))


def multi_frame(folder):
    folder.mkdir()
    SimpleITK.WriteImage(SimpleITK.Image(5, 6, 7, SimpleITK.sitkUInt16), str(folder / "x.dcm"))


def nothing(folder):
    folder.mkdir()
    (folder / "notes.txt").write_text("no image")


SPACING = {(0x28, 0x30, "DS"): "0.8\\0.9"}
BYTES = {(0x28, 0x100, "US"): 8, (0x28, 0x101, "US"): 8, (0x28, 0x102, "US"): 7}
COLORS = {(0x28, 2, "US"): 3, (0x28, 4, "CS"): "RGB", (0x28, 6, "US"): 0, **BYTES}
COLORS[0x7FE0, 0x10, "OW"] = bytes(3 * 9 * 8)


@pytest.mark.parametrize(
    ("make", "options", "sentence"),
    [
        (missing, {}, r"a slice is missing between `\w*_1\.dcm` and `\w*_3\.dcm`: 5 apart, oth"),
        (missing, {"places": (4, 5), "count": 9}, "2 slices are missing between"),
        (write_series, {"heights": [0, 2.5, 5, 8.6, 11, 13.5]}, "distances differ between"),
        (write_series, {"heights": [0, 2.5, 5, 5, 7.5, 10]}, "are slices of the same place"),
        (with_another, {"more": SPACING}, "the slices must have one spacing, got 0.[79], 0.8"),
        (with_another, {"size": (7, 8)}, "the slices must have one size, got [79], 8"),
        (with_another, {"more": COLORS}, "must have one number of components, got [13] in"),
        (multi_frame, {}, "several images in one file .enhanced DICOM."),
        (nothing, {}, "is a folder; expected a file, or a folder of DICOM images"),
    ],
)
def test_series_that_are_refused(tmp_path, make, options, sentence, refused):
    make(tmp_path / "scan", **options)
    handles = tmp_path / "handles.csv"
    handles.write_text("0,0,0,1,0,0\n")
    found = refused("deform", tmp_path / "scan", handles, tmp_path / "out.mha")
    assert re.search(sentence, found), found


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
    pixels = pixels_of(4, (16, 12))
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
    for k, pixels in enumerate(pixels_of(6, (16, 12))):
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
