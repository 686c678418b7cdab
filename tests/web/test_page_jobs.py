"""The jobs of the documentation on the page, from start to file, by mouse or fingers without a key.

Other programs read the files. Each step leaves a picture in build/web/.
"""

from __future__ import annotations

import subprocess
import sys
import time
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
from command_fixtures import PROJECT
from opened_brain import NAME, OpenedBrain, copy_to, scene_of
from page_mouse import drag
from page_server import server
from test_page import PHONE, Page
from vtkmodules.vtkFiltersVerdict import vtkCellSizeFilter
from vtkmodules.vtkIOXML import vtkXMLPolyDataReader, vtkXMLUnstructuredGridReader
from warped_brain import SUBJECT, Walk, WarpedBrain

from vtk_mls import io
from vtk_mls.editor.distortion import Distortion
from vtk_mls.editor.slices import Slices
from vtk_mls.vtk import arrays
from vtk_mls.vtk.objects import output_of

pytestmark = pytest.mark.matrix
BROWSER_ARGUMENTS = ("--disable-3d-apis",)
_PICTURES = PROJECT / "build" / "web"
_SIZES = {
    "1600x1000": {"viewport": {"width": 1600, "height": 1000}},
    "1000x700": {"viewport": {"width": 1000, "height": 700}},
    "390x780": PHONE,
}
_BONE = 13  # of the frog's labels


class User(Page):
    """Works by the mouse, or by fingers on a phone, and takes a picture after each step."""

    def __init__(self, browser, address, size, job):
        super().__init__(browser, address, **_SIZES[size])
        self.is_phone, self._count = _SIZES[size] is PHONE, 0
        self._name = f"{job}_{size}"
        _PICTURES.mkdir(parents=True, exist_ok=True)
        self.rest()
        self.done("opened")

    def done(self, step):
        self._count += 1
        self.tab.screenshot(path=_PICTURES / f"{self._name}_{self._count}_{step}.png")

    @property
    def size(self):
        """Pixels (width, height) of the picture."""
        box = self.tab.locator("canvas").bounding_box()
        return round(box["width"]), round(box["height"])

    def at(self, pixel):
        """A pixel of the picture, from its upper left corner, in the tab."""
        box = self.tab.locator("canvas").bounding_box()
        return box["x"] + float(pixel[0]), box["y"] + float(pixel[1])

    def click(self, pixel):
        if self.is_phone:
            self.tab.touchscreen.tap(*self.at(pixel))
        else:
            self.tab.mouse.click(*self.at(pixel))
        time.sleep(0.5)  # no double click

    def move(self, start, by):
        """Drag from a pixel of the picture."""
        if self.is_phone:
            self.swipe(np.divide(start, self.size), by)
        else:
            drag(self.tab.mouse, self.at(start), by)

    def deform(self, start, by):
        """Drag a handle, and wait for the final picture of the data that follow."""
        before = self.pixels()
        self.move(start, by)
        self.until(lambda: np.abs(self.pixels() - before).mean() > 1)
        self.rest()
        self.done("dragged")
        assert self.tab.get_by_text("unsaved").is_visible(), "the view is turned instead"

    def push(self, control):
        """Click a control, or tap it."""
        control.tap() if self.is_phone else control.click()

    @contextmanager
    def panel(self):
        """The panel is shown, on a phone for this step only."""
        if self.is_phone:
            self.push(self.tab.get_by_role("button", name="Panel"))
            time.sleep(1)
        yield
        if self.is_phone:
            self.tab.touchscreen.tap(15, 400)
            time.sleep(1)

    def press(self, name):
        """Press a button of the page, or of the panel."""
        button = self.tab.get_by_role("button", name=name, exact=True)
        shown = [one for one in button.all() if one.is_visible() and one.bounding_box()["x"] < 390]
        if shown or not self.is_phone:
            self.push(shown[0] if shown else button.filter(visible=True).first)
        else:
            with self.panel():
                self.push(button.first)
        self.done(name.split(":")[0])

    def handles(self):
        return self.tab.locator(".mls-row").all_text_contents()

    def save(self):
        self.press("Save")
        self.tab.get_by_role("link", name="picture.png").wait_for()
        self.done("saved")
        with self.tab.expect_download() as download:
            self.push(self.tab.get_by_role("link", name="picture.png"))
        assert download.value.path().read_bytes().startswith(b"\x89PNG")
        self.close()


@pytest.fixture(params=_SIZES)
def start(request, browser, tmp_path):
    """Starts a `User` of a size with arguments of the command in tmp_path."""
    job = request.function.__name__.removeprefix("test_")
    servers = []

    def start(*arguments):
        servers.append(server(tmp_path, *arguments, "--output", "saved"))
        _, address = servers[-1].__enter__()
        return User(browser, address, request.param, job)

    yield start
    for running in servers:
        running.__exit__(None, None, None)


def _image_in(path):
    """An image that SimpleITK reads: (nz, ny, nx)."""
    import SimpleITK as sitk

    return sitk.GetArrayFromImage(sitk.ReadImage(str(path)))


