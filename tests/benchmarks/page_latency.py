"""Time from a move of the mouse to the changed picture on the page, while a handle is dragged.

python tests/benchmarks/page_latency.py      # on an idle machine, with Chromium and playwright

The picture has 1200 x 800 pixels. A volume of 98 x 116 x 94 voxels and a surface of 26,000
triangles are deformed by 15 handles. The browser takes both times: that of the event, and that
after the picture has been drawn in which the 24 x 24 pixels under the mouse are others. A place
whose pixels do not change for 3 seconds is counted as missed.
"""

from __future__ import annotations

import shutil
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from playwright.sync_api import sync_playwright
from vtkmodules.vtkCommonDataModel import vtkImageData
from vtkmodules.vtkFiltersSources import vtkSphereSource

PROJECT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(PROJECT / "tests" / folder) for folder in ("web", "")]

from page_server import server  # noqa: E402

from vtk_mls import io  # noqa: E402
from vtk_mls.files import control_point_files  # noqa: E402
from vtk_mls.vtk import arrays  # noqa: E402
from vtk_mls.vtk.arrays import ImageGeometry  # noqa: E402

MOVES, WARM_UP = 100, 10
RADIUS = 88
WATCH = """() => {
  const canvas = document.querySelector('canvas'), context = canvas.getContext('2d');
  window.times = [];
  let at, before, asked;
  const block = () => context.getImageData(at[0] - 12, at[1] - 12, 24, 24).data.join();
  canvas.addEventListener('pointermove', (event) => {
    const box = canvas.getBoundingClientRect();
    at = [event.clientX - box.left, event.clientY - box.top];
    asked = event.timeStamp;
    before = block();
  }, true);
  new MutationObserver(() => {
    if (!asked || block() === before) return;
    const start = asked;
    asked = undefined;
    requestAnimationFrame(() => setTimeout(() => window.times.push(performance.now() - start)));
  }).observe(canvas, { attributes: true, attributeFilter: ['data-frames'] });
}"""


def write_data(folder):
    """A volume, a surface, and 15 handles on both."""
    image = vtkImageData()
    ImageGeometry((0, 97, 0, 115, 0, 93), (-98, -116, -94), (2, 2, 2)).apply_to(image)
    radius = np.linalg.norm(ImageGeometry.of_image(image).grid.points(), axis=1)
    values = np.clip(230 * (1.6 - radius / RADIUS), 0, 255).astype(np.uint8)
    arrays.add(image.GetPointData(), "density", values)
    image.GetPointData().SetActiveScalars("density")
    io.write_dataset(image, folder / "volume.vti")
    ball = vtkSphereSource()
    ball.SetRadius(RADIUS)
    ball.SetThetaResolution(115)
    ball.SetPhiResolution(115)
    ball.Update()
    io.write_dataset(ball.GetOutput(), folder / "surface.vtp")
    turns = np.pi * (1 + 5**0.5) * np.arange(15)
    height = 1 - 2 * (np.arange(15) + 0.5) / 15
    flat = np.sqrt(1 - height**2)
    handles = RADIUS * np.c_[flat * np.cos(turns), flat * np.sin(turns), height]
    handles[0] = 0, -RADIUS, 0
    control_point_files.write(folder / "handles.csv", handles, handles)


def times_of(browser, address):
    """Milliseconds of each move of a drag on the page."""
    page = browser.new_page(viewport={"width": 1548, "height": 900})
    page.goto(address)
    page.wait_for_selector("canvas[data-frames]")
    for _ in range(3):  # until the picture has the size
        box = page.locator("canvas").bounding_box()
        size = page.viewport_size
        width, height = 1200 - box["width"], 800 - box["height"]
        page.set_viewport_size(
            {"width": round(size["width"] + width), "height": round(size["height"] + height)}
        )
        time.sleep(1)
    time.sleep(10)
    x, y = _handle_at(page)
    page.mouse.move(x, y)
    time.sleep(1)
    page.evaluate(WATCH)  # not before: it counts moves
    page.mouse.down()
    for move in range(WARM_UP + MOVES):
        angle = 2 * np.pi * move / 20
        count = page.evaluate("times.length")
        page.mouse.move(x + 60 * np.sin(angle), y + 40 * (np.cos(angle) - 1))
        until = time.monotonic() + 3
        while page.evaluate("times.length") == count and time.monotonic() < until:
            time.sleep(0.005)
        time.sleep(0.05)
    page.mouse.up()
    times = page.evaluate("times")[WARM_UP:]
    page.close()
    return times


def _handle_at(page):
    """The pixel near the middle of the picture where the mouse shows a handle."""
    box = page.locator("canvas").bounding_box()
    middle = np.array([box["x"] + box["width"] / 2, box["y"] + box["height"] / 2])
    rows = "document.querySelectorAll('.mls-row.is-selected').length"
    steps = [(i, j) for i in range(-9, 10) for j in range(-9, 10)]
    for step in sorted(steps, key=np.linalg.norm):
        place = middle + 16 * np.array(step)
        page.mouse.click(*place)
        time.sleep(0.3)
        if page.evaluate(rows):
            return place
    raise RuntimeError("no handle is near the middle of the picture")


def main():
    folder = Path(tempfile.mkdtemp())
    write_data(folder)
    with sync_playwright() as playwright:
        chromium = shutil.which("chromium")
        browser = playwright.chromium.launch(executable_path=chromium, args=["--no-sandbox"])
        for name in ("volume.vti", "surface.vtp"):
            with server(folder, name, "handles.csv", "--alpha", "1.5") as (_, address):
                times = times_of(browser, address)
            p50, p99 = np.percentile(times, [50, 99])
            missed = MOVES - len(times)
            print(f"{name}: p50 {p50:.0f} ms, p99 {p99:.0f} ms, missed {missed} of {MOVES}")
        browser.close()
    shutil.rmtree(folder)


if __name__ == "__main__":
    main()
