"""Unsaved edits are kept, and the next session offers them."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hands import Hands, ball_mesh
from test_shapes import shapes

from vtk_mls import HalfPlane, Plane, Surface
from vtk_mls.editor import State, state_values
from vtk_mls.editor.autosave import Autosave


def hands_for(folder, path="ball.vtp"):
    return Hands(ball_mesh(), autosave=Autosave(path, folder))


def drag(hands):
    hands.drag(hands.pixel_of(13), (20, 10))


def test_unsaved_edits_are_restored(tmp_path):
    first = hands_for(tmp_path)
    assert first.message == ""
    drag(first)
    first.press("k")
    second = hands_for(tmp_path)
    assert "27 handles of" in second.message
    assert second.state.is_resting.all()
    second.press("Return")
    for name in ("rest", "deformed"):
        np.testing.assert_array_equal(getattr(second.state, name), getattr(first.state, name))
    assert second.state.kind == first.state.kind
    second.press("z")
    assert second.state.is_resting.all()
    other = hands_for(tmp_path, "other.vtp")
    assert other.message == ""


def test_the_offer_is_repeated_until_a_save(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    folder = tmp_path / "unsaved"
    first = hands_for(folder)
    drag(first)
    for keys in (["Return"], []):
        later = hands_for(folder)
        for key in keys:
            later.press(key)
            np.testing.assert_array_equal(later.state.deformed, first.state.deformed)
    later.press("s")  # also without an answer
    assert later.editor.offer == ""
    assert [*folder.iterdir()] == []
    assert hands_for(folder).message == ""


def test_the_offer_lasts_during_edits(tmp_path):
    """After undo, the file has the state of the earlier session again."""
    earlier = State([(0, 0, 0)], [(1, 1, 1)])
    Autosave("ball.vtp", tmp_path).store(earlier)
    hands = hands_for(tmp_path)
    drag(hands)
    hands.press("z")
    assert Autosave("ball.vtp", tmp_path).offered.deformed.tolist() == earlier.deformed.tolist()
    drag(hands)
    assert len(Autosave("ball.vtp", tmp_path).offered) == 27
    hands.press("Return")
    assert hands.state.deformed.tolist() == earlier.deformed.tolist()
    assert hands.message == "The unsaved edits are restored; Z returns to the other handles."
    hands.press("Return")
    assert "There are no unsaved edits to " in hands.message


@pytest.mark.parametrize("has_edits", [False, True])
def test_a_deleted_state_is_not_offered_again(has_edits, tmp_path):
    Autosave("ball.vtp", tmp_path).store(State([(0, 0, 0)], [(1, 1, 1)]))
    hands = hands_for(tmp_path)
    assert "N deletes them." in hands.message
    if has_edits:
        drag(hands)
    hands.press("n")
    assert hands.message == "The unsaved edits are deleted."
    hands.press("n")
    assert "There are no unsaved edits to " in hands.message
    assert len([*tmp_path.iterdir()]) == has_edits
    assert len(hands.state) == 27


def test_a_digest_identifies_data_in_any_folder(tmp_path, monkeypatch):
    state = State([(0, 0, 0)], [(1, 1, 1)])
    for number, folder in enumerate(("a", "b")):
        (tmp_path / folder).mkdir()
        monkeypatch.chdir(tmp_path / folder)
        autosave = Autosave("x.vti", tmp_path / "unsaved", digest="0123")
        assert (autosave.offered is not None) == bool(number)
        autosave.store(state)


def plain(value):
    """A value as lists, numbers, and names of classes with their fields."""
    if dataclasses.is_dataclass(value):
        fields = {field.name: getattr(value, field.name) for field in dataclasses.fields(value)}
        fields.pop("whole", None)  # of a Grid: itself
        return type(value).__name__, {name: plain(field) for name, field in fields.items()}
    if isinstance(value, (list, tuple)):
        return [*map(plain, value)]
    return value.tolist() if isinstance(value, np.ndarray) else value


def test_all_of_a_state_is_kept(tmp_path, rng):
    cuts = [
        Plane((1, 2, 3), (0, 1, 0)),
        HalfPlane((1, 2, 3), (1, 0, 0), (0, 0, 1)),
        Surface.polygon([(0, 0, 0), (1, 0, 0), (1, 1, 0.1)]),
    ]
    state = shapes().changed(
        **{"cuts": cuts, "weights": rng.uniform(1, 2, 2), "anchored": [True, False]},
        **{"enabled": [False, True], "path": rng.uniform(0, 9, (3, 2, 3))},
        **{"kind": "affine", "alpha": 2.5},
        **{"smoothing": 0.1, "nu": 3.0, "blend": 0.3, "cut_frame": "deformed", "degree": 3},
        **{"map_tolerance": 0.0, "steps": 4, "device": "reference"},
    )
    Autosave("x.vti", tmp_path).store(state)
    assert plain(Autosave("x.vti", tmp_path).offered) == plain(state)


def test_the_format_of_shapes_stays():
    """Files of earlier versions are read."""
    state = shapes().changed(cuts=[HalfPlane((1, 2, 3), (1, 0, 0), (0, 0, 1))])
    edit = state_values.encoded(state)
    assert edit["cuts"] == [["half-plane", [[1, 2, 3], [1, 0, 0], [0, 0, 1]]]]
    assert edit["mask"] == ["ball-mask", [[5, 5, 5], 20, 3]]
    *regions, curve = edit["handles"]
    assert curve == [
        "curve",
        [x.tolist() for x in (state.handles[4].rest, state.handles[4].deformed)],
    ]
    ball, capsule, solid, labels = (shape for name, (shape, motion) in regions if name == "region")
    assert ball == ["ball", [[1, 2, 3], 0.5]]
    assert capsule == ["capsule", [[3, 3, 3], [9, 3, 3], 1]]
    assert [solid[0], *map(len, solid[1][1])] == [
        "solid",
        *[3] * len(state.handles[2].shape.triangles),
    ]
    assert labels[0] == "labels"
    assert labels[1][1:] == [[7, 6, 5], [10, 11, 12], [0.5, -0.7, 0.9], np.eye(3).tolist()]


def test_a_broken_file_is_not_offered(tmp_path):
    Autosave("x.vti", tmp_path).store(shapes())
    (file,) = tmp_path.iterdir()
    whole = file.read_text()
    broken_labels = whole.replace('"labels", ["', '"labels", ["AAAA', 1)
    assert broken_labels != whole
    for text in ("", "{}", '{"rest": 1}', "[1, 2", "null", "[" * 100_000, broken_labels):
        file.write_text(text)
        assert Autosave("x.vti", tmp_path).offered is None, text[:100]


def test_a_folder_that_is_not_writable_is_reported(tmp_path):
    (tmp_path / "file").write_text("")
    hands = hands_for(tmp_path / "file")
    drag(hands)
    assert "file" in hands.message.lower()
