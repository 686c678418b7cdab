"""`vtk-mls view` in headless Chromium, by its real mouse and keyboard."""

from __future__ import annotations

import base64
import re
import time
from contextlib import closing
from urllib.error import HTTPError
from urllib.request import urlopen

import numpy as np
import pytest
from command_fixtures import run
from page_mouse import drag
from page_server import server
from vtk_fixtures import scalar_image
from vtkmodules.vtkFiltersSources import vtkSphereSource

from vtk_mls import Grid, io
from vtk_mls.editor import commands
from vtk_mls.files import control_point_files
from vtk_mls.vtk.arrays import ImageGeometry
from vtk_mls.vtk.objects import output_of

# the server draws: the browser needs no WebGL
BROWSER_ARGUMENTS = ("--disable-3d-apis",)
_TIMEOUT = 180  # seconds
_SIZE = {"width": 1100, "height": 760}
_PANEL_AT = "document.querySelector('.v-navigation-drawer').getBoundingClientRect().x"
_PIXELS = """() => {
  const canvas = document.querySelector('canvas'), { width, height } = canvas;
  const bytes = canvas.getContext('2d').getImageData(0, 0, width, height).data, parts = [];
  for (let i = 0; i < bytes.length; i += 8192)
    parts.push(String.fromCharCode(...bytes.subarray(i, i + 8192)));
  return [height, width, btoa(parts.join(''))];
}"""
PHONE = {
    "viewport": {"width": 390, "height": 780},
    "has_touch": True,
    "is_mobile": True,
    "device_scale_factor": 2,
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("web")
    ball = output_of(vtkSphereSource(), ThetaResolution=30, PhiResolution=30)
    io.write_dataset(ball, folder / "ball.vtp")
    _write(folder / "handles.csv", [(0, 0, 0), (0, -0.5, 0), (0.5, 0, 0), (-0.5, 0, 0)])
    _write(folder / "others.csv", [(0, 0, 0), (0.1, 0, 0)])
    (folder / "broken.vtp").write_text("<VTKFile type='PolyData'><PolyData></VTKFile>")
    (folder / "large.vtp").write_bytes(b"x" * (65 << 20))
    return folder


def _ball_image():
    grid = Grid((24,) * 3, (-0.6,) * 3, (1.2 / 23,) * 3)
    radius = np.linalg.norm(grid.points(), axis=1)
    values = np.clip(200 * (0.5 - radius) / 0.05, 0, 200).astype(np.uint8)
    return scalar_image(values, ImageGeometry.of_grid(grid))


def _write(path, positions):
    control_point_files.write(path, np.array(positions, float), np.array(positions, float))


@pytest.fixture(scope="module")
def address(folder):
    with server(folder, "ball.vtp", "handles.csv", "--output", "saved") as (_, address):
        yield address


class Page:
    """A tab, and actions in it."""

    def __init__(self, browser, address, **options):
        self.tab = browser.new_page(**(options or {"viewport": _SIZE}))
        self.tab.set_default_timeout(1000 * _TIMEOUT)
        self.errors = []
        self.tab.on("pageerror", lambda error: self.errors.append(str(error)))
        self.tab.goto(address)
        self.tab.wait_for_selector("canvas[data-frames]")
        # a narrow page shows its message instead
        self.tab.locator(".mls-status", has_text="handle").wait_for(state="attached")

    def status(self, *texts):
        """Wait until the status has all of the texts."""
        for text in texts:
            whole = re.compile(rf"(?<!\d){re.escape(text)}")
            self.tab.locator(".mls-status", has_text=whole).wait_for()

    def says(self, text):
        self.tab.locator(".mls-message", has_text=text).wait_for()

    def pixel(self, share):
        box = self.tab.locator("canvas").bounding_box()
        return [box["x"] + share[0] * box["width"], box["y"] + share[1] * box["height"]]

    def drag(self, start, by):
        """Drag with the mouse from a part of the picture."""
        drag(self.tab.mouse, self.pixel(start), by)

    def swipe(self, start, by):
        """Drag with a finger from a part of the picture."""
        x, y = self.pixel(start)
        self.touch([(x + by[0] * step / 8, y + by[1] * step / 8)] for step in range(9))

    def pinch(self, middle, widths):
        """Move two fingers about a part of the picture; the first touches it before the other."""
        x, y = self.pixel(middle)
        pairs = [[(x - width / 2, y), (x + width / 2, y)] for width in widths]
        self.touch([pairs[0][:1], *pairs])

    def touch(self, steps):
        """Touch with fingers, at pixels of each step, and take them away."""
        fingers, count = self.tab.context.new_cdp_session(self.tab), 0
        for places in steps:
            kind = "touchMove" if len(places) == count else "touchStart"
            count = len(places)
            points = [{"x": x, "y": y, "id": i} for i, (x, y) in enumerate(places)]
            fingers.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})
            time.sleep(0.04)
        fingers.send("Input.dispatchTouchEvent", {"type": "touchEnd", "touchPoints": []})

    def rest(self):
        """Wait until the picture is final."""
        canvas = "document.querySelector('canvas')"
        self.tab.wait_for_function(f"{canvas}.width === {canvas}.clientWidth")
        frames, busy = -1, self.tab.locator(".mls-stage > .v-progress-linear")
        while frames != self.frames() or busy.count():
            frames = self.frames()
            time.sleep(2)

    def until(self, is_true):
        """Wait until a function returns something true."""
        until = time.monotonic() + _TIMEOUT
        while not is_true():
            assert time.monotonic() < until
            time.sleep(0.3)

    def pixels(self):
        """The picture on the page: (height, width, 3) float, 0 to 255."""
        height, width, text = self.tab.evaluate(_PIXELS)
        values = np.frombuffer(base64.b64decode(text), np.uint8).reshape(height, width, 4)
        return values[..., :3].astype(float)

    def rows(self):
        texts = self.tab.locator(".mls-row .at").all_inner_texts()
        return np.array([[float(number) for number in text.split(",")] for text in texts])

    def moved_row(self, number, before):
        """The row once it is another one."""
        self.until(lambda: not np.allclose(self.rows()[number], before))
        return self.rows()[number]

    def frames(self):
        return int(self.tab.get_attribute("canvas", "data-frames"))

    def close(self):
        assert not self.errors
        self.tab.close()


