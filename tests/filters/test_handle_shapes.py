"""HandleShapes "cells": vertices are points, lines curves, closed surfaces rigid regions."""

import numpy as np
import pytest
from handle_surfaces import (
    ball,
    carried,
    displaced,
    joined,
    moved,
    polyline,
    positions,
    soup,
    transform,
    volume,
)
from pipelines import assert_fails, update
from vtk_fixtures import add_array
from vtkmodules.vtkCommonDataModel import VTK_TETRA, vtkMultiBlockDataSet
from vtkmodules.vtkFiltersCore import vtkAppendFilter, vtkDelaunay3D

from vtk_mls import Ball, CurveHandle, RegionHandle
from vtk_mls.filters import MLSDeform
from vtk_mls.vtk.objects import configured

CORNERS = np.array([(x, y, z) for x in (-6, 6) for y in (-6, 6) for z in (-6, 6)], float)
MOTION = transform()


def carried_by(by, mesh):
    """The points of a mesh where a vtkTransform moves them."""
    return [by.TransformPoint(point) for point in positions(mesh)]


def deforming(handles, mesh=None, device="reference", shapes="cells"):
    deform = configured(MLSDeform(), HandleShapes=shapes, Device=device)
    deform.SetInputData(0, ball((0, 0, 0), 3) if mesh is None else mesh)
    deform.SetInputData(1, handles)
    return deform


def matrix(by):
    return np.array([[by.GetMatrix().GetElement(i, j) for j in range(4)] for i in range(4)])


def held_bone():
    """A bone that moves between points that stay."""
    bone = ball((1, 0, 0), 2, 6)
    return joined(moved(bone, MOTION), polyline(CORNERS, kind="Verts"))


def test_a_closed_surface_moves_as_a_whole(device):
    mesh = ball((1, 0, 0), 1.2)  # inside of the bone
    output = update(deforming(held_bone(), mesh, device))
    expected = carried_by(MOTION, mesh)
    np.testing.assert_allclose(positions(output), expected, atol=2e-5)
    assert volume(output) == pytest.approx(volume(mesh), rel=1e-5)
    by_points = update(deforming(held_bone(), mesh, device, "points"))
    assert np.abs(positions(by_points) - expected).max() > 1e-3


def test_overlapping_bones_are_reported_once(messages):
    pushed = [moved(ball((x, 0, 0), 1, 6), transform(0, move=(0, 0, 0.1))) for x in (-3, 0, 3)]
    deform = deforming(joined(*pushed))
    update(deform)
    messages.assert_none()
    pushed[1] = displaced(pushed[1], (2, 0, 0))
    deform.SetInputData(1, joined(*pushed))
    update(deform)
    messages.assert_one("MLSDeform: rigid regions overlap where they were moved to: 1 and 2$")
    deform.Modified()
    update(deform)
    messages.assert_none()


@pytest.mark.parametrize(("radius", "is_reported"), [(1, True), (1.1, False)])
def test_equal_bones_that_change_places_are_reported(radius, is_reported, messages):
    """Copies that were appended in another order look so."""
    moves = ((-3, 1, 3), (0, radius, -3), (3, 1, 0))  # x, radius, motion
    bones = [moved(ball((x, 0, 0), r, 6), transform(0, move=(move, 0, 0))) for x, r, move in moves]
    update(deforming(joined(*bones)))
    if is_reported:
        messages.assert_one("MLSDeform: rigid regions 0 and 1 have the same shape, and are moved")
    else:
        messages.assert_none()


def test_what_the_handles_are():
    curve = np.array([(3, 3, 3), (3, 4, 3), (4, 4, 4)], float)
    handles = joined(held_bone(), polyline(curve, (0, 0, 1)), moved(ball((0, 0, 4)), MOTION))
    value = deforming(handles).updated_deformation()
    np.testing.assert_array_equal(value.rest, CORNERS)
    kinds = [type(handle) for handle in value.handles]
    assert kinds == [CurveHandle, RegionHandle, RegionHandle]
    np.testing.assert_array_equal(value.handles[0].rest, curve)
    np.testing.assert_array_equal(value.handles[0].deformed, curve + [0, 0, 1])
    for region in value.handles[1:]:
        np.testing.assert_allclose(region.motion, matrix(MOTION), atol=1e-12)
    np.testing.assert_allclose(value.handles[1].shape.bounds.mean(axis=0), (1, 0, 0), atol=0.1)
    np.testing.assert_allclose(value.handles[2].shape.bounds.mean(axis=0), (0, 0, 4), atol=0.1)
    by_points = deforming(handles, shapes="points").updated_deformation()
    assert len(by_points.rest) == handles.GetNumberOfPoints()
    assert by_points.handles == ()


def test_points_of_no_cell_are_points_and_have_weights():
    handles = held_bone()
    handles.SetVerts(None)
    weights = np.arange(1.0, 1 + handles.GetNumberOfPoints())
    add_array(handles.GetPointData(), "Weight", weights)
    value = deforming(handles).updated_deformation()
    np.testing.assert_array_equal(value.rest, CORNERS)
    np.testing.assert_array_equal(value.weights, weights[-8:])


def test_corners_at_the_same_place_join_triangles():
    (region,) = deforming(moved(soup(BONE), MOTION)).updated_deformation().handles
    np.testing.assert_allclose(region.motion, matrix(MOTION), atol=1e-12)


