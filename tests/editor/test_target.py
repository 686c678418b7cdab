"""The target beside the moving data, by mouse: landmarks, linked slices, comparisons."""

from __future__ import annotations

import numpy as np
import pytest
from hands import MIDDLE, SIZE, Hands, ball_image, ball_mesh, pixels_in

from vtk_mls.editor import State, window
from vtk_mls.editor.matching.target import CHECKERBOARD, DIFFERENCE, FADE, Comparison, Target
from vtk_mls.editor.matching.target_view import ComparedItem, difference_colors
from vtk_mls.vtk.arrays import ImageGeometry

NONE = {"device": "reference"}


def panes(slices):
    return {pane.axis: pane for pane in slices._panes}


@pytest.mark.parametrize("pixel", [(75, 160), (225, 160)])
def test_a_click_on_a_side_places_a_pair_on_surfaces_far_apart(pixel):
    hands = Hands(ball_mesh(), State([], [], **NONE), target=ball_mesh((500, 0, 40)), pixels=300)
    hands.click(pixel)
    assert hands.message == "Landmark 1 is on both sides. Drag it to its place where it is wrong."
    np.testing.assert_allclose(hands.state.deformed - hands.state.rest, [(500, 0, 40)], atol=1e-4)
    np.testing.assert_allclose(
        np.linalg.norm(hands.state.rest - MIDDLE), SIZE / 3, rtol=0.05
    )  # on the ball
    camera = hands.camera
    hands.drag((225, 40), (30, 10))
    assert hands.camera != camera
    assert len(hands.state) == 1
    hands.press("z")
    assert len(hands.state) == 0


@pytest.mark.parametrize("side", ["moving", "target"])
def test_the_partner_is_where_the_present_map_says(side, rng):
    q = MIDDLE + rng.uniform(-6, 6, (6, 3))
    state = State(q * (1.0, 0.9, 1.1) + 1, q, kind="auto", **NONE)
    hands = Hands(ball_mesh(), state, target=ball_mesh(), pixels=120)
    point = q.mean(axis=0)
    expected = state.deformation().backward([point])[0]
    hands.editor.place(side, point)
    np.testing.assert_allclose(hands.state.rest[-1], expected, atol=1e-4)
    np.testing.assert_allclose(hands.state.deformed[-1], point, atol=1e-4)
    np.testing.assert_allclose(hands.editor.slices.point, point, atol=1e-4)
    assert hands.editor.selected.tolist() == [6]
    hands.press("z")
    hands.press("b")  # the data are drawn at rest: the click is on p
    hands.editor.place("moving", expected)
    np.testing.assert_allclose(hands.state.rest[-1], expected)
    np.testing.assert_allclose(hands.state.deformed[-1], point, atol=1e-3)


def test_slices_of_both_sides_are_linked_and_take_landmarks():
    hands = Hands(ball_mesh(), State([], [], **NONE), target=ball_mesh(), pixels=300)
    hands.press("m")
    moving, target = hands.editor.slices, hands.editor.view.target.slices
    point = np.array((MIDDLE + 3, MIDDLE - 2, MIDDLE))
    hands.drag(pixels_in(panes(target)[2], point)[0], (4, 0))
    assert len(hands.state) == 0
    np.testing.assert_array_equal(moving.point, target.point)
    assert target.point[2] == MIDDLE
    hands.click(pixels_in(panes(target)[2], point)[0])
    start, end = pixels_in(panes(moving)[2], [point, point - (2, 0, 0)])
    hands.drag(start, end - start)
    np.testing.assert_allclose(hands.state.deformed, [point], atol=0.2)
    np.testing.assert_allclose(hands.state.rest, [point - (2, 0, 0)], atol=0.2)
    hands.drag(pixels_in(panes(target)[2], hands.state.deformed[0])[0], (0, 12))
    assert hands.state.deformed[0, 1] < point[1] - 1  # up is anterior, as y decreases
    np.testing.assert_allclose(hands.state.rest, [point - (2, 0, 0)], atol=0.2)


