"""Colors of the change of volume and lines of the deformed grid agree with the map."""

from __future__ import annotations

import numpy as np
import pytest
from drawing import MIDDLE, SIZE, Scene, drawn_volume, image_of, volume_of
from mesh_fixtures import array_of
from pipelines import ball
from vtk_fixtures import FAST
from vtkmodules.vtkFiltersSources import vtkPlaneSource
from vtkmodules.vtkRenderingCore import vtkActor, vtkPolyDataMapper

from vtk_mls import Deformation, Grid, Plane
from vtk_mls.rendering import (
    DeformedMesh,
    DeformedVolume,
    deformed_mesh,
    rest_lines,
    rest_surface,
    volume_colors,
)
from vtk_mls.rendering.rest_lines import RestLines
from vtk_mls.vtk import arrays
from vtk_mls.vtk.objects import configured

CORNERS = np.array([(x, y, z) for x in (8, 40) for y in (8, 40) for z in (8, 40)], float)
CENTER = np.full(3, MIDDLE)
BOX = np.array([[0.0] * 3, [SIZE - 1.0] * 3])
TETRAHEDRON = 1e-3 * np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)])


def crossing():
    """One handle is dragged past another."""
    moved = CORNERS.copy()
    moved[0] = 36, 30, 12
    return Deformation(CORNERS, moved, device=FAST)


def scaled(*factors):
    return Deformation(CORNERS, CENTER + factors * (CORNERS - CENTER), "affine", device=FAST)


def deformed(mesh, deformation, exact=True):
    actor = configured(vtkActor(), Mapper=configured(vtkPolyDataMapper(), InputData=mesh))
    drawn = DeformedMesh(actor)
    drawn.update(deformation, exact, has_distortion=True)
    return drawn, actor.GetMapper().GetInput()


def volumes(vertices):
    """Signed volumes of tetrahedra (n, 4, 3)."""
    return np.linalg.det(vertices[:, 1:] - vertices[:, :1]) / 6


def test_the_colors_are_those_of_volumes():
    assert volume_colors.doublings(np.array([4, 2, 1, 0.5])).tolist() == [-2, -1, 0, 1]
    colors = volume_colors.colors_of([0.25, 1, 4, 0, -3, np.nan])
    assert (colors[3:] == volume_colors.FOLDED).all()
    assert np.ptp(colors[1]) < 0.01  # gray
    assert colors[0][0] > 0.8 > 0.2 > colors[0][2]  # orange where it grows
    assert colors[2][2] > 0.6 > 0.2 > colors[2][0]  # blue where it shrinks
    gray = np.array([[0, 0, 0], [120, 120, 120]])
    assert (volume_colors.tinted(gray, np.ones(2)) == gray).all()
    assert (volume_colors.tinted(gray, np.full(2, -1))[:, 0] > 60).all()


def test_tables_have_the_colors():
    table, points = volume_colors.lookup_table(), volume_colors.table()
    for determinant in (-0.1, 0.1, 0.3, 0.7, 1, 1.9, 3.9):
        color, expected = [0.0] * 3, volume_colors.colors_of([determinant])[0]
        table.GetColor(determinant, color)
        np.testing.assert_allclose(color, expected, atol=0.02)
        found = [np.interp(determinant, points[:, 0], points[:, i]) for i in (1, 2, 3)]
        np.testing.assert_allclose(found, expected, atol=0.02)


def test_meshes_get_the_change_of_volume(opengl):
    d, mesh = crossing(), ball(CENTER, 15, 24)
    _, output = deformed(mesh, d)
    rest, values = array_of(output, "RestPosition"), array_of(output, "JacobianDeterminant")
    before = arrays.to_numpy(mesh.GetPoints().GetData())
    np.testing.assert_array_equal(rest, before)
    after = arrays.to_numpy(output.GetPoints().GetData())
    has_inverse = values > 0.05
    assert has_inverse.mean() > 0.9
    tetrahedra = after[has_inverse, None].astype(float) + TETRAHEDRON
    origins = Deformation(d.rest, d.deformed, device="reference").backward(
        tetrahedra.reshape(-1, 3)
    )
    ratios = volumes(origins.reshape(-1, 4, 3)) / volumes(TETRAHEDRON[None])
    np.testing.assert_allclose(values[has_inverse], ratios, rtol=0.02, atol=0.01)


