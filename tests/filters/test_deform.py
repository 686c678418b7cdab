"""MLSDeform gives the value's numbers, and behaves as VTK's own filters do."""

import gc

import numpy as np
import pytest
from vtk_fixtures import (
    DEFORMED,
    FAST,
    REST,
    TURNED,
    TYPES,
    Executions,
    add_array,
    connect,
    control_points,
    make_image,
    update,
    values_of,
)
from vtkmodules.vtkCommonCore import vtkStringArray
from vtkmodules.vtkCommonDataModel import vtkDataObject, vtkDataSetAttributes, vtkMultiBlockDataSet
from vtkmodules.vtkCommonExecutionModel import (
    vtkStreamingDemandDrivenPipeline,
    vtkTrivialProducer,
)
from vtkmodules.vtkImagingCore import vtkImageShiftScale, vtkRTAnalyticSource

from vtk_mls import INTERPOLATIONS, Deformation, Grid, Sampling
from vtk_mls.filters import MLSControlPoints, MLSDeform
from vtk_mls.model.options import ALPHA
from vtk_mls.vtk import arrays
from vtk_mls.vtk.arrays import ImageGeometry

PLACES = {
    "plain": {},
    "shifted": {"start": (3, -2, 5), "origin": (-2.7, 2.0, -5.5)},
    "turned": {"direction": TURNED, "origin": (2.0, -1.0, 0.5)},
    "slice": {"dimensions": (9, 8, 1), "origin": (0.5, 0.25, 4.0)},
}
OPTIONS = [
    {"kind": "affine"},
    {"kind": "rigid", "alpha": 1.5},
    {"kind": "affine", "smoothing": 1.5},
    {"kind": "similarity"},
    {"kind": "polynomial", "degree": 1},
]


@pytest.fixture
def deform(device):
    deform = MLSDeform()
    deform.SetDevice(device)
    return deform


def smooth_image(**place):
    """Point array "values" (float64), cell array "cells" (two components, float32)."""
    image = make_image(**place)
    grid = ImageGeometry.of_image(image).grid
    x, y, z = grid.points().T
    add_array(image.GetPointData(), "values", np.sin(x) + y * z)
    image.GetPointData().SetActiveScalars("values")
    x, y, z = grid.cells.points().T
    add_array(image.GetCellData(), "cells", np.stack([x * y, z], axis=1), TYPES["float"])
    return image


def expected(image, deformation, target=None, **options):
    """The arrays of `smooth_image`, deformed without VTK's pipeline."""
    grid = ImageGeometry.of_image(image).grid
    target = target or grid
    sampling = Sampling(grid, target, **options)
    (values,) = deformation.resample([values_of(image, "values")], sampling)
    cells = grid.cells
    old = arrays.to_numpy(image.GetCellData().GetArray("cells")).reshape(*cells.shape, 2)
    sampling = Sampling(cells, target.cells, **options)
    (new,) = deformation.resample([old], sampling)
    return values, new.reshape(-1, 2)


def assert_holds(output, values, cells):
    np.testing.assert_array_equal(values_of(output, "values"), values)
    np.testing.assert_array_equal(arrays.to_numpy(output.GetCellData().GetArray("cells")), cells)


# Numbers


@pytest.mark.parametrize("background", [-1000.0, np.nan])
def test_a_background_that_a_type_does_not_have_is_said(deform, messages, background):
    """Once, by the name of the array; the others have it."""
    image = smooth_image()
    labels = np.ones(image.GetNumberOfPoints(), np.uint8)
    arrays.add(image.GetPointData(), "labels", labels)
    deform.SetBackground(background)
    far = MLSControlPoints()
    far.SetRestPoints([(0, 0, 0)])
    far.SetDeformedPoints([(1000, 0, 0)])
    output = update(connect(deform, image, far))
    messages.assert_one(f"`background` .* got {background}: array `labels` .uint8. gets 0 instead")
    assert (values_of(output, "labels") == 0).all()
    np.testing.assert_array_equal(values_of(output, "values"), background)
    deform.SetBackground(0.0)
    update(deform)
    messages.assert_none()


