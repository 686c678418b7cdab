"""The editor by mouse and keys: what each does, what can be taken back, and what is drawn."""

from __future__ import annotations

import numpy as np
import pytest
from hands import SIZE, Hands, ball_image, ball_mesh

from vtk_mls import Deformation, Plane
from vtk_mls.editor import State, keys
from vtk_mls.editor.handle_glyphs import HELD
from vtk_mls.editor.pace import Pace

MIDDLE = (SIZE - 1) / 2
FRONT = 4  # the handle in the middle of the lattice's front, of 3 x 3 x 3


@pytest.fixture(params=["volume", "mesh"])
def hands(request):
    return Hands(ball_image() if request.param == "volume" else ball_mesh())


@pytest.fixture
def mesh_hands():
    return Hands(ball_mesh())


def front_row(hands):
    """The handle that is nearest to the eye."""
    return int(hands.editor.projection.pixels(hands.editor.state.deformed)[:, 2].argmin())


def test_it_begins_with_a_lattice_over_what_is_seen(hands):
    state = hands.editor.state
    assert len(state) == 27
    assert state.is_resting.all()
    np.testing.assert_allclose(state.rest.mean(axis=0), MIDDLE, atol=0.5)
    np.testing.assert_allclose(np.ptp(state.rest, axis=0), 2 * SIZE / 3, atol=1.5)


def test_a_dragged_handle_follows_the_mouse_and_the_camera_stays(hands):
    row, camera, before = front_row(hands), hands.camera, hands.picture()
    start = hands.pixel_of(row)
    hands.drag(start, (30, 18))
    np.testing.assert_allclose(hands.pixel_of(row), start + (30, 18), atol=1.5)
    state = hands.editor.state
    assert np.flatnonzero(~state.is_resting).tolist() == [row]
    assert hands.editor.selected.tolist() == [row]
    assert hands.camera == camera
    assert np.abs(hands.picture() - before).mean() > 0.3
    # as far from the eye as before
    depth = hands.editor.projection.pixels(np.stack([state.rest[row], state.deformed[row]]))[:, 2]
    assert depth[0] == pytest.approx(depth[1], abs=1e-9)


def test_data_follow_while_the_mouse_is_down(hands):
    row, before = front_row(hands), hands.picture()
    hands.press("a", "Ctrl")
    hands.drag(hands.pixel_of(row), (30, 18), released=False)
    assert np.abs(hands.picture() - before).mean() > 0.3
    assert hands.editor.grabbed == row
    state = hands.editor.state
    seen = hands.editor.surfaces().hit(hands.editor.projection, (150, 138))
    away = seen - (state.deformed - state.rest)[row] - MIDDLE
    assert np.linalg.norm(away) == pytest.approx(SIZE / 3, abs=0.7)


def test_beside_handles_the_mouse_moves_the_camera():
    hands = Hands(ball_mesh())
    camera = hands.camera
    hands.drag((5, 5), (40, 0))
    assert hands.camera != camera
    assert hands.editor.state.is_resting.all()


def test_only_the_newest_position_is_shown(mesh_hands, monkeypatch):
    hands, shown = mesh_hands, []
    hands.tick()
    monkeypatch.setattr(hands.editor.scene, "show", lambda *arguments: shown.append(arguments))
    start = hands.pixel_of(front_row(hands))
    hands.send("LeftButtonPressEvent", start)
    for step in range(1, 50):
        hands.move(start + (step, 0))
    assert shown == []
    hands.tick()
    hands.tick()
    assert len(shown) == 1


def test_without_a_timer_each_move_is_shown(mesh_hands, monkeypatch):
    hands, shown = mesh_hands, []
    monkeypatch.setattr(hands.editor.scene, "show", lambda *arguments: shown.append(arguments))
    start = hands.pixel_of(front_row(hands))
    hands.send("LeftButtonPressEvent", start)
    for step in range(1, 4):
        hands.move(start + (5 * step, 0))
    assert len(shown) == 3


def test_with_shift_it_goes_along_the_normal(hands):
    row = front_row(hands)
    hands.drag(hands.pixel_of(row), (0, 30), "Shift")
    state = hands.editor.state
    step = state.deformed[row] - state.rest[row]
    out = state.rest[row] - MIDDLE
    cosine = step @ out / np.linalg.norm(step) / np.linalg.norm(out)
    assert np.linalg.norm(step) > 0.5
    assert abs(cosine) > 0.95


