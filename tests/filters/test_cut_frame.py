"""The property CutFrame: cuts that the material takes along, or that stay where they are."""

import numpy as np
import pytest
from pipelines import update, values_of
from vtk_fixtures import FAST, make_image

from vtk_mls import CUT_FRAMES
from vtk_mls.filters import MLSDeform
from vtk_mls.filters.control_point_source import lattice


@pytest.mark.parametrize("cut", ["plane", "half-plane"])
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
