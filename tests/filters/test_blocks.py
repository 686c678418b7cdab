"""Images in blocks, AMR data, and control points that are any point set."""

import numpy as np
import pytest
from mesh_fixtures import array_of, cells, deforming, places_of, set_places
from vtk_fixtures import DEFORMED, REST, add_array, connect, control_points, make_image, update
from vtkmodules.vtkCommonDataModel import (
    VTK_HEXAHEDRON,
    VTK_TETRA,
    vtkMultiBlockDataSet,
    vtkNonOverlappingAMR,
    vtkPartitionedDataSet,
    vtkPartitionedDataSetCollection,
    vtkPointSet,
    vtkPolyData,
    vtkRectilinearGrid,
    vtkStructuredGrid,
    vtkUnstructuredGrid,
)
from vtkmodules.vtkFiltersSources import vtkSphereSource
from vtkmodules.vtkImagingCore import vtkExtractVOI
from vtkmodules.vtkIOXML import vtkXMLMultiBlockDataWriter

from vtk_mls import cli
from vtk_mls.filters import MLSDeform, MLSDisplacementField

try:
    from vtkmodules.vtkFiltersAMR import vtkAMRGaussianPulseSource
except ImportError:  # before VTK 9.5
    from vtkmodules.vtkFiltersSources import vtkAMRGaussianPulseSource

SEAM = "Warning: MLSDeform: `Input` has images in several blocks"


def halves(gap=0):
    """An image in two parts; `gap` voxels between them are in neither."""
    whole = make_image((21, 8, 7))
    add_array(whole.GetPointData(), "one", np.ones(21 * 8 * 7))
    parts = []
    for first, last in ((0, 10 - gap), (10, 20)):
        part = vtkExtractVOI()
        part.SetInputData(whole)
        part.SetVOI(first, last, 0, 7, 0, 6)
        parts.append(update(part))
    return parts


def composite(kind, parts):
    data = kind()
    for number, part in enumerate(parts):
        if kind is vtkMultiBlockDataSet:
            data.SetBlock(number, part)
        elif kind is vtkPartitionedDataSet:
            data.SetPartition(number, part)
        else:
            data.SetPartition(number, 0, part)
    return data


KINDS = [vtkMultiBlockDataSet, vtkPartitionedDataSet, vtkPartitionedDataSetCollection]


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("gap", [0, 1])
def test_images_that_touch_are_warned_about_at_each_update(kind, gap, messages):
    filter_ = deforming(composite(kind, halves(gap)))
    for alpha in (1.0, 1.5):
        filter_.SetAlpha(alpha)
        update(filter_)
        messages.assert_one(SEAM)
    filter_.Update()  # nothing is done
    heard = []
    filter_.AddObserver("WarningEvent", lambda *_: heard.append(1))
    filter_.Modified()
    update(filter_)
    assert len(heard) == 1


def test_many_images_are_one_sentence(messages):
    update(deforming(composite(vtkMultiBlockDataSet, [*halves(), *halves(1)])))
    messages.assert_one(SEAM)


def far_apart():
    return [make_image(), make_image(origin=(60, 0, 0))]


def same_place():
    return [make_image(), make_image()]


def image_and_mesh():
    return [make_image(), cells(VTK_TETRA)]


def one_alone():
    return [None, halves()[0]]


@pytest.mark.parametrize("make", [far_apart, same_place, image_and_mesh, one_alone])
def test_no_warning_where_nothing_can_cross(make):
    update(deforming(composite(vtkMultiBlockDataSet, make())))


def test_no_warning_where_nothing_moves():
    update(deforming(composite(vtkMultiBlockDataSet, halves()), control_points(REST, REST)))


def test_pieces_of_one_image_are_no_blocks():
    filter_ = deforming(halves()[0])
    for piece in range(3):
        filter_.UpdatePiece(piece, 3, 1)
    assert filter_.GetOutput().IsA("vtkImageData")


@pytest.fixture
def files(tmp_path):
    writer = vtkXMLMultiBlockDataWriter()
    writer.SetInputData(composite(vtkMultiBlockDataSet, halves()))
    writer.SetFileName(str(tmp_path / "in.vtm"))
    assert writer.Write()
    lines = [",".join(map(str, (*p, *q))) for p, q in zip(REST, DEFORMED)]
    (tmp_path / "h.csv").write_text("\n".join(["px,py,pz,qx,qy,qz", *lines]))
    return tmp_path