def test_points_without_an_inverse_are_folds():
    jacobian = np.array([2.0, 2, -1, -1])[:, None, None] * np.eye(3)
    values = rest_surface.determinants([(slice(4), jacobian)], np.array([True, False] * 2))
    np.testing.assert_allclose(values, [8, 0, -1, -1], rtol=1e-6)


def test_the_interpolated_map_gives_the_change_of_volume(opengl, monkeypatch):
    monkeypatch.setattr(deformed_mesh, "MAX_EXACT_POINTS", 100)
    moved = CORNERS + 3 * np.sin(CORNERS[:, [1, 2, 0]])
    d, mesh, calls = Deformation(CORNERS, moved, device=FAST), ball(CENTER, 15, 24), []
    _, exact = deformed(mesh, d)

    def needs_no_cell(coarse, field):
        calls.append(1)
        return np.zeros(len(coarse._is_crossed), bool)

    monkeypatch.setattr(deformed_mesh.CoarseForward, "_is_exact", needs_no_cell)
    _, coarse = deformed(mesh, d, exact=False)
    assert calls
    pair = (array_of(output, "JacobianDeterminant") for output in (coarse, exact))
    np.testing.assert_allclose(*pair, rtol=0.03)


@pytest.mark.parametrize(
    ("factors", "determinant"),
    [((2 ** (1 / 3),) * 3, 0.5), ((2 ** (-1 / 3),) * 3, 2), ((-1, 1, 1), -1), ((0.5, 2, 1), 1)],
)
def test_volumes_are_painted(opengl, factors, determinant):
    """The phantom is white, and so are unchanged parts."""
    values = np.full((SIZE,) * 3, 255, np.uint8)
    _, scene, drawn = drawn_volume(image_of(values), Ambient=1, Diffuse=0, Specular=0)
    drawn.update(scaled(*factors))
    plain = scene.picture()[75, 75]
    drawn.paint(has_colors=True)
    drawn.update(scaled(*factors))
    assert drawn.failure is None
    expected = volume_colors.colors_of([determinant])[0]
    if determinant == 1:
        expected = plain / 255
    np.testing.assert_allclose(scene.picture()[75, 75] / 255, expected, atol=0.03)
    drawn.paint()
    drawn.update(scaled(*factors))
    np.testing.assert_allclose(scene.picture()[75, 75], plain, atol=3)
    drawn.detach()


def front(scene):
    """Look along y, in parallel."""
    camera = scene.renderer.GetActiveCamera()
    configured(camera, ParallelProjection=True, ParallelScale=40, ViewUp=(0, 0, 1))
    configured(camera, FocalPoint=CENTER, Position=CENTER - (0, 100, 0))
    return scene


def brightness(picture, points):
    """Of pixels at points (n, 2) of world coordinates x and z, as `front` shows them."""
    pixels = np.rint(75 + (points - MIDDLE) * 75 / 40 - 0.5).astype(int)
    return picture[pixels[:, 1], pixels[:, 0]].mean(axis=-1)


SHIFT = np.array([3.0, 0, 0])
LINES = RestLines.over(BOX, 5)
_CROSS = LINES.origin[0] + LINES.step * np.arange(1, 5)
ON_LINES = np.array([(x + 3, z + LINES.step / 2) for x in _CROSS for z in _CROSS[:-1]])
BETWEEN = np.array([(x + 3, z) for x, z in ON_LINES + (LINES.step / 2 - 3, 0) if x < 40])


