"""Slices beside the 3-D view: their pictures, and handles in them."""

from __future__ import annotations

import gc
from types import SimpleNamespace

import numpy as np
import pytest
from hands import MIDDLE, Hands, ball_image, ball_mesh, pixels_in
from vtk_fixtures import add_array, make_image, scalar_image
from vtkmodules.vtkRenderingCore import vtkRenderer

from vtk_mls import Deformation, Grid, HalfPlane
from vtk_mls.editor import State
from vtk_mls.editor.scene_volume import SceneVolume
from vtk_mls.editor.slice_pane import EYE, UP, colors_of, letter_of
from vtk_mls.rendering import transfer_functions
from vtk_mls.vtk.arrays import ImageGeometry

CENTER = 13  # of a 3 x 3 x 3 lattice


@pytest.fixture(params=[pytest.param("volume", marks=pytest.mark.matrix), "mesh"])
def hands(request):
    hands = Hands(ball_image() if request.param == "volume" else ball_mesh(), pixels=360)
    hands.press("m")
    return hands


def panes(hands):
    """The panes, in the order of their axes."""
    by_axis = {}
    for y in (60, 180, 300):
        pane = hands.editor.slices.pane_at((330, y))
        by_axis[pane.axis] = pane
    return [by_axis[axis] for axis in range(3)]


def test_a_key_shows_and_hides_slices(hands):
    size = hands.editor.scene.renderer.GetSize()
    assert size[0] == pytest.approx(0.66 * 360, abs=2)
    assert hands.editor.slices.pane_at((100, 100)) is None
    hands.press("m")
    assert hands.editor.scene.renderer.GetSize() == (360, 360)
    assert hands.editor.slices.pane_at((330, 60)) is None
    camera = hands.camera
    hands.drag((350, 5), (-40, 0))
    assert hands.camera != camera


def test_detached_slices_are_removed_and_collected(hands, capfd):
    window = hands.editor.scene.window
    hands.editor.detach()
    del hands.editor
    gc.collect()
    window.Render()
    assert all(renderer.GetViewport() == (0, 0, 1, 1) for renderer in window.GetRenderers())
    assert "Traceback" not in capfd.readouterr().err  # of observers that VTK still calls


def test_a_handle_is_dragged_in_a_slice_and_all_follow(hands):
    camera = hands.camera
    for number, pane in enumerate(panes(hands)):
        before = hands.picture()
        start = pixels_in(pane, hands.state.deformed[CENTER])[0]
        position = hands.state.deformed[CENTER]
        hands.drag(start, (9, 6), steps=1)
        moved = hands.state.deformed[CENTER]
        assert moved[pane.axis] == pytest.approx(position[pane.axis], abs=1e-9)
        np.testing.assert_allclose(pixels_in(pane, moved)[0], start + (9, 6), atol=0.5)
        hands.editor.move_slices(moved)  # or the handle is not in the next slice
        assert np.abs(hands.picture() - before).mean() > 0.05, number
    assert hands.camera == camera
    assert np.flatnonzero(~hands.state.is_resting).tolist() == [CENTER]
    for _ in range(3):
        hands.press("z")
    assert hands.state.is_resting.all()


def test_mouse_and_wheel_move_the_slices(hands):
    pane = panes(hands)[2]
    camera = hands.camera
    target = np.array([MIDDLE + 3, MIDDLE - 4, MIDDLE])
    hands.drag(pixels_in(pane, target - (1, 0, 0))[0], (0, 0))
    hands.drag(pixels_in(pane, target)[0], (0, 0))
    np.testing.assert_allclose(hands.editor.slices.point, target, atol=0.4)
    before = hands.editor.slices.point[2]
    hands.send("MouseWheelForwardEvent")
    assert hands.editor.slices.point[2] > before
    hands.send("MouseWheelBackwardEvent")
    assert hands.editor.slices.point[2] == pytest.approx(before)
    for event in ("RightButtonPressEvent", "MiddleButtonPressEvent"):
        hands.send(event)
    assert hands.camera == camera
    assert hands.state.is_resting.all()


