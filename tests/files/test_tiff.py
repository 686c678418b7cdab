"""TIFF stacks that tifffile writes as ImageJ and OME do."""

from importlib.util import find_spec
from pathlib import Path

import nibabel
import nrrd
import numpy as np
import pytest
import SimpleITK
import tifffile

from vtk_mls import io
from vtk_mls.commands import series
from vtk_mls.commands.cli import main
from vtk_mls.vtk import arrays

SHAPE = (6, 7, 8)
OME = {"PhysicalSizeX": 0.5, "PhysicalSizeY": 0.25, "PhysicalSizeZ": 2000}
OME |= {"PhysicalSizeXUnit": "\u00b5m", "PhysicalSizeYUnit": "\u00b5m", "PhysicalSizeZUnit": "nm"}
IMAGEJ = {"axes": "ZYX", "spacing": 2.0, "unit": "um"}


@pytest.fixture(autouse=True)
def stack(tmp_path, monkeypatch, rng):
    monkeypatch.chdir(tmp_path)
    return rng.integers(0, 999, SHAPE).astype(np.uint16)


def values_of(image):
    return arrays.to_numpy(image.GetPointData().GetScalars())


def write(name, stack):
    """A stack with voxels of 0.5 x 0.25 x 2 micrometers, or 1."""
    if name == "imagej.tif":
        tifffile.imwrite(name, stack, imagej=True, resolution=(2, 4), metadata=IMAGEJ)
    elif name == "ome.ome.tif":
        tifffile.imwrite(name, stack, metadata={"axes": "ZYX", **OME}, compression="zlib")
    elif name == "big.tiff":
        tifffile.imwrite(name, stack.astype(">u2"), byteorder=">", metadata=None)
    else:
        with tifffile.TiffWriter(name) as writer:
            for page in stack:
                writer.write(page, contiguous=True, metadata=None)


@pytest.mark.parametrize("name", ["imagej.tif", "ome.ome.tif", "pages.tif", "big.tiff"])
def test_values_spacing_and_unit(stack, name):
    write(name, stack)
    image = io.read_dataset(name)
    has_unit = name in ("imagej.tif", "ome.ome.tif")
    np.testing.assert_array_equal(values_of(image), stack.ravel())
    np.testing.assert_allclose(image.GetSpacing(), (0.5, 0.25, 2) if has_unit else (1, 1, 1))
    io.write_dataset(image, "out.nrrd")
    io.write_dataset(image, "out.nii")
    units = nrrd.read_header("out.nrrd").get("space units")
    assert units == (["um"] * 3 if has_unit else None)
    header = nibabel.load("out.nii").header
    assert header.get_xyzt_units()[0] == ("micron" if has_unit else "mm")
    np.testing.assert_allclose(header.get_zooms(), image.GetSpacing())


def test_channels_colors_and_times(stack):
    tifffile.imwrite("c.ome.tif", np.stack([stack, stack + 1]), metadata={"axes": "CZYX"})
    image = io.read_dataset("c.ome.tif")
    expected = np.stack([stack.ravel(), stack.ravel() + 1], axis=1)
    np.testing.assert_array_equal(values_of(image), expected)
    colors = np.arange(7 * 8 * 3, dtype=np.uint8).reshape(7, 8, 3)
    tifffile.imwrite("rgb.tif", colors, photometric="rgb")
    np.testing.assert_array_equal(values_of(io.read_dataset("rgb.tif")), colors.reshape(-1, 3))
    movie = np.stack([stack, stack + 1])[:, :, None]
    details = {"axes": "TZCYX", "finterval": 0.5}
    tifffile.imwrite("t.tif", movie, imagej=True, metadata=details)
    np.savetxt("h.csv", [[1, 1, 1, 2, 1, 1], [5, 5, 5, 5, 5, 5]], "%g", ",")
    assert [time for time, _ in series.read_steps("t.tif")] == [0, 0.5]
    arguments = ["--background", "0"]
    assert main(["deform", "t.tif", "h.csv", "t.nii.gz", *arguments]) == 0
    found = np.asarray(nibabel.load("t.nii.gz").dataobj)
    for number in range(2):
        tifffile.imwrite("one.tif", stack + number)
        assert main(["deform", "one.tif", "h.csv", "one.nii.gz", *arguments]) == 0
        one = np.asarray(nibabel.load("one.nii.gz").dataobj)
        np.testing.assert_array_equal(found[..., number], one)


MICROMETERS = {"nm": 1e-3, "mm": 1e3, "km": 1e9, "pm": 1e-6, "\u00c5": 1e-4, "in": 25400}
MICROMETERS |= {"\u00b5m": 1, "yd": 914400}


def sizes(stack, **metadata):
    """Spacing and unit of an OME-TIFF."""
    tifffile.imwrite("s.ome.tif", stack, metadata={"axes": "ZYX", **metadata})
    image, unit = io.read_dataset("s.ome.tif"), ""
    if image.GetFieldData().HasArray("LengthUnit"):
        unit = image.GetFieldData().GetAbstractArray("LengthUnit").GetValue(0)
    return image.GetSpacing(), unit


