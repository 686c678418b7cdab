"""Session files: paths of the data relative to the session, an edit, views, and broken files."""

import json
import os
from pathlib import Path

import numpy as np
import pytest

from vtk_mls import Ball, BallMask, CurveHandle, HalfPlane, Plane, RegionHandle, Surface
from vtk_mls.editor import State, sessions, state_values
from vtk_mls.files import session_files
from vtk_mls.files.session_files import SessionFile
from vtk_mls.model.options import values_of


def _state():
    rest = np.array([(0.1, 0, 0), (1, 2, 3), (4, 5, 1e-17)])
    motion = np.eye(4)
    motion[0, 3] = 0.5
    return State(
        rest,
        rest + 1 / 3,
        np.array([1.0, 2, 3]),
        ("nose", "", "\N{LATIN SMALL LETTER E WITH ACUTE}"),
        [True, False, False],
        kind="affine",
        alpha=1.5,
        enabled=[True, False, True],
        cuts=[
            Plane((0, 0, 0), (1, 0, 0)),
            HalfPlane((0, 0, 1), (0, 1, 0), (1, 0, 0)),
            Surface([(0, 0, 0), (0, 1, 0), (0, 0, 1)], [(0, 1, 2)]),
        ],
        handles=[RegionHandle(Ball((9, 9, 9), 1), motion), CurveHandle(rest, rest + 1)],
        mask=BallMask((0, 0, 0), 5, 1),
    )


def _written(folder, **changes):
    """A session file with changes in its JSON."""
    path = folder / "s.mls.json"
    edit = state_values.encoded(_state())
    session_files.write(path, SessionFile((folder / "a.vti",), folder / "b.vti", edit))
    values = {**json.loads(path.read_text("utf-8")), **changes}
    path.write_text(json.dumps(values), "utf-8")
    return path


def test_a_session_is_read_as_it_was_written(tmp_path):
    folder = tmp_path / "inside"
    folder.mkdir()
    state, path = _state(), folder / "s.mls.json"
    views = {"slices": True}
    data = tmp_path / "a.vti", folder / "more" / "b.vtp"
    written = SessionFile(data, tmp_path / "target.nii.gz", state_values.encoded(state), views)
    session_files.write(path, written)
    values = json.loads(path.read_text("utf-8"))
    assert values["data"] == ["../a.vti", "more/b.vtp"]
    assert values["target"] == "../target.nii.gz"
    moved = tmp_path / "elsewhere" / "deep"
    moved.parent.mkdir()
    folder.rename(moved)
    session = session_files.read(moved / "s.mls.json")
    assert session.data == (moved.parent / "a.vti", moved / "more" / "b.vtp")
    assert session.target == moved.parent / "target.nii.gz"
    assert session.views == views
    found = sessions.state_of(session, path)
    for name in ("rest", "deformed", "weights", "anchored", "enabled"):
        np.testing.assert_array_equal(getattr(found, name), getattr(state, name))
    assert found.labels == state.labels
    assert values_of(found) == values_of(state)
    assert state_values.encoded(found) == state_values.encoded(state)


def test_a_failed_write_keeps_the_old_session(tmp_path, monkeypatch):
    path = _written(tmp_path)
    before = path.read_bytes()
    edit = {"rest": [float("nan")]}
    with pytest.raises(ValueError, match="Out of range"):
        session_files.write(path, SessionFile((tmp_path / "a.vti",), None, edit))

    def full(descriptor):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(OSError, match="could not be written: No space left"):
        session_files.write(path, SessionFile((tmp_path / "a.vti",), None, {}))
    assert path.read_bytes() == before
    assert [*tmp_path.iterdir()] == [path]


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"version": 2}, r"`.*s.mls.json` has version 2, .* up to version 1: update vtk_mls"),
        ({"format": "other"}, r"`.*s.mls.json` is JSON, but not a session of `vtk-mls view`"),
        ({"data": []}, r"`.*s.mls.json` is not a session: it lacks valid `data`"),
        ({"target": 3}, r"`.*s.mls.json` is not a session: it lacks valid `data`"),
    ],
)
def test_a_file_that_is_no_session(tmp_path, changes, sentence):
    with pytest.raises(ValueError, match=sentence):
        session_files.read(_written(tmp_path, **changes))


@pytest.mark.parametrize("text", ["", "{", "[" * 100_000, "\udcff"])
def test_broken_json(tmp_path, text):
    path = tmp_path / "s.mls.json"
    path.write_bytes(text.encode("utf-8", "surrogateescape"))
    with pytest.raises(ValueError, match=r"`.*s.mls.json` is not a session: its JSON is broken"):
        session_files.read(path)


@pytest.mark.parametrize(
    "change",
    [
        {"rest": [[0, 0, 0]]},
        {"labels": 3},
        {"kind": "elastic"},
        {"alpha": -1},
        {"deformed": [[float("nan")] * 3] * 3},
        {"cuts": [["plane", [1]]]},
        {"weights": {}},
    ],
)
def test_an_edit_that_is_not_valid(tmp_path, change):
    session = session_files.read(_written(tmp_path))
    session.edit.update(change)
    with pytest.raises(ValueError, match=r"`s` is not a session: its edit is not valid \("):
        sessions.state_of(session, Path("s"))


def test_missing_files_are_named(tmp_path):
    with pytest.raises(OSError, match=r"there is no file `.*none.mls.json`"):
        session_files.read(tmp_path / "none.mls.json")
    path = _written(tmp_path)
    with pytest.raises(
        OSError, match=r"s.mls.json` is a session of `.*a.vti`, which does not exist"
    ):
        session_files.check_files(session_files.read(path), path)