def test_with_ctrl_it_stays_on_the_surface(hands):
    hands.send("LeftButtonPressEvent", hands.pixel_of(front_row(hands)))
    hands.send("LeftButtonReleaseEvent")
    row = front_row(hands)
    middle = np.array(hands.editor.scene.window.GetSize()) / 2
    hands.drag(hands.pixel_of(row), middle - hands.pixel_of(row), "Ctrl")
    radius = np.linalg.norm(hands.editor.state.deformed[row] - MIDDLE)
    assert radius == pytest.approx(SIZE / 3, abs=1.0)
    np.testing.assert_allclose(hands.pixel_of(row), middle, atol=2)


def test_several_go_together_that_a_rubber_band_has_selected(mesh_hands):
    hands = mesh_hands
    at = np.array([hands.pixel_of(row) for row in range(27)])
    corner = np.rint(np.quantile(at, 0.7, axis=0)) + 0.5
    hands.drag((1, 1), corner - 1, "Ctrl")
    inside = (at < np.rint(corner)).all(axis=1)
    assert 0 < inside.sum() < 27
    np.testing.assert_array_equal(hands.editor.selected, np.flatnonzero(inside))
    hands.press("a", "Ctrl")
    row = front_row(hands)
    hands.drag(at[row], (12, 7))
    state = hands.editor.state
    step = state.deformed - state.rest
    np.testing.assert_allclose(step, step[row] + np.zeros((27, 3)), atol=1e-9)
    assert np.linalg.norm(step[row]) > 0.5
    hands.press("z")
    assert hands.editor.state.is_resting.all()


def test_a_click_with_ctrl_adds_to_the_selection_and_takes_from_it(mesh_hands):
    hands = mesh_hands
    at = [hands.pixel_of(row) for row in range(27)]
    first = front_row(hands)
    other = max(range(27), key=lambda row: np.linalg.norm(at[row] - at[first]))
    hands.click(at[first])
    hands.click(at[other], "Ctrl")
    assert hands.editor.selected.tolist() == sorted([first, other])
    hands.click(at[other], "Ctrl")
    assert hands.editor.selected.tolist() == [first]
    assert hands.editor.state.is_resting.all()
    hands.press("Escape")
    assert len(hands.editor.selected) == 0


def test_a_handle_is_added_on_the_visible_surface_and_changes_nothing(hands):
    row = front_row(hands)
    hands.drag(hands.pixel_of(row), (25, 15))
    deformation = hands.editor.state.deformation()
    hands.move(np.array(hands.editor.scene.window.GetSize()) / 2)
    hands.press("a")
    state = hands.editor.state
    assert len(state) == 28
    assert hands.editor.selected.tolist() == [27]
    # on the surface, which is where the material of the ball's surface is now
    origin = deformation.backward(state.deformed[[27]])[0]
    assert np.linalg.norm(origin - MIDDLE) == pytest.approx(SIZE / 3, abs=1.0)
    np.testing.assert_allclose(state.rest[27], origin, atol=1e-6)
    points = np.random.default_rng(0).uniform(0, SIZE, (50, 3))
    change = state.deformation().backward(points) - deformation.backward(points)
    assert np.abs(change).max() < 0.5
    hands.press("z")
    assert len(hands.editor.state) == 27


def test_beside_the_data_nothing_is_added(mesh_hands):
    mesh_hands.move((2, 2))
    mesh_hands.press("a")
    assert len(mesh_hands.editor.state) == 27
    assert "no surface" in mesh_hands.editor.message


def test_of_handles_behind_each_other_the_front_one_is_meant(mesh_hands):
    projection = mesh_hands.editor.projection
    near, far = projection.ray((120, 120))
    points = near + np.array([[0.9], [0.2], [0.6]]) * (far - near)
    assert projection.nearest(points, (122, 121), 9) == 1
    assert projection.nearest(points, (140, 120), 9) is None


def test_handles_are_deleted_and_come_back(mesh_hands):
    hands = mesh_hands
    row = front_row(hands)
    gone = hands.editor.state.rest[row]
    hands.click(hands.pixel_of(row))
    hands.press("x")
    assert len(hands.editor.state) == 26
    assert not (hands.editor.state.rest == gone).all(axis=1).any()
    hands.press("Delete")
    assert len(hands.editor.state) == 26
    assert "Select handles first" in hands.editor.message
    hands.press("z", "Ctrl")
    np.testing.assert_array_equal(hands.editor.state.rest[row], gone)


def test_all_can_be_deleted_and_one_added(mesh_hands):
    hands = mesh_hands
    hands.press("a", "Ctrl")
    hands.press("x")
    assert len(hands.editor.state) == 0
    hands.press("k")
    hands.move((120, 120))
    hands.press("a")
    assert len(hands.editor.state) == 1
    hands.drag(hands.pixel_of(0), (20, 0))
    assert not hands.editor.state.is_resting.any()


