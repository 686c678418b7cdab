"""Control points of a source, and of the deforming filters themselves; and the blend factor."""

import numpy as np
import pytest
from pipelines import Executions, connect, control_points, update, values_of
from vtk_fixtures import DEFORMED, FAST, REST, add_array, make_image

from vtk_mls import CUT_FRAMES
from vtk_mls.filters import MLSControlPoints, MLSDeform, MLSDisplacementField
from vtk_mls.filters.control_point_source import lattice
from vtk_mls.vtk import arrays
from vtk_mls.vtk.objects import configured

FILTERS = pytest.mark.parametrize("filter_type", [MLSDeform, MLSDisplacementField])


@pytest.fixture
def image(rng):
    image = make_image()
    add_array(image.GetPointData(), "value", rng.normal(size=image.GetNumberOfPoints()))
    return image


def alone(filter_type, image, **lists):
    """A filter with handles of its own."""
    return configured(filter_type(), Device="reference", InputData=image, **lists)


def with_handles(filter_type, image, *lists, **settings):
    """A filter with handles on port 1."""
    deforming = connect(filter_type(), image, control_points(*lists, **settings))
    return configured(deforming, Device="reference")


def result(deforming):
    output = update(deforming)
    return values_of(output, output.GetPointData().GetArrayName(0))


@FILTERS
@pytest.mark.parametrize("offset", [0, 5e5])
def test_nothing_moves_without_handles(filter_type, image, offset):
    image.SetOrigin(offset, 2 * offset, -offset)
    before = values_of(image, "value")
    deforming = alone(filter_type, image)
    expected = before if filter_type is MLSDeform else np.zeros((*before.shape, 3))
    np.testing.assert_array_equal(result(deforming), expected)


@FILTERS
@pytest.mark.parametrize("weights", [(), np.arange(1.0, 9)])
def test_own_handles_are_those_of_a_source(filter_type, image, weights):
    own = alone(filter_type, image, RestPoints=REST, DeformedPoints=DEFORMED, Weights=weights)
    expected = result(with_handles(filter_type, image, REST, DEFORMED, weights=weights))
    np.testing.assert_array_equal(result(own), expected)
    assert np.ptp(expected - result(alone(filter_type, image))) > 1


@FILTERS
def test_a_connected_source_takes_over(filter_type, image):
    lists = {"RestPoints": REST, "DeformedPoints": DEFORMED + 1.0}
    deforming = alone(filter_type, image, **lists)
    own = result(deforming)
    handles = control_points()
    deforming.SetInputConnection(1, handles.GetOutputPort())
    expected = result(with_handles(filter_type, image))
    np.testing.assert_array_equal(result(deforming), expected)
    assert not np.array_equal(own, expected)
    deforming.SetInputConnection(1, None)
    np.testing.assert_array_equal(result(deforming), own)


@FILTERS
def test_a_dragged_handle_is_followed_once(filter_type, image):
    deforming = alone(filter_type, image, RestPoints=REST)
    runs = Executions(deforming)
    rest = result(deforming)
    deforming.SetNumberOfDeformedPoints(len(REST))
    for number, place in enumerate(DEFORMED):
        deforming.SetDeformedPoint(number, *place)
    expected = result(with_handles(filter_type, image))
    np.testing.assert_array_equal(result(deforming), expected)
    assert not np.array_equal(rest, expected)
    assert runs.count == 2


def test_only_handles_at_rest_on_the_cut_itself_do_not_count(image):
    """Their weights go with them; what is dragged, or beside the cut, or beyond its edge counts."""
    deforming = alone(MLSDeform, image, CutType="half-plane", CutOrigin=(4, 4, 3))
    rest = np.vstack([REST, [(4, 1, 6), (4, 7, 6), (4, 1, 1), (4.1, 3, 5)]])
    deformed = np.vstack([DEFORMED, rest[8:]])
    deformed[9] += (0.5, 0, 0)
    counts = np.arange(12) != 8
    weights = np.arange(1.0, 13)

    def outcome(numbers):
        lists = {"RestPoints": rest[numbers], "DeformedPoints": deformed[numbers]}
        return result(configured(deforming, Weights=weights[numbers], **lists))

    everything = outcome(counts | True)
    np.testing.assert_array_equal(everything, outcome(counts))
    for number in range(9, 12):
        assert not np.array_equal(everything, outcome(counts & (np.arange(12) != number)))
    configured(deforming, RestPoints=[(4, 1, 6)], DeformedPoints=(), Weights=())
    np.testing.assert_array_equal(result(deforming), values_of(image, "value"))


