"""Labels are not mixed, and segments keep their names."""

import nibabel
import nrrd
import numpy as np
import pytest
import SimpleITK
import slicer_peer
from file_fixtures import DRAGGED, HANDLES, RIGHT, as_itk, as_nifti, nrrd_bytes, scalars
from pipelines import connect, control_points, update
from slicer_peer import needs_slicer
from vtk_fixtures import add_array

from vtk_mls import io
from vtk_mls.commands.cli import main
from vtk_mls.files import control_point_files, metadata
from vtk_mls.filters import MLSDeform

LABELS = np.zeros((7, 8, 9), np.uint8)
LABELS[2:5, 2:6, 1:5] = 1
LABELS[2:5, 2:6, 5:8] = 4
SEGMENTS = """Segment0_Color:=0.5 0.25 1
Segment0_Extent:=1 4 2 5 2 4
Segment0_ID:=Segment_1
Segment0_LabelValue:=1
Segment0_Layer:=0
Segment0_Name:=bone: left & \u00fcber
Segment1_Color:=1 0 0
Segment1_Extent:=5 7 2 5 2 4
Segment1_ID:=Segment_2
Segment1_LabelValue:=4
Segment1_Layer:=0
Segment1_Name:=vessel
Segmentation_MasterRepresentation:=Binary labelmap
Segmentation_ReferenceImageExtentOffset:=0 0 0
"""


def _segmentation(path):
    path.write_bytes(nrrd_bytes("LPS", RIGHT, LABELS, SEGMENTS))


def _nifti(path):
    image = as_nifti(RIGHT, LABELS)
    image.header.set_intent("label")
    nibabel.save(image, path)


def _by_itk(path):
    _nifti(path.with_name("y.nii"))
    SimpleITK.WriteImage(SimpleITK.ReadImage(str(path.with_name("y.nii"))), str(path))


MAKERS = {
    ".seg.nrrd": _segmentation,
    ".nii.gz": _nifti,
    ".mha": _by_itk,
    ".nrrd": _by_itk,
}


def deform(path, output, *options, dragged=DRAGGED):
    handles = path.with_name("h.csv")
    control_point_files.write(handles, HANDLES, dragged)
    arguments = ["deform", path, handles, output, *options]
    assert main(list(map(str, arguments))) == 0


@pytest.mark.parametrize("suffix", MAKERS)
@pytest.mark.parametrize("interpolation", ["linear", "cubic"])
def test_no_label_is_invented(tmp_path, suffix, interpolation):
    MAKERS[suffix](tmp_path / f"x{suffix}")
    output = tmp_path / f"out{suffix}"
    deform(tmp_path / f"x{suffix}", output, "--interpolation", interpolation)
    values = SimpleITK.GetArrayFromImage(SimpleITK.ReadImage(str(output)))
    assert set(np.unique(values)) == {0, 1, 4}
    assert (values != LABELS).sum() > 20
    # they are still labels for the next step, in any format
    for suffix in (".mha", ".nrrd", ".nii"):
        io.write_dataset(io.read_dataset(output), tmp_path / f"next{suffix}")
        assert metadata.load(io.read_dataset(tmp_path / f"next{suffix}"), "LabelArrays")


def test_a_volume_of_the_same_numbers_is_mixed(tmp_path):
    SimpleITK.WriteImage(as_itk(RIGHT, LABELS), str(tmp_path / "x.mha"))
    deform(tmp_path / "x.mha", tmp_path / "out.mha")
    assert not set(np.unique(scalars(io.read_dataset(tmp_path / "out.mha")))) <= {0, 1, 4}


def test_labels_after_scaling_are_none(tmp_path):
    image = as_nifti(RIGHT, LABELS)
    image.header.set_intent("label")
    image.header.set_slope_inter(0.5, 0)
    nibabel.save(image, tmp_path / "x.nii")
    assert metadata.load(io.read_dataset(tmp_path / "x.nii"), "LabelArrays") == ()


REFERENCE = (
    "Segmentation_ConversionParameters:=Reference image geometry|9;0;0;-1;0;9;0;-2;0;0;9;3;0;0;0;1;"
    "0;29;0;29;0;19;|Description&Oversampling factor|1|Another&\n"
    "Segmentation_ReferenceImageExtentOffset:=3 4 5\n"
)


