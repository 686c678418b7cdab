"""Unsaved edits are kept, and offered by the next start."""

from __future__ import annotations

import numpy as np
import pytest
from hands import SIZE, Hands, ball_mesh

from vtk_mls import HalfPlane, Plane, Surface
from vtk_mls.editor import State
from vtk_mls.editor.autosave import Autosave

MIDDLE = (SIZE - 1) / 2


def hands_for(folder, path="ball.vtp"):
    return Hands(ball_mesh(), autosave=Autosave(path, folder))


def drag(hands):
    hands.drag(hands.pixel_of(13), (20, 10))


def test_what_was_not_saved_comes_back(tmp_path):
    first = hands_for(tmp_path)
    assert first.editor.message == ""
    drag(first)
    first.press("k")
    second = hands_for(tmp_path)
    assert "27 handles of" in second.editor.message
    assert second.editor.state.is_resting.all()
    second.press("Return")
    for name in ("rest", "deformed"):
        np.testing.assert_array_equal(
            getattr(second.editor.state, name), getattr(first.editor.state, name)
        )
    assert second.editor.state.kind == first.editor.state.kind
    second.press("z")
    assert second.editor.state.is_resting.all()
    other = hands_for(tmp_path, "other.vtp")
    assert other.editor.message == ""


def test_it_is_offered_again_until_something_is_saved(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    folder = tmp_path / "unsaved"
    first = hands_for(folder)
    drag(first)
    for _ in range(2):
        later = hands_for(folder)
        later.press("Return")
        np.testing.assert_array_equal(later.editor.state.deformed, first.editor.state.deformed)
    later.press("s")
    assert [*folder.iterdir()] == []
    assert hands_for(folder).editor.message == ""


def test_the_offer_lasts_while_one_edits(tmp_path):
    """An edit that is undone leaves the earlier session's state in the file."""
    left = State([(0, 0, 0)], [(1, 1, 1)])
    Autosave("ball.vtp", tmp_path).keep(left)
    hands = hands_for(tmp_path)
    drag(hands)
    hands.press("z")
    assert Autosave("ball.vtp", tmp_path).offered.deformed.tolist() == left.deformed.tolist()
    drag(hands)
    assert len(Autosave("ball.vtp", tmp_path).offered) == 27
    hands.press("Return")
    assert hands.editor.state.deformed.tolist() == left.deformed.tolist()
    assert hands.editor.message == "They are back; Z takes the others again."
    hands.press("Return")
    assert hands.editor.message == "Nothing is offered."


@pytest.mark.parametrize("has_edits", [False, True])
def test_a_dropped_state_never_comes_back(has_edits, tmp_path):
    Autosave("ball.vtp", tmp_path).keep(State([(0, 0, 0)], [(1, 1, 1)]))
    hands = hands_for(tmp_path)
    assert "N drops them." in hands.editor.message
    if has_edits:
        drag(hands)
    hands.press("n")
    assert hands.editor.message == "They are dropped."
    hands.press("n")
    assert hands.editor.message == "Nothing is offered."
    assert len([*tmp_path.iterdir()]) == has_edits
    assert len(hands.editor.state) == 27


def test_a_save_ends_the_offer(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    folder = tmp_path / "unsaved"
    Autosave("ball.vtp", folder).keep(State([(0, 0, 0)], [(1, 1, 1)]))
    hands = hands_for(folder)
    drag(hands)
    hands.press("s")
    assert hands.editor.offer == ""
    assert [*folder.iterdir()] == []


def test_data_without_a_path_are_known_again_in_any_folder(tmp_path, monkeypatch):
    state = State([(0, 0, 0)], [(1, 1, 1)])
    for number, folder in enumerate(("a", "b")):
        (tmp_path / folder).mkdir()
        monkeypatch.chdir(tmp_path / folder)
        autosave = Autosave("x.vti", tmp_path / "unsaved", digest="0123")
        assert (autosave.offered is not None) == bool(number)
        autosave.keep(state)


def test_closing_during_a_drag_loses_nothing(tmp_path):
    hands = hands_for(tmp_path)
    hands.drag(hands.pixel_of(13), (20, 10), released=False)
    hands.press("q")
    state = Autosave("ball.vtp", tmp_path).offered
    assert not state.is_resting[13]


def test_every_state_is_kept_as_it_is(tmp_path, rng):
    rest = rng.uniform(0, 9, (5, 3))
    cuts = [
        Plane((1, 2, 3), (1, 2, 0.5)),
        HalfPlane((1, 2, 3), (1, 2, 0.5), (0, 0, 1)),
        Surface.polygon([(0, 0, 0), (1, 0, 0), (1, 1, 0.1)]),
    ]
    state = State(
        rest, rest + 1, rng.uniform(1, 2, 5), list("abcde"), [True, False] * 2 + [True], cuts=cuts
    ).changed(kind="affine", alpha=2.5, nu=3.0, blend=0.3, cut_frame="deformed", degree=3)
    state = state.changed(map_tolerance=0.0)
    Autosave("x.vti", tmp_path).keep(state)
    found = Autosave("x.vti", tmp_path).offered
    for name in ("rest", "deformed", "weights", "anchored"):
        np.testing.assert_array_equal(getattr(found, name), getattr(state, name))
    for name in ("labels", "kind", "alpha", "nu", "blend", "cut_frame", "degree", "map_tolerance"):
        assert getattr(found, name) == getattr(state, name)
    for cut, other in zip(found.cuts, cuts):
        assert type(cut) is type(other)
        for name in set(vars(cut)) & {"point", "normal", "inward", "points", "triangles"}:
            np.testing.assert_allclose(getattr(cut, name), getattr(other, name), rtol=1e-15)


@pytest.mark.parametrize("text", ["", "{}", '{"rest": 1}', "[1, 2", "null"])
def test_a_broken_file_is_not_offered(tmp_path, text):
    Autosave("x.vti", tmp_path).keep(State([(0, 0, 0)], [(1, 1, 1)]))
    (file,) = tmp_path.iterdir()
    file.write_text(text)
    assert Autosave("x.vti", tmp_path).offered is None


def test_a_folder_that_cannot_be_written_is_reported(tmp_path):
    (tmp_path / "file").write_text("")
    hands = hands_for(tmp_path / "file")
    drag(hands)
    assert "file" in hands.editor.message.lower()
