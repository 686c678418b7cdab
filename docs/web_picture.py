"""Draws docs/web.png: `vtk-mls view brain.nii.gz` in headless Chromium, by its mouse.

Run: python docs/web_picture.py [FOLDER FOR A PICTURE OF EACH STEP]
Needs: pip install 'vtk-mls[web,opencl]' nilearn playwright, and /usr/bin/chromium.
"""

import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import nilearn
from playwright.sync_api import sync_playwright

sys.path.append(str(Path(__file__).parents[1] / "tests" / "web"))
from page_mouse import drag

STEPS = Path(sys.argv[1]) if len(sys.argv) > 1 else None
BRAIN = (
    Path(nilearn.__file__).parent / "datasets/data/mni_icbm152_t1_tal_nlin_sym_09a_converted.nii.gz"
)
# Pixels, and how far the mouse goes from there: round the handles on the right, and with one.
AROUND, OPENING = ((466, 110), (445, 600)), ((502, 375), (130, 15))


def step(name):
    """Let the picture become fine, and keep it."""
    shown = None
    while shown != (shown := page.get_attribute("canvas", "data-frames")):
        time.sleep(8)
    if STEPS:
        page.screenshot(path=STEPS / f"{name}.png")


folder = Path(tempfile.mkdtemp())
shutil.copy(BRAIN, folder / "brain.nii.gz")
command = [sys.executable, "-m", "vtk_mls", "view", str(folder / "brain.nii.gz")]
command += ["--no-browser", "--port", "0", "--output", str(folder / "edited")]
server = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
try:
    address = server.stdout.readline().split()[-1]
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(
            executable_path="/usr/bin/chromium", args=["--no-sandbox"]
        )
        page = browser.new_page(viewport={"width": 1280, "height": 800})
        page.goto(address)
        page.wait_for_selector("canvas[data-frames]", timeout=60_000)
        step("1-opened")
        page.get_by_role("button", name="Half-plane").click()
        step("2-cut")
        page.keyboard.down("Control")
        drag(page.mouse, *AROUND)
        page.keyboard.up("Control")
        step("3-selected")
        drag(page.mouse, *OPENING, steps=10, rest=1)
        page.locator(".mls-row .moved", has_text=".").first.wait_for(timeout=240_000)
        step("4-dragged")
        page.screenshot(path=Path(__file__).with_name("web.png"))
        page.get_by_role("button", name="Save", exact=True).click()
        link = page.get_by_role("link", name="picture.png")
        link.wait_for(timeout=240_000)
        step("5-saved")
        with page.expect_download() as download:
            link.click()
        if STEPS:
            download.value.save_as(STEPS / "6-picture.png")
        browser.close()
finally:
    server.terminate()
