"""What cannot be drawn deformed is refused in a sentence, and stays as it was."""

from __future__ import annotations

import gc
import weakref

import numpy as np
import pytest
from drawing import Scene, assert_alike, image_of, volume_of
from test_deformed_volume import VALUES, deformation, resampled
from vtkmodules.vtkRenderingCore import vtkVolume
from vtkmodules.vtkRenderingVolume import vtkGPUVolumeRayCastMapper
from vtkmodules.vtkRenderingVolumeOpenGL2 import vtkSmartVolumeMapper

from vtk_mls.engine.device.devices import DeviceError
from vtk_mls.rendering import (
    DeformedVolume,
    RenderingError,
    deformed_volume,
    shader,
    volume_checks,
)

pytestmark = pytest.mark.usefixtures("opengl")


def smart_mapper():
    mapper = vtkSmartVolumeMapper()
    mapper.InteractiveAdjustSampleDistancesOff()
    return mapper


def assert_refused(drawn, scene, before, messages, why):
    """The next picture says why, once, and those after it are as before."""
    scene.picture()
    messages.assert_one(f"^DeformedVolume: {why}.*; it is drawn undeformed$")
    np.testing.assert_array_equal(scene.picture(), before)
    with pytest.raises(RenderingError, match=why):
        drawn.update(deformation())


def test_a_volume_is_deformed_by_one_only():
    volume = volume_of(image_of(VALUES))
    scene, other = Scene(volume), Scene(volume)
    before = scene.picture()
    first, second = (DeformedVolume(volume, view.renderer) for view in (scene, other))
    first.update(deformation())
    shown = scene.picture()
    refused = "`volume` is drawn deformed already; update or detach that one"
    with pytest.raises(ValueError, match=refused):
        second.update(deformation())
    with pytest.raises(ValueError, match=refused):
        DeformedVolume(volume, scene.renderer)
    second.detach()  # which had nothing to give back
    np.testing.assert_array_equal(scene.picture(), shown)
    first.detach()
    np.testing.assert_array_equal(scene.picture(), before)
    second.update(deformation())
    np.testing.assert_array_equal(other.picture(), shown)


def test_a_mapper_that_two_volumes_share(messages):
    volume, twin = volume_of(image_of(VALUES)), vtkVolume()
    twin.SetMapper(volume.GetMapper())
    twin.SetProperty(volume.GetProperty())
    twin.SetPosition(20, 0, 0)
    both, alone = Scene(volume, twin), Scene(volume)
    before = both.picture()
    why = "`volume` shares its mapper with another vtkVolume"
    with pytest.raises(ValueError, match=f"{why}.*; give each a mapper of its own"):
        DeformedVolume(volume, both.renderer).update(deformation())
    np.testing.assert_array_equal(both.picture(), before)
    drawn = DeformedVolume(volume, alone.renderer)
    drawn.update(deformation())
    alone.picture()
    with pytest.raises(ValueError, match=why):  # though it is in another window
        DeformedVolume(twin, Scene(twin).renderer).update(deformation())
    alone.renderer.AddViewProp(twin)
    assert_refused(drawn, alone, before, messages, why)


@pytest.mark.parametrize("mode", ["RayCast", "OSPRay"])
def test_a_smart_mapper_that_is_not_to_use_the_graphics_card(mode, messages):
    volume = volume_of(image_of(VALUES), mapper=smart_mapper())
    mapper, scene = volume.GetMapper(), Scene(volume)
    mode = f"{mode}RenderMode"
    drawn = DeformedVolume(volume, scene.renderer)
    mapper.SetRequestedRenderMode(getattr(mapper, mode))
    why = f"the mapper of `volume` must draw on the graphics card, got {mode}; call its SetReq.*GPU"
    with pytest.raises(ValueError, match=why):
        DeformedVolume(volume, scene.renderer)
    with pytest.raises(ValueError, match=why):
        drawn.update(deformation())
    mapper.SetRequestedRenderModeToGPU()
    drawn.update(deformation())
    scene.picture()
    mapper.SetRequestedRenderMode(getattr(mapper, mode))
    before = Scene(volume_of(image_of(VALUES), mapper=as_requested(mode))).picture()
    assert_refused(drawn, scene, before, messages, why)


