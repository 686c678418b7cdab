"""VTK <-> numpy keeps values, types and places."""

import gc
import weakref

import numpy as np
import pytest
from pipelines import update
from vtk_fixtures import TURNED, TYPES, add_array, make_image
from vtkmodules import vtkCommonCore
from vtkmodules.vtkCommonCore import VTK_DOUBLE, VTK_FLOAT, vtkInformation
from vtkmodules.vtkCommonDataModel import vtkDataSetAttributes, vtkPointData
from vtkmodules.vtkFiltersCore import vtkCellCenters

from vtk_mls.vtk import arrays
from vtk_mls.vtk.arrays import ImageGeometry
from vtk_mls.vtk.objects import configured

SHARES = hasattr(vtkCommonCore.vtkDoubleArray, "GetBuffer")
IMAGES = {
    "plain": {},
    "shifted": {"start": (3, -2, 5)},
    "turned": {"direction": TURNED, "start": (-1, 2, 0)},
    "left-handed": {"direction": np.diag([1, -1, 1])},
    "slice": {"dimensions": (5, 1, 4), "start": (0, 7, 0)},
    "line": {"dimensions": (1, 6, 1)},
    "point": {"dimensions": (1, 1, 1), "direction": TURNED},
}


@pytest.fixture(params=IMAGES)
def image(request):
    return make_image(**IMAGES[request.param])


@pytest.mark.parametrize("name", TYPES)
@pytest.mark.parametrize("shape", [(13,), (13, 3), (0,)])
def test_every_type_comes_back_as_it_was(name, shape, rng):
    values = rng.integers(0, 2 if name == "bit" else 100, shape)
    array = add_array(vtkPointData(), "values", values, TYPES[name])
    numbers = arrays.to_numpy(array)
    np.testing.assert_array_equal(numbers, values)
    if name != "bit" and len(values):
        assert np.shares_memory(numbers, arrays.to_numpy(array))  # that of VTK
        if numbers.dtype.kind != "f":
            limits = np.iinfo(numbers.dtype)
            numbers[:3].flat = limits.min, limits.max, limits.max - 1
    back = arrays.from_numpy(numbers.copy(), TYPES[name])
    assert back.GetDataType() == array.GetDataType()
    assert back.GetClassName() == array.GetClassName()
    assert back.GetNumberOfTuples() == len(values)
    np.testing.assert_array_equal(arrays.to_numpy(back), numbers)


@pytest.mark.parametrize(
    ("values", "name"),
    [
        (np.arange(6, dtype=np.int32), "id type"),
        (np.arange(6.0), "float"),
        (np.arange(6, dtype=np.uint8), "signed char"),
        (np.arange(6, dtype=">f8"), "double"),
    ],
)
def test_numbers_of_another_size_or_kind_are_refused(values, name):
    with pytest.raises(TypeError, match="`values` must be"):
        arrays.from_numpy(values, TYPES[name])


@pytest.mark.skipif(not SHARES, reason="before VTK 9.7 numpy memory is copied")
def test_numpy_memory_is_shared_and_kept_as_long_as_needed():
    values = np.arange(1000.0)
    alive = weakref.ref(values)
    array = arrays.from_numpy(values, VTK_DOUBLE)
    values[999] = -1
    copy = array.NewInstance()
    copy.ShallowCopy(array)
    holder = vtkPointData()
    holder.AddArray(copy)
    del values, array, copy
    gc.collect()
    assert alive() is not None
    assert holder.GetArray(0).GetValue(999) == -1
    del holder
    gc.collect()
    assert alive() is None


def test_memory_in_separate_components_is_read():
    if not hasattr(vtkCommonCore, "vtkSOADataArrayTemplate"):
        pytest.skip("this VTK has no such array in Python")
    array = vtkCommonCore.vtkSOADataArrayTemplate["float32"]()
    configured(array, NumberOfComponents=2, NumberOfTuples=3)
    for i in range(6):
        array.SetComponent(i // 2, i % 2, i)
    np.testing.assert_array_equal(arrays.to_numpy(array), [[0, 1], [2, 3], [4, 5]])


def test_points_and_cells_of_the_grid_are_where_vtk_has_them(image):
    centers, grid = vtkCellCenters(), ImageGeometry.of_image(image).grid
    centers.SetInputData(image)
    assert grid.dimensions == image.GetDimensions()
    for points, data in ((grid.points(), image), (grid.cells.points(), update(centers))):
        expected = [data.GetPoint(i) for i in range(data.GetNumberOfPoints())]
        np.testing.assert_allclose(points, expected, atol=1e-12)


def test_a_lattice_survives_image_and_information(image):
    lattice = ImageGeometry.of_image(image)
    other, info = make_image(), vtkInformation()
    lattice.apply_to(other)
    lattice.set_information(info)
    assert ImageGeometry.of_image(other) == ImageGeometry.of_information(info) == lattice
    grid = ImageGeometry.of_grid(lattice.grid).grid
    np.testing.assert_array_equal(grid.points(), lattice.grid.points())


def test_names_components_and_roles_are_kept(rng):
    image = make_image((3, 2, 2))
    data = image.GetPointData()
    for name in ("a", None, "n", "ids"):
        array = add_array(data, name, rng.normal(size=(12, 3)), VTK_FLOAT)
        array.SetComponentName(1, f"second of {name}")
    table = vtkCommonCore.vtkLookupTable()
    data.GetArray(0).SetLookupTable(table)
    data.SetActiveScalars("a")
    data.SetActiveAttribute(1, vtkDataSetAttributes.VECTORS)
    data.SetActiveNormals("n")
    data.SetActiveAttribute(3, vtkDataSetAttributes.PEDIGREEIDS)
    new = vtkPointData()
    values = arrays.image_values(data, ImageGeometry.of_image(image).grid)
    assert [v.shape for v in values] == [(2, 2, 3, 3)] * 4
    arrays.set_values(new, values, data)
    for i in range(4):
        assert new.GetArrayName(i) == data.GetArrayName(i)
        assert new.GetArray(i).GetComponentName(1) == data.GetArray(i).GetComponentName(1)
        assert new.IsArrayAnAttribute(i) == data.IsArrayAnAttribute(i) >= 0
    assert new.GetArray(0).GetLookupTable() is table


def test_texts():
    attributes, texts = vtkPointData(), ["a", "", 'ä, "b"', "c\nd"]
    arrays.add_texts(attributes, "names", texts)
    assert arrays.texts(attributes, "names") == texts
    arrays.add(attributes, "numbers", np.zeros(4))
    assert arrays.texts(attributes, "numbers") == arrays.texts(attributes, "none") == []
    attributes.GetAbstractArray("names").SetValue(1, b"\xff")
    assert arrays.texts(attributes, "names")[1] == "ÿ"  # of which no byte is lost
