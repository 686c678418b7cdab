"""Divided meshes are cached while the mesh and the cuts stay the same."""

from functools import partial

import mesh_fixtures
import numpy as np
import pytest
from handle_surfaces import carried, transform
from mesh_fixtures import CUTS, MESHES, OPENED, as_grid, cells, count, places_of
from pipelines import assert_same, control_points, update
from vtk_fixtures import add_array
from vtkmodules.vtkCommonDataModel import VTK_TETRA, vtkCellArray, vtkDataSetAttributes
from vtkmodules.vtkFiltersSources import vtkPlaneSource

from vtk_mls.filters import warping
from vtk_mls.vtk import arrays, splitting
from vtk_mls.vtk.objects import configured

SHIFT = transform(0, move=(1, 2, 3))

deforming = partial(mesh_fixtures.deforming, device="reference")  # numbers are not the point


@pytest.fixture
def calls(monkeypatch):
    """Has an entry for each time that a mesh is split."""
    calls = []
    monkeypatch.setattr(warping, "split", lambda *a: calls.append(1) or splitting.split(*a))
    return calls


@pytest.mark.parametrize("way", ["AddCut", "properties", "port 2"])
def test_dragging_does_not_split_again(way, calls):
    mesh, handles = cells(VTK_TETRA), control_points()
    filter_ = deforming(mesh, handles)
    if way == "AddCut":
        filter_.AddCut(CUTS["plane"])
    elif way == "properties":
        configured(filter_, CutType="plane", CutOrigin=(4.03, 4, 3))
    else:
        scalpel = configured(vtkPlaneSource(), Origin=(4.03, 1, 1), Point1=[4.03, 6, 1])
        scalpel.SetPoint2(4.03, 1, 5)
        filter_.SetInputConnection(2, scalpel.GetOutputPort())
    update(filter_)
    handles.SetDeformedPoints(OPENED)
    update(filter_)
    filter_.SetNu(3.0)
    update(filter_)
    assert len(calls) == 1
    mesh.Modified()
    update(filter_)
    assert len(calls) == 2
    filter_.AddCut(CUTS["half-plane"])
    update(filter_)
    assert len(calls) == 3


def marked(name="polyhedra"):
    """A mesh with arrays of many roles, and a filter that cuts it."""
    mesh = MESHES[name]()
    mesh.GetPointData().RemoveArray("names")
    add_array(mesh.GetPointData(), "normals", places_of(as_grid(mesh)) + 1)
    ghosts = np.zeros(mesh.GetNumberOfCells())
    ghosts[0] = vtkDataSetAttributes.DUPLICATECELL
    add_array(mesh.GetCellData(), arrays.GHOSTS, ghosts, 3)
    mesh.GetCellData().SetActiveScalars("number")
    return mesh, deforming(mesh, cut=CUTS["half-plane"])


def assert_alike(output, expected):
    """Also in the roles of the arrays."""
    assert_same(output, expected)
    for of in ("GetPointData", "GetCellData"):
        for kind in range(vtkDataSetAttributes.NUM_ATTRIBUTES):
            active, wanted = (
                getattr(dataset, of)().GetAbstractAttribute(kind) for dataset in (output, expected)
            )
            assert (active and active.GetName()) == (wanted and wanted.GetName())


@pytest.mark.parametrize(
    "name", ["polydata", "polyhedra", "structured", "rectilinear", "explicit structured"]
)
def test_what_changes_no_array_does_not_split_again(name, calls):
    mesh, filter_ = marked(name)
    update(filter_)
    carried(mesh, SHIFT)
    mesh.GetPointData().Modified()
    mesh.GetCellData().Modified()
    add_array(mesh.GetFieldData(), "time", [3.5])
    add_array(mesh.GetFieldData(), "place", [4])
    output = update(filter_)
    assert len(calls) == 1
    assert count(output, "time") == 3.5
    assert_alike(output, update(deforming(mesh, cut=CUTS["half-plane"])))


def _reverse(array, part=slice(None)):
    values = arrays.to_numpy(array)
    values[part] = values[part][::-1].copy()
    array.Modified()


CHANGES = {
    "point values": lambda m: _reverse(m.GetPointData().GetArray("linear")),
    "cell values": lambda m: _reverse(m.GetCellData().GetArray("number")),
    "ghosts": lambda m: _reverse(m.GetCellData().GetArray(arrays.GHOSTS)),
    "a new array": lambda m: add_array(m.GetPointData(), "new", np.arange(m.GetNumberOfPoints())),
    "another array": lambda m: add_array(m.GetCellData(), "number", np.ones(m.GetNumberOfCells())),
    "an array less": lambda m: m.GetPointData().RemoveArray("linear"),
    "a name": lambda m: m.GetPointData().GetArray("linear").SetName("renamed"),
    "scalars": lambda m: m.GetPointData().SetActiveScalars("linear"),
    "no scalars": lambda m: m.GetCellData().SetActiveAttribute(-1, vtkDataSetAttributes.SCALARS),
    "normals": lambda m: m.GetPointData().SetActiveNormals("normals"),
    "places": lambda m: _reverse(m.GetPoints().GetData(), slice(2)),
    "points": lambda m: m.SetPoints(carried(m, SHIFT).GetPoints()),
    "the mesh": lambda m: m.Modified(),
}
CHANGES_OF = {
    ("cells 10", "corners"): lambda m: _reverse(m.GetCells().GetConnectivityArray(), slice(4)),
    ("cells 10", "types"): lambda m: arrays.cell_type_array(m).Modified(),
    ("cells 10", "cells"): lambda m: m.SetCells(VTK_TETRA, cells(VTK_TETRA).GetCells()),
    ("polydata", "polygons"): lambda m: _reverse(m.GetPolys().GetConnectivityArray()),
    ("polydata", "lines"): lambda m: m.SetLines(vtkCellArray()),
    ("polyhedra", "faces"): lambda m: warping.FACES[0](m).Modified(),
    ("structured", "an extent"): lambda m: m.SetExtent(2, 6, -1, 3, 0, 5),
    ("explicit structured", "cells"): lambda m: m.GetCells().Modified(),
    ("rectilinear", "coordinates"): lambda m: _reverse(m.GetYCoordinates(), slice(2)),
}
CHANGES_OF.update({("polyhedra", what): change for what, change in CHANGES.items()})


@pytest.mark.parametrize(("name", "what"), CHANGES_OF)
def test_a_change_of_the_mesh_splits_it_again(name, what, calls):
    mesh, filter_ = marked(name)
    update(filter_)
    CHANGES_OF[name, what](mesh)
    filter_.Modified()  # VTK does not see all of these
    output = update(filter_)
    assert len(calls) == 2
    assert_alike(output, update(deforming(mesh, cut=CUTS["half-plane"])))
