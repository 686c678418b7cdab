"""Tests of the plugin in a real napari window; see `test_napari_plugin`."""

from __future__ import annotations

import os

import dask.array
import napari
import numpy as np
import pytest
import tifffile
from qtpy.QtCore import QPoint, Qt
from qtpy.QtTest import QTest
from qtpy.QtWidgets import QApplication

import vtk_mls
from vtk_mls.napari import deformed_levels

SHAPE = (24, 60, 80)


@pytest.fixture
def viewer():
    viewer = napari.Viewer(show=True)
    yield viewer
    viewer.close()


def checkers(shape=SHAPE):
    return (np.indices(shape) // 8).sum(axis=0) % 2 * np.float32(200) + 20


def opened(viewer):
    """The panel, as napari's menu opens it."""
    _, panel = viewer.window.add_plugin_dock_widget("vtk-mls", "MLS Deform")
    return panel


def with_points(viewer, image, places):
    panel = opened(viewer)
    viewer.add_points(places, name="rest", size=4)
    panel._data.value, panel._rest.value = image, viewer.layers["rest"]
    panel._copy.native.click()
    return panel, viewer.layers["rest moved"]


def pixel(viewer, place):
    """The pixel of the canvas at a place of the shown plane."""
    canvas = viewer.window._qt_viewer.canvas
    center, zoom = np.array(viewer.camera.center[-2:]), viewer.camera.zoom
    size = canvas.native.size()
    x, y = (np.array(place[-2:]) - center)[::-1] * zoom + (size.width() / 2, size.height() / 2)
    return canvas.native, QPoint(round(x), round(y))


def drag(viewer, start, end):
    canvas, first = pixel(viewer, start)
    _, last = pixel(viewer, end)
    QTest.mouseMove(canvas, first)
    QTest.mousePress(canvas, Qt.MouseButton.LeftButton, pos=first)
    shots = []
    for k in range(1, 6):
        QTest.mouseMove(canvas, first + (last - first) * k / 5)
        QTest.qWait(100)
        shots.append(viewer.screenshot(flash=False))
    QTest.mouseRelease(canvas, Qt.MouseButton.LeftButton, pos=last)
    QApplication.processEvents()
    return shots


def test_a_drag_of_the_mouse_changes_the_shown_pixels(viewer):
    image = viewer.add_image(checkers(), scale=(2, 1, 1), contrast_limits=(0, 255))
    places = np.array([(12, 5, 5), (12, 5, 75), (12, 55, 5), (12, 55, 75), (12, 30, 40)], float)
    places[:, 0] *= 2
    panel, moved = with_points(viewer, image, places)
    viewer.dims.set_point(0, 24)
    viewer.reset_view()
    QTest.qWait(500)
    result = panel._deformed
    assert np.array_equal(np.asarray(result.data[12]), image.data[12])
    before = viewer.screenshot(flash=False)
    shots = drag(viewer, (24, 30, 40), (24, 38, 52))
    assert moved.data[4] == pytest.approx((24, 38, 52), abs=1)
    # The picture follows while the button is down.
    changed = [(abs(shot.astype(int) - before) > 30).any(axis=2).mean() for shot in shots]
    assert changed[1] > 0.01
    assert changed[4] > changed[0]
    d = panel.deformation()
    assert np.asarray(result.data[12])[38, 52] == pytest.approx(image.data[12][30, 40], abs=60)
    (expected,) = d.resample([image.data], vtk_mls.Grid(SHAPE[::-1], spacing=(1, 1, 2)))
    assert np.asarray(result.data) == pytest.approx(expected, abs=1e-3)
    if folder := os.environ.get("PICTURES"):
        viewer.screenshot(os.path.join(folder, "napari.png"), canvas_only=False, flash=False)


@pytest.mark.parametrize("is_labels", [False, True])
@pytest.mark.parametrize("shape", [(60, 80), SHAPE])
def test_planes_and_labels(viewer, tmp_path, shape, is_labels):
    values = checkers(shape)
    image = viewer.add_labels(values.astype(int)) if is_labels else viewer.add_image(values)
    rest = np.array([np.array(shape) * f for f in (0.2, 0.5, 0.8)])
    panel, moved = with_points(viewer, image, rest)
    moved.data = rest + 3
    (path,) = panel._deformed.save(str(tmp_path / "deformed.tif"))
    assert np.array_equal(tifffile.imread(path), np.asarray(panel._deformed.data))
    found = np.asarray(panel._deformed.data)
    assert found.shape == values.shape
    assert found.dtype == image.data.dtype
    solid = values if values.ndim == 3 else values[None]
    how = "nearest" if is_labels else "linear"
    sampling = vtk_mls.Sampling(vtk_mls.Grid(solid.shape[::-1]), interpolation=how)
    (expected,) = panel.deformation().resample([solid], sampling)
    assert found.reshape(solid.shape) == pytest.approx(expected)


def test_levels_of_dask_are_lazy(viewer):
    asked = []

    def block(block_info=None):
        place = block_info[None]["array-location"]
        asked.append(place)
        return np.zeros([b - a for a, b in place], np.uint8)

    levels = [
        dask.array.map_blocks(block, chunks=((16,) * (n // 16),) * 3, dtype=np.uint8)
        for n in (512, 256, 64)
    ]
    layer = napari.layers.Image(levels, multiscale=True, contrast_limits=(0, 255))
    asked.clear()
    d = vtk_mls.Deformation([(100, 100, 100)], [(130, 100, 100)])
    results = deformed_levels(layer, d)
    assert [result.shape for result in results] == [level.shape for level in levels]
    assert not asked
    np.asarray(results[0][3])
    assert 0 < len(asked) < 32**3 / 4


@pytest.mark.parametrize("rgb", [False, True])
def test_unsupported_images_are_refused_in_one_sentence(viewer, rgb):
    values = np.zeros((8, 9, 10, 3), np.uint8) if rgb else np.zeros((2, 8, 9, 10))
    layer, d = napari.layers.Image(values, rgb=rgb), vtk_mls.Deformation([(0, 0, 0)], [(1, 0, 0)])
    with pytest.raises(ValueError, match="must have two or three dimensions and no colors"):
        deformed_levels(layer, d)
