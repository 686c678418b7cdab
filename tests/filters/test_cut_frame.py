"""The property CutFrame: cuts that the material takes along, or that stay where they are."""

import numpy as np
import pytest
from pipelines import connect, control_points, update, values_of
from vtk_fixtures import FAST, add_array, make_image

from vtk_mls import CUT_FRAMES, Deformation, HalfPlane, Plane, Sampling
from vtk_mls.filters import MLSDeform, MLSDisplacementField
from vtk_mls.filters.control_point_source import lattice
from vtk_mls.vtk.arrays import ImageGeometry

# Material on both sides of x = 3.9 is moved across it.
REST = np.array([(2.0, 3.0, 5.0), (6.0, 3.0, 5.0), (2.0, 3.0, 1.0), (6.0, 3.0, 1.0)])
MOVED = REST + (1.3, 0, 0)
CUTS = {
    "plane": Plane((3.9, 3, 2.6), (1, 0, 0)),
    "half-plane": HalfPlane((3.9, 3, 2.6), (1, 0, 0), (0, 0, 1)),
}
BOTH = pytest.mark.parametrize("kind", [MLSDeform, MLSDisplacementField])
EACH_CUT = pytest.mark.parametrize("cut", CUTS)


def scene(kind, cut, device=FAST, deformed=MOVED):
    """A filter on an image that is cut."""
    image = make_image()
    x, y, z = ImageGeometry.of_image(image).grid.points().T
    add_array(image.GetPointData(), "values", 5 + np.sin(0.3 * x) + 0.2 * y * z)
    deforming = kind()
    deforming.SetDevice(device)
    deforming.SetCutType(cut)
    deforming.SetCutOrigin(CUTS[cut].point)
    deforming.SetCutNormal(CUTS[cut].normal)
    return connect(deforming, image, control_points(REST, deformed))


@EACH_CUT
@pytest.mark.parametrize("frame", CUT_FRAMES)
def test_both_filters_ask_the_deformation_of_the_frame(device, cut, frame):
    value = Deformation(REST, MOVED, cuts=CUTS[cut], cut_frame=frame, device=device)
    for kind in (MLSDeform, MLSDisplacementField):
        deforming = scene(kind, cut, device)
        deforming.SetCutFrame(frame)
        output = update(deforming)
        grid = ImageGeometry.of_image(output).grid
        distance = value.void_distance_field(grid)
        np.testing.assert_array_equal(values_of(output, "VoidDistance"), distance)
        assert (values_of(output, "Void") > 0).any() == (frame == "deformed")
        if kind is MLSDeform:
            source = values_of(deforming.GetInputDataObject(0, 0), "values")
            (expected,) = value.resample([source], Sampling(grid))
            np.testing.assert_array_equal(values_of(output, "values"), expected)
        else:
            field = value.displacement_field(grid.dimensions, grid.origin, grid.spacing)
            np.testing.assert_array_equal(
                values_of(output, "BackwardDisplacement"), field.displacement
            )


@BOTH
def test_a_frame_that_does_not_exist_is_one_sentence(kind, messages):
    deforming = scene(kind, "plane")
    for wrong in ("world", 3, None):
        deforming.SetCutFrame(wrong)
        assert not deforming.GetExecutive().Update()
        messages.assert_one(f"`CutFrame` must be one of rest, deformed, got {wrong!r}")
    deforming.SetCutFrame("rest")
    update(deforming)


@EACH_CUT
@pytest.mark.parametrize("frame", CUT_FRAMES)
def test_a_handle_that_is_dragged_off_the_cut_takes_that_side_along(cut, frame):
    """Its rest position, on the cut, does not tell the side."""
    image = make_image((20, 20, 20))  # no point is on the cut
    bounds = np.array(image.GetBounds())
    middle = bounds.reshape(3, 2).mean(axis=1)
    rest = lattice((3, 3, 3), bounds)
    number = len(rest) // 2 + 9  # in the middle of the upper side
    assert (rest[number] == [*middle[:2], bounds[5]]).all()
    deforming = MLSDeform()
    deforming.SetDevice(FAST)
    deforming.SetInputData(image)
    deforming.SetCutFrame(frame)
    deforming.SetCutType(cut)
    deforming.SetCutOrigin(middle)
    deforming.SetRestPoints(rest)
    voids = []
    for way in (-4, 4):
        deformed = rest.copy()
        deformed[number, 0] += way
        deforming.SetDeformedPoints(deformed)
        voids.append(values_of(update(deforming), "VoidDistance") < -0.1)
    assert voids[0].sum() > 50
    np.testing.assert_array_equal(voids[0], voids[1][:, :, ::-1])
