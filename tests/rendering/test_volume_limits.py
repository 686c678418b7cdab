"""Volumes that cannot be drawn deformed: one error each, and no change."""

from __future__ import annotations

import gc
import weakref

import numpy as np
import pytest
from drawing import Scene, drawn_volume, image_of, volume_of
from test_deformed_volume import VALUES, deformation
from vtkmodules.vtkCommonCore import vtkOutputWindow
from vtkmodules.vtkRenderingCore import vtkVolume
from vtkmodules.vtkRenderingVolume import vtkGPUVolumeRayCastMapper
from vtkmodules.vtkRenderingVolumeOpenGL2 import vtkSmartVolumeMapper

from vtk_mls.engine.device.devices import DeviceError
from vtk_mls.rendering import (
    DeformedVolume,
    RenderingError,
    deformed_volume,
    shader,
)
from vtk_mls.vtk.objects import configured

pytestmark = pytest.mark.usefixtures("opengl")


def smart_mapper():
    return configured(vtkSmartVolumeMapper(), InteractiveAdjustSampleDistances=False)


def assert_refused(drawn, scene, before, messages, reason):
    """The next picture reports the reason once; pictures are as before."""
    scene.picture()
    messages.assert_one(f"^DeformedVolume: {reason}.*; it is drawn undeformed$")
    np.testing.assert_array_equal(scene.picture(), before)
    with pytest.raises(RenderingError, match=reason):
        drawn.update(deformation())


def test_a_volume_has_one_deformed_volume():
    volume = volume_of(image_of(VALUES))
    scene, other = Scene(volume), Scene(volume)
    before = scene.picture()
    first, second = (DeformedVolume(volume, view.renderer) for view in (scene, other))
    first.update(deformation())
    deformed = scene.picture()
    refused = "`volume` is drawn deformed already; update or detach that one"
    with pytest.raises(ValueError, match=refused):
        second.update(deformation())
    with pytest.raises(ValueError, match=refused):
        DeformedVolume(volume, scene.renderer)
    second.detach()  # it has drawn nothing
    np.testing.assert_array_equal(scene.picture(), deformed)
    first.detach()
    np.testing.assert_array_equal(scene.picture(), before)
    second.update(deformation())
    np.testing.assert_array_equal(other.picture(), deformed)


def test_a_mapper_that_two_volumes_share(messages):
    volume, twin = volume_of(image_of(VALUES)), vtkVolume()
    twin.SetMapper(volume.GetMapper())
    twin.SetProperty(volume.GetProperty())
    twin.SetPosition(20, 0, 0)
    both, alone = Scene(volume, twin), Scene(volume)
    before = both.picture()
    reason = "`volume` shares its mapper with another vtkVolume"
    with pytest.raises(ValueError, match=f"{reason}.*; give each a mapper of its own"):
        DeformedVolume(volume, both.renderer).update(deformation())
    np.testing.assert_array_equal(both.picture(), before)
    drawn = DeformedVolume(volume, alone.renderer)
    drawn.update(deformation())
    alone.picture()
    with pytest.raises(ValueError, match=reason):  # in another window, too
        DeformedVolume(twin, Scene(twin).renderer).update(deformation())
    alone.renderer.AddViewProp(twin)
    assert_refused(drawn, alone, before, messages, reason)


@pytest.mark.parametrize("mode", ["RayCast", "OSPRay"])
def test_a_smart_mapper_without_the_graphics_card(mode, messages):
    mapper, mode = smart_mapper(), f"{mode}RenderMode"
    volume, scene, drawn = drawn_volume(image_of(VALUES), mapper=mapper)
    mapper.SetRequestedRenderMode(getattr(mapper, mode))
    reason = f"the mapper of `volume` must draw on the graphics card, got {mode}; call its Set.*GPU"
    with pytest.raises(ValueError, match=reason):
        DeformedVolume(volume, scene.renderer)
    with pytest.raises(ValueError, match=reason):
        drawn.update(deformation())
    mapper.SetRequestedRenderModeToGPU()
    drawn.update(deformation())
    scene.picture()
    mapper.SetRequestedRenderMode(getattr(mapper, mode))
    usual = configured(smart_mapper(), RequestedRenderMode=getattr(mapper, mode))
    before = Scene(volume_of(image_of(VALUES), mapper=usual)).picture()
    assert_refused(drawn, scene, before, messages, reason)


