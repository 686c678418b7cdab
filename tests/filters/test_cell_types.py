"""Cells that VTK's filters treat apart: boxes by type, empty ones; and points that are integers."""

import os
import sys

import numpy as np
import pytest
from command_fixtures import python
from mesh_fixtures import (
    CUTS,
    array_of,
    as_grid,
    cells,
    count,
    deforming,
    grid_of,
    places_of,
    polyhedra,
    reference,
    set_places,
    sizes,
)
from pipelines import control_points, update
from vtk_fixtures import FAST, REST, TURNED, TYPES, add_array, polydata_of
from vtkmodules.vtkCommonCore import VTK_DOUBLE, VTK_ID_TYPE, vtkIdList, vtkPoints
from vtkmodules.vtkCommonDataModel import (
    VTK_EMPTY_CELL,
    VTK_HEXAHEDRON,
    VTK_LINE,
    VTK_PIXEL,
    VTK_POLY_LINE,
    VTK_POLY_VERTEX,
    VTK_POLYGON,
    VTK_POLYHEDRON,
    VTK_QUAD,
    VTK_TETRA,
    VTK_TRIANGLE,
    VTK_TRIANGLE_STRIP,
    VTK_VERTEX,
    VTK_VOXEL,
    vtkDataSetAttributes,
    vtkPointSet,
    vtkPolyData,
    vtkRectilinearGrid,
    vtkStructuredGrid,
    vtkUnstructuredGrid,
)
from vtkmodules.vtkFiltersCore import vtkAppendFilter

from vtk_mls import Plane
from vtk_mls.base.linear_algebra import unit
from vtk_mls.rendering.rest_surface import RestSurface
from vtk_mls.vtk import arrays

ORDER = {VTK_VOXEL: (VTK_HEXAHEDRON, [0, 1, 3, 2, 4, 5, 7, 6]), VTK_PIXEL: (VTK_QUAD, [0, 1, 3, 2])}
TURN = control_points(REST, (REST - 4) @ TURNED.T + 4)


def corners_of(mesh, number):
    ids = mesh.GetCell(number).GetPointIds()
    return [ids.GetId(i) for i in range(ids.GetNumberOfIds())]


def faces_of(mesh, number):
    stream = vtkIdList()
    mesh.GetFaceStream(number, stream)
    return [stream.GetId(i) for i in range(stream.GetNumberOfIds())]


def boxes(kind, free=False):
    """A lattice of voxels or pixels, or the same of hexahedra or quads."""
    grid = vtkUnstructuredGrid()
    set_places(grid, [(x, y, z) for z in range(5) for y in range(5) for x in range(5)])
    other, order = ORDER[kind]
    above = (0, 1) if kind == VTK_VOXEL else (0,)
    for k in range(4 if kind == VTK_VOXEL else 1):
        for j in range(4):
            for i in range(4):
                ids = [
                    i + a + 5 * (j + b + 5 * (k + c)) for c in above for b in (0, 1) for a in (0, 1)
                ]
                ids = [ids[n] for n in order] if free else ids
                grid.InsertNextCell(other if free else kind, len(ids), ids)
    add_array(grid.GetPointData(), "x", places_of(grid)[:, 0])
    return grid


@pytest.mark.parametrize("cut", [None, *CUTS])
@pytest.mark.parametrize("kind", ORDER)
def test_boxes_by_type_are_as_those_that_are_free(kind, cut):
    """Sizes, their cells and the points are those of hexahedra and quads."""
    cut = cut and Plane((2.1, 2, 2), (1, 0.1, 0.2))
    ours, theirs = (
        update(deforming(boxes(kind, free), TURN, Kind="rigid", cut=cut)) for free in (False, True)
    )
    assert not np.isin(arrays.cell_types(ours), list(ORDER)).any()
    np.testing.assert_allclose(sizes(ours).sum(), 64 if kind == VTK_VOXEL else 16, rtol=1e-5)
    if not cut:
        np.testing.assert_allclose(sizes(ours), 1, rtol=1e-5)
        for number in range(ours.GetNumberOfCells()):
            assert corners_of(ours, number) == corners_of(theirs, number)
        np.testing.assert_array_equal(places_of(ours), places_of(theirs))


