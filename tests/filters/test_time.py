"""Data, control points and cuts that change in time, each at its own steps."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from mesh_fixtures import places_of
from pipelines import KEYS, Source, assert_same, values_of
from vtk_fixtures import make_image
from vtkmodules.vtkCommonDataModel import vtkDataObject, vtkMultiBlockDataSet, vtkPolyData
from vtkmodules.vtkFiltersSources import vtkPlaneSource, vtkSphereSource

from vtk_mls.filters import MLSControlPoints, MLSDeform, MLSDisplacementField
from vtk_mls.vtk import arrays
from vtk_mls.vtk.control_point_polydata import fill_polydata
from vtk_mls.vtk.objects import configured, output_of

TOLERANCE = 1e-5  # of coordinates of about 10, in float32
FILTERS = MLSDeform, MLSDisplacementField
CORNERS = np.array([(x, y, z) for x in (0, 8) for y in (0, 8) for z in (0, 8)], float)


def translation(output, time):
    """A control point that is `time` along x."""
    fill_polydata(output, np.zeros((1, 3)), np.array([[time, 0, 0]]), None)


def growth(output, time):
    """The corners of a box that grows."""
    fill_polydata(output, CORNERS, CORNERS * (1 + time / 10), None)


def plane(output, time):
    made = configured(vtkPlaneSource(), Origin=(time / 10, -9, -9), Point1=[time / 10, 9, -9])
    output.ShallowCopy(output_of(made, Point2=[time / 10, -9, 9]))


def sphere(output, time):
    output.ShallowCopy(output_of(vtkSphereSource(), Center=(0, 10 * time, 0)))


def still_sphere():
    return output_of(vtkSphereSource())


def image(output, time):
    made = make_image()
    arrays.add(made.GetPointData(), "values", np.full(made.GetNumberOfPoints(), float(time)))
    output.ShallowCopy(made)


def blocks():
    made = vtkMultiBlockDataSet()
    inner = vtkMultiBlockDataSet()
    inner.SetBlock(0, still_sphere())
    made.SetBlock(0, still_sphere())
    made.SetBlock(2, inner)
    return made


def connected(make, data, handles=None, cuts=()):
    """A filter with data or algorithms on its ports."""
    filter_ = configured(make(), Device="reference")
    inputs = [(0, data), (1, handles), *((2, cut) for cut in cuts)]
    for port, source in inputs:
        if hasattr(source, "GetOutputPort"):
            filter_.AddInputConnection(port, source.GetOutputPort())
        elif source is not None:
            filter_.SetInputDataObject(port, source)
    if handles is None:
        pairs = np.array([(-0.5, 0, 0), (0.5, 0, 0)])
        configured(filter_, RestPoints=pairs, DeformedPoints=1.2 * pairs)
    return filter_


def leaf(data):
    """A dataset, or the innermost block."""
    while isinstance(data, vtkMultiBlockDataSet):
        data = data.GetBlock(data.GetNumberOfBlocks() - 1)
    return data


def moved(filter_):
    """How far the output is moved along x, on average."""
    data = leaf(filter_.GetOutput()).GetPointData()
    name = "Forward" if data.HasArray("ForwardDisplacement") else "Backward"
    sign = 1 if name == "Forward" else -1
    return sign * arrays.to_numpy(data.GetArray(f"{name}Displacement"))[:, 0].mean()


def announced(filter_):
    filter_.UpdateInformation()
    info = filter_.GetOutputInformation(0)
    return info.Get(KEYS.TIME_STEPS()), info.Get(KEYS.TIME_RANGE())


@pytest.mark.parametrize(
    ("make", "data"),
    [
        *itertools.product(FILTERS, ["mesh", "moving mesh", "blocks"]),
        (MLSDisplacementField, "image"),
        (MLSDisplacementField, "moving image"),
    ],
)
def test_control_points_move_in_time(make, data):
    steps = [0.0, 1.0, 2.0]
    made = {
        "mesh": still_sphere,
        "moving mesh": lambda: Source(sphere, steps),
        "image": make_image,
        "moving image": lambda: Source(image, steps, output_type="vtkImageData"),
        "blocks": blocks,
    }[data]()
    filter_ = connected(make, made, Source(translation, steps))
    assert announced(filter_) == ((0, 1, 2), (0, 2))
    for time in (0.0, 2.0, 1.0, 0.0):
        filter_.UpdateTimeStep(time)
        assert moved(filter_) == pytest.approx(time, abs=TOLERANCE)
        assert filter_.GetOutput().GetInformation().Get(vtkDataObject.DATA_TIME_STEP()) == time


@pytest.mark.parametrize("is_moving", [False, True])
def test_images_are_resampled_at_each_time(is_moving):
    still = make_image()
    x = np.tile(np.arange(9) * 0.9, (7, 8, 1))
    arrays.add(still.GetPointData(), "values", x.ravel())
    data = Source(image, [0.0, 1.8, 2.7], output_type="vtkImageData") if is_moving else still
    filter_ = connected(MLSDeform, data, Source(translation, [0.0, 1.8, 2.7]))
    for time in (0.0, 2.7, 1.8):  # multiples of the spacing
        filter_.UpdateTimeStep(time)
        expected = (x >= time - 0.1) * (time if is_moving else x - time)
        np.testing.assert_allclose(
            values_of(filter_.GetOutput(), "values"), expected, atol=TOLERANCE
        )


@pytest.mark.parametrize("make", FILTERS)
def test_cuts_move_in_time(make):
    filter_ = connected(make, still_sphere(), None, [Source(plane, [0.0, 1.0, 2.0, 3.0])])
    if make is MLSDisplacementField:
        filter_.SetSampleDimensions(5, 4, 4)
    found = set()
    for time in (0.0, 3.0, 1.0, 2.0):
        filter_.UpdateTimeStep(time)
        output = filter_.GetOutput()
        found.add(output.GetNumberOfPoints() if make is MLSDeform else moved(filter_))
    assert len(found) > 1


@pytest.mark.parametrize("make", FILTERS)
@pytest.mark.parametrize("kind", ["mesh", "image", "blocks"])
def test_a_filter_that_ran_before_is_as_a_fresh_one_at_any_time(make, kind, rng):
    """Also where inputs have steps of their own, and take the last one before."""

    def filled_blocks(output, time):
        sphere(part := vtkPolyData(), time)
        output.SetBlock(0, part)

    def inputs():
        fill, output_type = {
            "mesh": (sphere, "vtkPolyData"),
            "image": (image, "vtkImageData"),
            "blocks": (filled_blocks, "vtkMultiBlockDataSet"),
        }[kind]
        data = Source(fill, [0.0, 2.0, 4.0], output_type=output_type)
        cuts = [Source(plane, [1.5, 3.0]), Source(plane, (), [0.0, 3.5])]
        return data, Source(translation, [0.0, 1.0, 2.0]), cuts[: rng.integers(0, 3)]

    for _ in range(3):
        made = inputs()
        filter_ = connected(make, *made)
        for time in [*rng.permutation([0.0, 0.5, 1.0, 1.5, 2.0, 3.0]), 1.0, 0.0]:
            filter_.UpdateTimeStep(time)
            fresh = connected(make, *made)
            fresh.UpdateTimeStep(time)
            assert_same(leaf(filter_.GetOutput()), leaf(fresh.GetOutput()))


def test_steps_of_all_inputs_are_announced_in_order():
    filter_ = connected(
        MLSDeform,
        Source(sphere, [0.0, 2.0]),
        Source(translation, [0.5, 1.0]),
        [Source(plane, [2.0, 5.0]), Source(plane, (), [-1.0, 1.0])],
    )
    assert announced(filter_) == ((0, 0.5, 1, 2, 5), (-1, 5))
    filter_.DisconnectCuts()
    assert announced(filter_) == ((0, 0.5, 1, 2), (0, 2))
    filter_.DisconnectControlPoints()
    assert announced(filter_) == ((0, 2), (0, 2))
    filter_.SetInputDataObject(0, still_sphere())
    assert announced(filter_) == (None, None)


def test_each_input_gets_the_requested_time():
    sources = Source(sphere, (), [0.0, 9.0]), Source(translation, (), [0.0, 9.0])
    cut = Source(plane, (), [0.0, 9.0])
    filter_ = connected(MLSDeform, *sources, [cut])
    assert announced(filter_) == (None, (0, 9))
    for time in (2.5, 7.25):
        filter_.UpdateTimeStep(time)
        assert [source.times[-1] for source in (*sources, cut)] == [time] * 3
    filter_.UpdateTimeStep(7.25)
    assert [len(source.times) for source in (*sources, cut)] == [2] * 3


def test_a_fitted_grid_grows_in_time(coarse_fits):
    still = make_image((5, 5, 5), origin=(0, 0, 0), spacing=(1.8, 2, 2.2))
    filter_ = connected(MLSDeform, still, Source(growth, [0.0, 5.0]))
    configured(filter_, OutputGrid="fitted", Kind="affine")
    extents = []
    for time in (0.0, 5.0, 0.0):
        filter_.UpdateTimeStep(time)
        extents.append(filter_.GetOutput().GetExtent())
        size = np.ptp(np.reshape(filter_.GetOutput().GetBounds(), (3, 2)), axis=1)
        assert (size >= np.array([7.2, 8, 8.8]) * (1 + time / 10) - TOLERANCE).all()
    assert extents[0] == extents[2] != extents[1]


def test_the_field_covers_a_mesh_where_it_is_in_time():
    filter_ = connected(MLSDisplacementField, Source(sphere, [0.0, 1.0]))
    for time in (0.0, 1.0, 0.0):
        filter_.UpdateTimeStep(time)
        assert filter_.GetOutput().GetCenter()[1] == pytest.approx(10 * time, abs=TOLERANCE)


def test_the_output_is_empty_at_a_time_that_an_input_does_not_have(messages):
    class Failing(Source):
        def RequestData(self, request, in_info, out_info):
            if out_info.GetInformationObject(0).Get(KEYS.UPDATE_TIME_STEP()) == 1:
                return 0
            return super().RequestData(request, in_info, out_info)

    filter_ = connected(MLSDeform, still_sphere(), Failing(translation, [0.0, 1.0, 2.0]))
    counts = []
    for time in (0.0, 1.0, 2.0):
        filter_.UpdateTimeStep(time)
        counts.append(filter_.GetOutput().GetNumberOfPoints())
    messages.take()
    assert counts == [50, 0, 50]


def test_parts_of_an_image_at_each_time():
    """A piece at a time does not take the extent of another time."""
    still = make_image()
    handles = Source(translation, [0.0, 1.8])
    filter_ = connected(MLSDeform, still, handles)
    arrays.add(still.GetPointData(), "values", np.arange(still.GetNumberOfPoints(), dtype=float))
    for time, piece in itertools.product((0.0, 1.8), (0, 1)):
        filter_.UpdateTimeStep(time, piece, 2, 0)
        fresh = connected(MLSDeform, still, handles)
        fresh.UpdateTimeStep(time, piece, 2, 0)
        assert filter_.GetOutput().GetExtent() == fresh.GetOutput().GetExtent()
        assert_same(filter_.GetOutput(), fresh.GetOutput())


@pytest.mark.parametrize(
    ("asked", "own"), [(0.7, float(np.float32(0.7))), (0.333, 1 / 3), (2.1, 2.1)]
)
@pytest.mark.parametrize("of_table", [False, True])
def test_an_input_takes_its_step_that_the_time_misses_by_rounding(asked, own, of_table, tmp_path):
    """Float32 and decimal text are rounded; a reader of VTK would take the step before."""
    for data_step, handle_step in ((asked, own), (own, asked)):
        handles = Source(translation, [k * handle_step for k in range(5)])
        if of_table:
            rows = [f"{k * handle_step!r},0,0,0,{k * handle_step},0,0" for k in range(5)]
            (tmp_path / "h.csv").write_text("\n".join(["time,px,py,pz,qx,qy,qz", *rows]))
            handles = configured(MLSControlPoints(), Mode="file", FileName=str(tmp_path / "h.csv"))
        filter_ = connected(MLSDeform, Source(sphere, [k * data_step for k in range(5)]), handles)
        for k in (0, 3, 1, 4, 2):
            filter_.UpdateTimeStep(k * data_step)
            assert moved(filter_) == pytest.approx(k * handle_step, abs=TOLERANCE)
        filter_.UpdateTimeStep(0.97 * handle_step)
        assert moved(filter_) == pytest.approx(0, abs=TOLERANCE)


def test_a_table_with_times_moves_the_data(tmp_path):
    lines = ["px,py,pz,qx,qy,qz,time", "0,0,0,2,0,0,2", "0,0,0,0,0,0,0", "0,0,0,1,0,0,1"]
    (tmp_path / "moving.csv").write_text("\n".join(lines))
    handles = configured(MLSControlPoints(), Mode="file", FileName=str(tmp_path / "moving.csv"))
    filter_ = connected(MLSDeform, still_sphere(), handles)
    assert announced(filter_) == ((0, 1, 2), (0, 2))
    still = places_of(still_sphere())
    for time, move in ((1.0, 1), (0.5, 0), (2.0, 2), (-1.0, 0), (7.0, 2)):
        filter_.UpdateTimeStep(time)
        moved = places_of(filter_.GetOutput())
        np.testing.assert_allclose(moved, still + [move, 0, 0], atol=TOLERANCE)
    (tmp_path / "one.csv").write_text("px,py,pz,qx,qy,qz\n0,0,0,3,0,0")
    handles.SetFileName(str(tmp_path / "one.csv"))
    assert announced(filter_) == (None, None)
    moved = places_of(output_of(filter_))
    np.testing.assert_allclose(moved, still + [3, 0, 0], atol=TOLERANCE)