def test_a_brain_is_cut_open(start, tmp_path):
    copy_to(tmp_path)
    user = start(NAME)
    brain, (width, height) = OpenedBrain(tmp_path, user.size), user.size
    user.press("Half-plane")
    user.says("The blue sheet cuts up to its red edge")
    user.press("Select several handles (Ctrl)")
    user.move((0.5 * width, 0.1 * height), (0.48 * width, 0.8 * height))
    user.tab.locator(".mls-status", has_text="selected").wait_for(state="attached")
    user.press("Select several handles (Ctrl)")
    user.deform(np.multiply(brain.grabbed, user.size), (0.15 * width, 0.02 * height))
    user.save()
    brain.check(tmp_path / "saved")
    before, after = (_image_in(tmp_path / name) for name in (NAME, "saved/brain-deformed.nii.gz"))
    assert before.shape == after.shape
    assert (before != after).mean() > 0.05


def test_a_brain_is_matched_by_five_pairs(start, tmp_path):
    brain = WarpedBrain(tmp_path)
    user = start(NAME, "--target", SUBJECT)
    was_click = False
    for name, first, *more in Walk(brain, user.size, user.size[0] < 600).actions():
        before = user.handles()
        if name == "pane":
            user.press(first.capitalize())
        elif name == "click":
            user.click(first)
        else:
            user.move(first, *more)
        if name == "click" or was_click:  # it places a landmark, or corrects it
            user.until(lambda before=before: user.handles() != before)
        was_click = name == "click"
        user.rest()
        user.done(name)
    assert len(user.handles()) == 5
    user.press("Refine all")
    user.says("landmarks are refined")
    user.rest()
    user.done("refined")
    user.press("Fade")
    user.rest()
    user.done("faded")
    user.save()
    brain.check(tmp_path / "saved")
    matched, subject = (_image_in(tmp_path / x) for x in ("saved/brain-deformed.nii.gz", SUBJECT))
    assert matched.shape == subject.shape


@pytest.fixture
def frog(tmp_path):
    """The segmented frog of PyVista, coarse enough for software that draws."""
    import pyvista as pv

    frog = pv.examples.load_frog_tissues().resample(0.25)
    io.write_dataset(frog, tmp_path / "frog.seg.nrrd")
    return frog


def test_a_bone_is_posed(start, tmp_path, frog):
    user = start("frog.seg.nrrd")
    scene = scene_of(tmp_path / "frog.seg.nrrd", user.size)
    bones = frog.label_connectivity(scalar_range=(_BONE, _BONE))[0]
    bone = frog.points[bones.active_scalars == 3]  # a shin
    user.press("Make rigid: click on a mesh or label")
    user.click(_from_above(_seen_pixel(scene, bone), user.size)[0])
    user.tab.locator(".mls-status", has_text="1 rigid").wait_for(state="attached")
    user.rest()
    user.done("rigid")
    middle = (bone.min(axis=0) + bone.max(axis=0)) / 2
    (middle,) = _from_above(scene.projection.pixels(middle[None]), user.size)
    user.deform(middle, (0.05 * user.size[0], 0.08 * user.size[1]))
    user.deform(middle + (0.05 * user.size[0] + 14, 0.08 * user.size[1]), (30, 20))  # a turn
    user.save()
    labels = frog.active_scalars.reshape(frog.dimensions[::-1])
    posed = _image_in(tmp_path / "saved" / "frog-deformed.seg.nrrd")
    before, after = (np.count_nonzero(x == _BONE) for x in (labels, posed))
    assert 0.8 < after / before < 1.2
    assert (posed != labels).mean() > 0.01
    region = output_of(vtkXMLPolyDataReader(), FileName=str(tmp_path / "saved/handles.vtp"))
    corners = np.unique(arrays.to_numpy(region.GetPolys().GetConnectivityArray()))
    rest = arrays.to_numpy(region.GetPoints().GetData())[corners]
    for expected, found in (
        (bone.min(axis=0), rest.min(axis=0)),
        (bone.max(axis=0), rest.max(axis=0)),
    ):
        np.testing.assert_allclose(found, expected, atol=5)


