"""A user opens a brain, and matches one to another, in the window; with pictures of each step."""

from __future__ import annotations

import os
import time
from pathlib import Path

import pytest
import warped_brain
from command_fixtures import PROJECT
from opened_brain import MOST_ACTIONS, NAME, OpenedBrain, copy_to
from test_window import window
from warped_brain import SUBJECT, Walk, WarpedBrain

pytestmark = [pytest.mark.matrix, pytest.mark.usefixtures("screen")]
_SIZE = 1200, 850
_PICTURES = PROJECT / "build" / "window"


class Steps:
    """Counts the actions of the user, and saves a picture after each."""

    def __init__(self, viewer):
        self.count, self._viewer = 0, viewer
        _PICTURES.mkdir(parents=True, exist_ok=True)

    def done(self, name):
        self.count += 1
        time.sleep(3)
        self._viewer.photograph(_PICTURES / f"{self.count}_{name}.png")


def test_a_brain_is_cut_open_and_saved(tmp_path):
    copy_to(tmp_path)
    brain = OpenedBrain(tmp_path, _SIZE)
    grabbed = [round(share * (side - 1)) for share, side in zip(brain.grabbed, _SIZE)]
    with window(tmp_path, NAME) as viewer:
        steps = Steps(viewer)
        steps.done("opened")
        viewer.press("c")
        steps.done("plane")
        viewer.press("c")
        steps.done("half")
        viewer.do("keydown", "ctrl")
        viewer.drag((_SIZE[0] // 2, 60), (550, 740))
        viewer.do("keyup", "ctrl")
        steps.done("selected")
        viewer.drag(grabbed, (170, 20))
        steps.done("dragged")
        viewer.press("s")
        saved = tmp_path / "brain-edited"
        viewer.wait_for(saved / "deform.py")
        steps.done("saved")
        assert viewer.end() == (0, "")
    brain.check(saved)
    assert steps.count < MOST_ACTIONS


_TIMEOUT, _INTERVAL = 180, 3  # seconds
_IDLE = 0.05  # processor time of a window that only ticks, relative to the time


class SeenSteps(Steps):
    """Steps that wait, as a user does, until the window has drawn all.

    VTK takes the last of all waiting movements for the next one, also those after a release.
    """

    def done(self, name):
        until, before = time.monotonic() + _TIMEOUT, -_TIMEOUT
        seconds = _processor_time(self._viewer._process.pid)
        while seconds - before > _IDLE * _INTERVAL:
            assert time.monotonic() < until, f"the window still draws {name}"
            time.sleep(_INTERVAL)
            before, seconds = seconds, _processor_time(self._viewer._process.pid)
        super().done(name)


def _processor_time(pid):
    """Seconds of a process and its children."""
    process = Path("/proc") / str(pid)
    user, system = process.joinpath("stat").read_text().rpartition(")")[2].split()[11:13]
    children = process.joinpath("task", str(pid), "children").read_text().split()
    own = (int(user) + int(system)) / os.sysconf("SC_CLK_TCK")
    return own + sum(map(_processor_time, children))


def test_a_brain_is_matched_by_five_pairs_and_saved(tmp_path):
    brain = WarpedBrain(tmp_path)
    actions = [*Walk(brain, _SIZE).actions()]
    with window(tmp_path, warped_brain.NAME, "--target", SUBJECT) as viewer:
        steps = SeenSteps(viewer)
        steps.done("landmarks_opened")
        for name, *arguments in actions:
            getattr(viewer, name)(*arguments)
            steps.done(f"landmarks_{name}")
        viewer.press("ctrl+a")
        steps.done("landmarks_selected")
        viewer.press("7")
        steps.done("landmarks_refined")
        viewer.press("s")
        saved = tmp_path / "brain-edited"
        viewer.wait_for(saved / "deform.py")
        steps.done("landmarks_saved")
        assert viewer.end() == (0, "")
    brain.check(saved)
    assert steps.count < warped_brain.MOST_ACTIONS
