"""The visible surface of meshes, volumes and deformed volumes."""

import numpy as np
import pytest
from drawing import MIDDLE, PIXELS, SIZE, Scene, image_of, volume_of
from pipelines import ball
from vtkmodules.vtkRenderingCore import vtkActor, vtkPolyDataMapper

from vtk_mls import Deformation, Grid
from vtk_mls.rendering import DeformedVolume
from vtk_mls.rendering.surfaces import VisibleSurface
from vtk_mls.vtk.objects import configured

pytestmark = pytest.mark.usefixtures("opengl")
CENTER = np.full(3, MIDDLE)
SHIFT = np.array((6.0, 0, 3))
BALL_PIXELS = [(PIXELS // 2 + dx, PIXELS // 2 + dy) for dx in (-12, 0, 9) for dy in (-9, 0, 12)]


def ball_actor(radius):
    mapper = configured(vtkPolyDataMapper(), InputData=ball(CENTER, radius, 120))
    return configured(vtkActor(), Mapper=mapper)


def solid(radius, grid=None):
    """A volume that is opaque from a distance to the center of the image on."""
    grid = grid or Grid((SIZE,) * 3)
    distance = np.linalg.norm(grid.points() - grid.at([(MIDDLE,) * 3]), axis=1) / grid.spacing[0]
    values = np.clip(30 + 60 * (radius - distance), 0, 255)
    volume = volume_of(image_of(values.reshape(grid.shape).astype(np.uint8)[..., None], grid))
    volume.GetProperty().SetScalarOpacityUnitDistance(0.05)
    return volume


def surface_of(scene):
    """What is visible in the next picture."""
    scene.picture()
    return VisibleSurface(scene.renderer)


def distances(surface, center=CENTER):
    found = [surface.at(*pixel) for pixel in BALL_PIXELS]
    return np.linalg.norm(np.array(found) - center, axis=1)


@pytest.mark.parametrize("parallel", [False, True])
def test_a_mesh(parallel):
    actor = ball_actor(15)
    scene = Scene(actor)
    scene.renderer.GetActiveCamera().SetParallelProjection(parallel)
    scene.renderer.GetActiveCamera().SetParallelScale(25)
    surface = surface_of(scene)
    np.testing.assert_allclose(distances(surface), 15, atol=0.02)
    assert surface.at(1, 1) is None
    assert surface.at(-5, 10) is None
    # the point is under the pixel
    scene.renderer.SetWorldPoint(*surface.at(60, 80), 1)
    scene.renderer.WorldToDisplay()
    np.testing.assert_allclose(scene.renderer.GetDisplayPoint()[:2], (60.5, 80.5), atol=1e-3)


def test_excluded_props_are_visible_again():
    inner, outer = ball_actor(15), ball_actor(18)
    scene = Scene(inner, outer)
    before = scene.picture()
    surface = VisibleSurface(scene.renderer, without=[outer])
    np.testing.assert_allclose(distances(surface), 15, atol=0.02)
    np.testing.assert_array_equal(scene.picture(), before)


def test_later_changes_have_no_effect():
    actor = ball_actor(15)
    scene = Scene(actor)
    surface = surface_of(scene)
    actor.SetPosition(5, 5, 5)
    scene.renderer.GetActiveCamera().Azimuth(30)
    scene.picture()
    np.testing.assert_allclose(distances(surface), 15, atol=0.02)


def test_a_volume_hides_a_mesh_behind_it():
    scene = Scene(solid(15), ball_actor(10))
    np.testing.assert_allclose(distances(surface_of(scene)), 15, atol=0.6)
    scene.renderer.AddViewProp(ball_actor(18))
    np.testing.assert_allclose(distances(surface_of(scene)), 18, atol=0.02)


def test_a_volume_in_its_own_frame():
    direction = np.array([(0, 0, 1), (1, 0, 0), (0, 1, 0)])
    grid = Grid((SIZE,) * 3, (3, 4, 5), (0.5, 0.5, 0.5), direction)
    volume = solid(15, grid)
    volume.SetPosition(CENTER - 2 * grid.at([(MIDDLE,) * 3])[0])
    volume.SetScale(2)
    scene = Scene(volume)
    np.testing.assert_allclose(distances(surface_of(scene)), 15, atol=0.6)


def test_a_volume_that_is_drawn_deformed():
    volume = solid(15)
    scene = Scene(volume, focal=CENTER + SHIFT)
    corners = Grid((2, 2, 2), spacing=[SIZE] * 3).points()
    drawn = DeformedVolume(volume, scene.renderer)
    drawn.update(Deformation(corners, corners + SHIFT, kind="rigid"))
    found = distances(surface_of(scene), CENTER + SHIFT)
    np.testing.assert_allclose(found, 15, atol=0.6)
    drawn.detach()
    np.testing.assert_allclose(distances(surface_of(scene)), 15, atol=0.6)


def test_a_projection_hides_nothing():
    volume = solid(15)
    volume.GetMapper().SetBlendModeToMaximumIntensity()
    assert surface_of(Scene(volume)).at(*BALL_PIXELS[4]) is None