@pytest.fixture
def page(browser, address):
    page = Page(browser, address)
    yield page
    page.close()


def test_a_handle_is_dragged_and_undone(page):
    before, frames = page.rows()[0], page.frames()
    page.drag((0.5, 0.5), (70, -40))
    page.status("1 selected")
    after = page.moved_row(0, before)
    assert page.frames() > frames
    assert page.tab.get_by_text("unsaved").is_visible()
    page.tab.keyboard.press("z")
    np.testing.assert_allclose(page.moved_row(0, after), before)


def test_handles_are_added_fixed_placed_and_deleted(page):
    page.tab.mouse.move(*page.pixel((0.5, 0.42)))
    time.sleep(0.3)
    page.tab.keyboard.press("a")
    page.status("5 handles", "1 selected")
    page.tab.keyboard.press("f")
    page.status("1 fixed")
    page.tab.keyboard.press("f")
    box = page.tab.get_by_label("x", exact=True)
    box.fill("0.25")
    box.press("Enter")
    page.tab.locator(".mls-row .at", has_text="0.25,").wait_for()
    page.tab.get_by_role("button", name="Delete").click()
    page.status("4 handles")


def test_every_command_has_a_control_with_its_key_in_the_tool_tip(browser, folder):
    arguments = "ball.vtp", "handles.csv", "--target", "ball.vtp"
    with server(folder, *arguments) as (_, address), closing(Page(browser, address)) as page:
        page.tab.get_by_title("All commands (H)").click()
        for row in commands.COMMANDS:
            title = f"{row.text} ({commands.key_of(row)})"
            count = page.tab.locator(".mls-menu").get_by_title(title, exact=True).count()
            assert count == (row.method != "quit"), title
        page.tab.get_by_title("Add a handle on the surface (A)").click()
        page.says("Click on the surface")


def test_a_slider_is_set_by_its_keys(page):
    """The keys of a slider have an effect, up to the largest alpha of the landmark report."""
    slider = page.tab.get_by_role("slider", name="Alpha")
    slider.focus()
    page.tab.keyboard.press("End")
    page.status("alpha 6")
    page.tab.keyboard.press("ArrowLeft")
    page.status("alpha 5.9")
    for alpha in (6, 2):
        page.tab.keyboard.press("z")
        page.status(f"alpha {alpha}")