@pytest.mark.parametrize("unit", MICROMETERS)
def test_sizes_of_ome_are_in_the_unit_of_the_first(stack, unit, caplog):
    plane = {"PhysicalSizeX": 5.0, "PhysicalSizeXUnit": unit, "PhysicalSizeY": 4.0}
    plane |= {"PhysicalSizeYUnit": unit, "PhysicalSizeZ": 3.0}  # no unit: micrometers
    spacing, found = sizes(stack, **plane)
    np.testing.assert_allclose(spacing, (5, 4, 3 / MICROMETERS[unit]))
    assert found == {"\u00c5": "angstrom", "\u00b5m": "um"}.get(unit, unit)
    assert not caplog.records
    io.write_dataset(io.read_dataset("s.ome.tif"), "out.nii")
    header = nibabel.load("out.nii").header
    scale = {"micron": 1, "mm": 1e3}[header.get_xyzt_units()[0]]
    expected = np.multiply((5, 4, 3 / MICROMETERS[unit]), MICROMETERS[unit])
    np.testing.assert_allclose(np.multiply(header.get_zooms(), scale), expected, rtol=1e-6)


@pytest.mark.parametrize(
    ("stated", "spacing", "unit", "axes"),
    [
        ({"X": 0.25, "Y": 0.5}, (0.25, 0.5, 0.25), "um", "z"),
        ({"X": (5.0, "nm"), "Y": (5.0, "nm")}, (5, 5, 5), "nm", "z"),
        ({"Y": (2.0, "mm"), "Z": 500.0}, (2, 2, 0.5), "mm", "x"),
        ({"X": 0.25, "Y": 0.25, "Z": (7.0, "reference frame")}, (0.25, 0.25, 0.25), "um", "z"),
        ({axis: (2.0, "pixel") for axis in "XYZ"}, (2, 2, 2), "", ""),
        ({axis: (2.0, "Mm") for axis in "XYZ"}, (2, 2, 2), "", ""),
        ({}, (1, 1, 1), "", ""),
    ],
)
def test_an_unknown_size_of_ome_is_reported(stack, stated, spacing, unit, axes, caplog):
    metadata = {}
    for axis, size in stated.items():
        size, name = size if isinstance(size, tuple) else (size, "\u00b5m")
        metadata |= {f"PhysicalSize{axis}": size, f"PhysicalSize{axis}Unit": name}
    assert sizes(stack, **metadata) == (spacing, unit)
    messages = [record.getMessage() for record in caplog.records]
    assert len(messages) == len(axes)
    for message, axis in zip(messages, axes):
        assert f"does not state the size of voxels along {axis}" in message
    caplog.clear()
    sizes(stack[:1], **metadata)
    assert len(caplog.records) == ("x" in axes)  # the thickness of one layer


def test_units_of_imagej(stack):
    details = {**IMAGEJ, "unit": "inch", "zunit": "mm"}
    tifffile.imwrite("x.tif", stack, imagej=True, resolution=(2, 4), metadata=details)
    np.testing.assert_allclose(io.read_dataset("x.tif").GetSpacing(), (0.5, 0.25, 2 / 25.4))


@pytest.mark.parametrize("components", [(), (3,)])
def test_pages_that_are_written_one_by_one_are_a_stack(rng, components):
    pages = rng.integers(0, 99, (*SHAPE, *components)).astype(np.uint8)
    with tifffile.TiffWriter("x.tif") as writer:
        for page in pages:
            writer.write(page, contiguous=False, photometric="rgb" if components else "minisblack")
    image = io.read_dataset("x.tif")
    assert image.GetDimensions() == SHAPE[::-1]
    np.testing.assert_array_equal(values_of(image), pages.reshape(-1, *components))


@pytest.mark.skipif(find_spec("imagecodecs") is not None, reason="reads LZW")
def test_the_package_for_lzw_is_named(rng):
    writer = SimpleITK.ImageFileWriter()
    writer.SetFileName("x.tif")
    writer.UseCompressionOn()
    writer.SetCompressor("LZW")
    writer.Execute(SimpleITK.GetImageFromArray(rng.integers(0, 99, SHAPE).astype(np.uint8)))
    with pytest.raises(
        ValueError, match=r"used: it needs the package imagecodecs: pip install imagecodecs \(.*LZW"
    ):
        io.read_dataset("x.tif")


def appended(first, second):
    tifffile.imwrite("x.tif", first)
    tifffile.imwrite("x.tif", second, append=True)


def truncated(stack):
    tifffile.imwrite("x.tif", stack, compression="zlib")
    content = Path("x.tif").read_bytes()
    Path("x.tif").write_bytes(content[: len(content) // 2])


ONE = "it must be one stack, got 2 images"
REFUSED = {
    "two images": (lambda a: appended(a, a[:2, :5, :4]), f"{ONE} of different sizes or types"),
    "two stacks": (lambda a: appended(a, a), f"{ONE}$"),
    "two types": (lambda a: appended(a[0], a[0].astype("f4")), f"{ONE} of different sizes or ty"),
    "truncated": (truncated, "cannot be read|not a readable TIFF"),
    "no tiff": (lambda a: Path("x.tif").write_text("no image"), "not a readable TIFF file"),
    "complex": (lambda a: tifffile.imwrite("x.tif", a.astype("c8")), "type complex64 are not supp"),
    "two axes of layers": (
        lambda a: tifffile.imwrite("x.tif", np.stack([a, a]), metadata={"axes": "QZYX"}),
        "its axes must be rows, columns and at most one of layers",
    ),
}


@pytest.mark.parametrize("case", REFUSED)
def test_files_that_are_refused(stack, case):
    make, sentence = REFUSED[case]
    make(stack)
    with pytest.raises(ValueError, match=rf"`x\.tif` cannot be used: .*({sentence})"):
        io.read_dataset("x.tif")