@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize("options", OPTIONS, ids=lambda o: o["kind"])
def test_gives_the_numbers_of_the_value(deform, device, place, options):
    image = smooth_image(**PLACES[place])
    deform.SetKind(options["kind"])
    deform.SetAlpha(options.get("alpha", ALPHA.default))
    deform.SetDegree(options.get("degree", 2))
    deform.SetSmoothing(options.get("smoothing", 0))
    deform.SetBackground(-3.5)
    output = update(connect(deform, image, control_points()))
    value = Deformation(REST, DEFORMED, device=device, **options)
    values, cells = expected(image, value, background=-3.5)
    assert_holds(output, values, cells)
    assert np.abs(values - values_of(image, "values")).max() > 0.1
    assert ImageGeometry.of_image(output) == ImageGeometry.of_image(image)
    assert output.GetPointData().GetScalars().GetName() == "values"


def test_moves_material_to_where_the_handles_went(deform):
    image = make_image((21, 21, 21))
    points = ImageGeometry.of_image(image).grid.points()
    p, q = np.array([4.0, 4.0, 3.0]), np.array([7.0, 5.0, 6.0])
    add_array(image.GetPointData(), "ball", np.exp(-((points - p) ** 2).sum(axis=1)))
    output = update(connect(deform, image, control_points([p], [q])))
    brightest = points[values_of(output, "ball").ravel().argmax()]
    np.testing.assert_allclose(brightest, q, atol=0.6)


@pytest.mark.parametrize("name", TYPES)
@pytest.mark.parametrize("interpolation", INTERPOLATIONS)
def test_identity_is_exact_in_every_type(deform, name, interpolation, rng):
    image = make_image((5, 4, 3), start=(-1, 2, 0), direction=TURNED)
    high = 2 if name == "bit" else 100
    add_array(image.GetPointData(), "one", rng.integers(0, high, 60), TYPES[name])
    add_array(image.GetPointData(), "three", rng.integers(0, high, (60, 3)), TYPES[name])
    add_array(image.GetCellData(), "cell", rng.integers(0, high, 24), TYPES[name])
    deform.SetInterpolation(interpolation)
    output = update(connect(deform, image, control_points(REST, REST)))
    for old, new in (
        (image.GetPointData(), output.GetPointData()),
        (image.GetCellData(), output.GetCellData()),
    ):
        assert new.GetNumberOfArrays() == old.GetNumberOfArrays()
        for i in range(old.GetNumberOfArrays()):
            assert new.GetArray(i).GetClassName() == old.GetArray(i).GetClassName()
            assert new.GetArrayName(i) == old.GetArrayName(i)
            np.testing.assert_array_equal(
                arrays.to_numpy(new.GetArray(i)), arrays.to_numpy(old.GetArray(i))
            )


@pytest.mark.parametrize("name", ["char", "unsigned char", "int", "long long"])
def test_integers_are_rounded_not_cut(deform, name):
    image = make_image((6, 1, 1), origin=(0, 0, 0))
    image.SetSpacing(1, 1, 1)
    add_array(image.GetPointData(), "n", [0, 10, 20, 30, 40, 50], TYPES[name])
    # a shift by 0.26: linear values end in .6 below the next ten
    handles = control_points([(0, 0, 0)], [(0.26, 0, 0)])
    output = update(connect(deform, image, handles))
    assert values_of(output, "n").ravel().tolist() == [0, 7, 17, 27, 37, 47]


