"""A mesh is drawn as `MLSDeform` deforms it, and changes with the input of its actor."""

from __future__ import annotations

import gc
import weakref
from functools import partial

import drawing
import numpy as np
import pytest
from mesh_fixtures import CUTS, MESHES, OPENED, array_of, deforming, places_of, set_places, sphere
from pairwise import paired, rare
from pipelines import assert_same, ball, control_points, update
from vtk_fixtures import FAST, REST, add_array, polydata_of
from vtkmodules.vtkCommonDataModel import vtkMultiBlockDataSet, vtkPolyData, vtkUnstructuredGrid
from vtkmodules.vtkFiltersCore import vtkPolyDataNormals
from vtkmodules.vtkFiltersSources import vtkSphereSource
from vtkmodules.vtkRenderingCore import (
    vtkActor,
    vtkCompositePolyDataMapper,
    vtkDataSetMapper,
    vtkPolyDataMapper,
)

from vtk_mls import KINDS, Deformation, DeviceError
from vtk_mls.rendering import DeformedMesh, deformed_mesh
from vtk_mls.vtk import arrays, splitting
from vtk_mls.vtk.objects import configured, output_of

pytestmark = pytest.mark.usefixtures("opengl")


def mapper_of(mesh):
    mapper = vtkPolyDataMapper() if isinstance(mesh, vtkPolyData) else vtkDataSetMapper()
    return configured(mapper, InputData=mesh, ScalarRange=(-10, 15))


class Scene(drawing.Scene):
    """A window with one actor of a mesh or a mapper."""

    def __init__(self, data):
        self.actor = vtkActor()
        self.actor.SetMapper(data if data.IsA("vtkMapper") else mapper_of(data))
        super().__init__(self.actor, focal=(4, 4, 3), distance=24, pixels=200)


def drawn_mesh(data):
    scene = Scene(data)
    return scene, DeformedMesh(scene.actor)


def deformation(cuts=(), **options):
    return Deformation(REST, OPENED, cuts=cuts, device=FAST, **options)


def filtered(mesh, cuts=(), **properties):
    deform = deforming(mesh, control_points(REST, OPENED), **properties)
    for cut in cuts:
        deform.AddCut(cut)
    output = update(deform)
    arrays.set_roles(output.GetPointData(), mesh.GetPointData())
    arrays.set_roles(output.GetCellData(), mesh.GetCellData())
    return output


def assert_alike(picture, expected, mean=0.05):
    """Rounding changes a few pixels on edges only."""
    apart = np.abs(picture - expected).max(axis=2)
    assert (apart > 3).mean() < 1e-3
    assert apart.mean() < mean
    assert expected.std() > 10  # it is not empty


def colored(name, by):
    mesh = MESHES[name]()
    if by == "points":
        mesh.GetPointData().SetActiveScalars("linear")
    elif by == "cells":
        mesh.GetCellData().SetActiveScalars("number")
    return mesh


def with_cell_normals(mesh):
    return output_of(vtkPolyDataNormals(), InputData=mesh, ComputeCellNormals=True)


@paired(
    name=["cells 10", "cells 12", "cells 24", "polydata", "mixed", "structured", "rectilinear"],
    cut=[None, "plane", "half-plane", "polygon", "tent"],
    kind=["rigid", *rare(*sorted({*KINDS} - {"rigid"}))],
    frame=["rest", "deformed"],
    by=["points", "cells", "nothing"],
)
def test_the_picture_is_that_of_the_filter(name, cut, kind, frame, by):
    mesh, cuts = colored(name, by), [CUTS[cut]] if cut else []
    # with alpha 2 few handles send points next to a plane a million lengths away in other kinds
    alpha = 2 if kind == "rigid" else 1
    scene, deformed = drawn_mesh(mesh)
    before, original = scene.picture(), mesh.NewInstance()
    original.DeepCopy(mesh)
    stamp = mesh.GetMTime()
    deformed.update(deformation(cuts, kind=kind, cut_frame=frame, alpha=alpha))
    picture = scene.picture()
    assert (np.abs(picture - before).max(axis=2) > 50).mean() > 0.02
    expected = filtered(mesh, cuts, Kind=kind, CutFrame=frame, Alpha=alpha)
    # The deformed frame loses material at cuts. The search for its place ends nearby, at a point
    # that depends on the other points and on the processor.
    missing = arrays.to_numpy(expected.GetPointData().GetArray("NoInverse"))
    is_missing = frame == "deformed" and missing.any()
    assert_alike(picture, Scene(expected).picture(), mean=0.2 if is_missing else 0.05)
    assert mesh.GetMTime() == stamp
    assert_same(mesh, original)
    deformed.detach()
    np.testing.assert_array_equal(scene.picture(), before)
    assert scene.actor.GetMapper().GetInput() is mesh