@pytest.mark.parametrize("grid", ["input", "fitted", "reference"])
def test_the_reference_geometry_of_slicer_is_that_of_the_file(tmp_path, grid):
    """An image on the grid of its file keeps another one, such as that of a whole scan."""
    header = SEGMENTS.rpartition("Segmentation_Ref")[0] + REFERENCE
    (tmp_path / "x.seg.nrrd").write_bytes(nrrd_bytes("LPS", RIGHT, LABELS, header))
    SimpleITK.WriteImage(SimpleITK.Image(20, 21, 22, SimpleITK.sitkUInt8), str(tmp_path / "r.mha"))
    options = ("--reference", tmp_path / "r.mha") if grid == "reference" else ("--grid", grid)
    for name in ("out.seg.nrrd", "again.seg.nrrd"):
        deform(tmp_path / "x.seg.nrrd", tmp_path / name, *options, dragged=DRAGGED + [4, 0, 0])
    old, new = (nrrd.read_header(str(tmp_path / name)) for name in ("x.seg.nrrd", "out.seg.nrrd"))
    key, offset = "Segmentation_ConversionParameters", "Segmentation_ReferenceImageExtentOffset"
    if grid == "input":
        assert (new[key], new[offset]) == (old[key], "3 4 5")
        return
    geometry = np.array(new[key].split("|")[1].split(";")[:-1], float)
    to_ras = np.diag([-1, -1, 1]) @ np.column_stack(
        [new["space directions"].T, new["space origin"]]
    )
    np.testing.assert_allclose(geometry[:12].reshape(3, 4), to_ras, atol=1e-12)
    np.testing.assert_array_equal(geometry[12:17:2], [0, 0, 0])
    np.testing.assert_array_equal(geometry[16:], np.c_[np.zeros(3), new["sizes"] - 1].ravel())
    assert new[key].split("|")[2:] == old[key].split("|")[2:]
    assert new[offset] == "0 0 0"


@pytest.mark.parametrize("suffix", [".nrrd", ".mha"])
def test_keys_about_another_grid_are_left_out(tmp_path, suffix):
    source = as_itk(RIGHT, LABELS.astype(np.int16))
    about_grid = {
        "0020|0032": "1\\2\\3",
        "0028|0030": "1\\1",
        "srow_x": "1 0 0 0",
        "pixdim[1]": "1",
    }
    others = {"0010|0010": "anonymous", "descrip": "about nothing"}
    for key, text in (about_grid | others).items():
        source.SetMetaData(key, text)
    SimpleITK.WriteImage(source, str(tmp_path / f"x{suffix}"))
    image = io.read_dataset(tmp_path / f"x{suffix}")
    for expected in (about_grid | others, others):
        io.write_dataset(image, tmp_path / f"y{suffix}")
        written = SimpleITK.ReadImage(str(tmp_path / f"y{suffix}"))
        kept = {key: written.GetMetaData(key) for key in written.GetMetaDataKeys()}
        assert {key: kept[key] for key in about_grid | others if key in kept} == expected
        image.SetSpacing(1, 2, 3)


SLICER_SEGMENTS = """
import sys, slicer
from vtk.util.numpy_support import vtk_to_numpy
scene = slicer.vtkMRMLScene()
for path in sys.argv[1:]:
    node, storage = slicer.vtkMRMLSegmentationNode(), slicer.vtkMRMLSegmentationStorageNode()
    scene.AddNode(node)
    storage.SetFileName(path)
    assert storage.ReadData(node)
    for number in range(node.GetSegmentation().GetNumberOfSegments()):
        segment = node.GetSegmentation().GetNthSegment(number)
        image, label = segment.GetRepresentation("Binary labelmap"), segment.GetLabelValue()
        count = (vtk_to_numpy(image.GetPointData().GetScalars()) == label).sum()
        print("#", segment.GetName(), *segment.GetColor(), label, count, sep="|")
"""


