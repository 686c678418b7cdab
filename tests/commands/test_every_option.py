"""Every option of `vtk-mls deform` and `field`, with every format, has an effect or is refused."""

import re
import shutil
from pathlib import Path

import nibabel
import numpy as np
import pytest
import SimpleITK as sitk
import tifffile
import zarr
from vtk_fixtures import DEFORMED, REST, add_scalars, make_image
from vtkmodules.vtkCommonCore import VTK_UNSIGNED_CHAR
from vtkmodules.vtkFiltersGeometry import vtkImageDataGeometryFilter
from vtkmodules.vtkFiltersSources import vtkPlaneSource

from vtk_mls import Deformation, Grid, io
from vtk_mls.commands import cli
from vtk_mls.files import control_point_files
from vtk_mls.files.block_files import blocks
from vtk_mls.model.handles.curve import CurveHandle
from vtk_mls.vtk import arrays
from vtk_mls.vtk.objects import configured, output_of

FORMATS = {  # input and output of `deform`, and the output of `field`
    "vti": ("in.vti", "out.vti", "out.vti"),
    "nii.gz": ("in.nii.gz", "out.nii.gz", "out.nii.gz"),
    "nrrd": ("in.nrrd", "out.nrrd", "out.nrrd"),
    "mha": ("in.mha", "out.mha", "out.mha"),
    "tif": ("in.tif", "out.mha", "out.nrrd"),
    "ome.zarr": ("in.ome.zarr", "out.ome.zarr", "out.ome.zarr"),
    "mesh": ("in.vtp", "out.vtp", "out.vti"),
}
LABELS = {"nii.gz": "NIFTI", "nrrd": "NRRD", "mha": "MetaImage", "tif": "TIFF"}
# By option: its value, the options that it needs, and the file of handles.
VALUES = {
    "--interpolation": ("nearest",),
    "--background": ("7",),
    "--label": ("{array}",),
    "--grid": ("fitted",),
    "--reference": ("small.nrrd",),
    "--gradient": ("values",),
    "--overlap": (None, ["--cut-plane=4,4,3,1,0,0"]),
    "--cell-quality": (None,),
    "--deformed": ("q.csv",),
    "--pair-by": ("order", ["--deformed", "q.csv"], "p.csv"),
    "--handles-space": ("ras",),
    "--path": ("way_*.csv",),
    "--handle-shapes": ("cells", [], "curve.vtp"),
    "--kind": ("affine",),
    "--degree": ("1", ["--kind", "polynomial"], "many.csv"),
    "--order": ("1", ["--kind", "spline"], "many.csv"),
    "--alpha": ("1",),
    "--smoothing": ("3",),
    "--softening": ("3", ["--kind", "spline", "--order", "1"], "many.csv"),
    "--steps": ("4",),
    "--blend": ("0.5",),
    "--cut-plane": ("4,4,3,1,0,0",),
    "--cut-half-plane": ("4,4,3,1,0,0,0,0,1",),
    "--cut-surface": ("cut.vtp",),
    "--cut-frame": ("deformed", ["--cut-plane=4,4,3,1,1,1"]),
    "--nu": ("8", ["--cut-half-plane=4,4,3,1,0,0,0,0,1"]),
    "--map-tolerance": ("0.1",),
    "--device": ("reference",),
    "--mask-ball": ("4,4,3,2,1",),
    "--mask": ("small.nrrd",),
    "--fixed-plane": ("4,4,3,0,0,1,2",),
    "--sliding-plane": ("4,4,3,0,0,1,2",),
    "--initial-transform": ("shift.nii.gz",),
    "--progress": (None,),
    "--allow-identity": (None, [], "rest.csv"),
    "--scheduler": ("nothing://here",),
    "--inverse": (None,),
    "--jacobian": (None,),
    "--field-convention": ("ants",),
    "--dimensions": ("3,4,5",),
    "--spacing-factor": ("0.5",),
}
ALIKE = {"--device", "--map-tolerance"}  # the output may be the same


def options_of(command):
    """The options of a command, as its parser has them."""
    (commands,) = (a.choices for a in cli._parser()._actions if isinstance(a.choices, dict))
    flags = [a.option_strings[0] for a in commands[command]._actions if a.option_strings]
    return [flag for flag in flags if flag != "-h"]