def test_names_and_the_mask_by_the_panel(page):
    page.tab.locator(".mls-row").nth(1).click()
    for label, text in (("Name", "tip"), ("y at rest", "-0.4")):
        box = page.tab.get_by_label(label, exact=True)
        box.fill(text)
        box.press("Enter")
    page.tab.locator(".mls-row.is-selected .moved", has_text=re.compile("[1-9]")).wait_for()
    assert page.tab.locator(".mls-row", has_text="tip").count() == 1
    for name in ("Act in a ball only", "Act everywhere", "Undo", "Undo", "Undo", "Undo"):
        page.tab.get_by_role("button", name=name).click()
    page.tab.locator(".mls-row", has_text="tip").wait_for(state="detached")


def test_cuts_and_the_map_by_the_panel(page):
    page.tab.get_by_role("button", name="Half-plane").click()
    page.tab.get_by_text("Parting of cuts").wait_for()
    page.tab.get_by_role("button", name="None").click()
    page.tab.get_by_text("Parting of cuts").wait_for(state="detached")
    page.tab.keyboard.press("c")
    page.tab.get_by_text("Parting of cuts").wait_for()
    page.tab.keyboard.press("Control+z")
    page.tab.keyboard.press("k")
    page.status("similarity")
    assert page.tab.get_by_label("Order (0: automatic)").count() == 0
    for _ in range(3):
        page.tab.keyboard.press("k")
    page.status("spline")
    page.tab.get_by_label("Order (0: automatic)").first.wait_for()
    for _ in range(4):
        page.tab.keyboard.press("Control+z")
    page.status("rigid")


def test_an_image_with_a_mesh_slices_and_a_line_cut(browser, folder, tmp_path):
    image, saved = tmp_path / "ball.nii.gz", tmp_path / "saved"
    io.write_dataset(_ball_image(), image)
    arguments = str(image), "handles.csv", "--with", "ball.vtp", "--output", str(saved)
    with server(folder, *arguments) as (_, address), closing(Page(browser, address)) as page:
        before = page.rows()[0]
        page.tab.keyboard.press("m")
        page.drag((0.83, 1 / 6), (22, -12))  # in the upper slice, along z
        moved = page.moved_row(0, before)
        assert moved[2] == before[2]
        assert abs(moved - before)[:2].min() > 0.01
        page.tab.keyboard.press("m")
        page.drag((0.5, 0.9), (60, -20))  # the camera
        page.tab.keyboard.press("p")
        page.says("Click on the surface")
        for x in (0.42, 0.48, 0.54):
            page.tab.mouse.click(*page.pixel((x, 0.4)))
        page.tab.keyboard.press("p")
        page.tab.get_by_text("Parting of cuts").wait_for()
        assert page.tab.get_by_text("unsaved").is_visible()
        page.tab.keyboard.press("s")
        page.tab.get_by_role("link", name="ball-deformed.nii.gz").wait_for()
        assert not page.tab.get_by_text("unsaved").is_visible()
        for name in ("ball-deformed.nii.gz", "cut-1.vtp", "picture.png"):
            link = page.tab.get_by_role("link", name=name)
            with page.tab.expect_download() as download:
                link.click()
            assert download.value.path().read_bytes() == (saved / name).read_bytes()
    rest, deformed, *_ = control_point_files.read_pairs(saved / "handles.csv")
    np.testing.assert_allclose(deformed[0], moved, rtol=1e-3, atol=1e-4)
    assert (rest != deformed).any(axis=1).tolist() == [True, False, False, False]


def test_a_reload_during_a_drag_keeps_it(page):
    page.tab.keyboard.press("0")
    page.tab.keyboard.press("r")
    time.sleep(0.5)
    before, mouse = page.rows()[0], page.tab.mouse
    mouse.move(*page.pixel((0.5, 0.5)))
    time.sleep(0.3)
    mouse.down()
    mouse.move(*page.pixel((0.55, 0.45)), steps=5)
    page.status("1 selected")
    time.sleep(0.5)
    page.tab.reload()
    page.tab.wait_for_selector("canvas[data-frames]")
    mouse.up()
    moved = page.moved_row(0, before)
    mouse.move(*page.pixel((0.3, 0.3)), steps=5)  # nothing is held
    page.tab.keyboard.press("Escape")
    time.sleep(0.5)
    np.testing.assert_allclose(page.rows()[0], moved)
    page.tab.keyboard.press("0")


