"""The editor by mouse and keys: edits, undo, and pictures."""

from __future__ import annotations

import numpy as np
import pytest
from hands import MIDDLE, SIZE, Hands, ball_image, ball_mesh, key_and_modifiers
from pairwise import one_of

from vtk_mls import Deformation, Plane
from vtk_mls.editor import State, commands
from vtk_mls.editor.handle_glyphs import DRAGGED
from vtk_mls.model.options import ALPHA
from vtk_mls.rendering.pace import MapPace

BOTH = pytest.mark.parametrize("hands", ["volume", "mesh"], indirect=True)


@pytest.fixture
def hands(request):
    """Of a mesh, or of what a test asks for."""
    return Hands(ball_image() if getattr(request, "param", "") == "volume" else ball_mesh())


def front_row(hands):
    """Row of the handle nearest to the camera."""
    return int(hands.pixels(hands.state.deformed)[:, 2].argmin())


@BOTH
def test_the_initial_lattice_covers_the_visible_data(hands):
    state = hands.state
    assert len(state) == 27
    assert state.is_resting.all()
    np.testing.assert_allclose(state.rest.mean(axis=0), MIDDLE, atol=0.5)
    np.testing.assert_allclose(np.ptp(state.rest, axis=0), 2 * SIZE / 3, atol=1.5)


@BOTH
def test_a_dragged_handle_follows_the_mouse_and_the_camera_stays(hands):
    row, camera, before = front_row(hands), hands.camera, hands.picture()
    start = hands.pixel_of(row)
    hands.drag(start, (30, 18))
    np.testing.assert_allclose(hands.pixel_of(row), start + (30, 18), atol=1.5)
    state = hands.state
    assert np.flatnonzero(~state.is_resting).tolist() == [row]
    assert hands.editor.selected.tolist() == [row]
    assert hands.camera == camera
    assert np.abs(hands.picture() - before).mean() > 0.3
    # at the same depth
    depth = hands.pixels(np.stack([state.rest[row], state.deformed[row]]))[:, 2]
    assert depth[0] == pytest.approx(depth[1], abs=1e-9)


def test_a_drag_ends_where_the_button_is_released(hands):
    """X11 merges movements during a slow picture, also those after the release."""
    row = front_row(hands)
    start = hands.pixel_of(row)
    hands.drag(start, (30, 18), released=False)
    hands.move(start + (100, 70))
    hands.tick()
    hands.send("LeftButtonReleaseEvent", start + (30, 18))
    np.testing.assert_allclose(hands.pixel_of(row), start + (30, 18), atol=1.5)


@BOTH
def test_data_follow_during_a_drag(hands):
    row, before = front_row(hands), hands.picture()
    hands.press("a", "Ctrl")
    hands.drag(hands.pixel_of(row), (30, 18), released=False)
    assert np.abs(hands.picture() - before).mean() > 0.3
    assert hands.editor.document.grabbed == row
    state = hands.state
    hit = hands.hit((150, 138))
    offset = hit - (state.deformed - state.rest)[row] - MIDDLE
    assert np.linalg.norm(offset) == pytest.approx(SIZE / 3, abs=0.7)


@pytest.mark.parametrize("has_timer", [True, False])
def test_with_a_timer_only_the_latest_position_is_shown(has_timer, hands, monkeypatch):
    calls = []
    if has_timer:
        hands.tick()
    monkeypatch.setattr(hands.editor.scene, "show", lambda *arguments: calls.append(arguments))
    start = hands.pixel_of(front_row(hands))
    hands.send("LeftButtonPressEvent", start)
    for step in range(1, 4):
        hands.move(start + (5 * step, 0))
    assert len(calls) == (0 if has_timer else 3)
    hands.tick()
    hands.tick()
    assert len(calls) == (1 if has_timer else 3)


@BOTH
def test_shift_drags_along_the_normal(hands):
    row = front_row(hands)
    hands.drag(hands.pixel_of(row), (0, 30), "Shift")
    state = hands.state
    step = state.deformed[row] - state.rest[row]
    out = state.rest[row] - MIDDLE
    cosine = step @ out / np.linalg.norm(step) / np.linalg.norm(out)
    assert np.linalg.norm(step) > 0.5
    assert abs(cosine) > 0.95


@BOTH
def test_ctrl_drags_on_the_surface(hands):
    hands.send("LeftButtonPressEvent", hands.pixel_of(front_row(hands)))
    hands.send("LeftButtonReleaseEvent")
    row = front_row(hands)
    middle = np.array(hands.editor.scene.window.GetSize()) / 2
    hands.drag(hands.pixel_of(row), middle - hands.pixel_of(row), "Ctrl")
    radius = np.linalg.norm(hands.state.deformed[row] - MIDDLE)
    assert radius == pytest.approx(SIZE / 3, abs=1.0)
    np.testing.assert_allclose(hands.pixel_of(row), middle, atol=2)


