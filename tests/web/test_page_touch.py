"""The page on screens of several sizes: all texts fit, and fingers zoom, select and place."""

from __future__ import annotations

import numpy as np
import pytest
from page_server import server
from test_page import PHONE, Page
from vtk_fixtures import scalar_image

from vtk_mls import io
from vtk_mls.files import control_point_files
from vtk_mls.vtk.arrays import ImageGeometry

BROWSER_ARGUMENTS = ("--disable-3d-apis",)
_SIZES = {"1600x1000": (1600, 1000), "1000x700": (1000, 700), "390x780": None}
# i, j of voxels, beside the lines in the middle
_SPOTS = np.array([(8 + 6 * (3 * i % 10 % 5), 3.5 + 4 * i) for i in range(10)])
_SHIFT = np.array((2, 0))
# Texts wider than their element, and texts and controls outside of the screen, or of the part of it
# that scrolls them up and down.
_MISFITS = """() => [...document.querySelectorAll('body *')].filter((element) => {
  const box = element.getBoundingClientRect(), style = getComputedStyle(element);
  const hasText = [...element.childNodes].some((node) => node.nodeType === 3 && node.data.trim());
  const isRead = hasText || element.matches('button, input');
  const isHidden = !box.width || style.visibility === 'hidden' || box.left >= innerWidth;
  if (!isRead || isHidden) return false;
  let frame = element.parentElement;
  while (frame && !/auto|scroll/.test(getComputedStyle(frame).overflowY))
    frame = frame.parentElement;
  const { left, right } = frame?.getBoundingClientRect() ?? { left: 0, right: innerWidth };
  const isBeside = box.right > Math.min(right, innerWidth) + 1 || box.left < Math.max(left, 0) - 1;
  const isBelow = !frame && (box.bottom > innerHeight + 1 || box.top < -1);
  const isCut = style.display !== 'inline' && element.scrollWidth > element.clientWidth + 1;
  return isBeside || isBelow || (hasText && isCut);
}).map((element) => `${element.tagName} ${element.className} ${element.textContent.trim()}`)"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Two images, with ten bright spots each; those of the target are shifted."""
    folder = tmp_path_factory.mktemp("touch")
    for name, shift in (("moving.vti", 0), ("target.vti", _SHIFT)):
        values = np.full((9, 52, 48), 40.0, np.float32)
        k, j, i = np.indices(values.shape)
        for x, y in _SPOTS + shift:
            values += 200 * np.exp(-((i - x) ** 2 + (j - y) ** 2 + (k - 4) ** 2) / 2)
        geometry = ImageGeometry((0, 47, 0, 51, 0, 8))
        io.write_dataset(scalar_image(values.ravel(), geometry, "gray"), folder / name)
    return folder


@pytest.fixture(scope="module")
def address(folder):
    arguments = "moving.vti", "--target", "target.vti", "--kind", "rigid"
    with server(folder, *arguments) as (_, address):
        yield address


@pytest.fixture(params=[_SIZES["390x780"]])
def page(browser, address, request):
    """A tab of a size, on a phone if it has none."""
    size = request.param and dict(zip(("width", "height"), request.param))
    page = Page(browser, address, **({"viewport": size} if size else PHONE))
    yield page
    page.close()


def test_a_pinch_zooms_there_and_back_and_places_no_landmark(page):
    page.rest()
    before = page.pixels()
    for widths, is_reached in (
        ([30 + 10 * step for step in range(9)], lambda change: change > 5),
        ([110 - 10 * step for step in range(9)], lambda change: change < 1),
    ):
        page.pinch((0.5, 0.25), widths)
        page.until(lambda is_reached=is_reached: is_reached(np.abs(page.pixels() - before).mean()))
    assert page.tab.locator(".mls-pairs tbody input").count() == 0


def _spots(side):
    """Pixels (10, 2) of the bright spots in a part of a picture, from top to bottom."""
    gray, found = side.min(axis=2), []  # lines and letters have colors
    y, x = np.indices(gray.shape)
    for _ in _SPOTS:
        j, i = np.unravel_index(gray.argmax(), gray.shape)
        near = np.hypot(x - i, y - j) < 4
        weight = (gray * near).ravel()
        found.append((np.average(x.ravel(), weights=weight), np.average(y.ravel(), weights=weight)))
        gray = np.where(np.hypot(x - i, y - j) < 7, 0, gray)
    return np.array(sorted(found, key=lambda place: place[1]))


def test_ten_pairs_are_placed_by_fingers_within_one_voxel(page, folder):
    """The first pair is corrected. It shifts the data, and the other landmarks lie right then."""
    page.until(lambda: page.pixels().min(axis=2).max() > 200)
    page.rest()
    picture, box = page.pixels(), page.tab.locator("canvas").bounding_box()
    height, width, _ = picture.shape
    is_upright = height > width
    beside = np.array((0, height // 2) if is_upright else (width // 2, 0))
    sides = np.split(picture[: height // 2 * 2, : width // 2 * 2], 2, 0 if is_upright else 1)
    moving, target = map(_spots, sides)
    corner = np.array((box["x"], box["y"]))
    for i, place in enumerate([moving[0], *target[1:]]):
        page.tab.touchscreen.tap(*(corner + place))
        page.says(f"Landmark {i + 1} is on both sides")
        page.rest()
        if i == 0:
            before = page.pixels()
            page.swipe((place + beside) / (width, height), target[0] - place)
            page.until(lambda before=before: np.abs(page.pixels() - before).mean() > 1)
            page.rest()
    page.tab.get_by_role("button", name="Save", exact=True).tap()
    page.tab.get_by_role("link", name="handles.csv").wait_for()
    p, q, *_ = control_point_files.read_pairs(folder / "moving-edited" / "handles.csv")
    np.testing.assert_array_less(np.abs(p[:, :2] - _SPOTS), 1)
    np.testing.assert_array_less(np.abs(q[:, :2] - _SPOTS - _SHIFT), 1)


@pytest.mark.parametrize("page", _SIZES.values(), ids=_SIZES, indirect=True)
def test_all_texts_are_on_the_screen_and_fit(page):
    page.rest()
    page.tab.mouse.click(*page.pixel((0.3, 0.3)))
    page.tab.locator(".mls-pairs tbody button").first.wait_for()
    assert page.tab.evaluate(_MISFITS) == []
    page.tab.get_by_role("button", name="Panel").click()  # shows it, or hides it
    page.rest()
    assert page.tab.evaluate(_MISFITS) == []
