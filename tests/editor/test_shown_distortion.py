"""The key J shows the deformed grid, the change of volume, both, or neither."""

from __future__ import annotations

import numpy as np
import pytest
from hands import MIDDLE, SIZE, Hands, ball_image, ball_mesh, bone
from vtkmodules.vtkCommonDataModel import vtkUnstructuredGrid
from vtkmodules.vtkFiltersCore import vtkDelaunay3D

from vtk_mls import HalfPlane
from vtk_mls.editor.distortion import MODES
from vtk_mls.vtk.objects import output_of

PIXELS = 150
NOTHING, GRID, VOLUME, BOTH = range(4)


def tetrahedra():
    grid = output_of(vtkDelaunay3D(), InputData=ball_mesh())
    assert isinstance(grid, vtkUnstructuredGrid)
    return grid


@pytest.fixture(params=["volume", "mesh", "tetrahedra"])
def hands(request):
    data = {"volume": ball_image, "mesh": ball_mesh, "tetrahedra": tetrahedra}[request.param]()
    hands = Hands(data, pixels=PIXELS)
    hands.press("space")
    return hands


def pictures(hands):
    """The pictures of all modes; the key after the last mode shows the first one."""
    result = []
    for mode in (*range(len(MODES)), NOTHING):
        assert hands.editor.view.distortion.mode == mode
        hands.editor.say("")
        hands.editor.document.draw()
        hands.editor.scene.set_coarseness(1)
        result.append(hands.picture())
        hands.press("j")
    assert np.abs(result[-1] - result[0]).mean() < 1
    return result[:-1]


def differ(one, other):
    return (np.abs(one - other).max(axis=-1) > 30).mean()


def reds(picture):
    """The share of pixels in a red like that of folds."""
    red, green, blue = np.moveaxis(picture, -1, 0)
    return ((red > 60) & (green < red / 4) & (blue < red / 3)).mean()


def folded(hands):
    """Exchange the left and the right handle in the middle of the lattice."""
    rest = hands.state.rest
    middle = np.abs(rest[:, 1:] - MIDDLE).max(axis=1)
    rows = [int(np.argmin(middle + 2 * rest[:, 0])), int(np.argmin(middle - 2 * rest[:, 0]))]
    hands.editor.change(hands.state.moved(rows, rest[rows[::-1]]))


def test_undeformed_data_show_a_grid_and_no_colors(hands):
    nothing, grid, _, both = pictures(hands)
    assert differ(nothing, grid) > 0.01
    assert reds(both) < 0.01


def test_folds_are_red(hands):
    folded(hands)
    hands.press("m")
    nothing, grid, volume, both = pictures(hands)
    assert reds(nothing) < 0.01
    assert reds(volume) > reds(nothing) + 0.003
    assert differ(volume, both) > 0.005
    assert differ(nothing, grid) > 0.005


def test_slices_are_tinted_by_the_map():
    """The picture in a slice is gray where nothing moves, red in folds."""
    hands = Hands(ball_image(), pixels=PIXELS)
    folded(hands)
    distortion, d = hands.editor.view.distortion, hands.state.deformation()
    index = np.argwhere(np.ones((1, SIZE, SIZE)))[:, ::-1] + (0, 0, MIDDLE)
    gray = np.full((len(index), 3), 150, np.uint8)
    distortion.mode = VOLUME
    colors = distortion.tinted(index, gray).astype(float)
    is_inside = distortion.lines.covers(distortion.lines.coordinates(d.backward(index)))
    is_folded = (np.linalg.det(d.jacobian(index)) <= 0) & is_inside
    assert 20 < is_folded.sum() < 0.5 * len(index)
    assert (colors[is_folded, 0] > 3 * colors[is_folded, 1]).all()
    assert (colors[~is_inside] == 150).all()
    calm = is_inside & ~is_folded
    assert (colors[calm, 1] > 0.3 * colors[calm, 0]).all()


def test_colors_and_grid_follow_a_drag(hands):
    for _ in range(BOTH):
        hands.press("j")
    before = hands.picture()
    row = int(np.argmax(hands.pixels(hands.state.deformed)[:, 0]))
    hands.press("space")
    hands.drag(hands.pixel_of(row), (40, 0), released=False)
    assert not hands.state.is_resting[row]
    assert differ(before, hands.picture()) > 0.01
    assert hands.editor.view.distortion.deformation is not None
    hands.press("b")  # the drag ends; undeformed
    assert hands.editor.view.distortion.deformation is None


def test_cuts_and_shapes():
    cut = HalfPlane([MIDDLE] * 3, (1, 0, 0), (0, 0, 1))
    hands = Hands([ball_image(), bone()], pixels=PIXELS)
    state = hands.state.changed(cuts=[cut])
    rows = np.flatnonzero(state.rest[:, 0] > MIDDLE + 1)
    hands.editor.change(state.moved(rows, state.rest[rows] + (5, 0, 0)))
    hands.press("m")
    nothing, *_, both = pictures(hands)
    assert differ(nothing, both) > 0.01
    assert hands.editor.scene.items[0]._deformed.failure is None


def test_detached_data_are_not_painted():
    hands = Hands(ball_mesh())
    window, renderer = hands.editor.scene.window, hands.editor.scene.renderer
    hands.press("space")
    before = hands.picture()
    for _ in range(BOTH):
        hands.press("j")
    actor = renderer.GetActors().GetLastActor()
    hands.editor.detach()
    window.Render()
    assert actor.GetShaderProperty().GetNumberOfShaderReplacements() == 0
    assert before.max() > 0