@pytest.fixture(scope="module")
def inputs(tmp_path_factory):
    """A folder with all inputs."""
    folder = tmp_path_factory.mktemp("inputs")
    rng = np.random.default_rng(1)
    values = rng.integers(100, 200, (7, 8, 9)).astype("uint8")
    image = make_image(origin=(0, 0, 0), spacing=(1, 1, 1))
    add_scalars(image, "values", values.ravel(), VTK_UNSIGNED_CHAR)
    for ending in ("vti", "nii.gz", "nrrd", "mha"):
        io.write_dataset(image, folder / f"in.{ending}")
    tifffile.imwrite(folder / "in.tif", values)
    group = zarr.open_group(folder / "in.ome.zarr", mode="w", zarr_format=3)
    group.create_array("0", data=values, chunks=(4, 4, 4), dimension_names=[*"zyx"])
    sets = [{"path": "0", "coordinateTransformations": [{"type": "scale", "scale": [1.0] * 3}]}]
    scales = {"axes": [{"name": a, "type": "space"} for a in "zyx"], "datasets": sets}
    group.attrs["ome"] = {"version": "0.5", "multiscales": [scales]}
    surface = configured(vtkImageDataGeometryFilter(), InputData=image)
    surface.SetExtent(0, 8, 0, 7, 2, 2)
    io.write_dataset(output_of(surface), folder / "in.vtp")
    small = sitk.GetImageFromArray(np.arange(27, dtype="float32").reshape(3, 3, 3) / 27)
    small.SetSpacing((3.0, 3, 3))
    sitk.WriteImage(small, str(folder / "small.nrrd"))
    cut = configured(vtkPlaneSource(), Origin=(4.3, -20, -20), Point1=[4.3, 20, -20])
    io.write_dataset(output_of(cut, Point2=[4.3, -20, 20]), folder / "cut.vtp")
    names = [*"abcdefgh"]
    many = rng.uniform(0, 7, (20, 3))
    for name, p, q in (
        ("h", REST, DEFORMED),
        ("rest", REST, REST),
        ("many", many, many + rng.uniform(0, 1, (20, 3))),
    ):
        np.savetxt(folder / f"{name}.csv", np.hstack([p, q]), delimiter=",")
    control_point_files.write(folder / "p.csv", REST, REST, None, names)
    control_point_files.write(folder / "q.csv", DEFORMED[::-1], DEFORMED[::-1], None, names[::-1])
    for number, places in enumerate(((REST + DEFORMED) / 2 + 1, DEFORMED)):
        control_point_files.write(folder / f"way_{number}.csv", places, places, None, names)
    io.write_handles(folder / "curve.vtp", REST, DEFORMED, handles=[CurveHandle(REST, DEFORMED)])
    shift = Deformation(REST, DEFORMED, kind="affine", device="reference")
    io.write_transform(shift, folder / "shift.nii.gz", Grid((9, 8, 7)))
    return folder


@pytest.fixture
def folder(inputs, monkeypatch):
    """The current folder, with all inputs."""
    monkeypatch.chdir(inputs)
    return inputs


PLAIN = {}  # results by arguments


def contents(path):
    """All numbers of an output."""
    if path.name.endswith(".zarr"):
        return [zarr.open_array(path / "0", mode="r")[...]]
    found = []
    if path.name.endswith(".nii.gz"):  # as it is in the file
        found.append(np.asarray(nibabel.load(path).dataobj))
    for data in blocks(io.read_dataset(path)):
        found.append(np.array(data.GetBounds()))
        if not data.IsA("vtkImageData"):
            found.append(arrays.to_numpy(data.GetPoints().GetData()).copy())
        for attributes in (data.GetPointData(), data.GetCellData()):
            found += [arrays.to_numpy(array).copy() for array in arrays.all_arrays(attributes)]
    return found


def result(arguments, folder, capsys, caplog):
    """Exit status, numbers and text of a command."""
    for remains in folder.glob("out.*"):
        shutil.rmtree(remains) if remains.is_dir() else remains.unlink()
    capsys.readouterr()
    caplog.clear()
    status = cli.main(arguments)
    printed = capsys.readouterr()
    numbers = contents(folder / arguments[3]) if status == 0 else []
    return status, numbers, f"{printed.out}{printed.err}{caplog.text}"


def is_same(one, other):
    return (one[0], one[2], len(one[1])) == (other[0], other[2], len(other[1])) and all(
        np.array_equal(*pair, equal_nan=True) for pair in zip(one[1], other[1])
    )


