"""Nothing is drawn where a cut has opened, by any of VTK's ways to draw an image."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from drawing import Scene, image_of, volume_of
from vtk_fixtures import FAST
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonDataModel import vtkPlane
from vtkmodules.vtkFiltersCore import vtkContourFilter, vtkCutter
from vtkmodules.vtkFiltersGeometry import vtkGeometryFilter
from vtkmodules.vtkRenderingCore import vtkActor, vtkPolyDataMapper
from vtkmodules.vtkRenderingVolume import vtkFixedPointVolumeRayCastMapper

from vtk_mls import HalfPlane
from vtk_mls.filters import MLSDeform
from vtk_mls.vtk.objects import configured, output_of

SIZE, MIDDLE, ZOOM = 41, 20.0, 4  # voxels along an edge, their center, pixels per voxel
OPAQUE = 255


pytestmark = pytest.mark.usefixtures("opengl")


def _ball():
    z, y, x = np.mgrid[:SIZE, :SIZE, :SIZE] - MIDDLE
    values = np.clip(OPAQUE - (np.sqrt(x * x + y * y + z * z) - 15) * 60, 0, OPAQUE)
    return image_of(values.astype(np.uint8))


@cache
def _opened(background):
    """The ball, with a cut from above to below the middle, pulled apart to both sides."""
    rest = np.array([(x, y, z) for x in (12, 28) for y in (12, 28) for z in (8, 32)], float)
    apart = np.where(rest[:, 2] > MIDDLE, 9 * np.sign(rest[:, 0] - MIDDLE), 0)
    deform = configured(MLSDeform(), Device=FAST, InputData=_ball(), Background=background)
    deform.AddCut(HalfPlane((MIDDLE, MIDDLE, 14), (1, 0, 0), (0, 0, 1)))
    return output_of(deform, RestPoints=rest, DeformedPoints=rest + apart[:, None] * (1, 0, 0))


def _surface(image, first=None):
    surface = configured(vtkGeometryFilter(), InputData=image)
    if first is not None:
        first.SetInputData(image)
        surface.SetInputConnection(first.GetOutputPort())
    mapper = configured(vtkPolyDataMapper(), InputConnection=surface.GetOutputPort())
    actor = configured(vtkActor(), Mapper=configured(mapper, ScalarVisibility=False))
    actor.GetProperty().LightingOff()
    return actor


def _contour():
    contour = vtkContourFilter()
    contour.SetValue(0, 128)
    return contour


def _slice():
    plane = configured(vtkPlane(), Origin=(MIDDLE, MIDDLE + 0.3, MIDDLE), Normal=(0, 1, 0))
    return configured(vtkCutter(), CutFunction=plane)


def _lit(prop):
    """Where something is drawn (z, x), seen along y, one value for each voxel."""
    scene = Scene(prop, pixels=SIZE * ZOOM)
    scene.renderer.SetBackground(0, 0, 0)
    camera = scene.renderer.GetActiveCamera()
    configured(camera, ParallelProjection=True, ParallelScale=SIZE / 2)
    configured(camera, FocalPoint=(MIDDLE,) * 3, Position=(MIDDLE, MIDDLE - 100, MIDDLE))
    pixels = scene.picture().reshape(SIZE, ZOOM, SIZE, ZOOM, 3)
    return pixels.max(axis=(1, 3, 4)) > 30


def _gap():
    """Columns along y (z, x) that were in the ball and are void through and through."""
    data = _opened(0).GetPointData()
    distance = vtk_to_numpy(data.GetArray("VoidDistance")).reshape(SIZE, SIZE, SIZE)
    z, x = np.mgrid[:SIZE, :SIZE] - MIDDLE
    return (distance.max(axis=1) < -1.2) & (x * x + z * z < 13**2)


# With what in the void: hidden points and cells are left out even if opaque; contours and
# VTK's fixed-point ray caster do not look at them, and draw the background, which is 0.
DRAWN = {
    "volume": (OPAQUE, volume_of),
    "fixed-point volume": (0, lambda i: volume_of(i, mapper=vtkFixedPointVolumeRayCastMapper())),
    "contour": (0, lambda image: _surface(image, _contour())),
    "slice": (OPAQUE, lambda image: _surface(image, _slice())),
    "surface": (OPAQUE, _surface),
}


@pytest.mark.parametrize("way", DRAWN)
def test_nothing_is_drawn_in_the_void(way):
    background, prop = DRAWN[way]
    gap = _gap()
    assert np.count_nonzero(gap) > 50
    assert _lit(prop(_ball()))[gap].all()  # the picture can show something there
    after = _lit(prop(_opened(background)))
    assert not after[gap].any()
    assert np.count_nonzero(after) > 300
