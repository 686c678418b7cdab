"""VTK's messages while volumes are drawn for the first time: none is lost, none comes twice."""

from __future__ import annotations

import numpy as np
import pytest
from drawing import Scene, image_of, volume_of
from test_deformed_volume import VALUES, deformation
from vtkmodules.vtkCommonCore import vtkOutputWindow

from vtk_mls.rendering import DeformedVolume, shader

pytestmark = pytest.mark.usefixtures("opengl")


def some_volumes():
    """A scene, and three volumes in it that will be drawn deformed."""
    volumes = [volume_of(image_of(VALUES)) for _ in range(3)]
    scene = Scene(*volumes)
    return scene, [DeformedVolume(volume, scene.renderer) for volume in volumes]


def say(*_):
    vtkOutputWindow.GetInstance().DisplayText("by the way")


def test_new_volumes_in_one_picture(messages):
    scene, every = some_volumes()
    for drawn in every:
        drawn.update(deformation())
    scene.renderer.AddObserver("StartEvent", say, -1)
    usual = vtkOutputWindow.GetInstance()
    scene.picture()
    assert vtkOutputWindow.GetInstance() is usual
    messages.assert_one("^by the way$")
    say()
    messages.assert_one("^by the way$")


def test_a_volume_that_is_detached_while_it_is_drawn(messages):
    scene, (drawn, *_) = some_volumes()
    drawn.update(deformation())
    scene.renderer.AddObserver("StartEvent", say, -1)
    scene.renderer.AddObserver("StartEvent", lambda *_: drawn.detach(), -2)
    usual = vtkOutputWindow.GetInstance()
    scene.picture()
    assert vtkOutputWindow.GetInstance() is usual
    messages.assert_one("^by the way$")


def test_shaders_that_do_not_build(monkeypatch, messages):
    scene, every = some_volumes()
    before = scene.picture()
    monkeypatch.setitem(shader._REPLACEMENTS, "//VTK::Cropping::Impl", "not GLSL;\n{tag}")
    for drawn in every:
        drawn.update(deformation())
    scene.picture()
    said = messages.take().splitlines()
    assert [line for line in said if line.strip()] == [f"DeformedVolume: {every[0].failure}"] * 3
    np.testing.assert_array_equal(scene.picture(), before)
