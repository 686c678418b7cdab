"""Images in blocks, AMR data, and control points that are any point set."""

import itertools
from functools import partial

import mesh_fixtures
import numpy as np
import pytest
from mesh_fixtures import CUTS, array_of, cells, rectilinear, set_places
from pipelines import assert_fails, assert_same, ball, connect, content, control_points, update
from vtk_fixtures import DEFORMED, REST, add_array, make_image
from vtkmodules.vtkCommonDataModel import (
    VTK_HEXAHEDRON,
    VTK_TETRA,
    vtkImageData,
    vtkMolecule,
    vtkMultiBlockDataSet,
    vtkNonOverlappingAMR,
    vtkPartitionedDataSet,
    vtkPartitionedDataSetCollection,
    vtkPointSet,
    vtkPolyData,
    vtkRectilinearGrid,
    vtkStructuredGrid,
    vtkTable,
    vtkUnstructuredGrid,
)
from vtkmodules.vtkFiltersSources import vtkRandomHyperTreeGridSource, vtkSphereSource
from vtkmodules.vtkImagingCore import vtkExtractVOI

from vtk_mls import HalfPlane
from vtk_mls.files.block_files import blocks, leaves
from vtk_mls.filters import MLSDeform, MLSDisplacementField
from vtk_mls.vtk import arrays
from vtk_mls.vtk.arrays import ImageGeometry

try:
    from vtkmodules.vtkFiltersAMR import vtkAMRGaussianPulseSource
except ImportError:  # before VTK 9.5
    from vtkmodules.vtkFiltersSources import vtkAMRGaussianPulseSource

SEAM = "Warning: MLSDeform: `Input` has images in several blocks"

deforming = partial(mesh_fixtures.deforming, device="reference")  # numbers are not the point


def halves():
    """An image in two parts."""
    whole = make_image((21, 8, 7))
    add_array(whole.GetPointData(), "one", np.ones(21 * 8 * 7))
    parts = []
    for first, last in ((0, 10), (10, 20)):
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


CHANGES = {
    "half a voxel further": lambda first, second: second.SetOrigin(0.5, 0, 0),
    "other arrays": lambda first, second: second.GetPointData().RemoveArray("one"),
    "other values": lambda first, second: array_of(second, "one").fill(2),
    "ghosts": lambda first, _: add_array(first.GetPointData(), arrays.GHOSTS, np.zeros(616), 3),
}


def apart(name):
    """Three of the four parts of an image; or its halves, one of them after the change `name`."""
    if name not in CHANGES:
        return boxes(make_image((21, 8, 7)), [(0, 10), (10, 20)], [(0, 4), (4, 7)])[:3]
    parts = halves()
    CHANGES[name](*parts)
    return parts


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("name", [*CHANGES, "three quarters"])
def test_images_that_touch_are_warned_about_at_each_update(kind, name, messages):
    filter_ = deforming(composite(kind, apart(name)))
    for alpha in (1.0, 2.0):
        filter_.SetAlpha(alpha)
        update(filter_)
        messages.assert_one(SEAM)
    filter_.Update()  # nothing is done
    heard = []
    filter_.AddObserver("WarningEvent", lambda *_: heard.append(1))
    filter_.Modified()
    update(filter_)
    assert len(heard) == 1


def boxes(whole, *ranges):
    """Blocks of an image by ranges of indices along x, y and z."""
    dimensions = whole.GetDimensions()
    ranges = [*ranges, *[[(0, n - 1)] for n in dimensions[len(ranges) :]]]
    return [part_of(whole, extent) for extent in itertools.product(*ranges)]


def part_of(whole, extent):
    """A part of an image, which vtkExtractVOI misplaces if it has directions."""
    part = vtkImageData()
    ImageGeometry.of_image(whole).part(np.ravel(extent).tolist()).apply_to(part)
    for name, is_cells in (("GetPointData", 0), ("GetCellData", 1)):
        source, target = getattr(whole, name)(), getattr(part, name)()
        shape = np.array(whole.GetDimensions())[::-1] - is_cells
        region = tuple(slice(a, b + 1 - is_cells) for a, b in extent[::-1])
        values = [
            arrays.to_numpy(source.GetArray(i)).reshape(*shape, -1)[region]
            for i in range(source.GetNumberOfArrays())
        ]
        flat = [value.reshape(-1, *value.shape[3:][: value.shape[3] > 1]) for value in values]
        arrays.set_values(target, [np.ascontiguousarray(value) for value in flat], source)
    return part


