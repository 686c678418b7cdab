"""A user matches a brain to a warped one on the page; each step saves a picture."""

from __future__ import annotations

import time

import pytest
from page_mouse import drag
from page_server import server
from test_page import Page
from test_page_walk import Steps
from warped_brain import MOST_ACTIONS, NAME, SUBJECT, Walk, WarpedBrain

pytestmark = pytest.mark.matrix
BROWSER_ARGUMENTS = ("--disable-3d-apis",)
_WINDOW = {"width": 1280, "height": 900}
_SCORES = "document.querySelectorAll('.mls-pairs tbody tr td:nth-child(7)')"
_ARE_SCORED = f"[...{_SCORES}].filter(cell => cell.innerText.trim()).length === 5"


def test_a_brain_is_matched_by_five_pairs_and_saved(browser, tmp_path):
    brain = WarpedBrain(tmp_path)
    with server(tmp_path, NAME) as (_, address):
        page = Page(browser, address, viewport=_WINDOW)
        steps = Steps(page)
        steps.done("landmarks_opened")
        page.tab.locator("input[data-send=target]").set_input_files(tmp_path / SUBJECT)
        page.says(f"{SUBJECT} is shown")
        steps.done("landmarks_target")
        box = page.tab.locator("canvas").bounding_box()
        for name, start, *more in Walk(
            brain, (round(box["width"]), round(box["height"]))
        ).actions():
            start = start[0] + box["x"], start[1] + box["y"]
            if name == "drag":
                drag(page.tab.mouse, start, *more)
            else:
                page.tab.mouse.move(*start)
                time.sleep(0.3)
                page.tab.mouse.click(*start)
            steps.done(f"landmarks_{name}")
        page.tab.get_by_role("button", name="Refine all").click()
        page.tab.wait_for_function(_ARE_SCORED)
        steps.done("landmarks_refined")
        page.tab.get_by_role("button", name="Save", exact=True).click()
        page.tab.get_by_role("link", name="picture.png").wait_for()
        steps.done("landmarks_saved")
        page.close()
    saved = tmp_path / "brain-edited"
    brain.check(saved)
    assert steps.count < MOST_ACTIONS