def test_a_rubber_band_selects_handles_that_move_together(hands):
    pixels = np.array([hands.pixel_of(row) for row in range(27)])
    corner = np.rint(np.quantile(pixels, 0.7, axis=0)) + 0.5
    hands.drag((1, 1), corner - 1, "Ctrl")
    inside = (pixels < np.rint(corner)).all(axis=1)
    assert 0 < inside.sum() < 27
    np.testing.assert_array_equal(hands.editor.selected, np.flatnonzero(inside))
    hands.press("a", "Ctrl")
    row = front_row(hands)
    hands.drag(pixels[row], (12, 7))
    state = hands.state
    step = state.deformed - state.rest
    np.testing.assert_allclose(step, step[row] + np.zeros((27, 3)), atol=1e-9)
    assert np.linalg.norm(step[row]) > 0.5
    hands.press("z")
    assert hands.state.is_resting.all()


def test_ctrl_click_toggles_selection(hands):
    pixels = [hands.pixel_of(row) for row in range(27)]
    first = front_row(hands)
    other = max(range(27), key=lambda row: np.linalg.norm(pixels[row] - pixels[first]))
    hands.click(pixels[first])
    hands.click(pixels[other], "Ctrl")
    assert hands.editor.selected.tolist() == sorted([first, other])
    hands.click(pixels[other], "Ctrl")
    assert hands.editor.selected.tolist() == [first]
    assert hands.state.is_resting.all()
    hands.press("Escape")
    assert len(hands.editor.selected) == 0


@BOTH
def test_a_new_handle_is_on_the_visible_surface_and_keeps_the_map(hands):
    row = front_row(hands)
    hands.drag(hands.pixel_of(row), (25, 15))
    deformation = hands.state.deformation()
    hands.move(np.array(hands.editor.scene.window.GetSize()) / 2)
    hands.press("a")
    state = hands.state
    assert len(state) == 28
    assert hands.editor.selected.tolist() == [27]
    # the material at the new handle is that of the surface of the ball
    origin = deformation.backward(state.deformed[[27]])[0]
    assert np.linalg.norm(origin - MIDDLE) == pytest.approx(SIZE / 3, abs=1.0)
    np.testing.assert_allclose(state.rest[27], origin, atol=1e-6)
    points = np.random.default_rng(0).uniform(0, SIZE, (50, 3))
    change = state.deformation().backward(points) - deformation.backward(points)
    assert np.abs(change).max() < 0.5
    hands.press("z")
    assert len(hands.state) == 27


def test_the_foremost_handle_is_picked(hands):
    projection = hands.editor.scene.projection
    near, far = projection.ray((120, 120))
    points = near + np.array([[0.9], [0.2], [0.6]]) * (far - near)
    assert projection.nearest(points, (122, 121), 9) == 1
    assert projection.nearest(points, (140, 120), 9) is None


def test_undo_restores_deleted_handles(hands):
    row = front_row(hands)
    deleted = hands.state.rest[row]
    hands.click(hands.pixel_of(row))
    hands.press("x")
    assert len(hands.state) == 26
    assert not (hands.state.rest == deleted).all(axis=1).any()
    hands.press("Delete")
    assert len(hands.state) == 26
    assert "Select handles first" in hands.message
    hands.press("z", "Ctrl")
    np.testing.assert_array_equal(hands.state.rest[row], deleted)


def test_all_handles_can_be_deleted_and_one_added(hands):
    hands.press("a", "Ctrl")
    hands.press("x")
    assert len(hands.state) == 0
    hands.press("k")
    hands.move((120, 120))
    hands.press("a")
    assert len(hands.state) == 1
    hands.drag(hands.pixel_of(0), (20, 0))
    assert not hands.state.is_resting.any()


def test_an_anchored_handle_stays(hands):
    row = front_row(hands)
    hands.move(hands.pixel_of(row))
    hands.press("f")
    hands.drag(hands.pixel_of(row), (30, 0))
    assert hands.state.is_resting.all()
    hands.press("f")
    hands.drag(hands.pixel_of(row), (30, 0))
    assert not hands.state.is_resting[row]


def test_undo_and_redo_are_unlimited(hands):
    row = front_row(hands)
    for _ in range(30):
        hands.drag(hands.pixel_of(row), (2, 4), steps=1)
    last = hands.state.deformed
    for _ in range(30):
        hands.press("z")
    assert hands.state.is_resting.all()
    hands.press("z")
    assert "nothing to undo" in hands.message
    for _ in range(30):
        hands.press("Z", "Ctrl Shift")
    np.testing.assert_array_equal(hands.state.deformed, last)
    hands.press("y")
    assert "nothing to redo" in hands.message
    hands.press("0")
    assert hands.state.is_resting.all()
    hands.press("z")
    np.testing.assert_array_equal(hands.state.deformed, last)