@pytest.mark.parametrize("blend", [0.0, 1.0])
def test_cells_around_boxes_stay_as_they_are(blend):
    """Their order, data, ids and flags, and the faces of polyhedra among them."""
    append = vtkAppendFilter()
    for mesh in (boxes(VTK_VOXEL), polyhedra(2), boxes(VTK_PIXEL), cells(VTK_TETRA, 1)):
        append.AddInputData(mesh)
    append.SetOutputPointsPrecision(2)
    grid = update(append)
    data = grid.GetCellData()
    ids = add_array(data, "ids", np.arange(grid.GetNumberOfCells()), VTK_ID_TYPE)
    data.SetGlobalIds(ids)
    ghosts = np.arange(grid.GetNumberOfCells()) % 5 == 0
    add_array(data, arrays.GHOSTS, ghosts, TYPES["unsigned char"])
    before = vtkUnstructuredGrid()
    before.DeepCopy(grid)
    output = update(deforming(grid, TURN, Kind="rigid", Blend=blend))
    assert output.GetCellData().GetGlobalIds().GetName() == "ids"
    for name in ("ids", arrays.GHOSTS):
        np.testing.assert_array_equal(array_of(output, name, "Cell"), array_of(grid, name, "Cell"))
    for number in range(grid.GetNumberOfCells()):
        kind, ids = grid.GetCellType(number), corners_of(grid, number)
        assert kind == before.GetCellType(number)  # the input is as it was
        assert ids == corners_of(before, number)
        free, order = ORDER.get(kind, (kind, range(len(ids))))
        assert output.GetCellType(number) == free
        assert corners_of(output, number) == [ids[i] for i in order]
        if kind == VTK_POLYHEDRON:
            assert faces_of(output, number) == faces_of(before, number)
    np.testing.assert_allclose(sizes(output), sizes(before), rtol=1e-5)


# Empty cells: VTK's vtkCellCenters ends the process, so that these cases have one of their own.

POLYDATA = ("Verts", "Lines", "Polys", "Strips")
EMPTY_TYPES = (VTK_EMPTY_CELL, VTK_VERTEX, VTK_POLY_VERTEX, VTK_LINE, VTK_POLY_LINE, VTK_TRIANGLE)
EMPTY_TYPES += (VTK_TRIANGLE_STRIP, VTK_POLYGON, VTK_TETRA, 21, 68)


def with_empty_cells(kind):
    """A mesh whose first, third and last cells are empty, with vectors of cells."""
    lists = [(), (0, 1, 2), (), (1, 2, 3), ()]
    places = [(1, 2, 4), (3, 1, 4), (7, 6, 2), (5, 5, 3), (6, 1, 1)]
    if kind in POLYDATA:
        mesh = polydata_of(places, **{kind: lists})
    else:
        mesh = grid_of(places, [(VTK_TRIANGLE if ids else kind, ids) for ids in lists])
    values = np.random.default_rng(5).normal(size=(5, 3))
    add_array(mesh.GetCellData(), "flow", values)
    add_array(mesh.GetCellData(), "number", np.arange(5))
    mesh.GetCellData().SetNormals(add_array(mesh.GetCellData(), "across", unit(values)))
    return mesh


def empty_of(mesh):
    return np.array(
        [mesh.GetCell(i).GetNumberOfPoints() == 0 for i in range(mesh.GetNumberOfCells())]
    )


def test_empty_cells():
    """In a process of its own: see `check_empty`, which this file runs when it is called."""
    folders = os.pathsep.join(path for path in sys.path if path)
    status, out, err = python(__file__, path=folders)
    assert status == 0, out + err


def check_empty(kind):
    options = {"GenerateJacobian": True, "GenerateJacobianDeterminant": True}
    mesh = with_empty_cells(kind)
    moved = reference().forward(places_of(mesh))
    flow = array_of(mesh, "flow", "Cell").copy()
    for cut in (None, *CUTS.values()):
        for splits in (True, False):
            # kernels of cuts are not the point
            device = FAST if cut is None else "reference"
            filter_ = deforming(mesh, None, device, cut, SplitCells=splits, **options)
            filter_.AddPushForwardArray("flow")
            output = update(filter_)
            empty = empty_of(output)
            assert empty.sum() == 3, (cut, splits)
            numbers = array_of(output, "number", "Cell")
            assert sorted(numbers[empty]) == [0, 2, 4]
            assert set(numbers[~empty]) == {1, 3}
            np.testing.assert_array_equal(array_of(output, "flow", "Cell")[empty], flow[[0, 2, 4]])
            assert np.isfinite(array_of(output, "flow", "Cell")).all()
            assert count(output, "UncheckedCells") >= 3
            if cut is None:
                np.testing.assert_allclose(places_of(output), moved, atol=5e-5)
                np.testing.assert_array_equal(empty, [True, False, True, False, True])
                full = [1, 3]
                centers = np.array([places_of(output)[corners_of(output, i)].mean(0) for i in full])
                jacobian = reference().jacobian(centers)
                turned = np.linalg.solve(jacobian, flow[full][..., None])[..., 0]
                if kind not in ("Verts", "Lines"):  # whose centers are others
                    found = array_of(output, "flow", "Cell")[full]
                    np.testing.assert_allclose(found, turned, atol=5e-3)
        RestSurface(mesh, () if cut is None else (cut,)).moved(reference())
    mesh = with_empty_cells(kind)
    data = mesh.GetCellData()
    for i in range(data.GetNumberOfArrays()):
        data.GetAbstractArray(i).SetName(None)
    data.SetActiveAttribute(1, vtkDataSetAttributes.SCALARS)
    for cut in CUTS.values():
        output = update(deforming(mesh, None, "reference", cut))
        held = [output.GetCellData().GetAbstractArray(i) for i in range(data.GetNumberOfArrays())]
        assert {array.GetNumberOfTuples() for array in held} == {output.GetNumberOfCells()}
        numbers = arrays.to_numpy(output.GetCellData().GetScalars())
        assert sorted(numbers[empty_of(output)]) == [0, 2, 4]
    if kind in ("Polys", "Strips"):
        filter_ = deforming(cells(VTK_TETRA))
        filter_.AddInputDataObject(2, mesh)  # as a cut
        assert update(filter_).GetNumberOfCells() > 0


