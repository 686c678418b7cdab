"""Pieces of the output are the whole to the bit, from just what they need of the input; and control
points and cuts of several processes."""

import numpy as np
import pytest
from pairwise import paired
from pipelines import assert_fails, connect, control_points, update
from vtk_fixtures import DEFORMED, FAST, REST, TURNED, add_array, make_image
from vtkmodules.util.vtkAlgorithm import VTKPythonAlgorithmBase
from vtkmodules.vtkCommonDataModel import vtkImageData, vtkPolyData
from vtkmodules.vtkCommonExecutionModel import vtkAlgorithm, vtkStreamingDemandDrivenPipeline
from vtkmodules.vtkFiltersSources import vtkPlaneSource

from vtk_mls import CUT_FRAMES, INTERPOLATIONS, HalfPlane, Plane
from vtk_mls.filters import MLSDeform, MLSDisplacementField, parallel
from vtk_mls.vtk import arrays
from vtk_mls.vtk.arrays import ImageGeometry
from vtk_mls.vtk.control_point_polydata import fill_polydata
from vtk_mls.vtk.objects import configured, output_of

DIMENSIONS, START = (9, 8, 7), (3, -2, 5)
OPENED = HalfPlane((3, 4, 3), (0, 1, 0), (1, 0, 0))


class Cropped(VTKPythonAlgorithmBase):
    """A reader of just the part that is asked for: points "values", cells "cells"."""

    def __init__(self, **place):
        super().__init__(nInputPorts=0, nOutputPorts=1, outputType="vtkImageData")
        self.place = {"start": START, "origin": (-2.7, 2.0, -5.5), **place}
        self.gives_less = False

    def RequestInformation(self, request, inInfo, outInfo):
        info = outInfo.GetInformationObject(0)
        ImageGeometry.of_image(make_image(**self.place)).set_information(info)
        info.Set(vtkAlgorithm.CAN_PRODUCE_SUB_EXTENT(), 1)
        return 1

    def RequestData(self, request, inInfo, outInfo):
        key = vtkStreamingDemandDrivenPipeline.UPDATE_EXTENT()
        extent = list(outInfo.GetInformationObject(0).Get(key))
        extent[1] -= self.gives_less
        output = vtkImageData.GetData(outInfo)
        whole = ImageGeometry.of_image(make_image(**self.place))
        part = whole.part(extent)
        part.apply_to(output)
        grids = part.grid_within(whole), part.grid_within(whole).cells
        data = output.GetPointData(), output.GetCellData()
        for attributes, name, grid in zip(data, ("values", "cells"), grids):
            x, y, z = grid.points().T
            add_array(attributes, name, np.sin(x) + y * z)
        output.GetPointData().SetActiveScalars("values")
        return 1


def pipeline(kind, cuts=(), **place):
    algorithm = connect(configured(kind(), Device=FAST), Cropped(**place), control_points())
    for cut in cuts:
        algorithm.AddCut(cut)
    return algorithm


def check(make, counts=(2, 7)):
    """Pieces are parts of the whole, and all of it."""
    whole = update(make())
    shapes = [np.maximum(np.subtract(whole.GetDimensions(), n), 1)[::-1] for n in (0, 1)]
    for count in counts:
        algorithm, is_there = make(), [np.zeros(shape, bool) for shape in shapes]
        algorithm.UpdateInformation()
        for piece in range(count):
            algorithm.UpdatePiece(piece, count, 0)
            part = algorithm.GetOutputDataObject(0)
            first = np.subtract(part.GetExtent()[::2], whole.GetExtent()[::2])[::-1]
            size = np.array(part.GetDimensions())[::-1]
            for name, less in (("GetPointData", 0), ("GetCellData", 1)):
                size = np.where(shapes[0] > 1, size - less, size)  # slices have no volume cells
                region = tuple(slice(a, a + n) for a, n in zip(first, size))
                is_there[less][region] = True
                data = getattr(whole, name)()
                for number in range(data.GetNumberOfArrays() if size.all() else 0):
                    array = getattr(part, name)().GetArray(data.GetArrayName(number))
                    wanted = arrays.to_numpy(data.GetArray(number))
                    wanted = wanted.reshape(*shapes[less], -1)[region]
                    found = arrays.to_numpy(array).reshape(wanted.shape)
                    np.testing.assert_array_equal(found, wanted, array.GetName())
        assert all(places.all() for places in is_there)


