"""Cuts that belong to the material: meshes and images opened by the same filter fit each other."""

import numpy as np
import pytest
from mesh_fixtures import CUTS, MESHES, array_of, count, deforming, places_of, split
from pipelines import control_points, update, values_of
from vtk_fixtures import FAST, REST, add_array, add_scalars, make_image
from vtkmodules.vtkFiltersCore import vtkCellCenters

from vtk_mls import Deformation, Plane
from vtk_mls.base.linear_algebra import unit
from vtk_mls.filters import MLSDeform, MLSDisplacementField
from vtk_mls.vtk.arrays import ImageGeometry
from vtk_mls.vtk.objects import output_of

EXTENT = 6.0  # of the control points
HALF = CUTS["half-plane"]
ABOVE = HALF.plane.height(REST)[:, None] > 0


def turned(x, angle, axis, middle=HALF.point):
    """Points `x` turned about an axis through a point."""
    x, axis = x - middle, axis / np.linalg.norm(axis)
    along = (x @ axis)[:, None] * axis
    across = x - along
    return middle + along + np.cos(angle) * across + np.sin(angle) * np.cross(axis, across)


MOTIONS = {
    "all turned": turned(REST, 0.6, np.array([1, 2, 0.5])) + [1, -2, 0.5],
    "one side pulled": REST + np.where(ABOVE, [1, 0, 0], 0),
    "both pulled above": REST
    + np.where(REST[:, 2:] > 3, np.where(ABOVE, [1.2, 0, 0], [-0.4, 0.2, 0]), 0),
    "one side pushed": REST - np.where(ABOVE, [1, 0, 0], 0),
    "hinge": np.where(ABOVE, turned(REST, -0.25, HALF.along), turned(REST, 0.25, HALF.along)),
}
OPENINGS = [
    ("half-plane", "one side pulled"),
    ("half-plane", "both pulled above"),
    ("half-plane", "hinge"),
    ("polygon", "one side pulled"),
    ("polygon", "both pulled above"),
    ("plane", "one side pulled"),
]


def depth_in_polygon(x):
    """How far points on the polygon are from its edges."""
    distances = []
    corners = CUTS["polygon"].points[:4]
    for a, b in zip(corners, np.roll(corners, -1, axis=0)):
        share = np.clip((x - a) @ (b - a) / np.sum((b - a) ** 2), 0, 1)
        distances.append(np.linalg.norm(x - a - share[:, None] * (b - a), axis=1))
    return np.min(distances, axis=0)


DEPTH = {
    "plane": lambda x: np.full(len(x), np.inf),
    "half-plane": lambda x: HALF.frame(x)[1],
    "polygon": depth_in_polygon,
}


@pytest.mark.parametrize(("cut", "motion"), OPENINGS)
@pytest.mark.parametrize("name", ["cells 10", "cells 12"])
def test_faces_of_a_mesh_are_those_of_the_void(name, cut, motion, device):
    """A step out of the material is as far in the void as it is long."""
    mesh, shape, moved = MESHES[name](), CUTS[cut], MOTIONS[motion]
    output = update(deforming(mesh, control_points(REST, moved), device, shape))
    assert not array_of(output, "NoInverse").any()
    undeformed, shift = split(mesh, [shape])
    face = shift.any(axis=1)
    x, v = places_of(undeformed)[face] + shift[face], places_of(output)[face].astype(np.float64)
    value = Deformation(REST, moved, cuts=[shape], device=device)
    # how points on faces of the output move as material moves inwards
    jacobian = value.jacobian(v, origins=x)
    inwards = np.linalg.solve(jacobian, unit(shift[face])[:, :, None])[:, :, 0]
    step = 5e-4 * EXTENT
    inner, outer = (value.void_distance(v + side * step * inwards) for side in (1, -1))
    np.testing.assert_allclose(inner, step, rtol=0, atol=1e-4 * EXTENT)
    open_ = DEPTH[cut](x) > 0.3
    assert open_.mean() > 0.5
    np.testing.assert_allclose(outer[open_], -step, rtol=0, atol=1e-4 * EXTENT)


@pytest.mark.parametrize("angle", [0.25, -0.25])
def test_sides_that_overlap_turn_by_their_own_maps(angle, device):
    """Two rigid halves, partly one in the other: each point and cell turns as its half."""
    cut, mesh = CUTS["plane"], MESHES["cells 10"]()
    rest_normal = np.array([1.0, 0.0, 0.0])
    for data, number in (
        (mesh.GetPointData(), mesh.GetNumberOfPoints()),
        (mesh.GetCellData(), mesh.GetNumberOfCells()),
    ):
        for name in ("normal", "tangent"):
            add_array(data, name, np.tile(rest_normal, (number, 1)))
    deformed = [turned(REST, side * angle, HALF.along) for side in (1, -1)]
    handles = control_points(REST, np.where(ABOVE, *deformed))
    filter_ = deforming(mesh, handles, device, cut, CutFrame="rest", GenerateJacobian=True)
    filter_.AddGradientVectorArray("normal")
    filter_.AddPushForwardArray("tangent")
    output = update(filter_)
    undeformed, shift = split(mesh, [cut])
    for data, is_above in (
        ("Point", cut.height(places_of(undeformed) + shift) > 0),
        ("Cell", cut.height(places_of(output_of(vtkCellCenters(), InputData=undeformed))) > 0),
    ):
        turns = [
            turned(rest_normal[None], side * angle, HALF.along, np.zeros(3)) for side in (1, -1)
        ]
        expected = np.where(is_above[:, None], *turns)
        for name in ("normal", "tangent"):
            found = array_of(output, name, data)
            np.testing.assert_allclose(found, expected, rtol=0, atol=1e-4)
    jacobian = array_of(output, "Jacobian").astype(np.float64)
    determinant = np.linalg.det(jacobian.reshape(-1, 3, 3))
    np.testing.assert_allclose(determinant, 1, rtol=0, atol=1e-4)


