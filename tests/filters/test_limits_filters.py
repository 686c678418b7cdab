"""Where the deformation acts: masks and faces by properties and an input."""

from functools import partial

import numpy as np
import pytest
from pipelines import assert_fails, connect, control_points, update, values_of
from vtk_fixtures import DEFORMED, REST, add_scalars, make_image
from vtkmodules.vtkCommonCore import VTK_FLOAT, VTK_UNSIGNED_SHORT
from vtkmodules.vtkCommonDataModel import vtkImageData, vtkPolyData
from vtkmodules.vtkImagingCore import vtkRTAnalyticSource

from vtk_mls import BallMask, BoxMask, Deformation, FixedFace, Plane, SlidingFace
from vtk_mls.filters import MLSDeform, MLSDisplacementField
from vtk_mls.vtk.arrays import ImageGeometry
from vtk_mls.vtk.objects import configured


def scene(kind=MLSDeform):
    source = vtkRTAnalyticSource()
    source.SetWholeExtent(0, 8, 0, 8, 0, 8)
    return connect(configured(kind(), Device="reference"), source, control_points()), source


@pytest.fixture
def held(messages):
    """Handles are held, and VTK says nothing else."""
    yield
    lines = [line for line in messages.take().splitlines() if line.strip()]
    assert lines
    assert all("handles are not met, by up to" in line for line in lines), lines


def mask_image(values, vtk_type):
    image = make_image((9, 9, 9), origin=(0, 0, 0), spacing=(1, 1, 1))
    return add_scalars(image, "mask", np.ravel(values), vtk_type)


@pytest.mark.usefixtures("held")
@pytest.mark.parametrize("as_input", [False, True])
@pytest.mark.parametrize(
    ("inside", "vtk_type"), [(1, VTK_FLOAT), (0.5, VTK_FLOAT), (7, VTK_UNSIGNED_SHORT)]
)
def test_displacements_are_multiplied_by_an_image(as_input, inside, vtk_type):
    values = np.zeros((9, 9, 9))
    values[:, :, 4:] = inside
    field, _ = scene(MLSDisplacementField)
    whole = values_of(update(field), "BackwardDisplacement").copy()
    set_mask = partial(field.SetInputDataObject, 3) if as_input else field.SetMask
    set_mask(mask_image(values, vtk_type))
    part = values_of(update(field), "BackwardDisplacement")
    assert not part[:, :, :4].any()
    factor = min(inside, 1)
    np.testing.assert_allclose(part[:, :, 4:], factor * whole[:, :, 4:], atol=1e-6)
    unset_mask = field.DisconnectMask if as_input else partial(field.SetMask, None)
    unset_mask()
    np.testing.assert_array_equal(values_of(update(field), "BackwardDisplacement"), whole)


@pytest.mark.usefixtures("held")
@pytest.mark.parametrize("as_input", [True, False])
def test_a_changed_mask_is_used(as_input):
    field, _ = scene(MLSDisplacementField)
    image = mask_image(np.ones((9, 9, 9)), VTK_FLOAT)
    field.SetInputDataObject(3, image) if as_input else field.SetMask(image)
    assert values_of(update(field), "BackwardDisplacement").any()
    image.GetPointData().GetArray("mask").Fill(0)
    image.GetPointData().GetArray("mask").Modified()
    image.Modified()
    assert not values_of(update(field), "BackwardDisplacement").any()


@pytest.mark.parametrize("kind", [MLSDeform, MLSDisplacementField])
def test_held_handles_are_reported_once(kind, messages):
    deform, source = scene(kind)
    update(deform)
    messages.assert_none()
    deform.SetMaskBall(4, 4, 4, 1.5, 1)
    update(deform)
    miss = np.linalg.norm(DEFORMED - REST, axis=1)
    held = f"4 of 8 handles are not met, by up to {miss.max():.3g}, because the mask or a face"
    messages.assert_one(f"{kind.__name__}: {held} holds them$")
    source.Modified()
    deform.Modified()
    update(deform)
    messages.assert_none()
    deform.SetAlpha(1)
    update(deform)
    messages.assert_one(held)
    deform.SetMaskBall(4, 4, 4, 20, 1)
    update(deform)
    messages.assert_none()


Z_PLANE = Plane((0, 0, 4), (0, 0, -2))
LIMITS = {
    "ball": (lambda f: f.SetMaskBall(4, 4, 4, 1.5, 1), {"mask": BallMask((4, 4, 4), 1.5, 1)}),
    "fixed": (
        lambda f: f.SetFixedPlane(0, 0, 0, 4, 0, 0, -2, 2),
        {"constraints": FixedFace(Z_PLANE, 2)},
    ),
    "sliding": (
        lambda f: f.SetSlidingPlanes([(0, 0, 4, 0, 0, -2, 2)]),
        {"constraints": SlidingFace(Z_PLANE, 2)},
    ),
}


@pytest.mark.usefixtures("held")
@pytest.mark.parametrize("limit", LIMITS)
def test_limits_are_those_of_the_value(limit):
    set_limit, arguments = LIMITS[limit]
    field, _ = scene(MLSDisplacementField)
    set_limit(field)
    found = values_of(update(field), "BackwardDisplacement")
    value = Deformation(REST, DEFORMED, device="reference", **arguments)
    points = ImageGeometry.of_image(field.GetOutput()).grid.points()
    expected = value.backward(points) - points
    np.testing.assert_allclose(found.reshape(-1, 3), expected, atol=1e-6)


FLAT = add_scalars(make_image((9, 9, 1)), "mask", np.ones(81))
FULL = np.full((9, 9, 9), 200.0)
BAD = {
    "radius": ({"MaskBall": (0, 0, 0, -1, 1)}, "`MaskBall` is no ball: `radius` .* got -1.0$"),
    "falloff": ({"MaskBall": (0, 0, 0, 1, 0)}, "`MaskBall` is no ball: `falloff` .* got 0.0$"),
    "four": ({"MaskBall": (0, 0, 0, 1)}, "`MaskBall` must be five numbers"),
    "text": ({"MaskBall": "abcde"}, "`MaskBall` must be numbers"),
    "gray": (
        {"Mask": mask_image(FULL, VTK_FLOAT)},
        "`Mask` must have numbers from 0 to 1, got 200 to 200; divide",
    ),
    "no values": ({"Mask": vtkImageData()}, "`Mask` must be an image with one number"),
    "flat": ({"Mask": FLAT}, "`Mask` is no mask: .*2 points along each axis"),
    "a mesh": ({"Mask": vtkPolyData()}, "`mask` must be a BallMask"),
    "two masks": (
        {"MaskBall": (4, 4, 4, 1, 1), "Mask": BoxMask((0, 0, 0), (1, 1, 1), 1)},
        "one mask, got `MaskBall` and `Mask`",
    ),
    "no normal": (
        {"FixedPlanes": [(0, 0, 0, 0, 0, 0, 1)]},
        "`FixedPlanes`, row 0, is no plane with a fall-off: `normal`",
    ),
    "no fall-off": (
        {"SlidingPlanes": [(0, 0, 0, 0, 0, 1, 0)]},
        "`SlidingPlanes`, row 0, is no plane with a fall-off: `falloff`",
    ),
    "six numbers": (
        {"FixedPlanes": [(0, 0, 0, 0, 0, 1)]},
        "`FixedPlanes` must be rows of 7 numbers",
    ),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_limits(case, messages):
    properties, sentence = BAD[case]
    deform, _ = scene()
    assert_fails(configured(deform, **properties), messages, sentence)
