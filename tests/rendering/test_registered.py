"""A volume and a mesh that are drawn deformed by the same control points stay together."""

from __future__ import annotations

import numpy as np
import pytest
from drawing import MIDDLE, SIZE, Scene, image_of, volume_of
from pipelines import update
from test_deformed_volume import CUTS, REST
from vtk_fixtures import FAST
from vtkmodules.vtkCommonDataModel import vtkPiecewiseFunction
from vtkmodules.vtkFiltersCore import vtkContourFilter
from vtkmodules.vtkRenderingCore import vtkActor, vtkPolyDataMapper

from vtk_mls import Deformation
from vtk_mls.rendering import DeformedMesh, DeformedVolume

pytestmark = pytest.mark.usefixtures("opengl")


def ball():
    z, y, x = np.mgrid[:SIZE, :SIZE, :SIZE] - MIDDLE
    radius = np.sqrt(x * x + y * y + z * z)
    return image_of(np.clip(128 + 60 * (15 - radius), 0, 255).astype(np.uint8))


def covered(scene):
    """Pixels that are not background."""
    empty = Scene(pixels=300).picture()
    return np.abs(scene.picture() - empty).max(axis=2) > 12


def volume_of_ball():
    volume, opacity = volume_of(ball()), vtkPiecewiseFunction()
    for value in (0, 0), (126, 0), (130, 1), (255, 1):
        opacity.AddPoint(*value)
    volume.GetProperty().SetScalarOpacity(opacity)
    volume.GetProperty().SetAmbient(1)
    return volume


def mesh_of_ball():
    contour, mapper, actor = vtkContourFilter(), vtkPolyDataMapper(), vtkActor()
    contour.SetInputData(ball())
    contour.SetValue(0, 128)
    mapper.SetInputData(update(contour))
    mapper.ScalarVisibilityOff()
    actor.SetMapper(mapper)
    actor.GetProperty().SetAmbient(1)
    return actor


@pytest.mark.parametrize("cut", [None, "plane", "half-plane"])
def test_volume_and_mesh_cover_the_same_pixels(cut):
    apart = np.where(REST[:, :1] > MIDDLE, [[9, 2, 0]], [[-6, 0, 3]])
    d = Deformation(REST, REST + apart, cuts=[CUTS[cut]] if cut else [], device=FAST)
    volume, actor = volume_of_ball(), mesh_of_ball()
    first, second = Scene(volume, pixels=300), Scene(actor, pixels=300)
    before = covered(second)
    DeformedVolume(volume, first.renderer).update(d)
    DeformedMesh(actor).update(d)
    of_volume, of_mesh = covered(first), covered(second)
    assert (of_mesh != before).sum() > 0.1 * before.sum()
    assert (of_volume != of_mesh).sum() < 0.015 * of_mesh.sum()
    assert (of_volume != before).sum() > 10 * (of_volume != of_mesh).sum()