def test_cells_keep_their_data_beside_a_point_without_cells():
    """When they are cut, too."""
    mesh = cells(VTK_TETRA)
    set_places(mesh, np.vstack([places_of(mesh), [(4, 4, 4)]]))
    for i in range(mesh.GetPointData().GetNumberOfArrays())[::-1]:
        mesh.GetPointData().RemoveArray(i)
    output = update(deforming(mesh, cut=CUTS["plane"]))
    numbers = array_of(output, "number", "Cell")
    assert set(numbers) == set(range(mesh.GetNumberOfCells()))
    assert len(numbers) == output.GetNumberOfCells()


INTEGERS = [name for name in TYPES if name not in ("float", "double", "bit")]


def with_integers(mesh, vtk_type, places):
    points = vtkPoints()
    points.SetDataType(vtk_type)
    for place in places:
        points.InsertNextPoint(*place)
    mesh.SetPoints(points)
    return mesh


def integer_mesh(kind, vtk_type):
    places = [(x, y, z) for z in (1, 5) for y in (1, 4, 7) for x in (1, 7)]
    mesh = with_integers(kind(), vtk_type, places)
    if kind is vtkStructuredGrid:
        mesh.SetDimensions(2, 3, 2)
    if kind is vtkPolyData:
        quads = (0, 1, 3, 2), (2, 3, 5, 4), (6, 7, 9, 8)
        mesh.SetPolys(polydata_of([], Polys=quads).GetPolys())
    if kind is vtkUnstructuredGrid:
        mesh.InsertNextCell(VTK_VOXEL, 8, (0, 1, 2, 3, 6, 7, 8, 9))
        mesh.InsertNextCell(VTK_VOXEL, 8, (2, 3, 4, 5, 8, 9, 10, 11))
    return mesh, np.array(places, float)


@pytest.mark.parametrize("kind", [vtkPolyData, vtkUnstructuredGrid, vtkStructuredGrid, vtkPointSet])
@pytest.mark.parametrize("name", INTEGERS)
def test_points_of_integers(name, kind):
    mesh, places = integer_mesh(kind, TYPES[name])
    for cut in (None, CUTS["plane"]):
        output = update(deforming(mesh, cut=cut, GenerateJacobianDeterminant=True))
        assert output.GetPoints().GetDataType() == VTK_DOUBLE
        if cut is None:
            np.testing.assert_allclose(places_of(output), reference().forward(places), atol=5e-5)
            found = array_of(output, "ForwardDisplacement")
            np.testing.assert_allclose(places_of(output) - places, found, atol=1e-6)
    assert mesh.GetPoints().GetDataType() == TYPES[name]
    if kind is not vtkPointSet:  # of which nothing is drawn
        drawn = RestSurface(mesh, ()).moved(reference())
        assert drawn.GetPoints().GetDataType() == VTK_DOUBLE


def test_axes_of_integers():
    grid = vtkRectilinearGrid()
    grid.SetDimensions(3, 2, 2)
    for name, values in (("X", (1, 4, 7)), ("Y", (1, 7)), ("Z", (1, 5))):
        axis = add_array(vtkPolyData().GetPointData(), name, values, TYPES["int"])
        getattr(grid, f"Set{name}Coordinates")(axis)
    places = np.array([grid.GetPoint(i) for i in range(12)])
    output = update(deforming(grid))
    np.testing.assert_allclose(places_of(output), reference().forward(places), atol=5e-5)


def test_large_integers_lose_nothing():
    """As float32 they would be 16 apart."""
    far = 200_000_001
    mesh = with_integers(
        vtkPointSet(), TYPES["long long"], [(far, far + 2, far + 5), (far, far, far)]
    )
    rest = REST + far
    output = update(deforming(mesh, control_points(rest, rest + 0.5)))
    np.testing.assert_allclose(places_of(output)[0] - far, (0.5, 2.5, 5.5), atol=1e-5)


def test_control_points_of_integers():
    handles = with_integers(vtkPointSet(), TYPES["short"], REST.astype(int))
    add_array(handles.GetPointData(), "Displacement", np.full(REST.shape, 2), TYPES["int"])
    add_array(handles.GetPointData(), "Weight", np.arange(1, 9), TYPES["int"])
    mesh = as_grid(cells(VTK_TETRA))
    output = update(deforming(mesh, handles))
    np.testing.assert_allclose(places_of(output), places_of(mesh) + 2, atol=1e-5)


if __name__ == "__main__":
    for kind in (*POLYDATA, *EMPTY_TYPES):
        print("empty cells among", kind, flush=True)  # the last line names the case that fails
        check_empty(kind)