@pytest.mark.parametrize(
    "hands", [pytest.param("volume", marks=pytest.mark.matrix), "mesh"], indirect=True
)
def test_kind_and_alpha_change_and_undeformed_data_are_shown(hands, monkeypatch):
    # on a busy machine, too
    monkeypatch.setattr(MapPace, "nodes_at_rest", lambda pace: 64)
    monkeypatch.setattr(MapPace, "pixels", lambda pace, limits: 1.0)
    hands.drag(hands.pixel_of(front_row(hands)), (30, 18))
    after = hands.picture()
    state = hands.state
    hands.press("b")
    assert "shown undeformed" in hands.editor.status
    assert np.abs(hands.picture() - after).mean() > 0.1
    hands.press("b")
    assert hands.state is state
    assert np.abs(hands.picture() - after).mean() < 0.5
    for kind in ("similarity", "polynomial 2", "polynomial 3", "spline", "affine", "rigid"):
        hands.press("k")
        deformation = hands.state.deformation()
        assert deformation.kind == kind.split()[0]
        assert deformation.degree == (3 if "3" in kind else 2)
        assert f"handles   {kind}{'   alpha' * (kind != 'spline')}" in hands.editor.status
        if kind == "spline":  # whose kernels have no alpha
            hands.press("plus")
            assert hands.state.deformation().alpha == 1.25 * ALPHA.default
            hands.press("minus")
    hands.press("o")
    assert hands.state.deformation().steps == 0
    assert "steps automatic" in hands.editor.status
    hands.press("o")
    assert hands.state.deformation().steps == 1
    size = np.ptp(hands.editor.scene.bounds, axis=0).max()
    hands.press("period")
    assert hands.state.deformation().smoothing == pytest.approx(0.01 * size, rel=0.01)
    assert "smoothing" in hands.editor.status
    hands.press("comma")
    assert hands.state.deformation().smoothing == 0


@pytest.mark.parametrize(
    ("name", "keys", "largest", "values"),
    [("alpha", "-+", 6, (0.1, 0.3, 0.5, 1, 6, 9)), ("nu", "[]", 8, (1.02, 2, 8, 15))],
)
def test_keys_change_values_outside_the_range_of_sliders(name, keys, largest, values, hands):
    for value in values:
        found = []
        for key in keys:
            hands.editor.change(hands.state.changed(**{name: float(value)}))
            hands.press(key)
            found.append(getattr(hands.state, name))
        assert found[0] <= value <= found[1]
    hands.editor.change(hands.state.changed(**{name: largest - 0.1}))
    hands.press(keys[1])
    assert getattr(hands.state, name) == largest


def test_keys_change_smoothing_by_steps_down_to_none():
    state = State(np.eye(3), np.eye(3) + 1)
    lengths = []
    for factor in (0.8, 1.25, 1.25, 1.25, 0.8, 0.8, 0.8, 0.8):
        state = state.with_smoothing_times(factor, 2.0)
        lengths.append(state.smoothing)
    assert lengths == pytest.approx([0, 2, 2.5, 3.125, 2.5, 2, 0, 0], rel=0.01)


def test_showing_undeformed_data_is_not_an_edit(hands, tmp_path):
    row = front_row(hands)
    hands.drag(hands.pixel_of(row), (30, 18))
    after = hands.picture()
    hands.editor.change(hands.state.changed(blend=0.7))
    hands.press("k")
    hands.press("z")
    hands.press("b")
    hands.press("b")
    assert hands.state.blend == 0.7
    hands.press("y")
    assert "nothing" not in hands.message
    assert hands.state.kind == "similarity"
    for press in ("b", "z", "b"):
        hands.press(press)
    assert hands.editor.view.shows_undeformed
    pixel = hands.pixel_of(row)
    hands.drag(pixel, (0, 3))  # shows them deformed again
    assert not hands.editor.view.shows_undeformed
    assert np.abs(hands.picture() - after).mean() < 6
    assert hands.state.blend == 0.7


@pytest.mark.parametrize("blend", [0.7, 0.0])
def test_undeformed_display_does_not_change_saved_files(blend, hands, tmp_path):
    hands.drag(hands.pixel_of(front_row(hands)), (30, 18))
    hands.editor.change(hands.state.changed(blend=blend))
    hands.editor.saver.folder = tmp_path / "first"
    hands.press("s")
    hands.press("b")
    hands.editor.saver.folder = tmp_path / "second"
    hands.press("s")
    assert not hands.editor.view.shows_undeformed
    first, second = tmp_path / "first", tmp_path / "second"
    for name in ("picture.png", "data-1-deformed.vtp", "deform.py", "displacement-field.nrrd"):
        assert (second / name).read_bytes() == (first / name).read_bytes(), name
    assert f"SetBlend({blend})" in (second / "deform.py").read_text()