def check(command, flag, name, folder, capsys, caplog):
    source, *outputs = FORMATS[name]
    value, needed, handles = (*VALUES[flag], *([], "h.csv")[len(VALUES[flag]) - 1 :])
    arguments = [command, source, handles, outputs[command == "field"], *needed]
    key = folder, *arguments
    plain = PLAIN[key] = PLAIN.get(key) or result(arguments, folder, capsys, caplog)
    arguments.append(flag)
    if value is not None:
        arguments.append(value.format(array=LABELS.get(name, "values")))
    given = result(arguments, folder, capsys, caplog)
    if given[0] == 0:
        assert flag in ALIKE or not is_same(plain, given), f"{flag} is ignored"
    else:
        assert f"`{flag}" in given[2]
        assert re.fullmatch("vtk-mls: [^\n]*\n", given[2])
        assert plain[0] == 0, plain


@pytest.mark.parametrize("name", FORMATS)
@pytest.mark.parametrize("flag", options_of("deform"))
def test_no_option_of_deform_is_ignored(flag, name, folder, capsys, caplog):
    check("deform", flag, name, folder, capsys, caplog)


@pytest.mark.parametrize("name", FORMATS)
@pytest.mark.parametrize("flag", options_of("field"))
def test_no_option_of_field_is_ignored(flag, name, folder, capsys, caplog):
    check("field", flag, name, folder, capsys, caplog)


@pytest.mark.parametrize("command", ["deform", "field"])
@pytest.mark.parametrize(
    ("source", "output", "sentence"),
    [
        ("in.ome.zarr", "in.ome.zarr", "it is the input"),
        ("in.ome.zarr", "in.ome.zarr/out.ome.zarr", "it is in the folder of `in.ome.zarr`, which"),
        ("in.ome.zarr", "in.ome.zarr/0/out.nii.gz", "it is in the folder of `in.ome.zarr`, which"),
        ("in.vtm", "in/in_0.vti", "it is in the folder of `in.vtm`, which is read"),
        ("link.vtm", "in/b.vtm", "it is in the folder of `link.vtm`, which is read"),
        ("in/step_*.vti", "in.pvd", "`in/step_*.vti`, which is read, is in its folder"),
        ("x.zarr/in.vti", "x.zarr", "`x.zarr/in.vti`, which is read, is in its folder"),
        ("x.zarr/in.zarr", "x.zarr", "`x.zarr/in.zarr`, which is read, is in its folder"),
    ],
)
def test_an_output_in_its_input_is_refused(command, source, output, sentence, folder, refused):
    Path("in").mkdir(exist_ok=True)
    Path("link.vtm").unlink(missing_ok=True)
    Path("link.vtm").symlink_to("in.vtm")
    before = sorted(folder.rglob("*"))
    error = refused(command, source, "h.csv", output)
    assert error.startswith(f"`{output}` cannot be written: {sentence}")
    assert sorted(folder.rglob("*")) == before


SAID = {
    "far": (100, 100, "; all control points, at rest (p), are far from the data"),
    "away": (0, 500, "nothing of `IN` is in the output"),
    "crossed": (0, [(0, 0, (-1) ** i * 9) for i in range(8)], "; the map folds at 256 of 379 sam"),
    "--background=-5": (0, 0.1, "must be in the range of each array's type, got -5.0: "),
    "--fixed-plane=4,4,3,0,0,1,2": (0, (0, 0, -0.5), " of 8 handles are not met, by up to "),
}


@pytest.mark.parametrize("case", SAID)
def test_ome_zarr_has_the_remarks_of_other_formats(case, folder, capsys, caplog):
    shift, move, sentence = SAID[case]
    p = REST + shift
    np.savetxt("case.csv", np.hstack([p, p + move + np.eye(8, 3)]), delimiter=",")
    said = []
    for ending in ("nrrd", "ome.zarr"):
        arguments = ["deform", f"in.{ending}", "case.csv", f"out.{ending}"]
        options = [case] * case.startswith("--")
        status, _, text = result([*arguments, *options], folder, capsys, caplog)
        assert status == 0
        assert sentence.replace("IN", f"in.{ending}") in text
        own = rf"{ending}|; 1 resolution|; --grid fitted puts.*|array `NRRD`|the image"
        said.append(re.sub(own, "", text))
    assert said[0] == said[1]