def test_handles_far_from_a_slice_are_not_in_it(hands):
    pane = panes(hands)[2]
    start = pixels_in(pane, hands.state.deformed[CENTER])[0]
    hands.editor.move_slices(np.array((MIDDLE, MIDDLE, MIDDLE + 4)))
    hands.drag(start, (9, 6), steps=1)
    assert hands.state.is_resting.all()


def test_a_handle_is_added_in_a_slice(hands):
    pane, point = panes(hands)[0], np.array((MIDDLE, MIDDLE + 2, MIDDLE + 3))
    hands.move(pixels_in(pane, point)[0])
    hands.press("a")
    assert len(hands.state) == 28
    np.testing.assert_allclose(hands.state.rest[-1], point, atol=0.4)


def test_the_cut_widget_is_in_the_3d_view_wherever_the_mouse_is(hands):
    hands.move(pixels_in(panes(hands)[0], (MIDDLE, MIDDLE - 6, MIDDLE))[0])
    before = hands.picture()
    hands.press("c")
    changed = np.abs(hands.picture() - before).max(axis=2) > 20
    wide = hands.editor.scene.renderer.GetSize()[0]
    assert changed[:, :wide].sum() > 1000
    assert changed[:, wide + 2 :].sum() < 50


def oblique_image(is_mirrored):
    """An oblique image whose values are a function of world coordinates."""
    turn = np.array([(0.48, 0.64, 0.6), (-0.8, 0.6, 0.0), (-0.36, -0.48, 0.8)])
    direction = turn[:, [1, 0, 2]] if is_mirrored else turn
    grid = Grid((22, 30, 16), (3.0, -9.0, 4.0), (1.1, 0.7, 1.6), direction)
    return scalar_image(values_at(grid.points()), ImageGeometry.of_grid(grid)), grid


def values_at(points):
    """A linear function that differs along all axes."""
    return 400 + points @ (3.0, -7.0, 11.0)


def assert_gray(hands, grid, pane, rng):
    """Pixels of a pane have the gray of the deformed image."""
    editor, picture = hands.editor, hands.picture()
    preset = editor.scene.items[0].presets[0]
    left, low = pane.renderer.GetOrigin()
    width, height = pane.renderer.GetSize()
    low_corner, high_corner = (left + 26, low + 26), (left + width - 26, low + height - 26)
    pixels = rng.integers(low_corner, high_corner, (900, 2))  # between the letters at the edges
    points = np.array([pane.point_at(pixel) for pixel in pixels])
    deformation = editor.state.deformation()
    origins = points if deformation is None else deformation.backward(points)
    index = (origins - grid.origin) @ np.linalg.inv(grid.index_to_world).T
    last = np.array(grid.dimensions) - 1
    depth = np.minimum(index, last - index).min(axis=1)  # voxels from the border
    offsets = np.delete(points - editor.slices.point, pane.axis, axis=1)
    free = (np.abs(offsets) > 0.8).all(axis=1)  # beside the lines of other slices
    for handle in editor.state.deformed:
        free &= np.linalg.norm(pixels_in(pane, handle) - pixels, axis=1) > 9
    grays = picture[pixels[:, 1], pixels[:, 0]].mean(axis=1)
    expected = transfer_functions.slice_colors(preset, values_at(origins))[:, 0]
    inside, outside = free & (depth > 1.5), free & (depth < -1.5)
    assert inside.sum() > 60
    assert outside.sum() > 60
    assert np.abs(grays - expected)[inside].max() < 8
    assert grays[outside].max() < 16


