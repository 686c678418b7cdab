"""TIFF stacks that tifffile writes as ImageJ and OME do."""

import nibabel
import nrrd
import numpy as np
import pytest
import tifffile

from vtk_mls import io
from vtk_mls.cli import main
from vtk_mls.commands import series
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
    arguments = ["--device", "reference"]
    assert main(["deform", "t.tif", "h.csv", "t.nii.gz", *arguments]) == 0
    found = np.asarray(nibabel.load("t.nii.gz").dataobj)
    for number in range(2):
        tifffile.imwrite("one.tif", stack + number)
        assert main(["deform", "one.tif", "h.csv", "one.nii.gz", *arguments]) == 0
        one = np.asarray(nibabel.load("one.nii.gz").dataobj)
        np.testing.assert_array_equal(found[..., number], one)


def two_images(stack):
    tifffile.imwrite("x.tif", stack)
    tifffile.imwrite("x.tif", stack[:2, :5, :4], append=True)


def truncated(stack):
    tifffile.imwrite("x.tif", stack, compression="zlib")
    content = open_bytes()
    with open("x.tif", "wb") as file:
        file.write(content[: len(content) // 2])


def open_bytes():
    with open("x.tif", "rb") as file:
        return file.read()


def no_tiff(stack):
    with open("x.tif", "w") as file:
        file.write("no image")


def complex_numbers(stack):
    tifffile.imwrite("x.tif", stack.astype(np.complex64))


def two_axes_of_layers(stack):
    tifffile.imwrite("x.tif", np.stack([stack, stack]), metadata={"axes": "QZYX"})


@pytest.mark.parametrize(
    ("make", "sentence"),
    [
        (two_images, "it must be one stack, got 2 images"),
        (truncated, "cannot be read|not a readable TIFF"),
        (no_tiff, "not a readable TIFF file"),
        (complex_numbers, "type complex64 are not supported"),
        (two_axes_of_layers, "its axes must be rows, columns and at most one of layers"),
    ],
)
def test_files_that_are_refused(stack, make, sentence, capsys):
    make(stack)
    with pytest.raises(ValueError, match=rf"`x\.tif` cannot be used: .*({sentence})"):
        io.read_dataset("x.tif")