def test_a_landmark_dragged_on_the_data_is_corrected_there():
    """The data do not follow the mouse; then what is under it comes to the place on the target."""
    hands = Hands(ball_mesh(), State([], [], **NONE), target=ball_mesh(), pixels=300)
    hands.press("m")
    moving = hands.editor.slices
    q = np.array((MIDDLE + 3, MIDDLE - 2, MIDDLE))
    hands.editor.change(State([q - (2, 0, 0)], [q], **NONE))
    before, pixel = hands.state, pixels_in(panes(moving)[2], hands.state.deformed[0])[0]
    per_pixel = (
        1 / (pixels_in(panes(moving)[2], q + (1, 0, 0))[0] - pixels_in(panes(moving)[2], q)[0])[0]
    )
    hands.drag(pixel, (20, 0), released=False)
    assert hands.state is before
    hands.send("LeftButtonReleaseEvent")
    np.testing.assert_array_equal(hands.state.deformed, before.deformed)
    expected = before.rest + [(20 * per_pixel, 0, 0)]
    np.testing.assert_allclose(hands.state.rest, expected, atol=1e-3)
    hands.press("z")
    assert hands.state is before


def test_the_right_button_changes_brightness_and_contrast_of_one_side():
    hands = Hands(ball_image(), State([], [], **NONE), target=ball_image(), pixels=300)
    point = np.full((1, 3), MIDDLE)
    sides = hands.editor.scene.items[0], hands.editor.view.target.scene.items[0]
    before = [int(item.colors_at(point)[1][0, 0]) for item in sides]
    pixel = pixels_in(panes(hands.editor.view.target.slices)[1], point[0])[0]
    hands.move(pixel)
    hands.send("RightButtonPressEvent", pixel)
    hands.send("MouseMoveEvent", pixel - (0, 60))
    hands.send("RightButtonReleaseEvent", pixel - (0, 60))
    after = [int(item.colors_at(point)[1][0, 0]) for item in sides]
    assert after[0] == before[0]
    assert after[1] < before[1] - 40


def test_keys_compare_the_sides_in_one_view():
    hands = Hands(ball_mesh(), State([], [], **NONE), target=ball_image(), pixels=300)
    moving, target = hands.editor.slices, hands.editor.view.target.slices
    hands.press("4")
    assert (moving.is_visible, target.is_visible) == (True, False)
    hands.press("5")
    assert hands.message.startswith("Select handles first")
    hands.press("2")
    hands.press("Right")
    assert hands.editor.comparison == Comparison(FADE, 0.6)
    pixel = pixels_in(panes(moving)[2], np.full(3, MIDDLE))[0]
    hands.click(pixel)
    hands.drag(pixel, (9, 0))
    assert len(hands.state) == 1
    assert hands.state.deformed[0, 0] > hands.state.rest[0, 0]
    hands.press("1")
    assert (moving.is_visible, target.is_visible) == (True, True)
    hands.editor.set_target(None)
    assert hands.editor.scene.renderer.GetViewport() == (0, 0, 1, 1)


@pytest.mark.parametrize("data", [ball_image, ball_mesh])
def test_the_3d_view_fades_from_the_data_to_an_image(data):
    shifted = ImageGeometry((0, SIZE - 1) * 3, (6.0, 2, 0))
    hands = Hands(data(), State([], [], **NONE), target=ball_image(shifted), pixels=300)
    hands.press("2")
    hands.press(" ")

    def views(share):
        hands.editor.set_comparison(share=share)
        return np.split(hands.picture()[150:], 2, axis=1)

    (data_view, target_view), shares = views(0.0), (0.25, 1.0)
    assert np.abs(data_view - target_view).max() > 50
    for share in shares:
        faded, _ = views(share)
        expected = (1 - share) * data_view + share * target_view
        np.testing.assert_allclose(faded, expected, atol=2)
    hands.press("1")
    beside = hands.picture()
    hands.editor.set_comparison(share=0.0)
    np.testing.assert_array_equal(hands.picture(), beside)


class Gray:
    """An item of one gray value."""

    def __init__(self, gray):
        self._gray = gray

    def colors_at(self, points):
        return np.ones(len(points), bool), np.full((len(points), 3), self._gray, np.uint8)