@pytest.mark.parametrize("is_mirrored", [pytest.param(False, marks=pytest.mark.matrix), True])
def test_oblique_images_are_sliced_correctly_and_handles_move_in_slices(is_mirrored, rng):
    image, grid = oblique_image(is_mirrored)
    middle = grid.points().mean(axis=0)
    rest = middle + np.array([(0, 0, 0), (6, 5, 4), (-6, 5, -4), (6, -5, 4), (-6, -5, -4)])
    hands = Hands(image, State(rest, rest), pixels=720)
    hands.press("m")
    hands.editor.move_slices(middle)
    all_panes = [hands.editor.slices.pane_at((700, y)) for y in (60, 360, 660)]
    for pane in all_panes:
        assert_gray(hands, grid, pane, rng)
    for pane in all_panes:
        before = hands.state.deformed[0]
        hands.editor.move_slices(before)
        start = pixels_in(pane, before)[0]
        hands.drag(start, (14, 9))
        after = hands.state.deformed[0]
        np.testing.assert_allclose(pixels_in(pane, after)[0], start + (14, 9), atol=0.6)
        assert after[pane.axis] == pytest.approx(before[pane.axis], abs=1e-9)
        assert (np.delete(after - before, pane.axis) != 0).all()
        np.testing.assert_array_equal(hands.state.deformed[1:], rest[1:])
    hands.editor.move_slices(middle + (1, -1, 0.5))
    for pane in all_panes:
        assert_gray(hands, grid, pane, rng)


def test_the_gap_of_a_cut_has_the_color_with_which_it_is_saved():
    """That of the air at the corners of a CT; outside of the image it is black."""
    image = make_image((9, 8, 7), origin=(0, 0, 0))
    air = np.full((7, 8, 9), -1000, np.int16)
    air[1:, 1:-1, 1:-1] = 400
    add_array(image.GetPointData(), "ct", air.ravel())
    volume = SceneVolume(image, vtkRenderer())
    grid = ImageGeometry.of_image(image).grid
    middle = grid.corners().mean(axis=0)
    rest = middle + [(-1.5, 0, 1), (1.5, 0, 1)]
    cut = HalfPlane(middle, (1, 0, 0), (0, 0, 1))
    d = Deformation(rest, rest + [(-2, 0, 0), (2, 0, 0)], cuts=cut, device="reference")
    volume.show(d, 4, SimpleNamespace(has_grid=False, has_colors=False, lines=None), True)
    gap, outside = middle + (0, 0, 1.0), grid.corners().max(axis=0) + 50.0
    assert d.void(gap[None]).all()
    has_material, (in_gap, black) = colors_of([volume], np.array([gap, outside]))
    assert not has_material.any()
    expected = transfer_functions.slice_colors(volume.presets[0], np.array([-1000.0]))[0]
    np.testing.assert_array_equal(in_gap, expected)
    assert expected.any()
    assert not black.any()


def test_slices_zoom_at_the_mouse_move_along_and_return(hands):
    axial = panes(hands)[2]
    pixel, middle = np.array((330.0, 320)), axial.point_at((300, 300))
    point = axial.point_at(pixel)
    for _ in range(3):
        hands.send("MouseWheelForwardEvent", pixel, "Ctrl")
    np.testing.assert_allclose(axial.point_at(pixel), point, atol=1e-6)
    size = np.linalg.norm(axial.point_at((300, 300)) - point)
    assert size == pytest.approx(np.linalg.norm(middle - point) / 1.21**3, rel=1e-6)
    for keys, events in (("Shift", "LeftButton"), ("", "MiddleButton")):
        before = axial.point_at(pixel)
        hands.send(f"{events}PressEvent", pixel, keys)
        hands.move(pixel - (6, 4), keys)
        hands.send(f"{events}ReleaseEvent", pixel - (6, 4), keys)
        np.testing.assert_allclose(axial.point_at(pixel - (6, 4)), before, atol=1e-6)
    hands.press("r")
    np.testing.assert_allclose(axial.point_at((300, 300)), middle, atol=1e-6)


def test_a_double_click_enlarges_a_pane_and_returns(hands):
    point = panes(hands)[0].point_at((330, 60))
    for expected in ("sagittal", "all"):
        hands.click((330, 60))
        hands.send("LeftButtonDoubleClickEvent", (330, 60))
        assert hands.editor.slices.pane == expected
    assert panes(hands)[0].point_at((330, 60))[0] == point[0]


def test_letters_name_the_directions_of_lps():
    right, up = ([np.cross(UP[axis], EYE[axis]), UP[axis]] for axis in (2, 1))
    assert [letter_of(direction) for direction in (*right, *up)] == [*"LALS"]
    assert letter_of(-np.array(UP[0])) == "I"
