"""Every handle with every limit by every filter is the map of `Deformation`."""

import numpy as np
import pytest
from mesh_fixtures import places_of
from pipelines import ball, update
from vtk_fixtures import make_image, polydata_of

from vtk_mls import (
    Ball,
    BallMask,
    BoxMask,
    Capsule,
    CurveHandle,
    Deformation,
    FixedFace,
    Grid,
    ImageMask,
    Labels,
    Plane,
    RegionHandle,
    SlidingFace,
    Solid,
)
from vtk_mls.filters import MLSDeform, MLSDisplacementField
from vtk_mls.model.handles.shapes import Shape
from vtk_mls.vtk import arrays
from vtk_mls.vtk.cells import connectivity_of
from vtk_mls.vtk.objects import configured

C, S = np.cos(0.1), np.sin(0.1)  # a small turn about (2, 2, 2): nothing folds
MOTION = np.array([(C, -S, 0, 2 - 2 * (C - S)), (S, C, 0, 2 - 2 * (S + C)), (0, 0, 1, 0.05)])
MOTION = np.vstack([MOTION, [0, 0, 0, 1]])
GRID = Grid((3, 2, 2), (0.3, 1.4, 1.5), (1.6, 1.1, 1.1))
X = GRID.points()
VOXELS = np.arange(4)[:, None, None] + np.zeros((4, 4, 4)) < 2
VOXEL_GRID = Grid((4, 4, 4), (1.2, 1.2, 1.2), (0.5, 0.5, 0.5))


def solid():
    surface = ball((2, 2, 2), 0.8, 6)
    triangles = connectivity_of(surface.GetPolys())[0].reshape(-1, 3)
    return Solid(places_of(surface).astype(float), triangles)


SHAPES = {
    "ball": lambda: Ball((2, 2, 2), 0.8),
    "capsule": lambda: Capsule((1.5, 2, 2), (2.5, 2, 2), 0.6),
    "solid": solid,
    "labels": lambda: Labels(VOXELS, VOXEL_GRID),
    "a voxel": lambda: Labels(np.ones((1, 1, 1)), Grid((1, 1, 1), (2, 2, 2))),
}
CURVE = CurveHandle([(1, 1, 2), (3, 1, 2)], [(1, 1.05, 2), (2.9, 1.1, 2.1)])
HANDLES = {
    "points": tuple,
    "curve": lambda: (CURVE,),
    **{name: lambda make=make: (RegionHandle(make(), MOTION),) for name, make in SHAPES.items()},
}
RAMP = np.array([0.2, 0.6, 1])[:, None, None] + np.zeros((3, 2, 2))
FACE = Plane((0, 0, 2), (0.1, 0, 1))
LIMITS = {
    "none": {},
    "ball mask": {"mask": BallMask((2, 2, 2), 0.7, 2)},
    "box mask": {"mask": BoxMask((1, 1, 1), (2.4, 2, 2), 2)},
    "image mask": {"mask": ImageMask(RAMP, Grid((2, 2, 3), (0, 0, 0), (4, 4, 2)))},
    "fixed face": {"constraints": FixedFace(FACE, 1)},
    "sliding face": {"constraints": SlidingFace(FACE, 1)},
}
REST = np.array([(0.5, 0.5, 0.5), (3, 3.5, 3), (3, 1, 1)])
DEFORMED = REST + [(0, 0, 0), (0.1, 0, 0), (0, 0.1, 0.1)]


def image():
    data = make_image(GRID.dimensions, origin=GRID.origin, spacing=GRID.spacing)
    arrays.add(data.GetPointData(), "x", np.ascontiguousarray(X[:, 0]))
    return data


def image_values(output, value):
    found = arrays.to_numpy(output.GetPointData().GetArray("x"))
    origins = value.backward(X)
    is_inside = ((origins >= X.min(axis=0)) & (origins <= X.max(axis=0))).all(axis=1)
    assert is_inside.any()
    np.testing.assert_allclose(found[is_inside], origins[is_inside, 0], atol=1e-5)


def moved_points(output, value):
    np.testing.assert_allclose(places_of(output), value.forward(X), atol=1e-5)


def displacements(output, value):
    found = arrays.to_numpy(output.GetPointData().GetArray("BackwardDisplacement"))
    np.testing.assert_allclose(found, value.backward(X) - X, atol=1e-5)


FILTERS = {
    "image": (MLSDeform, image, image_values),
    "mesh": (MLSDeform, lambda: polydata_of(X), moved_points),
    "field": (MLSDisplacementField, image, displacements),
}


@pytest.mark.parametrize("limit", LIMITS)
@pytest.mark.parametrize("shape", HANDLES)
def test_filters_do_as_the_reference(shape, limit, messages):
    handles, limits = HANDLES[shape](), LIMITS[limit]
    value = Deformation(REST, DEFORMED, handles=handles, device="reference", **limits)
    for make_filter, make_input, check in FILTERS.values():
        filter_ = configured(make_filter(), RestPoints=REST, DeformedPoints=DEFORMED)
        filter_.SetInputDataObject(0, make_input())
        filter_.SetDevice("reference")
        for handle in handles:
            filter_.AddHandle(handle)
        filter_.SetMask(limits.get("mask"))
        if "constraints" in limits:
            filter_.AddConstraint(limits["constraints"])
        output = update(filter_)
        if limit == "none":
            messages.assert_none()
        else:
            messages.assert_one("handles are not met, by up to .* the mask or a face holds them")
        check(output, value)


@pytest.mark.parametrize("name", SHAPES)
def test_samples_are_of_the_shape(name):
    shape: Shape = SHAPES[name]()
    samples = shape.samples(8)
    low, high = shape.bounds
    size = max((high - low).max(), 1e-3)
    assert len(samples) >= 8**3
    assert shape.distance(samples)[0].max() < 0.06 * size
    np.testing.assert_allclose(samples.min(axis=0), low, atol=0.2 * size)
    np.testing.assert_allclose(samples.max(axis=0), high, atol=0.2 * size)


def test_a_region_that_is_held_inside_is_reported(messages):
    """A mask that holds nothing of its surface."""
    values = np.ones((9, 9, 9))
    values[4, 4, 4] = 0
    filter_ = MLSDeform()
    filter_.SetInputDataObject(0, polydata_of(X))
    filter_.SetDevice("reference")
    filter_.AddHandle(RegionHandle(Ball((2, 2, 2), 1.5), MOTION))
    filter_.SetMask(ImageMask(values, Grid((9, 9, 9), (0, 0, 0), (0.5, 0.5, 0.5))))
    update(filter_)
    messages.assert_one("1 of 1 handles are not met")