@pytest.mark.parametrize("frame", ["rest", "deformed"])
@pytest.mark.parametrize("cut", [None, "plane", "half-plane"])
@pytest.mark.parametrize("normals", ["of points", "of cells", "without a name"])
def test_normals_are_those_of_the_filter(normals, cut, frame):
    mesh, cuts = sphere(), [CUTS[cut]] if cut else []
    if normals == "of cells":
        mesh = with_cell_normals(mesh)
    elif normals == "without a name":
        mesh.GetPointData().GetNormals().SetName(None)
    scene = Scene(mesh)
    DeformedMesh(scene.actor).update(deformation(cuts, cut_frame=frame))
    drawn, expected = scene.actor.GetMapper().GetInput(), filtered(mesh, cuts, CutFrame=frame)
    of = "GetCellData" if normals == "of cells" else "GetPointData"
    found, reference = (
        arrays.to_numpy(getattr(surface, of)().GetNormals()) for surface in (drawn, expected)
    )
    np.testing.assert_array_equal(found, reference)
    assert_alike(scene.picture(), Scene(expected).picture())


def test_points_without_an_inverse_agree_with_the_filter():
    mesh, middle = sphere(), np.array([4, 4, 3])
    x = places_of(mesh).copy()
    x[7] = np.nan
    set_places(mesh, x)
    offset = np.array([[1.8, 0.3, 0], [-1.8, 0, 0.3], [0, 1.9, 0], [0, -1.9, 0.4]])
    rest = np.concatenate([REST, middle + offset])
    crossed = np.concatenate([REST, middle - offset])
    scene = Scene(mesh)
    DeformedMesh(scene.actor).update(Deformation(rest, crossed, "polynomial", device=FAST))
    expected = update(deforming(mesh, control_points(rest, crossed), Kind="polynomial"))
    assert array_of(expected, "NoInverse").sum() > 50
    drawn = scene.actor.GetMapper().GetInput()
    np.testing.assert_array_equal(places_of(drawn), places_of(expected))


# Functions that change a scene, and return the mesh that its actor then draws.
def _change_points(scene, mesh):
    arrays.to_numpy(mesh.GetPoints().GetData())[:] += [0.3, 0, 0.5]
    mesh.GetPoints().GetData().Modified()
    return mesh


def _change_values(scene, mesh):
    arrays.to_numpy(mesh.GetPointData().GetArray("linear"))[:] *= -1
    mesh.GetPointData().GetArray("linear").Modified()
    return mesh


def _change_input(scene, mesh, name="cells 12"):
    other = colored(name, "points")
    scene.actor.GetMapper().SetInputDataObject(0, other)
    return other


def _change_mapper(scene, mesh):
    other = colored("polydata", "points")
    scene.actor.SetMapper(mapper_of(other))
    return other


CHANGES = {
    "points": _change_points,
    "values": _change_values,
    "input": _change_input,
    "type": partial(_change_input, name="polydata"),
    "mapper": _change_mapper,
}


@pytest.mark.parametrize("cut", [None, "half-plane"])
@pytest.mark.parametrize("change", CHANGES)
def test_a_change_shows_in_the_next_picture(change, cut):
    mesh, cuts = colored("cells 10", "points"), [CUTS[cut]] if cut else []
    scene = Scene(mesh)
    old = scene.actor.GetMapper()
    deformed = DeformedMesh(scene.actor)
    deformed.update(deformation(cuts))
    scene.picture()
    new = CHANGES[change](scene, mesh)
    picture = scene.picture()
    assert_alike(picture, Scene(filtered(new, cuts)).picture())
    deformed.detach()
    np.testing.assert_array_equal(scene.picture(), Scene(new).picture())
    if scene.actor.GetMapper() is not old:
        assert old.GetInput() is mesh


