"""Filters in steps: nothing folds; and on paths of control points: the array "Path"."""

import numpy as np
import pytest
from mesh_fixtures import array_of, cells, count, deforming, places_of
from pipelines import connect, control_points, update
from turned_column import LEGS, turned
from turned_column import REST as COLUMN
from vtk_fixtures import FAST, add_array, make_image
from vtkmodules.vtkCommonDataModel import VTK_TETRA, vtkPolyData

from vtk_mls import CurveHandle, Deformation, Grid
from vtk_mls.filters import MLSDeform, MLSDisplacementField
from vtk_mls.model.handles.handle_cells import HandleCells
from vtk_mls.queries import certificate, fold_free
from vtk_mls.vtk.arrays import ImageGeometry
from vtk_mls.vtk.cells import scaled_jacobians
from vtk_mls.vtk.control_point_polydata import fill_polydata

COUNT = 8  # cells along each axis


@pytest.fixture
def handles(rng):
    rest = rng.uniform(1, COUNT - 1, (15, 3))
    return rest, rest + rng.normal(0, 0.15 * COUNT, rest.shape)


def _deformed(dataset, handles, steps, kind=MLSDeform, **properties):
    filter_ = deforming(dataset, control_points(*handles), kind=kind, Steps=steps, **properties)
    return update(filter_)


def test_every_point_of_a_mesh_has_a_place(handles, messages):
    once, safe = (
        _deformed(cells(VTK_TETRA, COUNT), handles, steps, GenerateJacobianDeterminant=True)
        for steps in (1, 0)
    )
    assert not once.GetFieldData().HasArray("StepsUsed")
    determinants = [array_of(mesh, "JacobianDeterminant") for mesh in (once, safe)]
    assert count(once, "FailedInverses") > 0 or np.nanmin(determinants[0]) < 0
    assert count(safe, "FailedInverses") == 0
    assert determinants[1].min() > 0
    assert count(safe, "StepsUsed") > 1
    assert count(safe, "SmallestDeterminant") > 0
    # cells are larger than the deformation is fine: some stay inverted, by VTK's measure, too
    inverted = count(safe, "InvertedCells")
    assert 0 < inverted < 0.6 * count(once, "InvertedCells")
    quality = scaled_jacobians(safe, places_of(safe))
    assert np.count_nonzero(quality <= 0) == inverted
    folded = array_of(safe, "Folded", "Cell")
    np.testing.assert_array_equal(folded, quality <= 0)
    messages.assert_one(
        f"{inverted} of {safe.GetNumberOfCells()} cells are inverted: .* refine the mesh"
    )


def test_no_warning_without_inverted_cells_or_where_the_remedy_is_requested(handles):
    rest, deformed = handles
    _deformed(cells(VTK_TETRA, COUNT), (rest, rest + 0.1 * (deformed - rest)), 0)
    safe = _deformed(cells(VTK_TETRA, COUNT), handles, 0, GenerateLargestBlend=True)
    assert 0 < count(safe, "LargestBlend") < 1


def _squeezed():
    box = np.array([(x, y, z) for x in (-55, 55) for y in (-55, 55) for z in (-55, 55)], float)
    return np.r_[box, box * 12 / 55], np.r_[box, box * 12 / 55 * 0.15]


@pytest.mark.parametrize("algorithm", [MLSDeform, MLSDisplacementField])
def test_folds_that_samples_miss_are_found_at_the_voxels(algorithm, monkeypatch):
    monkeypatch.setattr(fold_free, "in_enough_steps", lambda _, d, *more: d.in_steps(1))
    image = make_image((30,) * 3, origin=(-15, -15, -15), spacing=(1, 1, 1))
    output = _deformed(image, _squeezed(), 0, algorithm)
    assert count(output, "StepsUsed") > 1
    assert count(output, "SmallestDeterminant") > 0
    assert not array_of(output, "Folded").any()
    once = _deformed(image, _squeezed(), 1, algorithm)
    assert not once.GetPointData().HasArray("Folded")


def test_folds_that_samples_miss_are_found_at_cells(handles, monkeypatch, messages):
    monkeypatch.setattr(fold_free, "in_enough_steps", lambda _, d, *more: d.in_steps(1))
    output = _deformed(cells(VTK_TETRA, COUNT), handles, 0)
    assert count(output, "StepsUsed") > 1
    assert count(output, "FailedInverses") == 0
    folded = array_of(output, "Folded", "Cell")
    quality = scaled_jacobians(output, places_of(output))
    np.testing.assert_array_equal(folded, quality <= 0)
    messages.assert_one("straight edges are too long")