@needs_slicer
def test_slicer_reads_the_segments(tmp_path):
    _segmentation(tmp_path / "x.seg.nrrd")
    paths, expected = [], []
    far = DRAGGED + [4, 0, 0]  # out of the old extents
    for grid in ("input", "fitted"):
        deform(tmp_path / "x.seg.nrrd", tmp_path / "out.seg.nrrd", "--grid", grid, dragged=far)
        for name in ("out.seg.nrrd", "out.nrrd", "out.seg.nhdr"):
            paths.append(tmp_path / f"{grid}-{name}")
            io.write_dataset(io.read_dataset(tmp_path / "out.seg.nrrd"), paths[-1])
            values = SimpleITK.GetArrayFromImage(SimpleITK.ReadImage(str(paths[-1])))
            counts = [str((values == label).sum()) for label in (1, 4)]
            expected.append(["bone: left & \u00fcber", "0.5", "0.25", "1.0", "1", counts[0]])
            expected.append(["vessel", "1.0", "0.0", "0.0", "4", counts[1]])
    printed = slicer_peer.run(SLICER_SEGMENTS, *paths).splitlines()
    assert [line.split("|")[1:] for line in printed if line.startswith("#")] == expected


def test_segments_in_layers_overlap(tmp_path):
    layers = np.stack([LABELS, np.roll(LABELS, 2, axis=1)], axis=-1)
    segments = SEGMENTS.replace("1_Layer:=0", "1_Layer:=1")
    content = nrrd_bytes("LPS", RIGHT, layers, segments, "list")
    (tmp_path / "x.seg.nrrd").write_bytes(content)
    image = io.read_dataset(tmp_path / "x.seg.nrrd")
    np.testing.assert_array_equal(scalars(image), layers.reshape(-1, 2))
    io.write_dataset(image, tmp_path / "y.seg.nrrd")
    back = SimpleITK.ReadImage(str(tmp_path / "y.seg.nrrd"))
    np.testing.assert_array_equal(SimpleITK.GetArrayFromImage(back), layers)
    assert back.GetMetaData("Segment1_Layer") == "1"
    assert back.GetMetaData("Segment1_Extent") == "0 8 0 7 0 6"
    deform(tmp_path / "x.seg.nrrd", tmp_path / "out.seg.nrrd")
    assert set(np.unique(scalars(io.read_dataset(tmp_path / "out.seg.nrrd")))) == {0, 1, 4}


def test_a_segmentation_holds_integers(tmp_path):
    SimpleITK.WriteImage(as_itk(RIGHT, LABELS.astype(np.float32)), str(tmp_path / "x.mha"))
    image = io.read_dataset(tmp_path / "x.mha")
    with pytest.raises(ValueError, match=r"y\.seg\.nrrd` is for labels.*float32"):
        io.write_dataset(image, tmp_path / "y.seg.nrrd")
    assert not (tmp_path / "y.seg.nrrd").exists()


def test_arrays_that_are_not_labels_are_not_marked_as_labels(tmp_path):
    """A volume beside the labels, in the dataset that came from their file."""
    _segmentation(tmp_path / "x.seg.nrrd")
    image = io.read_dataset(tmp_path / "x.seg.nrrd")
    add_array(image.GetPointData(), "CT", LABELS.ravel())
    image.GetPointData().SetActiveScalars("CT")
    for suffix in (".nrrd", ".mha", ".nii"):
        io.write_dataset(image, tmp_path / f"y{suffix}")
        back = io.read_dataset(tmp_path / f"y{suffix}")
        assert metadata.load(back, metadata.LABEL_ARRAYS) == ()
    assert b"Segment" not in (tmp_path / "y.nrrd").read_bytes()


def test_other_arrays_than_those_of_labels_are_mixed(tmp_path):
    """Field data name the arrays, in any dataset; names of arrays that are gone do no harm."""
    _segmentation(tmp_path / "x.seg.nrrd")
    image = io.read_dataset(tmp_path / "x.seg.nrrd")
    add_array(image.GetPointData(), "CT", LABELS.ravel())
    metadata.store(image, metadata.LABEL_ARRAYS, ["NRRD", "gone"])
    deforming = connect(MLSDeform(), image, control_points(HANDLES, DRAGGED))
    deforming.SetDevice("reference")
    output = update(deforming).GetPointData()
    assert set(np.unique(scalars(update(deforming)))) == {0, 1, 4}
    assert metadata.load(update(deforming), metadata.LABEL_ARRAYS) == ("NRRD", "gone")
    values = {output.GetArray("CT").GetValue(i) for i in range(504)}
    assert not values <= {0, 1, 4}