def test_an_anchored_handle_stays(mesh_hands):
    hands = mesh_hands
    row = front_row(hands)
    hands.move(hands.pixel_of(row))
    hands.press("f")
    hands.drag(hands.pixel_of(row), (30, 0))
    assert hands.editor.state.is_resting.all()
    hands.press("f")
    hands.drag(hands.pixel_of(row), (30, 0))
    assert not hands.editor.state.is_resting[row]


def test_undo_and_redo_have_no_end(mesh_hands):
    hands = mesh_hands
    row = front_row(hands)
    for _ in range(30):
        hands.drag(hands.pixel_of(row), (2, 4), steps=1)
    last = hands.editor.state.deformed
    for _ in range(30):
        hands.press("z")
    assert hands.editor.state.is_resting.all()
    hands.press("z")
    assert "nothing to undo" in hands.editor.message
    for _ in range(30):
        hands.press("Z", "Ctrl Shift")
    np.testing.assert_array_equal(hands.editor.state.deformed, last)
    hands.press("y")
    assert "nothing to do again" in hands.editor.message
    hands.press("0")
    assert hands.editor.state.is_resting.all()
    hands.press("z")
    np.testing.assert_array_equal(hands.editor.state.deformed, last)


def test_kind_alpha_and_before_and_after(hands, monkeypatch):
    # however busy the machine is
    monkeypatch.setattr(Pace, "nodes_at_rest", lambda pace: 64)
    monkeypatch.setattr(Pace, "pixels_at_rest", lambda pace: 1.0)
    hands.drag(hands.pixel_of(front_row(hands)), (30, 18))
    after = hands.picture()
    state = hands.editor.state
    hands.press("b")
    assert "as it was before" in hands.editor.status
    assert np.abs(hands.picture() - after).mean() > 0.1
    hands.press("b")
    assert hands.editor.state is state
    assert np.abs(hands.picture() - after).mean() < 0.5
    kinds = set()
    for _ in range(4):
        hands.press("k")
        kinds.add(hands.editor.state.deformation().kind)
    assert kinds == {"affine", "rigid", "similarity", "polynomial"}
    hands.press("plus")
    assert hands.editor.state.deformation().alpha == 1.25


def test_keys_go_on_from_values_outside_of_the_sliders():
    rest = np.eye(3)
    for alpha in (0.1, 0.3, 0.5, 1, 4, 9):
        state = State(rest, rest + 1, alpha=alpha)
        assert state.with_alpha_times(0.9).alpha <= alpha <= state.with_alpha_times(1.1).alpha
    for nu in (1.02, 2, 8, 15):
        state = State(rest, rest + 1, nu=nu)
        assert state.with_nu_times(0.9).nu <= nu <= state.with_nu_times(1.1).nu
    assert State(rest, rest + 1, alpha=3.9).with_alpha_times(1.1).alpha == 4
    assert State(rest, rest + 1, nu=7.9).with_nu_times(1.1).nu == 8


def test_before_and_after_is_a_matter_of_looking(mesh_hands, tmp_path):
    hands = mesh_hands
    row = front_row(hands)
    hands.drag(hands.pixel_of(row), (30, 18))
    after = hands.picture()
    hands.editor.change(hands.editor.state.changed(blend=0.7))
    hands.press("k")
    hands.press("z")
    hands.press("b")
    hands.press("b")
    assert hands.editor.state.blend == 0.7
    hands.press("y")
    assert "nothing" not in hands.editor.message
    assert hands.editor.state.kind == "similarity"
    for press in ("b", "z", "b"):
        hands.press(press)
    assert hands.editor.shows_before
    at = hands.pixel_of(row)
    hands.drag(at, (0, 3))  # which is seen
    assert not hands.editor.shows_before
    assert np.abs(hands.picture() - after).mean() < 6
    assert hands.editor.state.blend == 0.7


@pytest.mark.parametrize("blend", [0.7, 0.0])
def test_what_is_set_is_saved_while_it_is_seen_as_before(blend, mesh_hands, tmp_path):
    hands = mesh_hands
    hands.drag(hands.pixel_of(front_row(hands)), (30, 18))
    hands.editor.change(hands.editor.state.changed(blend=blend))
    hands.editor.saver.folder = tmp_path / "first"
    hands.press("s")
    hands.press("b")
    hands.editor.saver.folder = tmp_path / "second"
    hands.press("s")
    assert not hands.editor.shows_before
    first, second = tmp_path / "first", tmp_path / "second"
    for name in ("picture.png", "data-1-deformed.vtp", "deform.py", "displacement-field.nrrd"):
        assert (second / name).read_bytes() == (first / name).read_bytes(), name
    assert f"SetBlend({blend})" in (second / "deform.py").read_text()