CUTS = {"none": (), "half-plane": (OPENED,), "plane": (Plane((4, 4, 3), (1, 0.3, 0.1)),)}


@paired(
    cuts=CUTS,
    interpolation=INTERPOLATIONS,
    grid=["input", "fitted", "given", "reference"],
    frame=CUT_FRAMES,
)
def test_pieces_of_a_deformed_image(cuts, interpolation, grid, frame):
    target = {"OutputGrid": grid, "OutputDimensions": (5, 6, 7)}
    if grid == "reference":
        target = {"Reference": make_image((5, 6, 7), (2, 0, -1), TURNED)}
    properties = {"CutFrame": frame, "Interpolation": interpolation, **target}
    properties |= {"GenerateJacobian": True, "GradientArray": "values"}
    properties["VoidValues"] = "continued" if grid == "given" else "background"
    check(lambda: configured(pipeline(MLSDeform, CUTS[cuts]), **properties))


@pytest.mark.parametrize("place", [{"direction": TURNED}, {"dimensions": (9, 8, 1)}])
def test_pieces_of_any_image(place):
    check(lambda: pipeline(MLSDeform, **place), counts=(3, 100))
    check(lambda: pipeline(MLSDisplacementField, **place), counts=(3, 100))


@pytest.mark.parametrize("cuts", [(), (OPENED,)])
def test_pieces_of_a_field(cuts):
    check(lambda: configured(pipeline(MLSDisplacementField, cuts), GenerateJacobian=True))


def asked(algorithm, extent):
    """The extent that is asked of the input for an extent of the output."""
    algorithm.UpdateInformation()
    assert algorithm.UpdateExtent(extent)
    assert algorithm.GetOutputDataObject(0).GetExtent() == tuple(extent)
    source = algorithm.GetInputAlgorithm(0, 0)
    return source.GetOutputDataObject(0).GetExtent()


def shifted(*steps, **place):
    """Everything moved by so many points along the axes."""
    spacing = np.array(make_image(**place).GetSpacing())
    image = Cropped(**place)
    handles = control_points([(0, 0, 0)], [np.multiply(steps, spacing)])
    return connect(configured(MLSDeform(), Device=FAST), image, handles)


def test_only_the_needed_extent_is_requested():
    part = [5, 7, 0, 2, 7, 8]
    assert asked(shifted(0, 0, 0), part) == tuple(part)
    assert asked(shifted(-2, 1, 0), part) == (7, 9, -1, 1, 7, 8)
    # halfway between points; cells are then where cells are
    assert asked(shifted(-2, 0.5, 0), part) == (7, 9, -1, 2, 7, 8)
    # the gradient looks two points around, cubic interpolation one; beyond the border is nothing
    cubic = configured(shifted(-2, 0.5, 0), Interpolation="cubic")
    assert asked(cubic, part) == (6, 10, -2, 3, 6, 9)
    steep = configured(shifted(0, 0, 0), GradientArray="values")
    assert asked(steep, part) == (3, 9, -2, 4, 5, 10)
    # all comes from outside
    assert asked(shifted(100, 0, 0), part) == (3, 4, -2, -1, 5, 6)
    # nothing to be gained
    assert asked(shifted(-2, 1, 0), [3, 11, -2, 5, 5, 11]) == (3, 11, -2, 5, 5, 11)


def test_cells_of_a_fine_grid_need_the_cells_around():
    fine = shifted(0, 0, 0, origin=(0, 0, 0))
    configured(fine, OutputGrid="given", OutputSpacing=(0.09, 0.1, 0.11))
    fine.SetOutputOrigin(np.multiply(START, (0.9, 1, 1.1)) + (2.565, 0, 0))
    # the cell between points 2.85 and 2.95 is cell 2.4: of cells 2 and 3, which end at point 4
    assert asked(fine, [0, 1, 0, 0, 0, 0])[:2] == (5, 7)


def test_a_field_asks_its_image_for_a_cell():
    field = pipeline(MLSDisplacementField)
    assert asked(field, [5, 7, 0, 2, 7, 8]) == (3, 4, -2, -1, 5, 6)


