"""What cannot be drawn deformed is refused in a sentence, and stays as it was."""

from __future__ import annotations

import numpy as np
import pytest
from drawing import Scene, image_of, volume_of
from test_deformed_volume import VALUES, deformation
from vtk_fixtures import messages, opengl  # noqa: F401  (fixtures)
from vtkmodules.vtkRenderingVolume import vtkGPUVolumeRayCastMapper
from vtkmodules.vtkRenderingVolumeOpenGL2 import vtkSmartVolumeMapper

from vtk_mls.rendering import DeformedVolume, RenderingError, deformed_volume

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
    first, second = (DeformedVolume(volume, each.renderer) for each in (scene, other))
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
        monkeypatch.setattr(deformed_volume, "vtkGPUVolumeRayCastMapper", Unsupported)
    volume = volume_of(image_of(VALUES), mapper=smart_mapper() if is_smart else Unsupported())
    scene = Scene(volume)
    before = scene.picture()
    drawn = DeformedVolume(volume, scene.renderer)
    drawn.update(deformation())
    why = "`volume` must be drawn on the graphics card, which VTK cannot do in this window"
    assert_refused(drawn, scene, before, messages, why)
