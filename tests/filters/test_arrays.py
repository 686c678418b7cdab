"""VTK <-> numpy keeps values, types and places."""

import gc
import weakref

import numpy as np
import pytest
from vtk_fixtures import TURNED, TYPES, add_array, make_image
from vtkmodules import vtkCommonCore
from vtkmodules.vtkCommonCore import VTK_DOUBLE, VTK_FLOAT, vtkInformation, vtkStringArray
from vtkmodules.vtkCommonDataModel import vtkDataSetAttributes, vtkPointData, vtkPolyData
from vtkmodules.vtkFiltersCore import vtkCellCenters

from vtk_mls.vtk import arrays
from vtk_mls.vtk.arrays import ImageGeometry

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
    back = arrays.from_numpy(numbers.copy(), TYPES[name])
    assert back.GetDataType() == array.GetDataType()
    assert back.GetClassName() == array.GetClassName()
    assert back.GetNumberOfTuples() == len(values)
    np.testing.assert_array_equal(arrays.to_numpy(back), values)


@pytest.mark.parametrize(
    ("values", "name"),
    [
        (np.arange(6, dtype=np.int32), "id type"),
        (np.arange(6, dtype=np.int64), "int"),
        (np.arange(6.0), "float"),
        (np.arange(6.0), "long long"),
        (np.arange(6, dtype=np.uint8), "signed char"),
        (np.arange(6, dtype=">f8"), "double"),
    ],
)
def test_numbers_of_another_size_or_kind_are_refused(values, name):
    with pytest.raises(TypeError, match="`values` must be"):
        arrays.from_numpy(values, TYPES[name])


@pytest.mark.parametrize("name", sorted(set(TYPES) - {"bit"}))
def test_memory_of_vtk_is_seen_not_copied(name):
    array = add_array(vtkPointData(), "values", [1, 2, 3], TYPES[name])
    numbers = arrays.to_numpy(array)
    array.SetComponent(1, 0, 7)
    assert numbers.tolist() == [1, 7, 3]