@FILTERS
@pytest.mark.parametrize("own", [False, True])
def test_blend_leads_from_rest_to_deformed(filter_type, image, own):
    lists = {"RestPoints": REST, "DeformedPoints": DEFORMED}
    deforming = alone(filter_type, image, **lists) if own else with_handles(filter_type, image)
    whole = result(deforming)
    deforming.SetBlend(0)
    np.testing.assert_array_equal(result(deforming), result(alone(filter_type, image)))
    deforming.SetBlend(0.25)
    expected = result(with_handles(filter_type, image, REST, REST + 0.25 * (DEFORMED - REST)))
    np.testing.assert_allclose(result(deforming), expected, atol=1e-5)
    deforming.SetBlend(1)
    np.testing.assert_array_equal(result(deforming), whole)


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
    cutting = {"CutFrame": frame, "CutType": cut, "CutOrigin": middle}
    deforming = configured(alone(MLSDeform, image, RestPoints=rest, **cutting), Device=FAST)
    voids = []
    for way in (-4, 4):
        deformed = rest.copy()
        deformed[number, 0] += way
        deforming.SetDeformedPoints(deformed)
        voids.append(values_of(update(deforming), "VoidDistance") < -0.1)
    assert voids[0].sum() > 50
    np.testing.assert_array_equal(voids[0], voids[1][:, :, ::-1])


# MLSControlPoints makes the polydata that the other filters read


def test_explicit_points(rng):
    rest, deformed = rng.normal(size=(2, 5, 3)) * 1e-9 + 5e5
    source = control_points(rest, deformed)
    output = update(source)
    p, q, weights = arrays.control_points(output, "Displacement")
    np.testing.assert_array_equal(p, rest)
    np.testing.assert_array_equal(q, deformed)
    assert weights is None
    assert output.GetPointData().GetNumberOfArrays() == 1
    assert output.GetPointData().GetVectors().GetName() == "Displacement"
    assert output.GetNumberOfVerts() == output.GetNumberOfCells() == 5
    assert [output.GetCell(i).GetPointId(0) for i in range(5)] == list(range(5))
    source.SetWeights([1, 2, 3, 4, 5])
    weights = update(source).GetPointData().GetArray("Weight")
    assert arrays.to_numpy(weights).tolist() == [1, 2, 3, 4, 5]


def test_nothing_moves_without_deformed_points():
    source = MLSControlPoints()
    assert update(source).GetNumberOfPoints() == 0
    source.SetRestPoints([(1, 2, 3), (4, 5, 6)])
    displacement = update(source).GetPointData().GetArray("Displacement")
    np.testing.assert_array_equal(arrays.to_numpy(displacement), np.zeros((2, 3)))


def test_lattice():
    source = configured(MLSControlPoints(), Mode="lattice", LatticeDimensions=(2, 3, 1))
    source.SetBounds(0, 1, 0, 4, -3, 5)
    p, _, _ = arrays.control_points(update(source), "Displacement")
    expected = [(0, 0), (1, 0), (0, 2), (1, 2), (0, 4), (1, 4)]
    np.testing.assert_array_equal(p, [(x, y, 1) for x, y in expected])
    moved = p + [0, 0, 1]
    source.SetDeformedPoints(moved)
    _, q, _ = arrays.control_points(update(source), "Displacement")
    np.testing.assert_array_equal(q, moved)


def test_arrows_lead_from_rest_to_deformed():
    source = MLSControlPoints()
    source.SetRestPoints([(0, 0, 0), (5, 5, 5), (1, 2, 3)])
    assert update(source).GetNumberOfPoints() == 3
    assert source.GetOutputDataObject(1).GetNumberOfPoints() == 0
    source.SetDeformedPoints([(0, 0, 0), (np.nan, 5, 5), (1, 2, 7)])
    update(source)
    arrows = source.GetOutputDataObject(1)
    assert arrows.GetNumberOfPolys() > 0
    np.testing.assert_allclose(arrows.GetBounds()[4:], (3, 7))
    np.testing.assert_allclose(arrows.GetCenter()[:2], (1, 2), atol=0.01)
    assert arrows.GetPointData().GetArray("Displacement").GetRange(2) == (4, 4)