def scene(rng, has_cells):
    """An oblique image with several arrays."""
    turn = [0.8, -0.6, 0, 0.6, 0.8, 0, 0, 0, 1]
    whole = make_image((13, 12, 11), direction=turn, spacing=(0.75, 0.8, 0.9))
    add_array(whole.GetPointData(), "values", rng.normal(size=13 * 12 * 11))
    add_array(whole.GetPointData(), "labels", rng.integers(0, 9, 13 * 12 * 11), 6)
    whole.GetPointData().SetActiveScalars("values")
    if has_cells:
        add_array(whole.GetCellData(), "cells", rng.normal(size=12 * 11 * 10))
    return whole


RANGES = {
    "shared points": ([(0, 5), (5, 12)], [(0, 7), (7, 11)]),
    "ghost layers": ([(0, 7), (3, 12)], [(0, 11)], [(0, 6), (6, 10)]),
    "no shared points": ([(0, 5), (6, 12)],),
}


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("name", RANGES)
def test_blocks_of_one_lattice_are_parts_of_one_image(kind, name, rng):
    """Equal to the joined image to the bit; origins and extents are those of each block."""
    whole = scene(rng, has_cells=name != "no shared points")
    parts = boxes(whole, *RANGES[name])
    # the same points with the first at index 0
    ImageGeometry.of_grid(ImageGeometry.of_image(parts[-1]).grid).apply_to(parts[-1])
    filters = [deforming(data) for data in (whole, composite(kind, parts))]
    for filter_ in filters:
        filter_.AddLabelArray("labels")
        filter_.SetGradientArray("values")
        filter_.AddCut(HalfPlane((0, 0, 0), (1, 0.2, 0), (0, 0, 1)))
        update(filter_)
    expected, found = (filter_.GetOutput() for filter_ in filters)
    assert found.IsA(kind.__name__)
    for part, block in zip(parts, blocks(found)):
        assert block.GetExtent() == part.GetExtent()
        assert block.GetOrigin() == part.GetOrigin()
        start = ImageGeometry.of_image(part).grid.origin[None]
        first = np.round(ImageGeometry.of_image(expected).grid.index_of(start)[0])
        last = first + np.array(part.GetDimensions()) - 1
        same = part_of(expected, np.column_stack([first, last]).astype(int).tolist())
        assert block.GetPointData().GetNumberOfArrays() == 6
        own, wanted = (
            {key: values for key, values in content(image).items() if key[0] in ("Point", "Cell")}
            for image in (block, same)
        )
        assert_same(own, wanted)


@pytest.mark.parametrize(
    "options",
    [{"OutputGrid": "fitted"}, {"kind": MLSDisplacementField, "SampleDimensions": (4, 4, 4)}],
)
@pytest.mark.parametrize("kind", KINDS)
def test_blocks_of_all_types_are_as_alone(kind, options, coarse_fits):
    parts = [cells(VTK_TETRA, 2), make_image((5, 4, 4)), ball((4, 4, 3), 2.4, 8), rectilinear()]
    filter_ = deforming(composite(kind, [None, *parts]), **options)
    for cut in (None, CUTS["plane"]):
        if cut is not None:
            filter_.AddCut(cut)
        for part, found in zip(parts, blocks(update(filter_))):
            alone = update(deforming(part, cut=cut, **options))
            assert found.GetClassName() == alone.GetClassName()
            assert_same(found, alone)


def test_names_of_blocks_and_another_update(rng):
    data = composite(vtkMultiBlockDataSet, halves())
    data.GetMetaData(1).Set(data.NAME(), "right")
    filter_ = deforming(data)
    for _ in range(2):
        output = update(filter_)
        assert output.GetMetaData(1).Get(output.NAME()) == "right"
        ones = np.concatenate([array_of(block, "one") for block in blocks(output)])
        alone = [array_of(update(deforming(half)), "one") for half in halves()]
        assert (np.concatenate(alone) == 0).sum() > (ones == 0).sum()
        array_of(data.GetBlock(0), "one")[:] = 1
        data.GetBlock(0).Modified()


