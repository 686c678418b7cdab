"""Units of time and of length in image files, and between all formats that state them."""

import nibabel
import nrrd
import numpy as np
import pytest
import SimpleITK
import tifffile

from vtk_mls import io
from vtk_mls.commands import series
from vtk_mls.commands.cli import main

pytestmark = pytest.mark.usefixtures("folder")
STEP, START, COUNT = 0.75, 1.5, 3  # seconds
VALUES = np.arange(2 * 3 * 4 * COUNT, dtype=np.int16).reshape(COUNT, 4, 3, 2)
SECONDS = {"s": 1, "sec": 1, "ms": 1e-3, "msec": 1e-3, "us": 1e-6, "usec": 1e-6}
SECONDS |= {"\u00b5s": 1e-6, "min": 60, "h": 3600, "": 1, "second": 1, "millisecond": 1e-3}


def write_nifti(unit):
    image = nibabel.Nifti1Image(VALUES.T, np.diag([2, 3, 4, 1]))
    image.header.set_xyzt_units("mm", unit)
    image.header["pixdim"][4], image.header["toffset"] = STEP / SECONDS[unit], START / SECONDS[unit]
    nibabel.save(image, "in.nii")
    assert SimpleITK.ReadImage("in.nii").GetSpacing()[3] == pytest.approx(STEP)
    return "in.nii"


def write_nrrd(unit, **fields):
    steps = np.diag([2, 3, 4, STEP / SECONDS[unit]])
    fields |= {"space dimension": 4, "space directions": steps}
    fields |= {"space origin": [0, 0, 0, START / SECONDS[unit]]}
    nrrd.write("in.nrrd", VALUES.T, {**fields, "space units": ["mm"] * 3 + [unit]})
    return "in.nrrd"


def write_axes(unit):
    """NRRD whose first axis is time, by `spacings` and `units`."""
    fields = {"spacings": [STEP / SECONDS[unit], 2, 3, 4], "units": [unit, *["mm"] * 3]}
    fields |= {"axis mins": [START / SECONDS[unit], *[np.nan] * 3]}
    fields |= {"kinds": ["time"] + ["domain"] * 3}
    nrrd.write("in.nrrd", np.moveaxis(VALUES.T, -1, 0), fields)
    return "in.nrrd"


def write_metaimage(unit):
    image = SimpleITK.GetImageFromArray(VALUES, isVector=False)
    image.SetSpacing((2, 3, 4, STEP))
    image.SetOrigin((0, 0, 0, START))
    SimpleITK.WriteImage(image, "in.mha")
    return "in.mha"


def write_imagej(unit):
    metadata = {"axes": "TZYX", "finterval": STEP / SECONDS[unit], "tunit": unit}
    tifffile.imwrite("in.tif", VALUES, imagej=True, metadata=metadata)
    return "in.tif"


def write_ome(unit):
    metadata = {"axes": "TZYX", "TimeIncrement": STEP / SECONDS[unit], "TimeIncrementUnit": unit}
    tifffile.imwrite("in.ome.tif", VALUES, ome=True, metadata=metadata)
    return "in.ome.tif"


def read_nifti():
    header = nibabel.load("out.nii").header
    unit = header.get_xyzt_units()[1]
    return header["toffset"], header["pixdim"][4], unit


def read_nrrd():
    fields = nrrd.read_header("out.nrrd")
    unit = fields["space units"][3]
    return fields["space origin"][3], fields["space directions"][3, 3], unit


def read_metaimage():
    image = SimpleITK.ReadImage("out.mha")
    return image.GetOrigin()[3], image.GetSpacing()[3], "s"


READ = {"out.nii": read_nifti, "out.nrrd": read_nrrd, "out.mha": read_metaimage}
WRITE = [
    *((write_nifti, unit) for unit in ("sec", "msec", "usec")),
    *((write_nrrd, unit) for unit in ("s", "sec", "ms", "us", "min", "millisecond")),
    *((write_axes, unit) for unit in ("s", "ms")),
    (write_metaimage, "s"),
    *((write_imagej, unit) for unit in ("sec", "ms", "min")),
    *((write_ome, unit) for unit in ("s", "ms", "\u00b5s", "h")),
]


def convert(source, target):
    """Times that are read from a file that is written to another one."""
    steps = series.read_steps(source)
    with series.writing(target, [time for time, _ in steps]) as add:
        for _, read in steps:
            add(read())
    return [time for time, _ in steps]


