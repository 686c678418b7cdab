"""A new user opens a brain, and matches one to another, on the page; each step leaves a picture."""

from __future__ import annotations

import time

import pytest
import warped_brain
from command_fixtures import PROJECT
from opened_brain import MOST_ACTIONS, NAME, OpenedBrain, copy_to
from page_mouse import drag
from page_server import server
from test_page import Page
from warped_brain import SUBJECT, Walk, WarpedBrain

pytestmark = pytest.mark.matrix
BROWSER_ARGUMENTS = ("--disable-3d-apis",)
_PICTURES = PROJECT / "build" / "web"
_WINDOW = {"width": 1280, "height": 800}


# The table says how far a handle is moved.
_HAS_MOVED = "[...document.querySelectorAll('.mls-row .moved')].some(cell => cell.innerText)"


class Steps:
    """Counts the actions of the user, and takes a picture after each."""

    def __init__(self, page):
        self.count, self._page = 1, page  # the command
        _PICTURES.mkdir(parents=True, exist_ok=True)

    def done(self, name):
        self.count += 1
        frames = -1
        while frames != self._page.frames():  # until the picture is final
            frames = self._page.frames()
            time.sleep(2)
        self._page.tab.screenshot(path=_PICTURES / f"{self.count}_{name}.png")


def test_a_brain_is_cut_open_and_saved(browser, tmp_path):
    copy_to(tmp_path)
    with server(tmp_path, NAME) as (_, address):
        page = Page(browser, address, viewport=_WINDOW)
        steps, keyboard = Steps(page), page.tab.keyboard
        steps.done("opened")
        page.tab.get_by_role("button", name="Half-plane").click()
        page.says("The blue sheet cuts up to its red edge")
        steps.done("cut")
        box = page.tab.locator("canvas").bounding_box()
        brain = OpenedBrain(tmp_path, (round(box["width"]), round(box["height"])))
        keyboard.down("Control")
        drag(page.tab.mouse, page.pixel((0.5, 0.1)), (0.48 * box["width"], 0.8 * box["height"]))
        keyboard.up("Control")
        page.status("selected")
        steps.done("selected")
        page.drag(brain.grabbed, (150, 20))
        page.tab.wait_for_function(_HAS_MOVED)
        steps.done("dragged")
        page.tab.get_by_role("button", name="Save", exact=True).click()
        page.tab.get_by_role("link", name="picture.png").wait_for()
        steps.done("saved")
        with page.tab.expect_download() as download:
            page.tab.get_by_role("link", name="picture.png").click()
        steps.done("taken")
        saved = tmp_path / "brain-edited"
        assert download.value.path().read_bytes() == (saved / "picture.png").read_bytes()
        page.close()
    brain.check(saved)
    assert steps.count < MOST_ACTIONS


_TALL_WINDOW = {"width": 1280, "height": 900}
_SCORES = "document.querySelectorAll('.mls-pairs tbody tr td:nth-child(7)')"
_ARE_SCORED = f"[...{_SCORES}].filter(cell => cell.innerText.trim()).length === 5"


def test_a_brain_is_matched_by_five_pairs_and_saved(browser, tmp_path):
    brain = WarpedBrain(tmp_path)
    with server(tmp_path, warped_brain.NAME) as (_, address):
        page = Page(browser, address, viewport=_TALL_WINDOW)
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
    assert steps.count < warped_brain.MOST_ACTIONS