NO_NEIGHBORS = {
    "far apart": lambda: [make_image(), make_image(origin=(60, 0, 0))],
    "same place": lambda: [make_image(), make_image()],
    "image and mesh": lambda: [make_image(), cells(VTK_TETRA)],
    "one alone": lambda: [None, halves()[0]],
}


@pytest.mark.parametrize("name", NO_NEIGHBORS)
def test_no_warning_where_nothing_can_cross(name):
    update(deforming(composite(vtkMultiBlockDataSet, NO_NEIGHBORS[name]())))


def test_no_warning_where_nothing_moves():
    update(deforming(composite(vtkMultiBlockDataSet, halves()), control_points(REST, REST)))


def table():
    data = vtkTable()
    add_array(data.GetRowData(), "history", [1.0, 2.0])
    return data


def trees():
    source = vtkRandomHyperTreeGridSource()
    source.SetDimensions(3, 3, 3)
    return update(source)


def molecule():
    data = vtkMolecule()
    data.AppendAtom(6, 0, 0, 0)
    return data


OTHERS = {table: 0, trees: 1, molecule: 1}  # and how many warnings


@pytest.mark.parametrize("make_filter", [MLSDeform, MLSDisplacementField])
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("make", OTHERS)
def test_blocks_that_are_no_datasets_pass(make, kind, make_filter, messages):
    others, mesh = [make(), make()], cells(VTK_TETRA, 1)
    data = composite(kind, [others[0], mesh, others[1]])
    options = {"kind": make_filter, "cut": HalfPlane((4, 4, 3), (1, 0.2, 0), (0, 0, 1))}
    if make_filter is MLSDisplacementField:
        options["SampleDimensions"] = 4, 4, 4
    filter_, alone = deforming(data, **options), deforming(mesh, **options)
    for alpha in (1.0, 2.0):
        filter_.SetAlpha(alpha)
        alone.SetAlpha(alpha)
        first, moved, last = leaves(update(filter_))
        said = [line for line in messages.take().splitlines() if line]
        assert len(said) == OTHERS[make]
        assert all("in a block, which is passed and stays at rest" in line for line in said)
        for other, passed in zip(others, (first, last)):
            assert passed.GetClassName() == other.GetClassName()
            assert passed.GetActualMemorySize() == other.GetActualMemorySize()
        assert_same(moved, update(alone))


def test_other_data_alone_are_refused(messages):
    rectilinear_handles = deforming(cells(VTK_TETRA), vtkRectilinearGrid())
    for filter_, kind in ((deforming(table()), "DataSet"), (rectilinear_handles, "PointSet")):
        assert not filter_.GetExecutive().Update()
        assert f"vtk{kind}" in messages.take()


def overlapping():
    return update(vtkAMRGaussianPulseSource())


@pytest.mark.parametrize("make_filter", [MLSDeform, MLSDisplacementField])
@pytest.mark.parametrize("make", [overlapping, vtkNonOverlappingAMR])
def test_amr_is_refused(make, make_filter, messages):
    filter_ = connect(make_filter(), make_image(), control_points())
    update(filter_)
    data = make()
    filter_.SetInputDataObject(0, data)
    assert_fails(
        filter_,
        messages,
        f"`Input` must be an image or a mesh, got AMR data .{data.GetClassName()}.",
    )
    assert filter_.GetOutput().GetOrigin() == (0, 0, 0)  # not that of the last image
    for change in (lambda: None, lambda: None, filter_.Modified):  # an error until it is mended
        change()
        assert_fails(filter_, messages, "resample it to one image first")
    filter_.SetInputDataObject(0, make_image())
    assert update(filter_).GetNumberOfPoints() > 0


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


@pytest.mark.parametrize("kind", KINDS)
def test_control_points_in_blocks_are_refused(kind, messages):
    handles = composite(kind, [with_displacement(vtkPolyData), update(vtkSphereSource())])
    filter_ = deforming(cells(VTK_TETRA), handles)
    for _ in range(3):
        assert_fails(
            filter_,
            messages,
            "`ControlPoints` must be one point set, got a vtk.*; merge its blocks first",
        )
    filter_.SetInputDataObject(1, with_displacement(vtkPolyData))
    assert update(filter_).IsA("vtkUnstructuredGrid")
