"""Cuts in the editor: by the widget, and along a line on the surface."""

from __future__ import annotations

import numpy as np
import pytest
from hands import MIDDLE, SIZE, Hands, ball_image, ball_mesh

from vtk_mls import HalfPlane, Plane, Surface
from vtk_mls.vtk.objects import configured


@pytest.fixture(params=[pytest.param("volume", marks=pytest.mark.matrix), "mesh"])
def hands(request):
    return Hands(ball_image() if request.param == "volume" else ball_mesh())


def test_c_makes_a_plane_then_a_half_plane_then_no_cut(hands):
    hands.press("c")
    (plane,) = hands.state.cuts
    assert isinstance(plane, Plane)
    hands.press("c")
    (half,) = hands.state.cuts
    assert isinstance(half, HalfPlane)
    np.testing.assert_array_equal(half.normal, plane.normal)
    np.testing.assert_allclose(half.inward, (0, 0, 1), atol=1e-12)
    hands.press("i")
    (other,) = hands.state.cuts
    assert other.inward @ half.inward == pytest.approx(np.sqrt(0.5))
    hands.press("bracketright")
    assert hands.state.nu > 2
    hands.press("c")
    assert hands.state.cuts == ()
    for _ in range(5):
        hands.press("z")
    assert hands.state.cuts == ()
    assert "nothing" not in hands.message
    hands.press("z")
    assert "nothing to undo" in hands.message


def test_the_mouse_moves_the_plane(hands):
    hands.editor.scene.renderer.GetActiveCamera().Azimuth(30)
    hands.press("c")
    (before,) = hands.state.cuts
    handles = [hands.pixel_of(row) for row in range(27)]
    face = [
        pixel
        for pixel in np.random.default_rng(0).uniform(60, 180, (400, 2))
        if min(np.linalg.norm(handles - pixel, axis=1)) > 14
    ]
    camera = hands.camera
    for pixel in face:
        hands.drag(pixel, (25, 0))
        (after,) = hands.state.cuts
        if hands.camera == camera and not np.array_equal(after.point, before.point):
            break
        turned = hands.editor.scene.renderer.GetActiveCamera()
        configured(turned, Position=camera[0], ViewUp=(0, 0, 1))
    else:
        raise AssertionError("the mouse does not find the plane")
    assert isinstance(after, Plane)
    hands.press("z")
    assert hands.state.cuts == (before,)


def test_a_line_on_the_surface_becomes_a_cut(hands):
    hands.press("Escape")
    hands.press("p")
    for x in (95, 120, 145):
        hands.click((x, 122))
    assert hands.state.is_resting.all()
    hands.press("p")
    (cut,) = hands.state.cuts
    assert isinstance(cut, Surface)
    line = cut.points[3:6]
    np.testing.assert_allclose(np.linalg.norm(line - MIDDLE, axis=1), SIZE / 3, atol=1)
    pixels = hands.pixels(cut.points)[:, :2]
    np.testing.assert_allclose(pixels, np.tile([(95, 122), (120, 122), (145, 122)], (3, 1)), atol=2)
    hands.press("z")
    assert hands.state.cuts == ()


def test_a_closed_line_cuts_straight_into_the_depth(hands):
    corners = [(100, 105), (140, 105), (145, 140), (105, 145)]
    hands.press("p")
    for corner in corners:
        hands.click(corner)
    hands.click((101, 107))  # the first point
    assert "closed" in hands.message
    hands.click((160, 160))  # a closed line does not grow
    hands.press("p")
    (cut,) = hands.state.cuts
    out, line, deep = cut.points.reshape(3, 4, 3)
    pixels = hands.pixels(line)[:, :2]
    np.testing.assert_allclose(pixels, corners, atol=2)
    np.testing.assert_allclose(np.linalg.norm(line - MIDDLE, axis=1), SIZE / 3, atol=1)
    # all walls have one direction, to the middle of the ball
    into = deep - line
    np.testing.assert_allclose(into, into[:1] + np.zeros((4, 3)), atol=1e-9)
    towards = MIDDLE - line.mean(axis=0)
    assert into[0] @ towards > 0.97 * np.linalg.norm(into[0]) * np.linalg.norm(towards)
    # the cut has no gap: it blocks all segments from inside to outside
    middle = line.mean(axis=0)
    outside = middle + 3 * (line - middle) - 0.5 * (out - line)
    assert cut.blocks(np.tile(middle + 0.3 * into[0], (4, 1)), outside).all()


def test_a_line_without_points_is_no_cut(hands):
    hands.press("p")
    hands.click((2, 2))
    hands.press("p")
    assert "at least two points" in hands.message
    hands.press("p")
    hands.press("Escape")
    camera = hands.camera
    hands.drag((5, 5), (40, 0))
    assert hands.camera != camera


def test_only_the_cutting_half_is_filled_up_to_its_edge():
    hands = Hands(ball_mesh(), pixels=300)
    hands.press("c")
    camera, normal = hands.editor.scene.renderer.GetActiveCamera(), hands.state.cuts[0].normal
    configured(camera, FocalPoint=(MIDDLE,) * 3, Position=MIDDLE + 60 * normal, ViewUp=(0, 0, 1))
    hands.press("c")
    hands.press("Escape")
    hands.press(" ")  # no sheet
    without = hands.picture()
    hands.press(" ")
    for is_upper in (True, False):
        assert (hands.state.cuts[0].inward[2] > 0.5) == is_upper
        change = hands.picture() - without
        corners = [np.abs(change[rows, 74:86]).mean() for rows in (slice(216, 226), slice(74, 84))]
        assert [change_of_corner > 20 for change_of_corner in corners] == [is_upper, not is_upper]
        edge, sheet = change[149:152, 100:140, 1], change[156:160, 100:140, 1]
        assert edge.mean() < min(-10, sheet.mean() - 5)  # less green: the edge is red
        for _ in range(4):
            hands.press("i")


def test_the_first_picture_of_a_cut_has_a_hint():
    hands, messages = Hands(ball_mesh()), []
    window = hands.editor.scene.window
    window.AddObserver("StartEvent", lambda *_: messages.append(hands.message))
    hands.press("c")
    assert len(messages) == 1
    assert messages[0].startswith("The blue sheet cuts, and the mouse moves it")
    hands.press("c")
    assert messages[1].startswith("The blue sheet cuts up to its red edge")
    hands.press("c")
    assert messages[2:] == [""]


@pytest.mark.parametrize("action", ["undo", "lay_lattice", "delete", "toggle_slices", "compare"])
def test_every_action_releases_the_cut_widget(action):
    """VTK's widget blocks keys during a drag, but not the buttons and the key S of the page."""
    hands = Hands(ball_mesh())
    hands.press("c")
    high, point = hands.editor.scene.bounds[1], hands.state.cuts[0].point
    above = point[0], high[1], high[2] + 0.03 * SIZE * 2 / 3
    start = hands.pixels([above])[0, :2]
    hands.drag(start, (20, 0), released=False)
    assert hands.state.cuts[0].point[0] > point[0] + 0.5
    hands.editor.do(action)
    state = hands.editor.document.committed
    assert hands.state is state
    hands.move(start + (40, 0))
    hands.tick()
    hands.send("LeftButtonReleaseEvent")
    assert hands.state is state
    hands.press("y" if action == "undo" else "z")
    hands.drag(start + (20, 0), (10, 0))  # the widget can be dragged again