def test_a_linear_field_that_folds_is_marked():
    rng = np.random.default_rng(5)
    rest = np.r_[0.5 + 0.02 * rng.normal(size=(3, 3)), np.eye(3), [(0, 0, 0), (1, 1, 1)]]
    deformed = rest.copy()
    deformed[:3] = 0.5 + (rest[:3] - 0.5) @ [(0, -1, 0), (1, 0, 0), (0, 0, 1)]
    image = make_image((12,) * 3, origin=(0, 0, 0), spacing=(1 / 11,) * 3)
    output = _deformed(image, (rest, deformed), 0, MLSDisplacementField)
    folded = array_of(output, "Folded")
    d = Deformation(rest, deformed, steps=int(count(output, "StepsUsed")), device=FAST)
    grid = Grid((12,) * 3, (0, 0, 0), (1 / 11,) * 3)
    proof = d.certificate(grid)
    assert proof.folded > 0
    expected = certificate.corner_points(grid, proof.indices)
    np.testing.assert_array_equal(folded, expected.ravel())


def test_the_path_of_few_steps_makes_the_same_map(messages):
    box = COUNT * np.array(list(np.ndindex(2, 2, 2)), float)
    rest = np.concatenate([box, 0.4 * COUNT + 0.2 * box])
    deformed = np.concatenate([box, rest[8:] * (-1, -1, 1) + (COUNT, COUNT, 0)])
    deformed[8:, 0] += 0.02 * (rest[8:, 1] - COUNT / 2)
    output = _deformed(make_image(), (rest, deformed), 0, MLSDisplacementField)
    path = output.GetFieldData().GetArray("Path")
    points = vtkPolyData()
    fill_polydata(points, rest, deformed, None)
    points.GetPointData().AddArray(path)
    steps = count(output, "StepsUsed")
    again = update(deforming(make_image(), points, kind=MLSDisplacementField, Steps=steps))
    a, b = (array_of(d, "BackwardDisplacement") for d in (output, again))
    np.testing.assert_array_equal(a, b)


def test_as_many_steps_as_given(handles):
    field = _deformed(make_image(), handles, 4, MLSDisplacementField)
    same = _deformed(make_image(), handles, 1, MLSDisplacementField)
    assert not field.GetFieldData().HasArray("StepsUsed")
    a, b = (array_of(d, "BackwardDisplacement") for d in (field, same))
    assert np.abs(a - b).max() > 0.01


PATH = np.array([turned(k / LEGS) for k in range(1, LEGS)])


def column(path=PATH, **more):
    polydata = vtkPolyData()
    fill_polydata(polydata, COLUMN, turned(1), None, path=path, **more)
    return polydata


def field_of(control_points, **properties):
    field = deforming(make_image(), control_points, kind=MLSDisplacementField, **properties)
    return array_of(update(field), "BackwardDisplacement"), field


def expected(*handles, **options):
    grid = ImageGeometry.of_image(make_image()).grid
    d = Deformation(*handles, device=FAST, **options)
    return d.displacement_field(grid).displacement.reshape(-1, 3)


def test_a_path_is_that_of_a_deformation():
    found, field = field_of(column())
    np.testing.assert_allclose(found, expected(COLUMN, turned(1), path=PATH), atol=1e-6)
    assert field.updated_deformation().smallest_step_determinant > 0.1
    straight, _ = field_of(column(()))
    assert np.abs(found - straight).max() > 1


@pytest.mark.parametrize("blend", [0.5, 0.25])
def test_a_blend_stops_on_the_way(blend):
    found, field = field_of(column(), Blend=blend)
    there = [turned(blend * k / LEGS) for k in range(1, LEGS + 1)]
    deformation = field.updated_deformation()
    np.testing.assert_allclose(deformation.deformed, there[-1], atol=1e-12)
    off = np.abs(found - expected(COLUMN, there[-1], path=there[:-1])).max()
    assert off < 0.1  # the way between the places of the array is straight
    half = np.abs(found - expected(COLUMN, COLUMN + blend * (turned(1) - COLUMN))).max()
    assert half > 1


def test_curves_have_no_path():
    rows = np.arange(len(COLUMN))
    cells = HandleCells(rows[9:], (rows[:9],))
    found, _ = field_of(column(cells=cells), HandleShapes="cells")
    curve = CurveHandle(COLUMN[:9], turned(1)[:9])
    other = expected(COLUMN[9:], turned(1)[9:], path=PATH[:, 9:], handles=[curve])
    np.testing.assert_allclose(found, other, atol=1e-5)


@pytest.mark.parametrize(
    ("values", "match"),
    [
        (np.zeros((len(COLUMN), 4)), "`ControlPoints`, array `Path`, must have 3 components per"),
        (np.zeros(len(COLUMN)), "got 1 components"),
        (np.full((len(COLUMN), 6), np.nan), "`ControlPoints`, array `Path`, must be finite"),
    ],
)
def test_bad_paths_are_errors(values, match, messages):
    polydata = column(())
    add_array(polydata.GetPointData(), "Path", values, 11)
    deform = connect(MLSDeform(), make_image(), polydata)
    deform.Update()
    messages.assert_one(match)
    polydata.GetPointData().RemoveArray("Path")
    deform.Update()
    assert deform.GetOutputDataObject(0).GetNumberOfPoints() > 0