def test_keys_call_methods_and_have_texts():
    for command in commands.COMMANDS:
        assert callable(getattr(Hands.__init__.__globals__["Editor"], command.method)), command
        assert command.text
    keys = [key for command in commands.COMMANDS for key in command.keys]
    assert len(set(keys)) == len(keys)


def test_a_hint_is_one_line_that_is_hidden_with_the_handles():
    hands = Hands(ball_mesh(), pixels=600)
    hands.press("Escape")

    def upper_rows():
        """Whether rows at the upper border have text."""
        return np.ptp(hands.picture()[560:], axis=(1, 2)) > 110

    with_hint = upper_rows()
    assert 0 < with_hint.sum() < 20
    hands.press(" ")
    assert not upper_rows().any()
    hands.press(" ")
    np.testing.assert_array_equal(upper_rows(), with_hint)


@pytest.mark.parametrize("symbol", one_of(3, sorted(commands.actions())))
def test_every_key_in_every_situation(symbol, hands, tmp_path, monkeypatch):
    """At the start, during a drag, and without handles."""
    monkeypatch.chdir(tmp_path)  # for saved files
    key, modifiers = key_and_modifiers(symbol)

    def press():
        hands.press(key, modifiers)
        if key == "d":  # clicks on handles add nodes to a curve
            hands.press("Escape")

    press()
    row = front_row(hands)
    hands.drag(hands.pixel_of(row), (20, 10), released=False)
    moved = hands.state.deformed
    press()
    assert hands.editor.document.grabbed is None
    hands.send("LeftButtonReleaseEvent")
    hands.press("a", "Ctrl")
    hands.press("x")
    press()
    while "nothing to undo" not in hands.message:
        hands.press("y" if key in "zy" and not hands.message else "z")
        if "nothing to redo" in hands.message:
            break
    assert len(moved) in (27, 64, 28)


def test_a_state_without_a_map_is_reported_and_not_committed(hands):
    hands.drag(hands.pixel_of(front_row(hands)), (10, 5))
    state = hands.state
    assert not hands.editor.change(state.changed(nu=0.5))
    assert hands.state is state
    assert "`nu` must be a number above 1" in hands.message


def test_hovered_and_dragged_handles_are_highlighted(hands):
    row = front_row(hands)
    pixel = np.rint(hands.pixel_of(row)).astype(int)

    def count_pixels(color):
        pixels = near(8).reshape(-1, 3)
        hue = np.array(color) / np.linalg.norm(color)
        return int((pixels @ hue > 0.97 * np.linalg.norm(pixels, axis=1)).sum())

    def near(distance=11):
        rows, columns = (slice(i - distance, i + distance + 1) for i in pixel[::-1])
        return hands.picture()[rows, columns]

    resting = near()
    hands.move(pixel)
    assert hands.editor.document.hovered == row
    assert (np.abs(near() - resting).max(axis=2) > 20).sum() > 50
    hands.send("LeftButtonPressEvent", pixel)
    assert count_pixels(DRAGGED) > 50
    hands.send("LeftButtonReleaseEvent")
    hands.send("LeaveEvent")
    assert hands.editor.document.hovered is None


def test_one_map_for_a_volume_and_a_mesh_together():
    hands = Hands([ball_image(), ball_mesh()])
    hands.drag(hands.pixel_of(front_row(hands)), (25, 15))
    assert len(hands.editor.scene.items) == 2
    volume, mesh = hands.editor.scene.picker().surfaces
    ray = hands.editor.scene.projection.ray((120, 120))
    np.testing.assert_allclose(volume.hit(*ray)[1], mesh.hit(*ray)[1], atol=1.0)


def test_the_initial_state_is_an_argument():
    plane = Plane((MIDDLE,) * 3, (1, 0, 0))
    rest, deformed = [(0, 0, 0), (20, 20, 20)], [(0, 0, 0), (24, 20, 20)]
    deformation = Deformation(rest, deformed, "affine", cuts=plane)
    hands = Hands(ball_mesh(), State.of(deformation))
    assert hands.state.deformation().kind == "affine"
    assert hands.state.cuts == (plane,)


def test_a_detached_editor_does_nothing(hands):
    hands.editor.detach()
    hands.drag(hands.pixel_of(front_row(hands)), (20, 20))
    hands.press("x")
    assert hands.state.is_resting.all()
