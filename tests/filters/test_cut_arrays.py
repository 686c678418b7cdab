"""Pieces of cut meshes keep the arrays that cannot be interpolated: ids, bits, texts and others."""

import numpy as np
import pytest
from mesh_fixtures import CUTS, MESHES, array_of, cells, places_of, split
from scipy.spatial import cKDTree
from vtk_fixtures import TYPES, add_array
from vtkmodules.vtkCommonCore import vtkVariant, vtkVariantArray
from vtkmodules.vtkCommonDataModel import VTK_HEXAHEDRON, VTK_TRIANGLE, vtkUnstructuredGrid


def numbered(mesh):
    """With the number of each point and each cell in arrays of several kinds."""
    for data, count in (
        (mesh.GetPointData(), mesh.GetNumberOfPoints()),
        (mesh.GetCellData(), mesh.GetNumberOfCells()),
    ):
        data.SetGlobalIds(add_array(data, "global", np.arange(count), TYPES["id type"]))
        data.SetPedigreeIds(add_array(data, "pedigree", np.arange(count), TYPES["id type"]))
        add_array(data, "ids", np.arange(count), TYPES["id type"])
        add_array(data, "odd", np.arange(count) % 2, TYPES["bit"])
        variants = vtkVariantArray()
        variants.SetName("variants")
        for number in range(count):
            variants.InsertNextValue(vtkVariant(number))
        data.AddArray(variants)
    return mesh


def texts(data, name):
    array = data.GetAbstractArray(name)
    return [array.GetVariantValue(i).ToString() for i in range(array.GetNumberOfTuples())]


@pytest.mark.parametrize("cut", ["plane", "tent"])
@pytest.mark.parametrize("name", [name for name in MESHES if name != "points"])
def test_pieces_keep_ids_bits_and_texts(name, cut):
    mesh = numbered(MESHES[name]())
    output, _ = split(mesh, [CUTS[cut]])
    assert output.GetNumberOfCells() > mesh.GetNumberOfCells()
    x = np.array([mesh.GetPoint(i) for i in range(mesh.GetNumberOfPoints())])
    rows = array_of(output, "ids")
    distances, _ = cKDTree(x).query(places_of(output))
    is_old = distances == 0
    assert is_old.sum() >= len(x)
    np.testing.assert_array_equal(x[rows[is_old]], places_of(output)[is_old])
    assert texts(output.GetPointData(), "names") == [str(row) for row in rows]
    of_cells = array_of(output, "number", "Cell")
    np.testing.assert_array_equal(array_of(output, "ids", "Cell"), of_cells)
    for data, numbers in (("Point", rows), ("Cell", of_cells.astype(int))):
        attributes = getattr(output, f"Get{data}Data")()
        assert attributes.GetGlobalIds() is None
        for each in ("global", "pedigree"):
            np.testing.assert_array_equal(array_of(output, each, data), numbers)
        np.testing.assert_array_equal(array_of(output, "odd", data), numbers % 2)
        assert texts(attributes, "variants") == [str(number) for number in numbers]


def test_new_points_have_the_id_of_the_nearest_corner():
    mesh = numbered(cells(VTK_HEXAHEDRON))
    output, _ = split(mesh, [CUTS["plane"]])
    x, found = places_of(mesh), places_of(output)
    distances, _ = cKDTree(x).query(found)
    own = np.linalg.norm(found - x[array_of(output, "ids")], axis=1)
    assert (distances > 0.1).any()
    np.testing.assert_allclose(own, distances, atol=1e-12)


@pytest.mark.parametrize("is_filled", [False, True])
def test_cells_without_points_keep_their_ids(is_filled):
    mesh = vtkUnstructuredGrid()
    mesh.SetPoints(cells(VTK_HEXAHEDRON).GetPoints())
    for _ in range(2):
        mesh.InsertNextCell(VTK_TRIANGLE, 0, [])
    if is_filled:
        mesh.InsertNextCell(VTK_TRIANGLE, 3, [0, 4, 5])
    output, _ = split(numbered(mesh), [CUTS["plane"]])
    ids = array_of(output, "ids", "Cell").tolist()
    assert ids == [2] * (output.GetNumberOfCells() - 2) + [0, 1]