def as_requested(mode):
    mapper = smart_mapper()
    mapper.SetRequestedRenderMode(getattr(mapper, mode))
    return mapper


@pytest.mark.parametrize("is_smart", [False, True])
def test_a_window_without_graphics_card(is_smart, monkeypatch, messages):
    class Unsupported(vtkGPUVolumeRayCastMapper):
        def IsRenderSupported(self, window, looks):
            return 0

    if is_smart:
        monkeypatch.setattr(volume_checks, "vtkGPUVolumeRayCastMapper", Unsupported)
    volume = volume_of(image_of(VALUES), mapper=smart_mapper() if is_smart else Unsupported())
    scene = Scene(volume)
    before = scene.picture()
    drawn = DeformedVolume(volume, scene.renderer)
    drawn.update(deformation())
    why = "`volume` must be drawn on the graphics card, which VTK cannot do in this window"
    assert_refused(drawn, scene, before, messages, why)


@pytest.mark.parametrize("error", [DeviceError("the device is gone"), MemoryError()])
def test_a_map_that_cannot_be_made_when_the_data_change(error, monkeypatch, messages):
    volume = volume_of(image_of(VALUES))
    scene = Scene(volume)
    drawn = DeformedVolume(volume, scene.renderer)
    drawn.update(deformation())
    scene.picture()

    def fail(*_):
        raise error

    monkeypatch.setattr(deformed_volume, "layers", fail)
    volume.GetMapper().SetInputData(image_of(255 - VALUES))
    before = Scene(volume_of(image_of(255 - VALUES))).picture()
    assert_refused(drawn, scene, before, messages, str(error) or "there is not enough memory")


def test_a_texture_that_the_graphics_card_refuses(monkeypatch, messages):
    class Refusing(shader.vtkTextureObject):
        def Create3DFromRaw(self, *_):
            return False

    monkeypatch.setattr(shader, "vtkTextureObject", Refusing)
    volume = volume_of(image_of(VALUES))
    scene = Scene(volume)
    before = scene.picture()
    drawn = DeformedVolume(volume, scene.renderer)
    drawn.update(deformation())
    why = r"the graphics driver has no 3-D texture of \d+ x \d+ x \d+ points with four floats"
    assert_refused(drawn, scene, before, messages, why)


def test_a_box_that_grows_too_often_has_its_own_map(monkeypatch):
    monkeypatch.setattr(deformed_volume, "_MAX_GROWTHS", 1)
    volume, d = volume_of(image_of(VALUES)), deformation(right=(25, 2, 0))
    scene = Scene(volume)
    DeformedVolume(volume, scene.renderer).update(d)
    assert_alike(scene.picture(), Scene(volume_of(resampled(d))).picture())


def test_what_nobody_holds_says_nothing(capfd):
    """Python's collector empties what only VTK's observers hold, and VTK calls it still."""
    volume = volume_of(image_of(VALUES))
    scene = Scene(volume)
    window, drawn = scene.window, DeformedVolume(volume, scene.renderer)
    drawn.update(deformation())
    scene.picture()
    alive = weakref.ref(drawn)
    del drawn, scene
    gc.collect()
    assert alive() is None
    window.Render()
    assert "Traceback" not in capfd.readouterr().err


def test_a_shader_that_does_not_build_later(monkeypatch, messages):
    volume = volume_of(image_of(VALUES), Shade=False)
    scene = Scene(volume)
    drawn = DeformedVolume(volume, scene.renderer)
    drawn.update(deformation())
    scene.picture()
    shader = volume.GetShaderProperty()
    tag = "//VTK::Clipping::Impl"
    shader.AddFragmentShaderReplacement(tag, True, "not GLSL;", False)
    volume.GetProperty().ShadeOn()
    scene.picture()
    messages.assert_one("DeformedVolume: the graphics driver does not build the shader")
    shader.ClearFragmentShaderReplacement(tag, True)
    before = Scene(volume_of(image_of(VALUES))).picture()
    np.testing.assert_array_equal(scene.picture(), before)