@pytest.mark.parametrize("where", ["point", "cell"])
def test_labels_ghosts_and_strings_are_not_mixed(deform, where):
    image = make_image((6, 5, 4))
    data = image.GetPointData() if where == "point" else image.GetCellData()
    count = image.GetNumberOfPoints() if where == "point" else image.GetNumberOfCells()
    numbers = np.arange(count)
    add_array(data, "labels", 1000 * (numbers % 2), TYPES["int"])
    add_array(data, "plain", 1000 * (numbers % 2), TYPES["int"])
    add_array(data, vtkDataSetAttributes.GhostArrayName(), 32 * (numbers % 2), TYPES["bit"] + 2)
    strings = vtkStringArray()
    strings.SetName("names")
    strings.SetNumberOfTuples(count)
    for i in range(count):
        strings.SetValue(i, f"{where} {1000 * (i % 2)}")
    data.AddArray(strings)
    deform.AddLabelArray("labels")
    deform.SetBackground(7)
    handles = control_points([(0, 0, 0)], [(0.3, 0.4, 0.2)])
    output = update(connect(deform, image, handles))
    data = output.GetPointData() if where == "point" else output.GetCellData()
    labels = arrays.to_numpy(data.GetArray("labels"))
    assert set(labels) == {0, 1000, 7} or set(labels) == {0, 1000}
    assert not set(arrays.to_numpy(data.GetArray("plain"))) <= {0, 1000, 7}
    ghosts = arrays.to_numpy(data.GetArray(vtkDataSetAttributes.GhostArrayName()))
    np.testing.assert_array_equal(ghosts, np.where(labels == 1000, 32, 0))
    names = data.GetAbstractArray("names")
    for i, label in enumerate(labels):
        assert names.GetValue(i) == ("" if label == 7 else f"{where} {label}")


def test_strings_are_empty_and_ghosts_zero_outside(deform):
    image = make_image((3, 3, 3))
    strings = vtkStringArray()
    strings.SetName("names")
    for _ in range(27):
        strings.InsertNextValue("here")
    image.GetPointData().AddArray(strings)
    add_array(image.GetPointData(), "vtkGhostType", np.full(27, 2), TYPES["unsigned char"])
    add_array(image.GetPointData(), "values", np.ones(27))
    deform.SetBackground(9)
    output = update(connect(deform, image, control_points([(0, 0, 0)], [(100, 0, 0)])))
    assert output.GetPointData().GetAbstractArray("names").GetValue(13) == ""
    assert not values_of(output, "vtkGhostType").any()
    assert (values_of(output, "values") == 9).all()


def test_float64_keeps_its_digits(deform):
    image = make_image((5, 4, 3))
    values = 1 + np.arange(60) * 1e-12
    add_array(image.GetPointData(), "fine", values)
    handles = control_points([(0, 0, 0)], [(0.9, 0, 0)])  # by one voxel
    output = values_of(update(connect(deform, image, handles)), "fine")
    np.testing.assert_allclose(
        output[..., 1:] - 1, values.reshape(3, 4, 5)[..., :-1] - 1, rtol=0, atol=1e-15
    )


def test_field_data_passes(deform):
    image = smooth_image()
    add_array(image.GetFieldData(), "patient", [17])
    output = update(connect(deform, image, control_points()))
    assert output.GetFieldData().GetArray("patient").GetValue(0) == 17


def test_an_image_without_arrays_gives_one(deform):
    output = update(connect(deform, make_image(), control_points()))
    assert output.GetDimensions() == (9, 8, 7)
    assert output.GetPointData().GetNumberOfArrays() == 0


def test_weights_count(deform, device):
    image, weights = smooth_image(), np.arange(1.0, 9.0)
    output = update(connect(deform, image, control_points(weights=weights)))
    value = Deformation(REST, DEFORMED, weights=weights, device=device)
    assert_holds(output, *expected(image, value))


# Output grids


def test_given_grid(deform, device):
    image = smooth_image(direction=TURNED, start=(2, 0, -1))
    deform.SetOutputGrid("given")
    deform.SetOutputDimensions(4, 5, 6)
    deform.SetOutputSpacing(1.5, 1.25, 0.75)
    deform.SetOutputOrigin(0.5, 1, 2)
    output = update(connect(deform, image, control_points()))
    target = Grid((4, 5, 6), (0.5, 1, 2), (1.5, 1.25, 0.75), TURNED)
    value = Deformation(REST, DEFORMED, device=device)
    assert_holds(output, *expected(image, value, target))
    np.testing.assert_allclose(ImageGeometry.of_image(output).grid.points(), target.points())


