"""Folders of processes that were killed are removed by the next one; those in use stay."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import tempfile
import time

import pytest
from command_fixtures import PROJECT

from vtk_mls.commands import temporary_folder

pytest.importorskip("fcntl")
_HOLD = """
import sys
from vtk_mls.commands import temporary_folder
with temporary_folder.made() as folder:
    print(folder, flush=True)
    sys.stdin.read()
"""
_DAY = 86_400  # seconds


@pytest.fixture
def where(tmp_path, monkeypatch):
    """Where temporary folders are."""
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    monkeypatch.setattr(tempfile, "tempdir", None)
    return tmp_path


def _hold(name):
    """A process that has a folder with a file, both a day old; and the folder."""
    process = subprocess.Popen(
        [sys.executable, "-c", _HOLD],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        env={**os.environ, "PYTHONPATH": str(PROJECT)},
        text=True,
    )
    folder = process.stdout.readline().strip()
    with open(os.path.join(folder, name), "w") as file:
        file.write("large")
    _make_old(folder)
    return process, folder


def _make_old(folder):
    os.utime(folder, (time.time() - _DAY,) * 2)


def _names(where):
    return sorted(path.name for path in where.iterdir())


def test_a_killed_one_leaves_nothing_for_long(where):
    killed, left = _hold("data.nii.gz")
    killed.send_signal(signal.SIGKILL)
    killed.communicate()
    assert os.path.isdir(left)
    running, in_use = _hold("other.vtp")
    assert _names(where) == [os.path.basename(in_use)]
    with temporary_folder.made() as own:
        assert _names(where) == sorted(map(os.path.basename, (in_use, own)))
    assert os.listdir(in_use) == ["other.vtp"]
    running.communicate("")
    assert running.returncode == 0
    assert _names(where) == []


def test_what_is_young_or_not_ours_stays(where, monkeypatch):
    for name in ("vtk-mls-temporary-young", "vtk-mls-temporary-old", "vtk-mls-results"):
        (where / name).mkdir()
    target = where / "target"
    target.mkdir()
    (target / "kept").write_text("")
    (where / "vtk-mls-temporary-link").symlink_to(target)
    (where / "vtk-mls-temporary-file").write_text("")
    for name in ("vtk-mls-temporary-old", "vtk-mls-results", "target"):
        _make_old(where / name)
    monkeypatch.setattr(os, "getuid", lambda: 12345)
    temporary_folder.remove_abandoned(where)
    assert (where / "vtk-mls-temporary-old").is_dir()
    monkeypatch.undo()
    temporary_folder.remove_abandoned(where)
    kept = [
        "target",
        "vtk-mls-results",
        *(f"vtk-mls-temporary-{n}" for n in ("file", "link", "young")),
    ]
    assert _names(where) == kept
    assert (target / "kept").exists()


def test_where_there_are_no_locks_nothing_is_removed(where, monkeypatch):
    (where / "vtk-mls-temporary-old").mkdir()
    _make_old(where / "vtk-mls-temporary-old")

    def refuse(*_):
        raise OSError("no locks available")

    monkeypatch.setattr(temporary_folder.fcntl, "flock", refuse)
    with temporary_folder.made() as folder:
        assert os.path.isdir(folder)
        assert (where / "vtk-mls-temporary-old").is_dir()