def test_extreme_values():
    for dtype, name in ((np.int64, "long long"), (np.uint64, "unsigned long long")):
        limits = np.iinfo(dtype)
        values = np.array([limits.min, limits.max, limits.max - 1], dtype)
        back = arrays.to_numpy(arrays.from_numpy(values, TYPES[name]))
        assert back.dtype == dtype
        np.testing.assert_array_equal(back, values)


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
    if hasattr(vtkCommonCore, "vtkSOADataArrayTemplate"):
        array = vtkCommonCore.vtkSOADataArrayTemplate["float32"]()
    else:
        pytest.skip("this VTK has no such array in Python")
    array.SetNumberOfComponents(2)
    array.SetNumberOfTuples(3)
    for i in range(6):
        array.SetComponent(i // 2, i % 2, i)
    np.testing.assert_array_equal(arrays.to_numpy(array), [[0, 1], [2, 3], [4, 5]])


def test_points_of_the_grid_are_where_vtk_has_them(image):
    grid = ImageGeometry.of_image(image).grid
    assert grid.dimensions == image.GetDimensions()
    expected = [image.GetPoint(i) for i in range(image.GetNumberOfPoints())]
    np.testing.assert_allclose(grid.points(), expected, atol=1e-12)


def test_cells_of_the_grid_are_where_vtk_has_them(image):
    centers = vtkCellCenters()
    centers.SetInputData(image)
    centers.Update()
    expected = centers.GetOutput()
    cells = ImageGeometry.of_image(image).grid.cells
    assert cells.size == image.GetNumberOfCells()
    expected = [expected.GetPoint(i) for i in range(expected.GetNumberOfPoints())]
    np.testing.assert_allclose(cells.points(), expected, atol=1e-12)


def test_a_lattice_survives_image_and_information(image):
    lattice = ImageGeometry.of_image(image)
    other, info = make_image(), vtkInformation()
    lattice.apply_to(other)
    lattice.set_information(info)
    assert ImageGeometry.of_image(other) == ImageGeometry.of_information(info) == lattice
    grid = ImageGeometry.of_grid(lattice.grid).grid
    np.testing.assert_array_equal(grid.points(), lattice.grid.points())


def test_which_extents_a_lattice_holds():
    lattice = ImageGeometry((0, 4, -2, 2, 1, 1))
    assert lattice.holds((0, 4, -2, 2, 1, 1))
    assert lattice.holds((1, 1, 0, 2, 1, 1))
    assert not lattice.holds((0, 4, -3, 2, 1, 1))
    assert not lattice.holds((0, -1, 0, -1, 0, -1))
    assert ImageGeometry((0, -1, 0, -1, 0, -1)).is_empty
    assert not lattice.is_empty


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
    arrays.set_image_values(new, values, data)
    for i in range(4):
        assert new.GetArrayName(i) == data.GetArrayName(i)
        assert new.GetArray(i).GetComponentName(1) == data.GetArray(i).GetComponentName(1)
        assert new.IsArrayAnAttribute(i) == data.IsArrayAnAttribute(i) >= 0
    assert new.GetArray(0).GetLookupTable() is table


def test_strings_are_picked_by_index():
    strings = vtkStringArray()
    strings.SetName("words")
    strings.SetNumberOfTuples(4)
    for i, word in enumerate("abcd"):
        strings.SetValue(i, word)
    old, new = vtkPointData(), vtkPointData()
    old.AddArray(strings)
    image = make_image((2, 2, 1))
    (index,) = arrays.image_values(old, ImageGeometry.of_image(image).grid)
    assert index.tolist() == [[[0, 1], [2, 3]]]
    arrays.set_image_values(new, [np.array([[[3, -1], [1, 0]]])], old)
    picked = new.GetAbstractArray("words")
    assert [picked.GetValue(i) for i in range(4)] == ["d", "", "b", "a"]


def test_an_array_of_another_size_is_refused():
    image = make_image((2, 2, 2))
    add_array(image.GetPointData(), "short", np.zeros(7))
    with pytest.raises(ValueError, match=r"`short` must have one tuple for each of the 8 .*got 7"):
        arrays.image_values(image.GetPointData(), ImageGeometry.of_image(image).grid)


def test_control_points_are_float64_whatever_they_were():
    points = vtkCommonCore.vtkPoints()  # float32
    points.InsertNextPoint(1, 2, 3)
    polydata = vtkPolyData()
    polydata.SetPoints(points)
    add_array(polydata.GetPointData(), "move", [[1, 0, -1]], TYPES["short"])
    add_array(polydata.GetPointData(), "factor", [2], TYPES["int"])
    rest, deformed, weights = arrays.control_points(polydata, "move", "factor")
    assert rest.dtype == deformed.dtype == weights.dtype == np.float64
    assert (rest.tolist(), deformed.tolist(), weights.tolist()) == ([[1, 2, 3]], [[2, 2, 2]], [2])
    with pytest.raises(ValueError, match="no numeric point array `shift`; it has `move`, `factor`"):
        arrays.control_points(polydata, "shift")
    with pytest.raises(ValueError, match="`factor`, must have 3 components, got 1"):
        arrays.control_points(polydata, "factor")
    with pytest.raises(ValueError, match="`ControlPoints` has no points"):
        arrays.control_points(vtkPolyData(), "move")


def test_texts():
    attributes, texts = vtkPointData(), ["a", "", 'ä, "b"', "c\nd"]
    arrays.add_texts(attributes, "names", texts)
    assert arrays.texts(attributes, "names") == texts
    arrays.add(attributes, "numbers", np.zeros(4))
    assert arrays.texts(attributes, "numbers") == arrays.texts(attributes, "none") == []
    attributes.GetAbstractArray("names").SetValue(1, b"\xff")
    assert arrays.texts(attributes, "names")[1] == "ÿ"  # of which no byte is lost