def test_fitted_grid_follows_the_control_points():
    deform, image, handles = MLSDeform(), smooth_image(), control_points()
    deform.SetDevice(FAST)
    deform.SetOutputGrid("fitted")
    connect(deform, image, handles)
    for deformed in (DEFORMED, DEFORMED + [20, 0, -5], REST):
        handles.SetDeformedPoints(deformed)
        value = Deformation(REST, deformed, device=FAST)
        target = value.fitted_grid(ImageGeometry.of_image(image).grid)
        deform.UpdateInformation()
        info = deform.GetOutputInformation(0)
        assert ImageGeometry.of_information(info) == ImageGeometry.of_grid(target)
        assert_holds(update(deform), *expected(image, value, target))
        run = Executions(deform)
        update(deform)
        assert run.count == 0


# Pipeline


def test_nothing_is_done_twice(deform):
    source, handles = vtkRTAnalyticSource(), control_points()
    source.SetWholeExtent(0, 8, 0, 8, 0, 8)
    runs = [Executions(algorithm) for algorithm in (source, handles, deform)]
    connect(deform, source, handles)

    def counts():
        update(deform)
        return [run.count for run in runs]

    assert counts() == counts() == [1, 1, 1]
    properties = {
        "Kind": "affine",
        "Alpha": 1.5,
        "Smoothing": 0.5,
        "Degree": 3,
        "Interpolation": "nearest",
        "Background": 2.0,
        "OutputGrid": "given",
        "OutputDimensions": (5, 5, 5),
        "OutputSpacing": (2.0, 2.0, 2.0),
        "OutputOrigin": (1.0, 1.0, 1.0),
    }
    for number, (name, value) in enumerate(properties.items(), start=2):
        for _ in range(2):
            getattr(deform, f"Set{name}")(value)
            assert getattr(deform, f"Get{name}")() == value
            assert counts() == [1, 1, number], name
    before = deform.GetMTime()
    deform.SetOutputDimensions(5, 5, 5)
    deform.SetOutputSpacing((2, 2, 2))
    deform.ClearLabelArrays()
    assert deform.GetMTime() == before
    handles.SetRestPoint(0, 1.0, 1.0, 1.5)
    assert counts() == counts() == [1, 2, 12]
    source.SetStandardDeviation(0.4)
    assert counts() == counts() == [2, 2, 13]


def test_label_arrays_are_a_property(deform):
    deform.AddLabelArray("a")
    deform.AddLabelArray("b")
    before = deform.GetMTime()
    deform.AddLabelArray("a")
    assert deform.GetLabelArrays() == ("a", "b")
    assert deform.GetMTime() == before
    deform.ClearLabelArrays()
    assert deform.GetLabelArrays() == ()
    assert deform.GetMTime() > before


def test_changed_data_are_noticed(deform):
    image, polydata = smooth_image(), update(control_points())
    connect(deform, image, polydata)
    first = values_of(update(deform), "values").copy()
    arrays.to_numpy(polydata.GetPointData().GetArray("Displacement"))[:] += 0.5
    polydata.GetPointData().GetArray("Displacement").Modified()
    polydata.GetPointData().Modified()
    second = values_of(update(deform), "values").copy()
    assert not np.array_equal(first, second)
    arrays.to_numpy(image.GetPointData().GetArray("values"))[:] *= 2
    image.GetPointData().GetArray("values").Modified()
    third = values_of(update(deform), "values")
    np.testing.assert_allclose(third, 2 * second, atol=1e-12)


