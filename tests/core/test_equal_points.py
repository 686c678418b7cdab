"""Equal points have equal answers, to the bit, whatever else is asked in the same call."""

import numpy as np
import pytest
from control_point_sets import EVERYWHERE, EXTENT, deformation, random_handles
from cut_shapes import SHAPES
from pairwise import paired, rare

from vtk_mls.engine import dispatch
from vtk_mls.engine import opencl_engine as engine

CUTS = {"none": ()} | {name: SHAPES[name] for name in ("half-plane", "polygon", "plane")}
KINDS = [("rigid", 1), ("affine", 1), ("similarity", 1), ("polynomial", 2), ("polynomial", 3)]
# Control points moved past each other, so that some points have no inverse.
SHIFT = 14


def forward(d, points):
    """Displacements and whether they were found (m, 4)."""
    field = d.forward_field(points)
    return np.column_stack([field.displacement, field.found])


QUESTIONS = {
    "forward": forward,
    "backward": lambda d, points: d.backward(points),
    "void distance": lambda d, points: d.void_distance(points),
    "jacobian": lambda d, points: d.jacobian(points),
}


def scattered(rng, count):
    """Points (count, 3) in and around the control points, some of them far away."""
    points = rng.uniform(-0.2 * EXTENT, 1.2 * EXTENT, (count, 3)).astype(np.float32)
    points[:4] *= np.float32([[3], [30], [1e4], [1e7]])
    return points


def calls(points, rng):
    """Arrays of points, and for each of them the row of `points` that it is equal to."""
    rows = np.arange(len(points))
    shuffled, repeated = rng.permutation(rows), rng.integers(0, len(rows), 3 * len(rows))
    for some in (shuffled, repeated, rows[3:20], rows[:1], rows[::-1][:33], *rows[5:9, None]):
        yield points[some], some
    yield points.astype(np.float64), rows
    yield np.asfortranarray(points), rows


def assert_equal_bits(got, expected):
    assert got.dtype == expected.dtype
    np.testing.assert_array_equal(got, expected)


@paired(
    question=QUESTIONS,
    cuts=CUTS,
    cut_frame=["rest", "deformed"],
    kind_and_degree=KINDS,
    alpha=[2, *rare(1, 1.3)],
    device=EVERYWHERE,
)
def test_for_any_other_points(question, cuts, cut_frame, kind_and_degree, alpha, device, rng):
    """Other orders, single points, repeated ones, and the same numbers in another type."""
    options = {"alpha": alpha, "cuts": CUTS[cuts], "cut_frame": cut_frame}
    # the specification takes seconds for each point that it loses
    is_slow = device == "reference"
    d = deformation(
        *random_handles(rng, 40, 2 if is_slow else SHIFT), kind_and_degree, device, **options
    )
    points, ask = scattered(rng, 500), QUESTIONS[question]
    if is_slow:
        points = points[4:40]
    whole = ask(d, points)
    for some, rows in calls(points, rng):
        assert_equal_bits(ask(d, some), whole[rows])


@paired(question=QUESTIONS, cuts=CUTS, kind_and_degree=KINDS)
def test_few_and_many(question, cuts, kind_and_degree, key, rng):
    d = deformation(*random_handles(rng, 40, SHIFT), kind_and_degree, key, cuts=CUTS[cuts])
    points, ask = scattered(rng, 150_000), QUESTIONS[question]
    whole = ask(d, points)
    rows = rng.permutation(len(points))[:300]
    assert_equal_bits(ask(d, points[rows]), whole[rows])


@pytest.mark.parametrize("cuts", CUTS)
def test_little_memory(cuts, key, rng, monkeypatch):
    d = deformation(*random_handles(rng, 40, SHIFT), ("rigid", 1), key, cuts=CUTS[cuts])
    points = scattered(rng, 20_000)
    expected = [ask(d, points) for ask in QUESTIONS.values()]
    monkeypatch.setattr(engine.on(dispatch.choose(key)).memory, "limit", 4 * 64 * 1024)
    for ask, whole in zip(QUESTIONS.values(), expected):
        assert_equal_bits(ask(d, points), whole)
