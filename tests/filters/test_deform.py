"""MLSDeform gives the value's numbers."""

import numpy as np
import pytest
from pipelines import Executions, assert_same, connect, control_points, update, values_of
from smooth_images import PLACES, assert_holds, expected, smooth_image
from vtk_fixtures import DEFORMED, REST, TURNED, TYPES, add_array, make_image
from vtkmodules.vtkCommonDataModel import vtkDataSetAttributes

from vtk_mls import INTERPOLATIONS, Deformation, Grid
from vtk_mls.filters import MLSDeform
from vtk_mls.vtk import arrays
from vtk_mls.vtk.arrays import ImageGeometry
from vtk_mls.vtk.objects import configured

OPTIONS = [
    {"kind": "affine"},
    {"kind": "rigid", "alpha": 1.0},
    {"kind": "affine", "smoothing": 1.5},
    {"kind": "similarity"},
    {"kind": "polynomial", "degree": 1},
    {"kind": "rigid", "weights": np.arange(1.0, 9)},
]


@pytest.fixture
def reference():
    """A filter for tests of arrays, in which numbers are not the point."""
    return configured(MLSDeform(), Device="reference")


@pytest.mark.parametrize("background", [-1000.0, np.nan])
def test_a_background_outside_the_range_of_a_type_is_reported(reference, messages, background):
    """Once, by the name of the array; the others have it."""
    image = smooth_image()
    labels = np.ones(image.GetNumberOfPoints(), np.uint8)
    arrays.add(image.GetPointData(), "labels", labels)
    reference.SetBackground(background)
    output = update(connect(reference, image, control_points([(0, 0, 0)], [(1000, 0, 0)])))
    messages.assert_one(f"`background` .* got {background}: array `labels` .uint8. gets 0 instead")
    assert (values_of(output, "labels") == 0).all()
    np.testing.assert_array_equal(values_of(output, "values"), background)
    reference.SetBackground(0.0)
    update(reference)
    messages.assert_none()


@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize("options", OPTIONS, ids=lambda o: o["kind"])
def test_gives_the_numbers_of_the_value(reference, place, options):
    image = smooth_image(**PLACES[place])
    properties = {name.capitalize(): value for name, value in options.items() if name != "weights"}
    configured(reference, Background=-3.5, **properties)
    add_array(image.GetFieldData(), "patient", [17])
    handles = control_points(weights=options.get("weights", ()))
    output = update(connect(reference, image, handles))
    value = Deformation(REST, DEFORMED, device="reference", **options)
    values, cells = expected(image, value, background=-3.5)
    assert_holds(output, values, cells)
    assert np.abs(values - values_of(image, "values")).max() > 0.1
    assert ImageGeometry.of_image(output) == ImageGeometry.of_image(image)
    assert output.GetPointData().GetScalars().GetName() == "values"
    assert output.GetFieldData().GetArray("patient").GetValue(0) == 17


@pytest.mark.parametrize("name", TYPES)
@pytest.mark.parametrize("interpolation", INTERPOLATIONS)
def test_identity_is_exact_in_every_type(reference, name, interpolation, rng):
    image = make_image((5, 4, 3), start=(-1, 2, 0), direction=TURNED)
    high = 2 if name == "bit" else 100
    add_array(image.GetPointData(), "one", rng.integers(0, high, 60), TYPES[name])
    add_array(image.GetPointData(), "three", rng.integers(0, high, (60, 3)), TYPES[name])
    add_array(image.GetCellData(), "cell", rng.integers(0, high, 24), TYPES[name])
    reference.SetInterpolation(interpolation)
    output = update(connect(reference, image, control_points(REST, REST)))
    assert_same(output, image)
    for old, new in (
        (image.GetPointData(), output.GetPointData()),
        (image.GetCellData(), output.GetCellData()),
    ):
        for i in range(old.GetNumberOfArrays()):
            assert new.GetArray(i).GetClassName() == old.GetArray(i).GetClassName()
            assert new.GetArrayName(i) == old.GetArrayName(i)


@pytest.mark.parametrize("where", ["point", "cell"])
def test_labels_ghosts_and_strings_are_not_mixed(reference, where):
    image = make_image((6, 5, 4))
    data = image.GetPointData() if where == "point" else image.GetCellData()
    count = image.GetNumberOfPoints() if where == "point" else image.GetNumberOfCells()
    numbers = np.arange(count)
    add_array(data, "labels", 1000 * (numbers % 2), TYPES["int"])
    add_array(data, "plain", 1000 * (numbers % 2), TYPES["int"])
    data.SetPedigreeIds(add_array(data, "ids", 1000 * (numbers % 2), TYPES["id type"]))
    add_array(data, vtkDataSetAttributes.GhostArrayName(), 32 * (numbers % 2), TYPES["bit"] + 2)
    arrays.add_texts(data, "names", [f"{where} {1000 * (i % 2)}" for i in range(count)])
    reference.AddLabelArray("labels")
    reference.SetBackground(7)
    handles = control_points([(0, 0, 0)], [(1.2, 0.4, 0.2)])  # nearest: the next along x
    output = update(connect(reference, image, handles))
    data = output.GetPointData() if where == "point" else output.GetCellData()
    labels = arrays.to_numpy(data.GetArray("labels"))
    assert {0, 1000} <= set(labels) <= {0, 1000, 7}
    np.testing.assert_array_equal(arrays.to_numpy(data.GetArray("ids")), labels)
    assert not set(arrays.to_numpy(data.GetArray("plain"))) <= {0, 1000, 7}
    ghosts = arrays.to_numpy(data.GetArray(vtkDataSetAttributes.GhostArrayName()))
    np.testing.assert_array_equal(ghosts, np.where(labels == 1000, 32, 0))
    expected = ["" if label == 7 else f"{where} {label}" for label in labels]
    assert arrays.texts(data, "names") == expected


def test_given_grid(deform, device):
    image = smooth_image(direction=TURNED, start=(2, 0, -1))
    target = Grid((4, 5, 6), (0.5, 1, 2), (1.5, 1.25, 0.75), TURNED)
    configured(deform, OutputDimensions=target.dimensions, OutputSpacing=target.spacing)
    configured(deform, OutputGrid="given", OutputOrigin=target.origin)
    output = update(connect(deform, image, control_points()))
    value = Deformation(REST, DEFORMED, device=device)
    assert_holds(output, *expected(image, value, target))
    np.testing.assert_allclose(ImageGeometry.of_image(output).grid.points(), target.points())


def test_fitted_grid_follows_the_control_points(reference, coarse_fits):
    image = smooth_image(dimensions=(5, 4, 4), spacing=(1.8, 2.0, 2.2))
    handles = control_points()
    reference.SetOutputGrid("fitted")
    connect(reference, image, handles)
    for deformed in (DEFORMED, DEFORMED + [20, 0, -5], REST):
        handles.SetDeformedPoints(deformed)
        value = Deformation(REST, deformed, device="reference")
        target = value.fitted_grid(ImageGeometry.of_image(image).grid)
        reference.UpdateInformation()
        info = reference.GetOutputInformation(0)
        assert ImageGeometry.of_information(info) == ImageGeometry.of_grid(target)
        assert_holds(update(reference), *expected(image, value, target))
        run = Executions(reference)
        update(reference)
        assert run.count == 0