def test_a_cord_is_straightened(start, tmp_path, frog):
    labels = frog.active_scalars.reshape(frog.dimensions[::-1])
    cord = np.argwhere(labels == 12)[:, ::-1] * frog.spacing + frog.origin
    cord = cord[abs(cord[:, 1] - 229) < 10]
    bins = np.digitize(cord[:, 0], np.linspace(110, 380, 8))
    nodes = np.array([np.median(cord[bins == i], axis=0) for i in range(1, 8)])
    user = start("frog.seg.nrrd")
    user.press("Select all")
    user.press("Delete")
    user.press("Axial")
    scene = scene_of(tmp_path / "frog.seg.nrrd", user.size)
    first, last = _in_slice(scene, "axial", np.array([nodes[0] + (0, 40, 0), nodes[3]]), user.size)
    user.move(first, last - first)
    user.press("Coronal")
    user.rest()
    user.done("coronal")
    user.press("Draw a curve")
    for pixel in _in_slice(scene, "coronal", nodes, user.size):
        user.click(pixel)
    user.rest()
    user.done("drawn")
    user.press("End the curve")
    user.press("Straighten the curve")
    user.says("Straightened")
    user.rest()
    user.done("straight")
    user.save()
    curve = output_of(vtkXMLPolyDataReader(), FileName=str(tmp_path / "saved/handles.vtp"))
    assert curve.GetNumberOfLines() == 1
    rest = arrays.to_numpy(curve.GetPoints().GetData())
    step = arrays.to_numpy(curve.GetPointData().GetArray("Displacement"))
    np.testing.assert_allclose(rest[:, [0, 2]], nodes[:, [0, 2]], atol=4)
    _, sizes, _ = np.linalg.svd(rest + step - (rest + step).mean(axis=0))
    assert sizes[1] < 1e-3 * sizes[0]
    straight = _image_in(tmp_path / "saved" / "frog-deformed.seg.nrrd")
    assert (straight != labels).mean() > 0.01


def test_a_mesh_is_morphed(start, tmp_path):
    import pyvista as pv

    box = pv.ImageData(dimensions=(15, 15, 15)).to_tetrahedra(5)
    surface = box.extract_surface(algorithm="dataset_surface")
    boundary = pv.PolyData(surface.points[::3].astype(float))
    x, _, z = boundary.points.T
    wave = np.column_stack([0 * x, 0 * x, np.sin(x / 4) * (z > 13.5)])
    boundary["Displacement"] = wave
    box.save(tmp_path / "part.vtu")
    boundary.save(tmp_path / "boundary.vtp")
    user = start("part.vtu")
    with user.panel():
        with user.tab.expect_file_chooser() as chooser:
            user.push(user.tab.get_by_role("button", name="Open handles ..."))
        chooser.value.set_files(tmp_path / "boundary.vtp")
        user.says("boundary.vtp is shown")
        user.push(user.tab.locator(".v-select", has_text="Kind"))
        user.push(user.tab.get_by_role("option", name="affine"))
    user.tab.locator(".mls-status", has_text="affine").wait_for(state="attached")
    user.rest()
    user.done("morphed")
    user.save()
    path = str(tmp_path / "saved" / "part-deformed.vtu")
    morphed = output_of(vtkXMLUnstructuredGridReader(), FileName=path)
    moved = arrays.to_numpy(morphed.GetPoints().GetData())
    rows = [box.find_closest_point(point) for point in boundary.points]
    np.testing.assert_allclose(moved[rows], boundary.points + wave, atol=0.02)
    grown = _volumes(morphed) / _volumes(box)
    assert 0.6 < grown.min() < grown.max() < 2.2


def _volumes(mesh):
    sizes = output_of(vtkCellSizeFilter(), InputData=mesh)
    return arrays.to_numpy(sizes.GetCellData().GetArray("Volume"))


def test_a_large_image_is_deformed_in_all_resolutions(start, tmp_path):
    zarr = pytest.importorskip("zarr")
    pytest.importorskip("ngff_zarr")
    copy_to(tmp_path)
    convert = [Path(sys.executable).with_name("ngff-zarr"), "-i", NAME, "-o", "brain.ome.zarr"]
    convert += ["-c", "64"]  # or there is one resolution
    subprocess.run(convert, cwd=tmp_path, check=True, capture_output=True)
    user = start("brain.ome.zarr")
    brain = OpenedBrain(tmp_path, user.size)
    user.deform(np.multiply(brain.grabbed, user.size), (0.15 * user.size[0], 0))
    user.save()
    paths = tmp_path / "brain.ome.zarr", tmp_path / "saved" / "brain-deformed.ome.zarr"
    before, after = ([*zarr.open_group(path, mode="r").arrays()] for path in paths)
    assert [name for name, _ in before] == [name for name, _ in after]
    assert [array.shape for _, array in before] == [array.shape for _, array in after]
    for (_, old), (_, new) in zip(before, after):
        assert np.abs(old[:] - new[:]).max() > 0.2 * old[:].max()


def _in_slice(scene, pane, points, size):
    """Pixels (n, 2) of points (n, 3) in a slice that is shown alone."""
    slices = Slices(scene, Distortion(scene.bounds))
    slices.set_pane(pane)
    slices.show(True)
    scene.window.Render()
    (shown,) = slices._visible_panes
    return _from_above(shown.projection.pixels(points), size)


def _seen_pixel(scene, bone):
    """A pixel (1, 2) where a bone with voxels at points (n, 3) is seen."""
    box = bone.min(axis=0), bone.max(axis=0)
    pixels = scene.projection.pixels(bone)
    for pixel in np.rint(pixels[pixels[:, 2].argsort(), :2]):
        hit = scene.items[0].rigid_hit(*scene.projection.ray(pixel))
        if hit and np.allclose(hit[1]().bounds, box, atol=4):
            return pixel[None]
    raise AssertionError("the bone is hidden")


def _from_above(pixels, size):
    return np.column_stack([pixels[:, 0], size[1] - 1 - pixels[:, 1]])