def test_unsaved_handles_are_offered_beside_other_messages(browser, folder):
    caches = {"XDG_CACHE_HOME": str(folder / "caches"), "VTK_MLS_DEVICE": "reference"}
    given = server(folder, "ball.vtp", "handles.csv", **caches)
    with given as (_, address), closing(Page(browser, address)) as page:
        for _ in range(2):
            _send(page, "data", folder / "ball.vtp")
            page.says("is shown")
            page.status("27 handles")
            page.tab.keyboard.press("k")
            page.status("similarity")
        page.says("27 handles of")
        page.tab.get_by_role("button", name="Later").click()
        page.tab.get_by_role("button", name="Bring them back").wait_for(state="detached")
        page.tab.keyboard.press("z")
        page.status("rigid")
        page.tab.keyboard.press("Enter")
        page.says("The unsaved edits are restored")
        page.status("similarity")
        _send(page, "data", folder / "ball.vtp")
        page.status("rigid")
        page.tab.get_by_role("button", name="Drop them").click()
        page.says("The unsaved edits are deleted.")
        page.tab.get_by_role("button", name="Drop them").wait_for(state="detached")
    assert not [*folder.glob("sent-*")]


@pytest.mark.matrix
def test_a_second_tab_takes_over(page, browser, address):
    second = Page(browser, address)
    page.tab.get_by_text("This session goes on in another tab.").wait_for()
    page.tab.get_by_role("button", name="Continue here").click()
    second.tab.get_by_text("This session goes on in another tab.").wait_for()
    page.tab.get_by_text("in another tab").wait_for(state="detached")
    second.close()


def test_a_phone(browser, address):
    page = Page(browser, address, **PHONE)
    canvas = page.tab.locator("canvas")
    assert canvas.bounding_box()["width"] == 390
    page.tab.keyboard.press("0")  # handles and camera as at first
    page.tab.keyboard.press("r")
    page.tab.locator(".mls-row .at", has_text=re.compile("^0, 0, 0")).first.wait_for(
        state="attached"
    )
    before = page.rows()[0]
    page.swipe((0.5, 0.5), (50, -30))
    page.status("1 selected")
    assert not np.allclose(page.moved_row(0, before), before)
    panel = page.tab.get_by_text("Locality (alpha)", exact=True)
    assert panel.bounding_box()["x"] > 390, "the panel is in the picture's way"
    page.tab.get_by_role("button", name="Panel").tap()
    page.tab.wait_for_function(f"{_PANEL_AT} < 390")
    assert canvas.bounding_box()["width"] == 390
    page.tab.touchscreen.tap(15, 400)
    page.tab.wait_for_function(f"{_PANEL_AT} >= 390")
    page.tab.get_by_role("button", name="Undo").tap()
    page.close()


def _send(page, kind, path):
    page.tab.locator(f"input[data-send={kind}]").set_input_files(path)


def test_files_are_sent(page, folder):
    _send(page, "handles", folder / "broken.vtp")
    page.says("broken.vtp")
    _send(page, "handles", folder / "large.vtp")
    page.says("64 MB")
    _send(page, "handles", folder / "others.csv")
    page.status("2 handles")
    _send(page, "data", folder / "broken.vtp")
    page.says("broken.vtp")
    page.status("2 handles")
    _send(page, "data", folder / "ball.vtp")
    page.says("is shown")
    page.status("27 handles")


def _status_of(address):
    try:
        with urlopen(address) as answer:
            return answer.status
    except HTTPError as error:
        return error.code


def test_nothing_is_served_without_the_token(address):
    start, _, _ = address.partition("?")
    paths = "", "index.html", "picture", "ws", "saved/handles.csv", "vtk_mls_page/picture.js"
    for path in paths:
        assert _status_of(start + path) == 403
        assert _status_of(f"{start}{path}?token=wrong") == 403
    assert _status_of(address) == 200


def test_other_machines_need_the_token(folder):
    arguments = "ball.vtp", "handles.csv", "--host", "0.0.0.0"
    with server(folder, *arguments) as (process, address):
        local_address = re.sub("//.*:", "//127.0.0.1:", address)
        assert "//0.0.0.0" not in address  # where no browser goes
        assert _status_of(local_address) == 200
        assert _status_of(local_address.partition("?")[0]) == 403
        process.terminate()
        assert "`--host 0.0.0.0` lets other machines reach the page" in process.communicate()[1]


def test_a_port_in_use_is_an_error(folder, address, monkeypatch):
    port = address.split(":")[2].partition("/")[0]
    monkeypatch.chdir(folder)
    status, _, stderr = run("view", "ball.vtp", "--port", port)
    assert status == 1
    assert stderr.startswith(f"vtk-mls: `127.0.0.1:{port}` cannot be listened on")
    assert stderr.count("\n") == 1
