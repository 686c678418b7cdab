"""Fixtures of the web page: a headless Chromium."""

from __future__ import annotations

import os
import shutil

import pytest


@pytest.fixture(scope="module")
def browser(request):
    """A browser of playwright; `BROWSER_ARGUMENTS` of a test module are its own."""
    chromium = shutil.which("chromium")
    stop = pytest.fail if os.environ.get("CI") == "true" else pytest.skip
    if chromium is None:
        stop("no chromium on this system: tests/web/install.sh brings it")
    try:
        from playwright.sync_api import sync_playwright
    except ModuleNotFoundError:
        stop("no playwright: pip install 'vtk-mls[test]'")
    arguments = ["--no-sandbox", *getattr(request.module, "BROWSER_ARGUMENTS", ())]
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=chromium, args=arguments)
        yield browser
        browser.close()
