"""How far a dragged handle reaches with the default options, at every door."""

import numpy as np
import pytest
from mesh_fixtures import places_of, set_places
from vtkmodules.vtkCommonDataModel import vtkPolyData

from vtk_mls import Deformation, io
from vtk_mls.commands.cli import main
from vtk_mls.editor import State
from vtk_mls.filters import MLSDeform

# A lattice of spacing 1, whose middle is dragged along x.
REST = np.array([(x, y, z) for z in (-1, 0, 1) for y in (-1, 0, 1) for x in (-1, 0, 1.0)])
DRAG = 0.5
DEFORMED = REST + np.where((REST == 0).all(axis=1)[:, None], (DRAG, 0, 0), 0)


def by_numpy(points):
    return Deformation(REST, DEFORMED).forward(points)


def by_the_filter(points):
    mesh, deform = vtkPolyData(), MLSDeform()
    set_places(mesh, points)
    deform.SetInputData(mesh)
    deform.SetRestPoints(REST)
    deform.SetDeformedPoints(DEFORMED)
    deform.Update()
    return places_of(deform.GetOutput())


def by_the_editor(points):
    return State(REST, DEFORMED).deformation().forward(points)


def by_the_command(points):
    np.savetxt("handles.csv", np.hstack([REST, DEFORMED]), delimiter=",")
    np.savetxt("points.csv", points, delimiter=",")
    assert main(["points", "points.csv", "handles.csv", "moved.csv"]) == 0
    return io.read_landmarks("moved.csv").positions


@pytest.mark.parametrize("moved", [by_numpy, by_the_filter, by_the_editor, by_the_command])
@pytest.mark.parametrize("direction", [(0, 1, 0), (0, 0, -1)])
def test_half_the_drag_is_left_beyond_two_fifths_of_the_spacing(
    moved, direction, tmp_path, monkeypatch
):
    """Across the drag; with alpha 1 it is left at 0.08 only, and half the spacing is the most."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("VTK_MLS_DEVICE", "reference")
    distance = np.linspace(0, 1, 101)
    points = distance[:, None] * direction
    height = np.linalg.norm(moved(points) - points, axis=1)
    assert height[0] == pytest.approx(DRAG)
    assert height[-1] == pytest.approx(0, abs=1e-6)
    reach = distance[np.argmax(height < DRAG / 2)]
    assert 0.40 <= reach <= 0.5