@pytest.mark.parametrize("is_smart", [False, True])
def test_a_window_without_graphics_card(is_smart, monkeypatch, messages):
    class Unsupported(vtkGPUVolumeRayCastMapper):
        def IsRenderSupported(self, window, looks):
            return 0

    if is_smart:
        monkeypatch.setattr(deformed_volume, "vtkGPUVolumeRayCastMapper", Unsupported)
    _, scene, drawn = drawn_volume(
        image_of(VALUES), mapper=smart_mapper() if is_smart else Unsupported()
    )
    before = scene.picture()
    drawn.update(deformation())
    reason = "`volume` must be drawn on the graphics card, which VTK cannot do in this window"
    assert_refused(drawn, scene, before, messages, reason)


@pytest.mark.parametrize("error", [DeviceError("the device is gone"), MemoryError()])
def test_an_error_of_the_map_after_a_change_of_the_data(error, monkeypatch, messages):
    volume, scene, drawn = drawn_volume(image_of(VALUES))
    drawn.update(deformation())
    scene.picture()

    def fail(*_):
        raise error

    monkeypatch.setattr(deformed_volume, "layers", fail)
    volume.GetMapper().SetInputData(image_of(255 - VALUES))
    before = Scene(volume_of(image_of(255 - VALUES))).picture()
    assert_refused(drawn, scene, before, messages, str(error) or "there is not enough memory")


def test_the_graphics_card_has_no_texture(monkeypatch, messages):
    class Refusing(shader.vtkTextureObject):
        def Create3DFromRaw(self, *_):
            return False

    monkeypatch.setattr(shader, "vtkTextureObject", Refusing)
    _, scene, drawn = drawn_volume(image_of(VALUES))
    before = scene.picture()
    drawn.update(deformation())
    reason = r"the graphics driver has no 3-D texture of \d+ x \d+ x \d+ points with four floats"
    assert_refused(drawn, scene, before, messages, reason)


def test_a_collected_volume_reports_nothing(capfd):
    """Python's collector clears the object, and VTK still calls its observers."""
    _, scene, drawn = drawn_volume(image_of(VALUES))
    window = scene.window
    drawn.update(deformation())
    scene.picture()
    alive = weakref.ref(drawn)
    del drawn, scene
    gc.collect()
    assert alive() is None
    window.Render()
    assert "Traceback" not in capfd.readouterr().err


def test_a_shader_error_after_the_first_picture(monkeypatch, messages):
    volume, scene, drawn = drawn_volume(image_of(VALUES), Shade=False)
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


# Messages of VTK while it draws the first volume. VTK reports each of them once.


def three_volumes():
    volumes = [volume_of(image_of(VALUES)) for _ in range(3)]
    scene = Scene(*volumes)
    return scene, [DeformedVolume(volume, scene.renderer) for volume in volumes]


def report(*_):
    vtkOutputWindow.GetInstance().DisplayText("by the way")


@pytest.mark.parametrize("is_detached", [False, True])
def test_new_volumes_in_one_picture(is_detached, messages):
    """They are drawn, or the only one is detached meanwhile."""
    scene, volumes = three_volumes()
    for drawn in volumes[: 1 if is_detached else 3]:
        drawn.update(deformation())
    scene.renderer.AddObserver("StartEvent", report, -1)
    if is_detached:
        scene.renderer.AddObserver("StartEvent", lambda *_: drawn.detach(), -2)
    usual = vtkOutputWindow.GetInstance()
    scene.picture()
    assert vtkOutputWindow.GetInstance() is usual
    messages.assert_one("^by the way$")
    report()
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