@pytest.mark.parametrize("place", ["plain", "shifted", "turned"])
@pytest.mark.parametrize("choice", ["input", "given"])
def test_a_part_is_the_same_as_in_the_whole(deform, place, choice):
    image, handles = smooth_image(**PLACES[place]), control_points()
    deform.SetOutputGrid(choice)
    deform.SetOutputDimensions(7, 8, 6)
    whole = update(connect(deform, image, handles))
    assert not np.array_equal(values_of(whole, "values"), values_of(image, "values"))
    wanted = values_of(whole, "values").copy()
    low = np.array(whole.GetExtent()[::2])
    extent = [int(i) for a, n in zip(low, (3, 4, 2)) for i in (a + 1, a + n)]
    part_filter = MLSDeform()
    part_filter.SetDevice(deform.GetDevice())
    part_filter.SetOutputGrid(choice)
    part_filter.SetOutputDimensions(7, 8, 6)
    connect(part_filter, image, handles)
    assert part_filter.UpdateExtent(extent)
    part = part_filter.GetOutputDataObject(0)
    assert part.GetExtent() == tuple(extent)
    np.testing.assert_allclose(values_of(part, "values"), wanted[1:3, 1:5, 1:4], rtol=0, atol=1e-4)
    # more than was there is made, and nothing but that asks for it
    runs = Executions(part_filter)
    part_filter.UpdateExtent(extent)
    assert runs.count == 0
    part_filter.UpdateWholeExtent()
    assert runs.count == 1
    np.testing.assert_array_equal(values_of(part_filter.GetOutputDataObject(0), "values"), wanted)


def test_pieces_make_up_the_whole_and_each_sees_all_input(deform):
    source = vtkRTAnalyticSource()
    source.SetWholeExtent(0, 9, 0, 9, 0, 9)
    connect(deform, source, control_points())
    whole = values_of(update(deform), "RTData").copy()
    seen = np.zeros(whole.shape, bool)
    for piece in range(3):
        deform.UpdatePiece(piece, 3, 0)
        assert source.GetOutput().GetExtent() == (0, 9, 0, 9, 0, 9)
        part = deform.GetOutputDataObject(0)
        e = part.GetExtent()
        where = np.s_[e[4] : e[5] + 1, e[2] : e[3] + 1, e[0] : e[1] + 1]
        np.testing.assert_allclose(values_of(part, "RTData"), whole[where], rtol=1e-4)
        seen[where] = True
        runs = Executions(deform)
        deform.UpdatePiece(piece, 3, 0)
        assert runs.count == 0
    assert seen.all()


def test_the_input_may_be_only_a_part_of_what_it_could_be(deform, device):
    class Part(vtkTrivialProducer):
        pass

    producer = Part()
    image = smooth_image()
    producer.SetOutput(image)
    producer.SetWholeExtent(0, 8, 0, 7, 0, 6)
    output = update(connect(deform, producer, control_points()))
    assert_holds(output, *expected(image, Deformation(REST, DEFORMED, device=device)))


def test_a_filter_downstream_gets_the_output(deform):
    scale = vtkImageShiftScale()
    scale.SetScale(2)
    connect(deform, smooth_image(), control_points())
    scale.SetInputConnection(deform.GetOutputPort())
    scale.SetOutputScalarTypeToDouble()
    output = update(scale)
    np.testing.assert_array_equal(
        values_of(output, "values"), 2 * values_of(deform.GetOutputDataObject(0), "values")
    )


@pytest.mark.parametrize("choice", ["input", "fitted"])
def test_blocks_are_deformed_one_by_one(choice, messages):
    deform = MLSDeform()
    deform.SetDevice(FAST)
    deform.SetOutputGrid(choice)
    blocks = vtkMultiBlockDataSet()
    images = [smooth_image(), smooth_image(dimensions=(6, 5, 4), direction=TURNED)]
    for number, image in enumerate(images):
        blocks.SetBlock(number, image)
    output = update(connect(deform, blocks, control_points()))
    messages.assert_one("what crosses a border between them is lost")
    value = Deformation(REST, DEFORMED, device=FAST)
    for number, image in enumerate(images):
        grid = ImageGeometry.of_image(image).grid
        target = value.fitted_grid(grid) if choice == "fitted" else grid
        assert_holds(output.GetBlock(number), *expected(image, value, target))


def test_progress_rises_to_one(deform):
    fractions = []
    deform.AddObserver("ProgressEvent", lambda *_: fractions.append(deform.GetProgress()))
    update(connect(deform, smooth_image(), control_points()))
    assert fractions == sorted(fractions)
    assert fractions[0] >= 0
    assert fractions[-1] == 1
    assert len(fractions) >= 3


