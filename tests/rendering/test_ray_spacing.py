"""Pictures during movement have fewer rays and the same colors."""

from __future__ import annotations

import numpy as np
import pytest
from drawing import Scene, drawn_volume, image_of, phantom, volume_of
from test_deformed_volume import deformation
from vtkmodules.vtkRenderingVolumeOpenGL2 import vtkSmartVolumeMapper

from vtk_mls.rendering import pace
from vtk_mls.rendering.pace import adjust_rays, usual_step
from vtk_mls.vtk.objects import configured

pytestmark = pytest.mark.usefixtures("opengl")


def blurred(picture, size=6):
    """Means of squares of pixels."""
    height, width, _ = picture.shape
    squares = picture.reshape(height // size, size, width // size, size, 3)
    return squares.mean(axis=(1, 3))


def test_pictures_during_movement_have_fewer_rays_and_the_same_colors(monkeypatch):
    volume, scene, drawn = drawn_volume(image_of(phantom()))
    mapper = volume.GetMapper()
    drawn.update(deformation())
    resting = scene.picture()
    monkeypatch.setattr(pace, "_PICTURE_SECONDS", mapper.GetTimeToDraw() / 6)
    scene.window.SetDesiredUpdateRate(15)
    adjust_rays(mapper, scene.window)
    assert mapper.GetImageSampleDistance() == 3  # at least 6 times fewer
    moving = scene.picture()
    assert np.abs(moving - resting).mean() > 0.1
    assert np.abs(blurred(moving) - blurred(resting)).mean() < 1
    monkeypatch.setattr(pace, "_PICTURE_SECONDS", 1e-6)
    adjust_rays(mapper, scene.window)
    assert mapper.GetImageSampleDistance() == 4
    scene.window.SetDesiredUpdateRate(1e-4)
    adjust_rays(mapper, scene.window)
    np.testing.assert_array_equal(scene.picture(), resting)


def test_the_first_picture_during_movement_has_few_rays():
    volume = volume_of(image_of(phantom()))
    scene = Scene(volume)
    scene.window.SetDesiredUpdateRate(15)
    adjust_rays(volume.GetMapper(), scene.window)
    assert volume.GetMapper().GetImageSampleDistance() == 4


@pytest.mark.parametrize("size", [30, 120])
def test_steps_are_those_of_the_smart_mapper(size):
    image = configured(image_of(phantom(size)), Spacing=(1, 2, 0.6))
    mapper = configured(vtkSmartVolumeMapper(), InteractiveAdjustSampleDistances=False)
    mapper.SetRequestedRenderModeToGPU()
    volume = volume_of(image, mapper=mapper)
    mapper.SetSampleDistance(-1)  # automatic
    expected = Scene(volume).picture()
    other = volume_of(image)
    other.GetMapper().SetSampleDistance(usual_step(image))
    other.SetProperty(volume.GetProperty())
    np.testing.assert_array_equal(Scene(other).picture(), expected)
    other.GetMapper().SetSampleDistance(1.01 * usual_step(image))
    assert not np.array_equal(Scene(other).picture(), expected)
