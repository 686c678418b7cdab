"""A user cuts a brain open in the window; each step saves a picture."""

from __future__ import annotations

import time

import pytest
from command_fixtures import PROJECT
from opened_brain import MOST_ACTIONS, NAME, OpenedBrain, copy_to
from test_window import window

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