def test_lines_are_painted_on_volumes(opengl):
    volume = volume_of(image_of(np.full((SIZE,) * 3, 255, np.uint8)), Ambient=1, Diffuse=0)
    scene = front(Scene(volume))
    drawn = DeformedVolume(volume, scene.renderer)
    drawn.paint(LINES)
    drawn.update(Deformation(CORNERS, CORNERS + SHIFT, device=FAST))
    picture = scene.picture()
    assert drawn.failure is None
    assert (brightness(picture, ON_LINES) < 120).all()
    assert (brightness(picture, BETWEEN) > 220).all()
    drawn.detach()
    assert (brightness(scene.picture(), ON_LINES) > 220).all()


def test_lines_are_painted_on_meshes(opengl):
    """None of the grid's plane in which the mesh lies."""
    y, actor = LINES.origin[1], vtkActor()
    source = configured(vtkPlaneSource(), Origin=(0, y, 0), Point1=[SIZE - 1, y, 0])
    configured(source, Point2=[0, y, SIZE - 1])
    actor.SetMapper(vtkPolyDataMapper())
    actor.GetMapper().SetInputConnection(source.GetOutputPort())
    actor.GetProperty().LightingOff()
    scene = front(Scene(actor))
    drawn = DeformedMesh(actor)
    drawn.update(Deformation(CORNERS, CORNERS + SHIFT, device=FAST), has_distortion=True)
    rest_lines.show(actor, actor.GetMapper(), LINES)
    picture = scene.picture()
    assert (brightness(picture, ON_LINES) < 120).all()
    assert (brightness(picture, BETWEEN) > 220).all()
    rest_lines.show(actor, actor.GetMapper(), None)
    assert (brightness(scene.picture(), ON_LINES) > 220).all()


@pytest.mark.parametrize("axis", range(3))
def test_lines_in_slices(axis):
    """All lines are drawn, where a coordinate of the map is an integer."""
    lines = RestLines.over(BOX, 6)
    dimensions, first = [200] * 3, [-24.0] * 3
    dimensions[axis], first[axis] = 1, 20.0
    grid = Grid(dimensions, first, (0.5,) * 3)
    everywhere = np.ones(grid.size, bool)
    ends = lines.in_slice(axis, grid, grid.points(), everywhere)
    length = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=-1).sum()
    assert length == pytest.approx(2 * 7 * 6 * lines.step, rel=0.02)
    d = Deformation(CORNERS, CORNERS + 4 * np.sin(CORNERS[:, [1, 2, 0]]), device=FAST)
    ends = lines.in_slice(axis, grid, d.backward(grid.points()), everywhere)
    assert len(ends) > 1000
    assert (ends[..., axis] == 20).all()
    coordinates = lines.coordinates(d.backward(ends.reshape(-1, 3)))
    across = np.delete(coordinates, axis, axis=1)
    assert np.abs(across - np.rint(across)).min(axis=1).max() < 0.01
    assert (coordinates > -0.01).all()
    assert (coordinates < 6.01).all()


def test_lines_end_at_voids():
    apart = CORNERS + 6 * np.sign(CORNERS[:, :1] - MIDDLE) * [1, 0, 0]
    d = Deformation(CORNERS, apart, cuts=Plane(CENTER, (1, 0, 0)), device=FAST)
    grid = Grid((200, 1, 200), (-24, 20, -24), (0.5,) * 3)
    points = grid.points()
    ends = RestLines.over(BOX, 6).in_slice(1, grid, d.backward(points), ~d.void(points))
    assert len(ends) > 500
    assert not d.void(ends.reshape(-1, 3)).any()


def test_a_slice_outside_the_grid_has_no_lines():
    grid = Grid((2, 1, 2), (1e6, 0, 0))
    lines = RestLines.over(BOX, 6)
    assert lines.in_slice(1, grid, grid.points(), np.ones(4, bool)).shape == (0, 2, 3)