def test_the_command_says_so(files, capsys, caplog):
    arguments = [str(files / name) for name in ("in.vtm", "h.csv", "out.vtm")]
    assert cli.main(["deform", *arguments]) == 0
    assert "what crosses a border between them is lost" in caplog.text
    assert "2 blocks" in capsys.readouterr().out


# AMR


def overlapping():
    return update(vtkAMRGaussianPulseSource())


@pytest.mark.parametrize("make_filter", [MLSDeform, MLSDisplacementField])
@pytest.mark.parametrize("make", [overlapping, vtkNonOverlappingAMR])
def test_amr_is_refused(make, make_filter, messages):
    filter_ = connect(make_filter(), make_image(), control_points())
    update(filter_)
    data = make()
    filter_.SetInputDataObject(0, data)
    assert not filter_.GetExecutive().Update()
    messages.assert_one(f"`Input` must be an image or a mesh, got AMR data .{data.GetClassName()}.")
    assert filter_.GetOutput().GetNumberOfPoints() == 0
    for change in (lambda: None, lambda: None, filter_.Modified):  # an error until it is mended
        change()
        assert not filter_.GetExecutive().Update()
        messages.assert_one("resample it to one image first")
        assert filter_.GetOutput().GetNumberOfPoints() == 0
    filter_.SetInputDataObject(0, make_image())
    assert update(filter_).GetNumberOfPoints() > 0


# Control points


def with_displacement(kind):
    handles = kind()
    set_places(handles, REST)
    add_array(handles.GetPointData(), "Displacement", DEFORMED - REST)
    if kind is vtkUnstructuredGrid:
        handles.InsertNextCell(VTK_HEXAHEDRON, 8, (0, 1, 3, 2, 4, 5, 7, 6))
    if kind is vtkStructuredGrid:
        handles.SetDimensions(2, 2, 2)
    return handles


POINT_SETS = [vtkPolyData, vtkUnstructuredGrid, vtkStructuredGrid, vtkPointSet]


@pytest.mark.parametrize("kind", POINT_SETS)
@pytest.mark.parametrize(
    ("make_filter", "name"),
    [(MLSDeform, "ForwardDisplacement"), (MLSDisplacementField, "BackwardDisplacement")],
)
def test_any_point_set_has_control_points(kind, make_filter, name):
    expected, found = (
        array_of(update(connect(make_filter(), cells(VTK_TETRA), handles)), name)
        for handles in (control_points(), with_displacement(kind))
    )
    np.testing.assert_array_equal(found, expected)


@pytest.mark.parametrize("kind", POINT_SETS)
def test_weights_and_other_names(kind):
    handles = with_displacement(kind)
    weights = np.linspace(1, 3, len(REST))
    add_array(handles.GetPointData(), "Weight", weights)
    add_array(handles.GetPointData(), "other", (DEFORMED - REST) / 2)
    mesh = cells(VTK_TETRA)
    filter_ = deforming(mesh, handles)
    filter_.SetInputArrayToProcess(0, 1, 0, 0, "other")
    expected = deforming(mesh, control_points(REST, (REST + DEFORMED) / 2, weights))
    np.testing.assert_array_equal(places_of(update(filter_)), places_of(update(expected)))


def test_what_is_missing_is_named(messages):
    handles = with_displacement(vtkUnstructuredGrid)
    handles.GetPointData().RemoveArray("Displacement")
    add_array(handles.GetPointData(), "shift", DEFORMED - REST)
    filter_ = deforming(cells(VTK_TETRA), handles)
    assert not filter_.GetExecutive().Update()
    messages.assert_one("no numeric point array `Displacement`; it has `shift`")


@pytest.mark.parametrize("kind", KINDS)
def test_control_points_in_blocks_are_refused(kind, messages):
    handles = composite(kind, [with_displacement(vtkPolyData), update(vtkSphereSource())])
    filter_ = deforming(cells(VTK_TETRA), handles)
    for _ in range(3):
        assert not filter_.GetExecutive().Update()
        messages.assert_one(
            "`ControlPoints` must be one point set, got a vtk.*; merge its blocks first"
        )
    filter_.SetInputDataObject(1, with_displacement(vtkPolyData))
    assert update(filter_).IsA("vtkUnstructuredGrid")


def test_grids_by_axes_have_no_points_of_their_own(messages):
    filter_ = deforming(cells(VTK_TETRA), vtkRectilinearGrid())
    assert not filter_.GetExecutive().Update()
    assert "vtkPointSet is required" in messages.take()
