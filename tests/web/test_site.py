"""The built site in headless Chromium, as wide as a desktop and as a phone.

Pictures of all pages are left in build/site/.
"""

from __future__ import annotations

from pathlib import Path

import pytest

PROJECT = Path(__file__).resolve().parents[2]
SITE = PROJECT / "docs" / "_build" / "html"
PICTURES = PROJECT / "build" / "site"
WIDTHS = (1280, 390)
PAGES = [path.relative_to(SITE).as_posix() for path in sorted(SITE.rglob("*.html"))]
PAGES = [page for page in PAGES if not page.startswith("_")]

pytestmark = pytest.mark.matrix

# What of a page is wider than it may be: than the window, or than its own box, unless it or what
# holds it is scrolled; and which of its pictures are not there.
WIDE = """
() => {
  const room = document.documentElement.clientWidth;
  const scrolls = (each) => ["auto", "scroll"].includes(getComputedStyle(each).overflowX);
  const held = (each) =>
    each && each.matches(".bd-article *") && (scrolls(each) || held(each.parentElement));
  const wide = [...document.querySelectorAll(".bd-article *")].filter((each) =>
    getComputedStyle(each).display === "block" && each.scrollWidth > each.clientWidth + 1 ||
    each.getBoundingClientRect().right > room + 1);
  const found = wide.filter((each) => !held(each)).map((each) => each.outerHTML.slice(0, 100));
  return document.documentElement.scrollWidth > room ? ["the page", ...found] : found;
}
"""
LOST = """
async () => {
  const lost = [];
  for (const each of document.images) {
    each.loading = "eager";
    await each.decode().catch(() => lost.push(each.src));
  }
  return lost;
}
"""


@pytest.fixture(scope="module", params=WIDTHS)
def tab(browser, request):
    """A tab of a width; `problems` holds what its console and its requests have said."""
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
def test_a_page_fits_and_is_whole(tab, page):
    tab.problems.clear()
    tab.goto((SITE / page).as_uri())
    lost = tab.evaluate(LOST)
    width = tab.viewport_size["width"]
    picture = PICTURES / str(width) / page.replace("/", ".").replace(".html", ".png")
    tab.screenshot(path=picture, full_page=True)
    assert not lost
    assert not tab.problems
    assert not tab.evaluate(WIDE)
