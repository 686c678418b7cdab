"""Nothing is lost: what is not saved is offered by the next start."""

from __future__ import annotations

import os
import time

import numpy as np
import pytest
from hands import SIZE, Hands, ball_mesh

from vtk_mls import HalfPlane, Plane, Surface
from vtk_mls.editor import State
from vtk_mls.editor.drafts import Drafts

MIDDLE = (SIZE - 1) / 2
_GONE = 2**22 + 1  # above all numbers of processes


def hands_for(folder, path="ball.vtp"):
    return Hands(ball_mesh(), drafts=Drafts(path, folder))


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
    folder = tmp_path / "drafts"
    drag(hands_for(folder))
    second = hands_for(folder)
    drag(second)
    drag(second)
    assert len([*folder.iterdir()]) == 2
    third = hands_for(folder)
    assert third.editor.message
    third.press("Return")
    np.testing.assert_array_equal(third.editor.state.deformed, second.editor.state.deformed)
    third.press("s")
    third.press("0")
    third.press("z")
    (left,) = folder.iterdir()
    fourth = hands_for(folder)
    fourth.press("Return")
    fourth.press("s")
    assert not left.exists()
    assert hands_for(folder).editor.message == ""


def test_what_nobody_has_seen_outlives_a_save(tmp_path, monkeypatch):
    """Also that of a session that still runs; older ones are offered after the newest."""
    monkeypatch.chdir(tmp_path)
    folder, states = tmp_path / "drafts", []
    for _ in range(2):
        hands = hands_for(folder)
        drag(hands)
        for _ in range(len(states) + 1):
            hands.press("k")
        states.append(hands.editor.state)
    other = hands_for(folder)
    drag(other)
    other.press("s")
    assert len([*folder.iterdir()]) == 2
    assert "were not saved: Return" in other.editor.offer
    for state in reversed(states):
        other.press("Return")
        assert other.editor.state.kind == state.kind
    assert other.editor.message == "They are back; Z takes the others again."
    other.press("Return")
    assert "Nothing is offered" in other.editor.message
    other.press("s")
    assert [*folder.iterdir()] == []


def _left_by_another(folder, monkeypatch, kind="rigid"):
    """What a session has left whose process is gone."""
    with monkeypatch.context() as patch:
        patch.setattr(os, "getpid", lambda: _GONE)
        Drafts("ball.vtp", folder).keep(State([(0, 0, 0)], [(1, 1, 1)], kind=kind))


def test_what_is_dropped_never_comes_back(tmp_path, monkeypatch):
    folder = tmp_path / "drafts"
    for kind in ("affine", "similarity"):
        _left_by_another(folder, monkeypatch, kind)
    hands = hands_for(folder)
    assert "N drops them." in hands.editor.message
    hands.press("n")
    assert hands.editor.message.startswith("They are dropped. 1 handles of")
    assert hands_for(folder).editor._unsaved.offered.kind == "affine"
    hands.press("n")
    assert hands.editor.message == "They are dropped."
    hands.press("n")
    assert hands.editor.message == "Nothing is offered."
    assert hands_for(folder).editor.message == ""
    assert [*folder.iterdir()] == []
    assert len(hands.editor.state) == 27


def test_what_was_passed_over_is_gone_with_a_save(tmp_path, monkeypatch):
    """So is what was passed over before that; not what another session edits."""
    monkeypatch.chdir(tmp_path)
    folder = tmp_path / "drafts"
    _left_by_another(folder, monkeypatch)
    _left_by_another(folder, monkeypatch)
    hands = hands_for(folder)
    drag(hands)
    assert len([*folder.iterdir()]) == 3
    hands.press("s")
    assert hands.editor.offer == ""
    assert [*folder.iterdir()] == []
    running = hands_for(folder)
    drag(running)
    hands = hands_for(folder)
    drag(hands)
    hands.press("s")
    assert len([*folder.iterdir()]) == 1
    assert "were not saved" in hands_for(folder).editor.message


def test_what_is_written_after_the_start_outlives_a_save(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    folder = tmp_path / "drafts"
    _left_by_another(folder, monkeypatch)
    hands = hands_for(folder)
    (left,) = folder.iterdir()
    os.utime(left, (time.time() + 1,) * 2)  # its session was going on
    drag(hands)
    hands.press("s")
    assert left.exists()


def test_data_without_a_path_are_known_again_in_any_folder(tmp_path, monkeypatch):
    state = State([(0, 0, 0)], [(1, 1, 1)])
    for number, folder in enumerate(("a", "b")):
        (tmp_path / folder).mkdir()
        monkeypatch.chdir(tmp_path / folder)
        drafts = Drafts("x.vti", tmp_path / "drafts", digest="0123")
        assert bool(drafts.found()) == bool(number)
        drafts.keep(state)


def test_closing_during_a_drag_loses_nothing(tmp_path):
    hands = hands_for(tmp_path)
    hands.drag(hands.pixel_of(13), (20, 10), released=False)
    hands.press("q")
    state, _ = Drafts("ball.vtp", tmp_path).found()
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
    Drafts("x.vti", tmp_path).keep(state)
    found, _ = Drafts("x.vti", tmp_path).found()
    for name in ("rest", "deformed", "weights", "anchored"):
        np.testing.assert_array_equal(getattr(found, name), getattr(state, name))
    for name in ("labels", "kind", "alpha", "nu", "blend", "cut_frame", "degree", "map_tolerance"):
        assert getattr(found, name) == getattr(state, name)
    for cut, other in zip(found.cuts, cuts):
        assert type(cut) is type(other)
        for name in set(vars(cut)) & {"point", "normal", "inward", "points", "triangles"}:
            np.testing.assert_allclose(getattr(cut, name), getattr(other, name), rtol=1e-15)


@pytest.mark.parametrize("text", ["", "{}", '{"rest": 1}', "[1, 2", "null"])
def test_a_broken_draft_is_passed_over(tmp_path, text):
    drafts = Drafts("x.vti", tmp_path)
    drafts.keep(State([(0, 0, 0)], [(1, 1, 1)]))
    (file,) = tmp_path.iterdir()
    file.write_text(text)
    assert Drafts("x.vti", tmp_path).found() is None


def test_a_draft_that_cannot_be_kept_is_said(tmp_path):
    (tmp_path / "file").write_text("")
    hands = hands_for(tmp_path / "file")
    drag(hands)
    assert "file" in hands.editor.message.lower()
