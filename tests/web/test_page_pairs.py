"""Pairs of landmarks on the page, in headless Chromium by its real mouse."""

from __future__ import annotations

import json
from contextlib import closing

import numpy as np
import pytest
from page_server import server
from test_page import Page
from test_session import SIZE, _image, _texture

from vtk_mls import io
from vtk_mls.files import control_point_files

pytestmark = pytest.mark.matrix
BROWSER_ARGUMENTS = ("--disable-3d-apis",)
_WINDOW = {"width": 960, "height": 640}
_PAIRS = np.array([(13.0, 13, 13), (15, 12, 14), (12, 15, 15), (16, 16, 12)])


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("pairs")
    values = _texture(np.random.default_rng(2))
    io.write_dataset(_image(values), folder / "moving.vti")
    io.write_dataset(_image(np.roll(values, (1, -2), (1, 2))), folder / "target.vti")
    control_point_files.write(folder / "pairs.csv", _PAIRS, _PAIRS, None, [*"abcd"])
    return folder


def _page(browser, address):
    return closing(Page(browser, address, viewport=_WINDOW))


_ROWS = "document.querySelectorAll('.mls-pairs tbody input[type=checkbox]').length"


def test_landmarks_are_placed_on_both_sides_and_refined(browser, folder):
    arguments = "moving.vti", "pairs.csv", "--target", "target.vti"
    with server(folder, *arguments) as (_, address), _page(browser, address) as page:
        page.tab.wait_for_function(f"{_ROWS} === 4")
        page.tab.get_by_role("button", name="3-D").click()  # hidden: two 3-D views
        page.tab.mouse.click(*page.pixel((0.19, 0.36)))  # beside the handles
        page.tab.wait_for_function(f"{_ROWS} === 5")
        page.says("is on both sides")
        name = page.tab.get_by_label("Name of 5")
        name.fill("nose")
        name.press("Enter")
        page.tab.get_by_label("Delete nose").click()
        page.tab.wait_for_function(f"{_ROWS} === 4")
        page.tab.get_by_label("Use b").uncheck()
        page.status("1 off")
        page.tab.get_by_role("button", name="Refine all").click()
        page.says("3 of 3 landmarks are refined")
        page.tab.get_by_role("button", name="Save session").click()
        page.tab.get_by_role("link", name="session.mls.json").wait_for()
    session = json.loads((folder / "moving-edited" / "session.mls.json").read_text("utf-8"))
    moved = np.array(session["edit"]["deformed"]) - _PAIRS
    np.testing.assert_allclose(moved[[0, 2, 3]], [(-2, 1, 0)] * 3, atol=0.15)
    np.testing.assert_array_equal(moved[1], 0)
    arguments = ("moving-edited/session.mls.json",)
    with server(folder, *arguments) as (_, address), _page(browser, address) as page:
        page.status("4 handles", "1 off")
        assert page.tab.get_by_label("Use b").is_checked() is False


def test_a_save_is_stopped(browser, folder):
    """The tab's messages are answered while a save goes on."""
    large = np.kron(_texture(np.random.default_rng(1)), np.ones((3, 3, 3)))
    assert large.shape == (3 * SIZE,) * 3
    io.write_dataset(_image(large), folder / "large.vti")
    # the specification in numpy takes long, and reports its progress
    arguments = "large.vti", "pairs.csv", "--device", "reference"
    with server(folder, *arguments) as (_, address), _page(browser, address) as page:
        page.tab.get_by_role("button", name="Save", exact=True).click()
        page.tab.get_by_role("button", name="Stop").click()
        page.says("Saving was stopped")
        assert not page.tab.get_by_role("link", name="handles.csv").is_visible()