def test_an_algorithm_in_front_of_the_mapper_runs_again():
    source = configured(vtkSphereSource(), Center=(4, 4, 3), Radius=2)
    mapper = configured(vtkPolyDataMapper(), InputConnection=source.GetOutputPort())
    scene, deformed = drawn_mesh(mapper)
    deformed.update(deformation())
    scene.picture()
    configured(source, Radius=3, ThetaResolution=50)
    assert_alike(scene.picture(), Scene(filtered(output_of(source))).picture())
    deformed.detach()
    assert mapper.GetInputAlgorithm() is source


def test_a_static_mapper_draws_the_deformed_mesh():
    mesh = sphere()
    scene = Scene(mesh)
    scene.picture()
    scene.actor.GetMapper().StaticOn()
    DeformedMesh(scene.actor).update(deformation())
    assert_alike(scene.picture(), Scene(filtered(mesh)).picture())


@pytest.fixture
def interpolated(monkeypatch):
    """Meshes with more than 100 points are moved by the interpolated map."""
    monkeypatch.setattr(deformed_mesh, "MAX_EXACT_POINTS", 100)


def fine_sphere(normals=True):
    return ball((4, 4, 3), 2.4, 150, normals)


@pytest.mark.parametrize("cut", [None, "plane", "half-plane", "polygon", "tent"])
@pytest.mark.parametrize("moved", [OPENED, REST + (OPENED - REST) * 2])
def test_the_interpolated_map_has_an_error_of_at_most_half_a_pixel(moved, cut, interpolated):
    mesh = fine_sphere()
    scene, deformed = drawn_mesh(mesh)
    d = Deformation(REST, moved, cuts=[CUTS[cut]] if cut else [], device=FAST)
    found = []
    for exact in (False, True):
        deformed.update(d, exact=exact)
        drawn = scene.actor.GetMapper().GetInput()
        normals = arrays.to_numpy(drawn.GetPointData().GetNormals())
        found.append((scene.picture(), places_of(drawn).copy(), normals.copy()))
    (coarse, x, n), (fine, y, m) = found
    assert 0 < np.abs(x - y).max() < 2 * deformed_mesh._MAX_ERROR * 4.8
    cosine = (n * m).sum(axis=1) / np.linalg.norm(n, axis=1) / np.linalg.norm(m, axis=1)
    assert np.quantile(cosine, 0.01) > np.cos(np.radians(3))
    apart = np.abs(coarse - fine).max(axis=2)
    assert apart.mean() < 0.3
    assert np.quantile(apart, 0.99) <= 6


@pytest.mark.parametrize(
    ("cut", "frame"),
    [(cut, "rest") for cut in ("plane", "half-plane", "polygon", "tent")]
    + [("half-plane", "deformed")],
)
def test_the_map_is_exact_on_cuts_and_everywhere_in_the_deformed_frame(cut, frame, interpolated):
    mesh, cuts = fine_sphere(), [CUTS[cut]]
    scene = Scene(mesh)
    DeformedMesh(scene.actor).update(deformation(cuts, cut_frame=frame), exact=False)
    split, _, side = splitting.split(mesh, cuts)
    on_cut = side.any(axis=1) | (frame == "deformed")
    assert on_cut.sum() > 50
    drawn, expected = scene.actor.GetMapper().GetInput(), filtered(mesh, cuts, CutFrame=frame)
    np.testing.assert_array_equal(places_of(drawn)[on_cut], places_of(expected)[on_cut])
    for surface in (drawn, expected):
        assert surface.GetNumberOfPoints() == split.GetNumberOfPoints()
    normals = [
        arrays.to_numpy(surface.GetPointData().GetNormals()) for surface in (drawn, expected)
    ]
    np.testing.assert_array_equal(normals[0][on_cut], normals[1][on_cut])


def test_points_far_from_all_others_are_exact(interpolated):
    mesh = fine_sphere(normals=False)
    x = places_of(mesh)
    x[5], x[6] = (400, 4, 3), np.nan
    scene = Scene(mesh)
    DeformedMesh(scene.actor).update(deformation(), exact=False)
    drawn = places_of(scene.actor.GetMapper().GetInput())
    expected = x + deformation().forward_field(x).displacement
    np.testing.assert_allclose(drawn[5:7], expected[5:7], atol=1e-4)
    assert np.nanmax(np.abs(drawn - expected)) < 2 * deformed_mesh._MAX_ERROR * 4.8


def test_cell_normals_are_computed_from_the_interpolated_shape(interpolated):
    mesh = with_cell_normals(fine_sphere())
    scene, deformed = drawn_mesh(mesh)
    deformed.update(deformation(), exact=False)
    coarse = scene.picture()
    deformed.update(deformation())
    assert np.abs(coarse - scene.picture()).mean() < 0.5


