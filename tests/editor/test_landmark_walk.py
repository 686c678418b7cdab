"""A user matches a brain to a warped one in the window; each step saves a picture."""

from __future__ import annotations

import pytest
from test_window import window
from test_window_walk import Steps
from warped_brain import MOST_ACTIONS, NAME, SUBJECT, Walk, WarpedBrain

pytestmark = [pytest.mark.matrix, pytest.mark.usefixtures("screen")]
_SIZE = 1200, 850


def test_a_brain_is_matched_by_five_pairs_and_saved(tmp_path):
    brain = WarpedBrain(tmp_path)
    actions = [*Walk(brain, _SIZE).actions()]
    with window(tmp_path, NAME, "--target", SUBJECT) as viewer:
        steps = Steps(viewer)
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
    assert steps.count < MOST_ACTIONS
