"""The initial handles lie on the visible data."""

from __future__ import annotations

import numpy as np
import pytest
from hands import MIDDLE, SIZE, Hands, ball_image, ball_mesh
from pipelines import ball
from vtk_fixtures import polydata_of
from vtkmodules.vtkFiltersCore import vtkAppendPolyData
from vtkmodules.vtkFiltersSources import vtkPlaneSource, vtkPointSource

from vtk_mls.vtk import arrays
from vtk_mls.vtk.objects import output_of

RADIUS = SIZE / 3


@pytest.mark.parametrize("data", [ball_image, ball_mesh])
def test_handles_are_on_and_in_a_ball(data):
    hands = Hands(data())
    for count in (27, 64, 125):
        rest = hands.state.rest
        assert 0.9 * count < len(rest) <= count
        radius = np.linalg.norm(rest - MIDDLE, axis=1)
        assert radius.max() < RADIUS + 1
        assert (np.abs(radius - RADIUS) < 1).sum() >= count / 2
        hands.press("l")
    distances = np.linalg.norm(rest - rest[:, None], axis=2) + 99 * np.eye(len(rest))
    assert distances.min() > 0.5


def test_a_sheet_has_one_layer():
    sheet = vtkPlaneSource()
    sheet.SetResolution(10, 10)
    rest = Hands(output_of(sheet)).editor.state.rest
    assert len(rest) == 9
    np.testing.assert_allclose(rest[:, 2], 0, atol=1e-9)


def test_no_handles_between_two_balls():
    append = vtkAppendPolyData()
    for x in (0, 10):
        append.AddInputData(ball((x, 0, 0), 2, 8))
    rest = Hands(output_of(append)).editor.state.rest
    assert len(rest) > 15
    assert np.abs(np.abs(rest[:, 0] - 5) - 5).max() < 2.01
    assert set(rest[:, 0] > 5) == {False, True}


def test_points_without_cells():
    points = output_of(vtkPointSource(), NumberOfPoints=500).GetPoints()
    positions = arrays.to_numpy(points.GetData())
    rest = Hands(polydata_of(positions)).editor.state.rest
    assert len(rest) > 15
    distances = np.linalg.norm(positions - rest[:, None], axis=2).min(axis=1)
    np.testing.assert_allclose(distances, 0, atol=1e-6)


def test_a_single_point_has_one_handle():
    assert Hands(polydata_of([(3, 4, 5)])).editor.state.rest.tolist() == [[3, 4, 5]]


def test_an_empty_image_has_all_handles():
    image = ball_image()
    arrays.to_numpy(image.GetPointData().GetScalars())[:] = 0
    assert len(Hands(image).editor.state) == 27
