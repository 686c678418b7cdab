"""The built site in headless Chromium, as wide as a desktop and as a phone.

Pictures of all pages are left in build/site/.
"""

from __future__ import annotations

import pytest
from command_fixtures import PROJECT

SITE = PROJECT / "docs" / "_build" / "html"
PICTURES = PROJECT / "build" / "site"
WIDTHS = (1280, 390)
PAGES = [path.relative_to(SITE).as_posix() for path in sorted(SITE.rglob("*.html"))]
PAGES = [page for page in PAGES if not page.startswith("_")]

pytestmark = pytest.mark.matrix

# Elements that are wider than the window or than their own box and cannot be scrolled.
WIDE = """
() => {
  const width = document.documentElement.clientWidth;
  const scrolls = (element) => ["auto", "scroll"].includes(getComputedStyle(element).overflowX);
  const isScrolled = (element) =>
    element?.matches(".bd-article *") && (scrolls(element) || isScrolled(element.parentElement));
  const wide = [...document.querySelectorAll(".bd-article *")].filter((element) =>
    getComputedStyle(element).display === "block" && element.scrollWidth > element.clientWidth + 1
    || element.getBoundingClientRect().right > width + 1);
  const texts = wide.filter((element) => !isScrolled(element))
    .map((element) => element.outerHTML.slice(0, 100));
  return document.documentElement.scrollWidth > width ? ["the page", ...texts] : texts;
}
"""
MISSING_IMAGES = """
async () => {
  const missing = [];
  for (const image of document.images) {
    image.loading = "eager";
    await image.decode().catch(() => missing.push(image.src));
  }
  return missing;
}
"""


@pytest.fixture(scope="module", params=WIDTHS)
def tab(browser, request):
    """A tab of a width; `problems` are errors of its console and its requests."""
    tab = browser.new_page(viewport={"width": request.param, "height": 900})
    tab.problems = []
    tab.on("pageerror", lambda error: tab.problems.append(str(error)))
    tab.on("requestfailed", lambda request: tab.problems.append(request.url))
    tab.on("console", lambda said: said.type == "error" and tab.problems.append(said.text))
    yield tab
    tab.close()


def test_the_site_is_built():
    if not PAGES:
        pytest.skip("no site to look at: make docs, which .ci/run does before")
    assert "index.html" in PAGES


@pytest.mark.parametrize("page", PAGES)
def test_a_page_fits_and_is_complete(tab, page):
    tab.problems.clear()
    tab.goto((SITE / page).as_uri())
    missing = tab.evaluate(MISSING_IMAGES)
    width = tab.viewport_size["width"]
    picture = PICTURES / str(width) / page.replace("/", ".").replace(".html", ".png")
    tab.screenshot(path=picture, full_page=True)
    assert not missing
    assert not tab.problems
    assert not tab.evaluate(WIDE)