@pytest.mark.parametrize(("cut", "motion"), OPENINGS)
def test_jacobians_of_known_material_are_those_of_the_map(cut, motion, device):
    value = Deformation(REST, MOTIONS[motion], cuts=[CUTS[cut]], cut_frame="rest", device=device)
    v = np.random.default_rng(3).uniform(0, 8, (300, 3))
    v = v[value.void_distance(v) > 0.05]
    origins = value.backward(v)
    expected = value.jacobian(v)
    np.testing.assert_allclose(value.jacobian(v, origins=origins), expected, rtol=0, atol=1e-4)
    with pytest.raises(ValueError, match=r"`origins` must be as many as `points`, got 1 for 2"):
        value.jacobian(v[:2], origins=v[:1])


@pytest.mark.parametrize("cut", ["plane", "half-plane", "polygon"])
@pytest.mark.parametrize("motion", MOTIONS)
def test_overlap_is_where_other_material_comes_to_the_same_place(cut, motion, device):
    """A point of the material to which other material is mapped: `backward` gives one of them."""
    value = Deformation(REST, MOTIONS[motion], cuts=[CUTS[cut]], cut_frame="rest", device=device)
    x = np.random.default_rng(4).uniform(0, 8, (4000, 3))
    v = value.forward(x)
    assert np.isfinite(v).all()
    hidden = np.linalg.norm(value.backward(v) - x, axis=1) > 1e-3 * EXTENT
    overlaps = value.overlap(v)
    assert np.count_nonzero(hidden & ~overlaps) <= 2  # on the face, to rounding
    if motion == "one side pushed":
        assert hidden.sum() > 3
        assert np.count_nonzero(overlaps) > 1.3 * hidden.sum()
    if motion in ("one side pulled", "all turned"):
        assert not overlaps.any()
    assert not (overlaps & value.void(v)).any()


@pytest.mark.parametrize("kind", [MLSDeform, MLSDisplacementField])
@pytest.mark.parametrize("frame", ["rest", "deformed"])
def test_filters_mark_the_overlap(kind, frame):
    image = make_image((13, 12, 11), origin=(-1, -1, -1))
    cut, moved = CUTS["half-plane"], MOTIONS["one side pushed"]
    filter_ = deforming(image, control_points(REST, moved), FAST, cut, kind, CutFrame=frame)
    assert not update(filter_).GetPointData().HasArray("Overlap")
    filter_.SetGenerateOverlap(True)
    output = update(filter_)
    value = Deformation(REST, moved, cuts=[cut], cut_frame=frame, device=FAST)
    expected = value.overlap_field(ImageGeometry.of_image(image).grid)
    got = values_of(output, "Overlap")
    assert got.dtype == np.uint8
    np.testing.assert_array_equal(got, expected)
    assert count(output, "OverlappingPoints") == expected.sum()
    assert (expected.sum() > 10) == (frame == "rest")


def test_nothing_overlaps_without_cuts_or_where_material_is_gone(device):
    x = np.random.default_rng(4).uniform(0, 8, (50, 3))
    pushed_ = MOTIONS["one side pushed"]
    for options in ({}, {"cuts": [CUTS["plane"]], "cut_frame": "deformed"}):
        assert not Deformation(REST, pushed_, device=device, **options).overlap(x).any()


# Gradients of images at the faces


def test_faces_of_a_turned_image_look_into_the_opening(device):
    """Two halves of a block, apart, turned and moved: the gradient on each face is its normal."""
    axis, angle, by = np.array([1, 2, 0.5]), 0.5, np.array([1.0, 0, -3])
    apart = REST + np.where(REST[:, 2:] > 3, 1, -1) * [0, 0, 2]
    image = make_image((17, 17, 17), origin=(-3, -4, -8))
    add_scalars(image, "one", np.ones(image.GetNumberOfPoints()))
    handles = control_points(REST, turned(apart, angle, axis) + by)
    properties = {"CutFrame": "rest", "GradientArray": "one", "NormalizeGradient": True}
    output = update(deforming(image, handles, device, Plane((4, 4, 3), (0, 0, 1)), **properties))
    slope = values_of(output, "Gradient").reshape(-1, 3)
    distance = values_of(output, "VoidDistance").ravel()
    assert (slope[distance < 0] == 0).all()
    x = ImageGeometry.of_image(image).grid.points()
    middle = turned(np.array([(4.0, 4, 3)]), angle, axis) + by
    normal = turned(np.array([(0.0, 0, 1)]), angle, axis, np.zeros(3))[0]
    height = (x - middle) @ normal
    near = (distance >= 0) & (distance < 0.4) & (np.linalg.norm(x - middle, axis=1) < 4)
    assert near.sum() > 20
    outwards = np.sign(height[near])[:, None] * normal
    np.testing.assert_allclose(slope[near], outwards, rtol=0, atol=1e-3)