def test_an_abort_leaves_nothing_and_can_be_resumed(deform):
    connect(deform, smooth_image(), control_points())
    tag = deform.AddObserver("ProgressEvent", lambda *_: deform.SetAbortExecute(1))
    deform.Update()
    assert deform.GetOutputDataObject(0).GetNumberOfPoints() == 0
    deform.RemoveObserver(tag)
    deform.SetAbortExecute(0)
    assert update(deform).GetNumberOfPoints() == 504


def test_the_output_outlives_the_filter(deform):
    image, handles = smooth_image(), control_points()
    output = update(connect(deform, image, handles))
    wanted = values_of(output, "values").copy()
    copy = output.NewInstance()
    copy.ShallowCopy(output)
    del deform, handles, image, output
    gc.collect()
    rubbish = [np.full(wanted.shape, np.nan) for _ in range(50)]
    np.testing.assert_array_equal(values_of(copy, "values"), wanted)
    del rubbish


def test_the_same_output_object_is_refilled(deform):
    connect(deform, smooth_image(), control_points())
    output = update(deform)
    deform.SetKind("affine")
    assert update(deform) is output


def test_another_displacement_array(deform, device):
    image, polydata = smooth_image(), update(control_points())
    half = (DEFORMED - REST) / 2
    add_array(polydata.GetPointData(), "half", half)
    connect(deform, image, polydata)
    points = vtkDataObject.FIELD_ASSOCIATION_POINTS
    deform.SetInputArrayToProcess(0, 1, 0, points, "half")
    value = Deformation(REST, REST + half, device=device)
    assert_holds(update(deform), *expected(image, value))
    polydata.GetPointData().SetActiveVectors("Displacement")
    deform.SetInputArrayToProcess(0, 1, 0, points, vtkDataSetAttributes.VECTORS)
    value = Deformation(REST, REST + (DEFORMED - REST), device=device)
    assert_holds(update(deform), *expected(image, value))
    # "Weight" may be named although it is absent
    deform.SetInputArrayToProcess(1, 1, 0, points, "Weight")
    assert_holds(update(deform), *expected(image, value))


def test_whole_extent_is_announced(deform):
    source = vtkRTAnalyticSource()
    source.SetWholeExtent(-3, 4, 0, 5, 2, 9)
    connect(deform, source, control_points())
    deform.UpdateInformation()
    info = deform.GetOutputInformation(0)
    extent = info.Get(vtkStreamingDemandDrivenPipeline.WHOLE_EXTENT())
    assert extent == (-3, 4, 0, 5, 2, 9)


def test_pyvista_datasets_are_accepted(deform):
    pyvista = pytest.importorskip("pyvista", reason="PyVista is not installed")
    image = pyvista.ImageData(dimensions=(9, 8, 7))
    image["values"] = np.arange(504.0)
    handles = pyvista.PolyData(REST)
    handles["Displacement"] = DEFORMED - REST
    output = pyvista.wrap(update(connect(deform, image, handles)))
    assert output.dimensions == image.dimensions
    assert not np.array_equal(output["values"], image["values"])
    handles["Displacement"] = np.zeros((8, 3))
    output = pyvista.wrap(update(deform))
    np.testing.assert_array_equal(output["values"], image["values"])


def named_image(name, dimensions):
    """An image with one point array, its active scalars."""
    image = make_image(dimensions=dimensions)
    values = np.arange(np.prod(dimensions), dtype=float)
    add_array(image.GetPointData(), name, values)
    image.GetPointData().SetActiveScalars(name)
    return image


def point_arrays(image):
    data = image.GetPointData()
    return [data.GetArrayName(i) for i in range(data.GetNumberOfArrays())]


def test_blocks_do_not_keep_scalars_of_other_blocks(deform, messages):
    """VTK leaves them in the output of an algorithm that runs on several."""
    blocks = vtkMultiBlockDataSet()
    for number, name in enumerate("abc"):
        blocks.SetBlock(number, named_image(name, (5 - number, 4, 3)))
    connect(deform, blocks, control_points())
    output = update(deform)
    messages.assert_one("what crosses a border between them is lost")
    assert [point_arrays(output.GetBlock(number)) for number in range(3)] == [["a"], ["b"], ["c"]]