def test_the_outer_faces_of_a_volume_are_a_region():
    bone, tetrahedra, append = moved(ball((1, 0, 0), 2), MOTION), vtkDelaunay3D(), vtkAppendFilter()
    tetrahedra.SetInputData(bone)
    append.AddInputConnection(tetrahedra.GetOutputPort())
    append.AddInputData(polyline(CORNERS, kind="Verts"))
    append.AddInputData(polyline(CORNERS[:2] / 2, (1, 0, 0)))
    append.SetOutputPointsPrecision(1)
    grid = update(append)
    assert VTK_TETRA in {grid.GetCellType(i) for i in range(grid.GetNumberOfCells())}
    value = deforming(grid).updated_deformation()
    curve, region = value.handles
    np.testing.assert_array_equal(curve.rest, CORNERS[:2] / 2)
    np.testing.assert_allclose(region.motion, matrix(MOTION), atol=1e-7)  # float32 of Delaunay
    np.testing.assert_array_equal(value.rest, CORNERS)


@pytest.mark.parametrize("share", [0.0, 0.25, 0.5])
def test_blend_turns_by_a_share_of_the_angle(share):
    deform = deforming(held_bone())
    deform.SetBlend(share)
    (region,) = deform.updated_deformation().handles
    part = transform(30 * share, move=(0, 0, 0))
    np.testing.assert_allclose(region.motion[:3, :3], matrix(part)[:3, :3], atol=1e-12)
    (whole,) = deforming(held_bone()).updated_deformation().handles
    count, expected = (round(1 / share), whole.motion) if share else (1, np.eye(4))
    np.testing.assert_allclose(np.linalg.matrix_power(region.motion, count), expected, atol=1e-12)


def test_handles_of_python():
    mesh = ball((0, 0, 0), 1)
    deform = configured(MLSDeform(), InputData=mesh, Device="reference")
    deform.AddHandle(RegionHandle(Ball((0, 0, 0), 2), matrix(MOTION)))
    np.testing.assert_allclose(positions(update(deform)), carried_by(MOTION, mesh), atol=1e-5)
    deform.ClearHandles()
    np.testing.assert_array_equal(positions(update(deform)), positions(mesh))


def test_a_moved_dataset_gives_displacements_by_point_number(device):
    bone, corners = ball((1, 0, 0), 2, 6), polyline(CORNERS, kind="Verts")
    mesh = ball((1, 0, 0), 1.2)  # inside of the bone
    deform = deforming(joined(bone, corners), mesh, device)
    deform.SetInputDataObject(4, joined(carried(bone, MOTION), corners))
    np.testing.assert_allclose(positions(update(deform)), carried_by(MOTION, mesh), atol=2e-5)
    value = deform.updated_deformation()
    np.testing.assert_array_equal(value.deformed, CORNERS)
    (shape,) = (handle.shape for handle in value.handles)
    further = transform(80)
    deform.SetInputDataObject(4, joined(carried(bone, further), corners))
    np.testing.assert_allclose(positions(update(deform)), carried_by(further, mesh), atol=2e-5)
    (handle,) = deform.updated_deformation().handles
    assert handle.shape is shape  # whose distance image takes seconds
    deform.DisconnectDeformedControlPoints()
    deform.SetInputData(1, held_bone())
    np.testing.assert_allclose(positions(update(deform)), carried_by(MOTION, mesh), atol=2e-5)


def test_points_are_paired_with_those_moved():
    deform = deforming(polyline(CORNERS, kind="Verts"), shapes="points")
    deform.SetInputDataObject(4, polyline(CORNERS + [0, 0, 1], kind="Verts"))
    np.testing.assert_array_equal(deform.updated_deformation().deformed, CORNERS + [0, 0, 1])


def test_moved_data_that_do_not_pair(messages):
    deform = deforming(BONE)
    deform.SetInputDataObject(4, ball((1, 0, 0), 2, 6))
    assert_fails(
        deform, messages, "`DeformedControlPoints` must have a point for each of the 226 points of"
    )
    deform.SetInputDataObject(4, carried(BONE, MOTION))
    assert update(deform).GetNumberOfPoints() > 0
    deform.DisconnectControlPoints()
    assert_fails(
        deform, messages, "`DeformedControlPoints` is what `ControlPoints` is, moved: connect that"
    )
    blocks = vtkMultiBlockDataSet()
    blocks.SetBlock(0, BONE)
    deform.SetInputDataObject(1, BONE)
    deform.SetInputDataObject(4, blocks)
    assert_fails(
        deform, messages, "`DeformedControlPoints` must be one point set, got a vtkMultiBlock"
    )


BONE = ball((1, 0, 0), 2)
BAD = {
    "open": (
        displaced(
            joined(ball((1, 0, 0)), polyline([(5, 5, 5), (6, 5, 5), (5, 6, 5)], kind="Polys")), 0
        ),
        "`ControlPoints`, surface 1, is no rigid region: .* closed surface, got 3 edges",
    ),
    "stretched": (
        displaced(BONE, positions(BONE) * (0.1, 0, 0)),
        r"surface 0, is no rigid region: its points must move by .* up to 0\.\d+, of a size of 4",
    ),
    "mirrored": (displaced(BONE, positions(BONE) * (-2, 0, 0)), "surface 0, is no rigid region"),
    "NaN": (displaced(BONE, np.nan), "surface 0, is no rigid region: .*finite"),
    "one node": (polyline([(0, 0, 0)]), "line 0, is no curve handle: .*2 nodes of a curve, got 1"),
    "a node twice": (polyline([(0, 0, 0), (0, 0, 0)]), "line 0, is no curve handle: .*repeat"),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_cells(case, messages):
    handles, sentence = BAD[case]
    deform = deforming(handles)
    assert_fails(deform, messages, sentence)
    deform.SetInputData(1, held_bone())
    assert update(deform).GetNumberOfPoints() > 0
