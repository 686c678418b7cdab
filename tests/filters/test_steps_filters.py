"""Filters in steps: nothing folds."""

import numpy as np
import pytest
from pipelines import connect, control_points, update
from vtk_fixtures import FAST, make_image
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonDataModel import VTK_TETRA
from vtkmodules.vtkFiltersSources import vtkCellTypeSource

from vtk_mls.filters import MLSDeform, MLSDisplacementField
from vtk_mls.vtk.cell_quality import scaled_jacobians

COUNT = 8  # cells along each axis


@pytest.fixture
def handles(rng):
    rest = rng.uniform(1, COUNT - 1, (15, 3))
    return rest, rest + rng.normal(0, 0.15 * COUNT, rest.shape)


def _tetrahedra():
    source = vtkCellTypeSource()
    source.SetCellType(VTK_TETRA)
    source.SetBlocksDimensions(COUNT, COUNT, COUNT)
    source.Update()
    return source.GetOutput()


def _deformed(dataset, handles, steps, algorithm=MLSDeform, **properties):
    deform = algorithm()
    deform.SetInputData(dataset)
    deform.SetRestPoints(handles[0])
    deform.SetDeformedPoints(handles[1])
    deform.SetDevice(FAST)
    deform.SetSteps(steps)
    for name, value in properties.items():
        getattr(deform, f"Set{name}")(value)
    return update(deform)


def _of_field(dataset, name):
    return vtk_to_numpy(dataset.GetFieldData().GetArray(name))[0]


def test_every_point_of_a_mesh_has_a_place(handles, messages):
    once, safe = (
        _deformed(_tetrahedra(), handles, steps, GenerateJacobianDeterminant=True)
        for steps in (1, 0)
    )
    assert not once.GetFieldData().HasArray("StepsUsed")
    determinants = [
        vtk_to_numpy(mesh.GetPointData().GetArray("JacobianDeterminant")) for mesh in (once, safe)
    ]
    assert _of_field(once, "FailedInverses") > 0 or np.nanmin(determinants[0]) < 0
    assert _of_field(safe, "FailedInverses") == 0
    assert determinants[1].min() > 0
    assert _of_field(safe, "StepsUsed") > 1
    assert _of_field(safe, "SmallestDeterminant") > 0.1
    # cells are larger than the deformation is fine: some stay inverted, by VTK's measure, too
    count = _of_field(safe, "InvertedCells")
    assert 0 < count < 0.6 * _of_field(once, "InvertedCells")
    quality = scaled_jacobians(safe, vtk_to_numpy(safe.GetPoints().GetData()))
    assert np.count_nonzero(quality <= 0) == count
    messages.assert_one(
        f"{count} of {safe.GetNumberOfCells()} cells are inverted: .* refine the mesh"
    )


def test_no_warning_without_inverted_cells_or_where_the_remedy_is_requested(handles):
    rest, deformed = handles
    _deformed(_tetrahedra(), (rest, rest + 0.1 * (deformed - rest)), 0)
    safe = _deformed(_tetrahedra(), handles, 0, GenerateLargestBlend=True)
    assert 0 < _of_field(safe, "LargestBlend") < 1


def test_as_many_steps_as_given(handles):
    field = _deformed(make_image(), handles, 4, MLSDisplacementField)
    same = _deformed(make_image(), handles, 1, MLSDisplacementField)
    assert not field.GetFieldData().HasArray("StepsUsed")
    a, b = (vtk_to_numpy(d.GetPointData().GetArray("BackwardDisplacement")) for d in (field, same))
    assert np.abs(a - b).max() > 0.01


def test_bad_steps_are_errors(messages):
    deform = MLSDeform()
    connect(deform, make_image(), control_points())
    deform.SetSteps(1000)
    deform.Update()
    messages.assert_one("`steps` must be an integer from 1 to 256")
    deform.SetSteps(2)
    assert deform.GetExecutive().Update()
    assert deform.GetOutputDataObject(0).GetNumberOfPoints() > 0