@pytest.mark.parametrize("make", [vtkPolyData, vtkUnstructuredGrid, lambda: polydata_of([])])
def test_an_empty_mesh_draws_nothing(make):
    scene, deformed = drawn_mesh(make())
    for cuts in ([], [CUTS["plane"]]):
        deformed.update(deformation(cuts), exact=False)
        assert scene.picture().std(axis=(0, 1)).max() == 0
    deformed.detach()
    assert scene.picture().std(axis=(0, 1)).max() == 0


def test_an_actor_may_lose_its_mesh_and_its_mapper():
    mesh = sphere()
    scene = Scene(mesh)
    mapper, deformed = scene.actor.GetMapper(), DeformedMesh(scene.actor)
    deformed.update(deformation())
    mapper.RemoveAllInputs()
    deformed.update(deformation())
    mapper.SetInputData(mesh)
    assert_alike(scene.picture(), Scene(filtered(mesh)).picture())
    scene.actor.SetMapper(None)
    deformed.update(deformation())
    assert mapper.GetInput() is mesh
    scene.actor.SetMapper(mapper)
    assert_alike(scene.picture(), Scene(filtered(mesh)).picture())
    scene.renderer.RemoveActor(scene.actor)
    deformed.update(deformation())
    deformed.detach()


def test_detach_restores_the_actor_and_update_deforms_it_again():
    mesh = sphere()
    scene = Scene(mesh)
    before, deformed = scene.picture(), DeformedMesh(scene.actor)
    deformed.detach()
    for _ in range(2):
        deformed.update(deformation())
        assert (scene.picture() != before).any()
        deformed.detach()
        deformed.detach()
        np.testing.assert_array_equal(scene.picture(), before)
        scene.actor.GetMapper().SetInputData(mesh)  # without observers
        scene.actor.Modified()


def test_it_is_collected_with_its_actor():
    scene, deformed = drawn_mesh(sphere())
    deformed.update(deformation())
    scene.picture()
    alive = weakref.ref(deformed)
    del deformed
    gc.collect()
    assert alive() is not None
    del scene
    gc.collect()
    assert alive() is None


def test_other_actors_are_refused():
    actor = vtkActor()
    with pytest.raises(TypeError, match=r"`actor` must have a vtkPolyDataMapper .* got none"):
        DeformedMesh(actor)
    mapper = vtkCompositePolyDataMapper()
    mapper.SetInputDataObject(vtkMultiBlockDataSet())
    actor.SetMapper(mapper)
    with pytest.raises(TypeError, match="got vtk.*Composite.*give each block an actor of its own"):
        DeformedMesh(actor)
    scene = Scene(sphere())
    DeformedMesh(scene.actor).update(deformation())
    with pytest.raises(ValueError, match="`actor` shows a deformed mesh already"):
        DeformedMesh(scene.actor)


def test_an_error_does_not_change_the_picture():
    mesh = sphere()
    scene, deformed = drawn_mesh(mesh)
    before = scene.picture()
    with pytest.raises(DeviceError):
        deformed.update(Deformation(REST, OPENED, device="97:0"))
    np.testing.assert_array_equal(scene.picture(), before)
    deformed.update(deformation())
    moved = scene.picture()
    with pytest.raises(TypeError, match="`deformation` must be a Deformation, got 3"):
        deformed.update(3)
    with pytest.raises(DeviceError):
        deformed.update(Deformation(REST, OPENED, device="97:0"))
    np.testing.assert_array_equal(scene.picture(), moved)


def test_an_array_that_is_too_short_is_an_error(messages):
    mesh = sphere()
    scene, deformed = drawn_mesh(mesh)
    deformed.update(deformation())
    add_array(mesh.GetPointData(), "short", [1.0, 2.0])
    with pytest.raises(ValueError, match="array `short` must have one tuple for each"):
        deformed.update(deformation())
    assert scene.picture().std(axis=(0, 1)).max() == 0  # VTK reports it at the next picture
    lines = {line for line in messages.take().splitlines() if line}
    assert len(lines) == 1
    assert "array `short` must have one tuple for each of the 1122 points" in lines.pop()
    mesh.GetPointData().RemoveArray("short")
    assert_alike(scene.picture(), Scene(filtered(mesh)).picture())