def test_an_input_that_gives_less_is_an_error(messages):
    deform = shifted(0, 0, 0)
    deform.GetInputAlgorithm(0, 0).gives_less = True
    deform.UpdateInformation()
    assert not deform.UpdateExtent([5, 7, 0, 2, 7, 8])
    messages.assert_one(r"`Input` must be able to give any part .*\(5, 6, .* for \(5, 7,")
    assert deform.GetOutput().GetNumberOfPoints() == 0


# Several processes, played by one that knows what the others would answer.


@pytest.fixture
def processes(monkeypatch):
    """Pretend that other processes have these polydata, or fail."""

    def pretend(before=(), after=()):
        calls = []

        def all_gather(own):
            calls.append(own)
            return [*map(packed, before), own, *map(packed, after)]

        monkeypatch.setattr(parallel, "is_parallel", lambda: True)
        monkeypatch.setattr(parallel, "all_gather", all_gather)
        return calls

    return pretend


def packed(answer):
    """What another process sends."""
    if isinstance(answer, str):
        return None, answer
    return [parallel._pack(polydata) for polydata in answer], None


def handles(part=slice(None)):
    return update(control_points(REST[part], DEFORMED[part]))


def deformed(polydata, *cuts):
    deform = connect(configured(MLSDeform(), Device=FAST), Cropped(), polydata)
    for cut in cuts:
        deform.AddInputDataObject(2, cut)
    return deform


def values(algorithm):
    return arrays.to_numpy(update(algorithm).GetPointData().GetArray("values")).copy()


def test_control_points_of_several_processes(processes):
    expected = values(deformed(handles()))
    for before, own, after in (
        ([], handles(), [[handles()], [handles()]]),
        ([[vtkPolyData()]], handles(), [[vtkPolyData()]]),
        ([[handles()]], vtkPolyData(), [[handles()]]),
        ([[handles(slice(0, 3))], [vtkPolyData()]], handles(slice(3, 5)), [[handles(slice(5, 8))]]),
    ):
        processes(before, after)
        np.testing.assert_array_equal(values(deformed(own)), expected)


def test_a_path_of_several_processes(processes):
    def shared(part):
        polydata = vtkPolyData()
        path = [(REST + DEFORMED) / 2 + (0.5, 0, 0), DEFORMED + (0, 0.5, 0)]
        points = REST[part], DEFORMED[part], None
        fill_polydata(polydata, *points, path=[places[part] for places in path])
        return polydata

    expected = values(deformed(shared(slice(None))))
    straight = values(deformed(handles()))
    assert np.abs(expected - straight).max() > 0.01
    processes([[shared(slice(0, 3))], [vtkPolyData()]], [[shared(slice(5, 8))]])
    np.testing.assert_array_equal(values(deformed(shared(slice(3, 5)))), expected)


def test_processes_talk_only_after_a_change(processes):
    calls = processes([], [[vtkPolyData()]])
    source = control_points()
    deform = configured(MLSDeform(), Device=FAST, OutputGrid="fitted")
    connect(deform, Cropped(), source)
    first = values(deform)
    assert len(calls) <= 2  # for the information, and for an extent
    calls.clear()
    deform.SetKind("affine")
    assert not np.array_equal(values(deform), first)
    for piece in range(3):
        deform.UpdatePiece(piece, 3, 1)
    assert calls == []
    source.SetDeformedPoints(REST)
    values(deform)
    assert len(calls) > 0


def test_cuts_of_several_processes(processes):
    plane = configured(vtkPlaneSource(), Origin=(3, 4, -20), Point1=[20, 4, -20])
    cut = output_of(plane, Point2=[3, 4, 20])
    expected = values(deformed(handles(), cut))
    assert not np.array_equal(expected, values(deformed(handles())))
    processes([[handles(), vtkPolyData()]], [[handles(), cut]])
    np.testing.assert_array_equal(values(deformed(handles(), vtkPolyData())), expected)


def test_an_error_of_one_process_is_that_of_all(processes, messages):
    processes(["the disk is full"], [[handles()]])
    deform = deformed(handles())
    assert_fails(deform, messages, r"the disk is full \(on process 0 of 3\)")
    processes([[handles()]], [[handles()]])
    deform.SetInputDataObject(1, handles())
    assert values(deform).size