@pytest.mark.parametrize("through", [None, "out.pvd"])
@pytest.mark.parametrize("target", READ)
@pytest.mark.parametrize(("write", "unit"), WRITE)
def test_times_are_seconds_and_keep_their_unit(write, unit, target, through):
    source = write(unit)
    start = 0 if ".tif" in source else START
    assert convert(source, through or target) == pytest.approx([start + STEP * n for n in range(3)])
    if through:
        convert(through, target)
    found_start, found_step, found_unit = READ[target]()
    factor = SECONDS[found_unit]
    np.testing.assert_allclose([found_start * factor, found_step * factor], [start, STEP], 1e-6)
    if source.rpartition(".")[2] == target.rpartition(".")[2] != "mha":
        assert found_unit == unit  # of the file
    else:
        assert found_unit in ("s", "sec")
    image = SimpleITK.ReadImage(target)
    np.testing.assert_array_equal(SimpleITK.GetArrayFromImage(image), VALUES)
    if found_unit in ("s", "sec") or target == "out.nii":
        np.testing.assert_allclose(image.GetSpacing()[3], STEP, 1e-6)


@pytest.mark.parametrize("unit", ["unknown", "hz", "ppm", "rads"])
@pytest.mark.parametrize("target", READ)
def test_what_is_not_a_time_is_not_converted(unit, target):
    image = nibabel.Nifti1Image(VALUES.T, np.eye(4))
    image.header["pixdim"][4] = 5
    image.header.set_xyzt_units("mm", unit)
    nibabel.save(image, "in.nii")
    assert convert("in.nii", target) == [0, 5, 10]
    if target == "out.nii":
        assert read_nifti()[1:] == (5, unit)
    elif target == "out.nrrd":
        fields = nrrd.read_header("out.nrrd")
        assert fields["space directions"][3, 3] == 5
        names = {"unknown": None, "hz": "Hz", "ppm": "ppm", "rads": "rad/s"}
        assert fields.get("space units", [None])[-1] == names[unit]
    else:
        assert read_metaimage()[1] == 5


@pytest.mark.parametrize("unit", ["s", ""])
def test_counted_times_get_no_unit(unit):
    metadata = {"axes": "TZYX", **({"TimeIncrement": 1.0} if unit else {})}
    tifffile.imwrite("in.ome.tif", VALUES, ome=True, metadata=metadata)
    assert convert("in.ome.tif", "out.nii") == [0, 1, 2]
    assert read_nifti()[2] == ("sec" if unit else "unknown")


def test_lengths_in_micrometers_are_those_of_itk(capsys):
    values = np.random.default_rng(1).uniform(0, 100, (9, 10, 11)).astype(np.float32)
    fields = {"space units": ["microns"] * 3, "space": "LPS", "space origin": [0, 0, 0]}
    nrrd.write("in.nrrd", values.T, {**fields, "space directions": np.diag([2, 3, 4])})
    image = io.read_dataset("in.nrrd")
    assert image.GetSpacing() == (2, 3, 4)
    io.write_dataset(image, "in.nii")
    assert nibabel.load("in.nii").header.get_xyzt_units()[0] == "micron"
    io.write_handles("h.vtp", [(4, 4, 4), (14, 9, 8)], [(5, 4, 3.5), (15, 10, 8)])
    for command, output in (("deform", "out.nii"), ("field", "field.nrrd"), ("field", "field.nii")):
        main([command, "in.nrrd", "h.vtp", output])
    assert (
        "in millimeters, for images in NIfTI, while the input is in um" in capsys.readouterr().err
    )
    assert nrrd.read_header("field.nrrd")["space units"] == ["um"] * 3
    image, expected = map(SimpleITK.ReadImage, ("in.nii", "out.nii"))
    np.testing.assert_allclose(image.GetSpacing(), [2e-3, 3e-3, 4e-3])
    field = SimpleITK.ReadImage("field.nii", SimpleITK.sitkVectorFloat64)
    move = SimpleITK.DisplacementFieldTransform(field)
    found = SimpleITK.Resample(image, expected, move, SimpleITK.sitkLinear, 0.0)
    found, expected = (SimpleITK.GetArrayFromImage(i)[1:-1, 1:-1, 1:-1] for i in (found, expected))
    assert np.abs(expected - values[1:-1, 1:-1, 1:-1]).max() > 10
    np.testing.assert_allclose(found, expected, atol=2e-3)
