"""Pairs of landmarks on the page, without a page: edits, refinement, sessions, stopped saves."""

from __future__ import annotations

import json

import numpy as np
import pytest
from test_session import Panel, ball_mesh, do
from vtk_fixtures import scalar_image

from vtk_mls import Grid, io
from vtk_mls.editor import State
from vtk_mls.editor.matching.target import Target
from vtk_mls.vtk.arrays import ImageGeometry
from vtk_mls.web.session import Session
from vtk_mls.web.transfers import Transfers

SIZE = 28
_SHIFT = np.array((2.0, -1, 0))


def _texture(rng):
    """Smooth random values (SIZE, SIZE, SIZE)."""
    values = rng.normal(size=(SIZE,) * 3)
    for axis in range(3):
        for _ in range(3):
            values = values + np.roll(values, 1, axis)
    return 100 + 50 * values / values.std()


def _image(values):
    geometry = ImageGeometry.of_grid(Grid(values.shape[::-1]))
    return scalar_image(values.astype(np.float32).ravel(), geometry, "gray")


@pytest.fixture
def session(rng, tmp_path, monkeypatch):
    """A session of two images; the target is the moving one, shifted by whole points."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("vtk_mls.web.session._SIZE", (160, 120))  # software draws it
    values = _texture(rng)
    images = _image(values), _image(np.roll(values, _SHIFT.astype(int)[::-1], (0, 1, 2)))
    for name, image in zip(("moving.vti", "target.vti"), images):
        io.write_dataset(image, name)
    p = np.array([(13.0, 13, 13), (15, 12, 14), (12, 15, 15)])
    state = State(p, p, labels=["a", "b", "c"])
    session = Session(Panel())
    target = Target(images[1], tmp_path / "target.vti")
    paths = ["moving.vti"]
    session.call(lambda: session.open([images[0]], state, paths, None, target)).result()
    do(session, "say", "")
    return session


def test_pairs_are_edited_by_the_table(session):
    values = session._on_change.values
    assert values["has_target"]
    assert values["pane"] == "axial"  # a small picture has no room for all slices
    assert [pair["name"] for pair in values["pairs"]] == ["a", "b", "c"]
    do(session, "enable", [1, False])
    assert [pair["enabled"] for pair in values["pairs"]] == [True, False, True]
    state = session.editor.state
    assert state.enabled.tolist() == [True, False, True]
    distances = np.linalg.norm(state.deformed - state.rest, axis=1)
    np.testing.assert_array_equal([pair["distance"] for pair in values["pairs"]], distances)
    do(session, "name", [2, "nose"])
    do(session, "jump", [2])
    assert values["selected"] == [2]
    np.testing.assert_allclose(session.editor.slices.point, (12, 15, 15))
    do(session, "delete_pair", [0])
    assert [pair["name"] for pair in values["pairs"]] == ["b", "nose"]
    do(session, "undo")
    assert [pair["enabled"] for pair in values["pairs"]] == [True, False, True]
    for mode in ("difference", "fade"):
        assert do(session, "comparison", mode)["comparison"] == mode
    assert do(session, "share", 0.25)["share"] == 0.25
    before = session.editor.state
    for name, value in (
        ("comparison", "magic"),
        ("share", 7),
        ("enable", [9, True]),
        ("jump", [-1]),
        ("delete_pair", [99]),
        ("enable", []),
        ("delete_pair", 3),
    ):
        do(session, name, value)
    assert session.editor.state is before
    assert values["share"] == 0.25
    session.call(lambda: session.editor.place("moving", np.array((5.0, 5, 5)))).result()
    assert len(values["pairs"]) == 4
    assert not any(pair["outlier"] for pair in values["pairs"])


def test_the_table_names_the_spline_that_is_chosen(session, rng):
    values = session._on_change.values
    assert values["choice"] == ""
    q = rng.uniform(4, SIZE - 4, (9, 3))
    state = State(q * (1.0, 0.5, 1.5), q, kind="auto")
    session.call(lambda: session.editor.change(state)).result()
    assert values["choice"].startswith("spline of order ")
    assert values["kind"] == "auto"


def test_landmarks_are_refined(session):
    editor, values = session.editor, session._on_change.values
    do(session, "select", [1])
    session.call(editor.refine).result()
    assert values["message"].startswith("Landmark b is moved by 2.2")
    np.testing.assert_allclose(editor.state.deformed[1] - editor.state.rest[1], _SHIFT, atol=0.1)
    assert values["pairs"][1]["score"] > 0.99
    assert values["pairs"][0]["score"] is None
    drawn = []

    def note(done):
        drawn.append(editor.view.drawn_message)
        return False

    session.call(lambda: editor.refine_all(progress=note)).result()
    assert set(drawn) == {"Refining ..."}
    assert values["message"].startswith("3 of 3 landmarks are refined; moved by")
    shift = editor.state.deformed - editor.state.rest
    np.testing.assert_allclose(shift, [_SHIFT] * 3, atol=0.1)
    do(session, "position", [0, 25, 2, 2])
    session.call(lambda: editor.refine([0])).result()
    assert "Landmark a is not moved: " in values["message"]
    assert values["pairs"][0]["refused"]
    np.testing.assert_array_equal(editor.state.deformed[0], (25, 2, 2))
    before = editor.state
    session.call(lambda: editor.refine_all(progress=lambda done: done > 0.3)).result()
    assert values["message"] == "Refining was stopped; no landmark has moved."
    assert editor.state is before


def test_a_mesh_cannot_refine(session):
    editor = session.editor
    session.call(lambda: editor.set_target(ball_mesh())).result()
    do(session, "select", [0])
    session.call(lambda: editor.do("refine")).result()
    assert "landmarks are refined by two images" in editor.message.lower()


def test_a_stopped_save_is_reported(session):
    editor = session.editor
    editor.saver.progress = lambda done: done > 0.1
    assert not session.call(editor.save).result()
    assert session._on_change.values["message"].startswith("Saving was stopped")
    editor.saver.progress = None
    assert session.call(editor.save).result()
    message = session._on_change.values["message"]
    assert message.startswith(f"Saved in {editor.saver.folder}: handles, deformed data on the grid")


def test_a_session_is_saved_and_sent(session, tmp_path):
    editor, values = session.editor, session._on_change.values
    do(session, "enable", [1, False])
    do(session, "comparison", "fade")
    do(session, "share", 0.75)
    assert session.call(editor.save_session).result()
    path = editor.saver.folder / "session.mls.json"
    assert values["is_saved"]
    assert json.loads(path.read_text("utf-8"))["data"] == ["../moving.vti"]
    transfers = Transfers(session, tmp_path, None)
    do(session, "delete_pair", [0])
    do(session, "comparison", "beside")
    session.call(lambda: transfers._resume(path)).result()
    assert editor.state.enabled.tolist() == [True, False, True]
    assert (values["comparison"], values["share"]) == ("fade", 0.75)
    text = path.read_text("utf-8").replace("target.vti", "other.vti")
    other = tmp_path / "other.mls.json"
    other.write_text(text, "utf-8")
    with pytest.raises(ValueError, match=r"`other.mls.json` is a session of .*`other.vti`"):
        session.call(lambda: transfers._resume(other)).result()
