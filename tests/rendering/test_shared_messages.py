"""Each of VTK's messages during the first picture of volumes is reported once."""

from __future__ import annotations

import numpy as np
import pytest
from drawing import Scene, image_of, volume_of
from test_deformed_volume import VALUES, deformation
from vtkmodules.vtkCommonCore import vtkOutputWindow

from vtk_mls.rendering import DeformedVolume, shader

pytestmark = pytest.mark.usefixtures("opengl")


def three_volumes():
    """A scene, and the DeformedVolumes of three volumes in it."""
    volumes = [volume_of(image_of(VALUES)) for _ in range(3)]
    scene = Scene(*volumes)
    return scene, [DeformedVolume(volume, scene.renderer) for volume in volumes]


def report(*_):
    vtkOutputWindow.GetInstance().DisplayText("by the way")


def test_new_volumes_in_one_picture(messages):
    scene, volumes = three_volumes()
    for drawn in volumes:
        drawn.update(deformation())
    scene.renderer.AddObserver("StartEvent", report, -1)
    usual = vtkOutputWindow.GetInstance()
    scene.picture()
    assert vtkOutputWindow.GetInstance() is usual
    messages.assert_one("^by the way$")
    report()
    messages.assert_one("^by the way$")


def test_a_volume_that_is_detached_while_it_is_drawn(messages):
    scene, (drawn, *_) = three_volumes()
    drawn.update(deformation())
    scene.renderer.AddObserver("StartEvent", report, -1)
    scene.renderer.AddObserver("StartEvent", lambda *_: drawn.detach(), -2)
    usual = vtkOutputWindow.GetInstance()
    scene.picture()
    assert vtkOutputWindow.GetInstance() is usual
    messages.assert_one("^by the way$")


def test_shaders_that_do_not_build(monkeypatch, messages):
    scene, volumes = three_volumes()
    before = scene.picture()
    monkeypatch.setitem(shader._REPLACEMENTS, "//VTK::Cropping::Impl", "not GLSL;\n{tag}")
    for drawn in volumes:
        drawn.update(deformation())
    scene.picture()
    lines = messages.take().splitlines()
    assert [line for line in lines if line.strip()] == [f"DeformedVolume: {volumes[0].failure}"] * 3
    np.testing.assert_array_equal(scene.picture(), before)