def test_keys_have_the_names_of_methods_and_lines_in_the_legend():
    for name, value in keys.actions().values():
        assert callable(getattr(Hands.__init__.__globals__["Editor"], name)), value
    assert all(shown and text for shown, text in keys.legend())


@pytest.mark.parametrize("symbol", ["h", "question", "F1"])
def test_a_line_tells_of_the_legend_that_covers_the_view_when_asked(symbol):
    hands = Hands(ball_mesh(), pixels=600)
    hands.press("Escape")
    shares = []
    for press in (None, symbol, symbol):
        if press:
            hands.press(press)
        upper = hands.picture()[300:]
        shares.append((np.ptp(upper, axis=(1, 2)) > 110).mean())  # of rows with light on dark
    hands.press(" ")
    none = hands.picture()[570:]
    assert np.ptp(none, axis=(1, 2)).max() < 110
    hands.press(" ")
    assert np.ptp(hands.picture()[570:], axis=(1, 2)).max() > 110  # the line is back
    assert shares[1] > shares[0] + 0.1
    assert shares[2] == shares[0]


@pytest.mark.parametrize("symbol", sorted(keys.actions()))
def test_every_key_at_any_moment(symbol, mesh_hands, tmp_path, monkeypatch):
    """At first, during a drag, with nothing left: the editor goes on, and says what is wrong."""
    monkeypatch.chdir(tmp_path)  # for what is saved
    hands = mesh_hands
    *modifiers, key = symbol.split("+") if len(symbol) > 1 else [symbol]
    keys_down = " ".join(modifiers) + " Shift" * (key == "Z")
    hands.press(key, keys_down)
    if "q" not in key:
        hands.press("h")
    row = front_row(hands)
    hands.drag(hands.pixel_of(row), (20, 10), released=False)
    moved = hands.editor.state.deformed
    hands.press(key, keys_down)
    assert hands.editor.grabbed is None
    hands.send("LeftButtonReleaseEvent")
    hands.press("a", "Ctrl")
    hands.press("x")
    hands.press(key, keys_down)
    while "nothing to undo" not in hands.editor.message:
        hands.press("y" if key in "zy" and not hands.editor.message else "z")
        if "nothing to do again" in hands.editor.message:
            break
    assert len(moved) in (27, 64, 28)


def test_what_has_no_map_is_said_and_not_kept(mesh_hands):
    hands = mesh_hands
    hands.drag(hands.pixel_of(front_row(hands)), (10, 5))
    state = hands.editor.state
    assert not hands.editor.change(state.changed(nu=0.5))
    assert hands.editor.state is state
    assert "`nu` must be a number above 1" in hands.editor.message


def test_hovered_and_held_handles_are_seen(mesh_hands):
    hands = mesh_hands
    row = front_row(hands)
    at = np.rint(hands.pixel_of(row)).astype(int)

    def seen(colour):
        near = hands.picture()[at[1] - 8 : at[1] + 9, at[0] - 8 : at[0] + 9].reshape(-1, 3)
        hue = np.array(colour) / np.linalg.norm(colour)
        return int((near @ hue > 0.97 * np.linalg.norm(near, axis=1)).sum())

    def near():
        return hands.picture()[at[1] - 11 : at[1] + 12, at[0] - 11 : at[0] + 12]

    resting = near()
    hands.move(at)
    assert hands.editor.hovered == row
    assert (np.abs(near() - resting).max(axis=2) > 20).sum() > 50
    hands.send("LeftButtonPressEvent", at)
    assert seen(HELD) > 50
    hands.send("LeftButtonReleaseEvent")
    hands.send("LeaveEvent")
    assert hands.editor.hovered is None


def test_one_map_for_a_volume_and_a_mesh_together():
    hands = Hands([ball_image(), ball_mesh()])
    hands.drag(hands.pixel_of(front_row(hands)), (25, 15))
    assert len(hands.editor.scene.shown) == 2
    volume, mesh = hands.editor.surfaces()._surfaces
    ray = hands.editor.projection.ray((120, 120))
    np.testing.assert_allclose(volume.hit(*ray)[1], mesh.hit(*ray)[1], atol=1.0)


def test_it_begins_with_a_state():
    plane = Plane((MIDDLE,) * 3, (1, 0, 0))
    made = Deformation([(0, 0, 0), (20, 20, 20)], [(0, 0, 0), (24, 20, 20)], "affine", cuts=plane)
    hands = Hands(ball_mesh(), State.of(made))
    assert hands.editor.state.deformation().kind == "affine"
    assert hands.editor.state.cuts == (plane,)


def test_detached_it_leaves_all_as_it_was(mesh_hands):
    hands = mesh_hands
    hands.editor.detach()
    hands.drag(hands.pixel_of(front_row(hands)), (20, 20))
    hands.press("x")
    assert hands.editor.state.is_resting.all()