@pytest.mark.parametrize("mode", [FADE, CHECKERBOARD, DIFFERENCE])
def test_colors_of_compared_images(mode, rng):
    bounds, points = np.array([(0.0, 0, 0), (8, 8, 8)]), rng.uniform(0, 8, (1000, 3))
    item = ComparedItem([Gray(200)], [Gray(100)], Comparison(mode, 0.25), bounds)
    has_material, colors = item.colors_at(points)
    assert has_material.all()
    if mode == FADE:
        assert (colors == 175).all()
    elif mode == CHECKERBOARD:
        inside = (np.abs(points - np.rint(points)) < 0.4).all(axis=1)
        is_target = np.rint(points[inside]).sum(axis=1) % 2 == 1
        np.testing.assert_array_equal(colors[inside, 0], np.where(is_target, 100, 200))
    else:
        assert (colors == np.rint(difference_colors(200.0 * np.ones((1, 3)), 100))).all()
        assert colors[0, 0] > colors[0, 2]  # orange: the moving data are brighter
        equal = ComparedItem([Gray(7)], [Gray(7)], Comparison(mode), bounds)
        assert (equal.colors_at(points)[1] == 0).all()


def test_a_target_with_blocks_is_refused():
    from vtkmodules.vtkCommonDataModel import vtkMultiBlockDataSet

    with pytest.raises(TypeError, match="`target` must be a single image or mesh, got a vtkMulti"):
        Target(vtkMultiBlockDataSet())


def test_the_device_is_checked_before_a_window_with_a_target_is_shown(monkeypatch):
    """The check takes seconds, in which clicks would be lost."""

    def stop(name, needed):
        raise RuntimeError(f"checks {name} for {' and '.join(needed)}")

    monkeypatch.setattr(window.display, "check", lambda: None)
    monkeypatch.setattr(window, "_OFFSCREEN_CLASSES", ())
    monkeypatch.setattr(window, "engine_for", stop)
    state = State([], [], device="0:0")
    with pytest.raises(RuntimeError, match="checks 0:0 for spline and fields"):
        window.show([ball_mesh()], state, ["ball.vtp"], target=Target(ball_mesh()))


# Names of landmarks on both sides, in 3-D views and slices: none over another

_BLANK = "\N{NO-BREAK SPACE}"
_NAMES = "frontal", "insula"


@pytest.mark.parametrize("selected", [0, 1])
def test_of_names_that_overlap_that_of_the_selected_landmark_is_drawn(selected):
    points = MIDDLE + np.array([(0.0, 0, 0), (0.3, 0, 0)])
    state = State(points, points, labels=("", ""), device="reference")
    hands = Hands(ball_mesh(), state, target=ball_mesh(), pixels=480)
    hands.press("m")
    hands.editor.select([selected])
    pictures = {}
    for labels in (_NAMES, (_BLANK,) * 2, (_NAMES[0], _BLANK), (_BLANK, _NAMES[1])):
        hands.editor.change(hands.state.changed(labels=labels))
        pictures[labels] = hands.picture()
    alone = tuple(name if row == selected else _BLANK for row, name in enumerate(_NAMES))
    np.testing.assert_array_equal(pictures[_NAMES], pictures[alone])
    is_name = (pictures[alone] != pictures[(_BLANK,) * 2]).any(axis=2)
    for quarter in (is_name[:240, :240], is_name[:240, 240:], is_name[240:, :240]):
        assert quarter.any()


def test_a_name_follows_the_camera():
    place = np.full(3, MIDDLE)
    state = State([place], [place], labels=[""], device="reference")
    hands = Hands(ball_mesh(), state, target=ball_mesh(), pixels=480)
    view, where = hands.editor.view, []
    for look_at in (place, place + (0, 0, 5)):
        view.center_on(look_at)
        pictures = []
        for name in ("insula", _BLANK):
            hands.editor.change(hands.state.changed(labels=[name]))
            pictures.append(hands.picture())
        is_name = (pictures[0] != pictures[1]).any(axis=2)
        is_name[:, 240:] = False  # the target
        where.append((np.mean(np.nonzero(is_name)[::-1], axis=1), hands.pixels(place[None])[0, :2]))
    (first, first_pixel), (second, second_pixel) = where
    np.testing.assert_allclose(second - first, second_pixel - first_pixel, atol=2)
