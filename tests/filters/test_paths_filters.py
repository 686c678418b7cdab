"""Paths of control points in filters: the array "Path"."""

import numpy as np
import pytest
from mesh_fixtures import array_of, deforming
from pipelines import connect, update
from turned_column import LEGS, REST, turned
from vtk_fixtures import FAST, add_array, make_image
from vtkmodules.vtkCommonDataModel import vtkPolyData

from vtk_mls import CurveHandle, Deformation
from vtk_mls.filters import MLSDeform, MLSDisplacementField
from vtk_mls.model.handles.handle_cells import HandleCells
from vtk_mls.vtk.arrays import ImageGeometry
from vtk_mls.vtk.control_point_polydata import fill_polydata

PATH = np.array([turned(k / LEGS) for k in range(1, LEGS)])


def handles(path=PATH, **more):
    polydata = vtkPolyData()
    fill_polydata(polydata, REST, turned(1), None, path=path, **more)
    return polydata


def field_of(control_points, **properties):
    field = deforming(make_image(), control_points, kind=MLSDisplacementField, **properties)
    return array_of(update(field), "BackwardDisplacement"), field


def expected(*handles, **options):
    grid = ImageGeometry.of_image(make_image()).grid
    d = Deformation(*handles, device=FAST, **options)
    return d.displacement_field(grid).displacement.reshape(-1, 3)


def test_a_path_is_that_of_a_deformation():
    found, field = field_of(handles())
    np.testing.assert_allclose(found, expected(REST, turned(1), path=PATH), atol=1e-6)
    assert field.updated_deformation().smallest_step_determinant > 0.1
    straight, _ = field_of(handles(()))
    assert np.abs(found - straight).max() > 1


@pytest.mark.parametrize("blend", [0.5, 0.25])
def test_a_blend_stops_on_the_way(blend):
    found, field = field_of(handles(), Blend=blend)
    there = [turned(blend * k / LEGS) for k in range(1, LEGS + 1)]
    deformation = field.updated_deformation()
    np.testing.assert_allclose(deformation.deformed, there[-1], atol=1e-12)
    off = np.abs(found - expected(REST, there[-1], path=there[:-1])).max()
    assert off < 0.1  # the way between the places of the array is straight
    half = np.abs(found - expected(REST, REST + blend * (turned(1) - REST))).max()
    assert half > 1


def test_curves_have_no_path():
    rows = np.arange(len(REST))
    cells = HandleCells(rows[9:], (rows[:9],))
    found, _ = field_of(handles(cells=cells), HandleShapes="cells")
    curve = CurveHandle(REST[:9], turned(1)[:9])
    other = expected(REST[9:], turned(1)[9:], path=PATH[:, 9:], handles=[curve])
    np.testing.assert_allclose(found, other, atol=1e-5)


@pytest.mark.parametrize(
    ("values", "match"),
    [
        (np.zeros((len(REST), 4)), "`ControlPoints`, array `Path`, must have 3 components per"),
        (np.zeros(len(REST)), "got 1 components"),
        (np.full((len(REST), 6), np.nan), "`ControlPoints`, array `Path`, must be finite"),
    ],
)
def test_bad_paths_are_errors(values, match, messages):
    polydata = handles(())
    add_array(polydata.GetPointData(), "Path", values, 11)
    deform = connect(MLSDeform(), make_image(), polydata)
    deform.Update()
    messages.assert_one(match)
    polydata.GetPointData().RemoveArray("Path")
    deform.Update()
    assert deform.GetOutputDataObject(0).GetNumberOfPoints() > 0
