"""Parts get the values of the whole, to the bit: of a grid, and among any other points."""

import numpy as np
import pytest
from control_point_sets import (
    EVERYWHERE,
    EXTENT,
    HARD_SETS,
    KINDS_AND_DEGREES,
    block,
    deformation,
    random_handles,
    random_rotation,
)
from cut_shapes import SHAPES
from pairwise import paired, rare

from vtk_mls import INTERPOLATIONS, Grid, HalfPlane, Plane, Sampling, Surface
from vtk_mls.engine import dispatch
from vtk_mls.engine import opencl_engine as engine
from vtk_mls.engine.device.devices import Device

WHOLE = (37, 22, 19)
PARTS = [  # first index and dimensions
    ((0, 0, 0), (37, 22, 10)),
    ((0, 0, 10), (37, 22, 9)),
    ((5, 3, 2), (11, 18, 17)),
    ((36, 21, 18), (1, 1, 1)),
    ((13, 0, 18), (24, 1, 1)),
]
PART_CUTS = {
    "none": (),
    "plane": (Plane((100, 120, 130), (0.2, 1, 0.1)),),
    "half-plane and surface": (
        HalfPlane((128, 128, 128), (0.2, 0.1, 1), (1, 0.3, 0)),
        Surface.polygon([(20, 60, 90), (200, 60, 95), (190, 70, 220), (30, 66, 200)]),
    ),
}


@pytest.fixture
def grid(rng):
    size = 256 / np.array(WHOLE)
    return Grid(WHOLE, (3.3, -2.1, 5.7), size, random_rotation(rng) * [1, 1, -1])


def needed(d, source, target, reach):
    """The part of `source` that interpolation needs for `target`, and where it lies."""
    low, high = d.source_bounds(Sampling(source, target))
    if not np.isfinite(low).all():
        low = high = np.zeros(3)
    size = np.array(source.dimensions)
    low = np.clip(np.floor(low - 1e-3) - reach, 0, size - 1).astype(int)
    high = np.clip(np.ceil(high + 1e-3) + reach, 0, size - 1).astype(int)
    return source.part(low, high - low + 1), block(low, high - low + 1)


@paired(
    kind_and_degree=[("rigid", 1), *rare(*KINDS_AND_DEGREES[1:])],
    cuts=PART_CUTS,
    lanes=["vectors", *rare("scalars")],
    alpha=[2, *rare(3)],
)
def test_a_part_is_the_whole_to_the_bit(
    key, kind_and_degree, cuts, lanes, alpha, grid, rng, monkeypatch
):
    """With alpha 3 rotations are fitted again at some places and not at others, side by side."""
    if lanes == "scalars":
        monkeypatch.setattr(Device, "lanes", property(lambda self: 1))
    options = {"alpha": alpha, "cuts": PART_CUTS[cuts]}
    check(deformation(*random_handles(rng, 15), kind_and_degree, key, **options), grid)


@pytest.mark.parametrize("hard", HARD_SETS)
def test_hard_sets_too(key, hard, grid, rng):
    rest, deformed = HARD_SETS[hard](rng)
    if hard.startswith("at "):
        size = np.ptp(deformed, axis=0).max() / 256
        grid = Grid(WHOLE, deformed.min(axis=0), size * grid.spacing, grid.direction)
    d = deformation(rest, deformed, ("rigid", 1), key)
    check(d, grid, PARTS[:3] if len(rest) < 1000 else PARTS[2:3])


def check(d, grid, parts=PARTS):
    field, jacobian = d.displacement_field(grid), d.jacobian_field(grid)
    image = np.random.default_rng(1).normal(size=grid.shape).astype(np.float32)
    resampled = {i: d.resample([image], Sampling(grid, interpolation=i))[0] for i in INTERPOLATIONS}
    for first, dimensions in parts:
        part, target_block = grid.part(first, dimensions), block(first, dimensions)
        got = d.displacement_field(part)
        np.testing.assert_array_equal(got.displacement, field.displacement[target_block])
        np.testing.assert_array_equal(d.jacobian_field(part), jacobian[target_block])
        if d.cuts:
            np.testing.assert_array_equal(got.void_distance, field.void_distance[target_block])
        for method, expected in resampled.items():
            source, source_block = needed(d, grid, part, 1 if method == "cubic" else 0)
            (values,) = d.resample([image[source_block]], Sampling(source, part, method))
            np.testing.assert_array_equal(values, expected[target_block], err_msg=method)


@pytest.mark.parametrize("cuts", PART_CUTS)
def test_the_specification_agrees(kind_and_degree, cuts, rng):
    d = deformation(*random_handles(rng, 8), kind_and_degree, cuts=PART_CUTS[cuts])
    grid = Grid((18, 11, 9), (3.3, -2.1, 5.7), (14, 23, 28), random_rotation(rng) * [1, 1, -1])
    first, dimensions = (3, 2, 1), (6, 8, 7)
    part, target_block = grid.part(first, dimensions), block(first, dimensions)
    got = d.displacement_field(part).displacement
    np.testing.assert_allclose(
        got, d.displacement_field(grid).displacement[target_block], rtol=0, atol=1e-5
    )
    image = rng.normal(size=grid.shape)
    source, source_block = needed(d, grid, part, 1)
    (values,) = d.resample([image[source_block]], Sampling(source, part, "cubic"))
    (expected,) = d.resample([image], Sampling(grid, interpolation="cubic"))
    np.testing.assert_allclose(values, expected[target_block], rtol=0, atol=1e-9)


def test_bounds_of_the_needed_part(device):
    shift = [(3.25, 0, -1.5)]
    d = deformation(np.add(shift, 5), [(5, 5, 5)], ("rigid", 1), device)
    grid = Grid((20, 21, 22))
    low, high = d.source_bounds(Sampling(grid, grid.part((2, 4, 6), (3, 4, 5))))
    np.testing.assert_allclose([low, high], [(5.25, 4, 4.5), (7.25, 7, 8.5)], atol=1e-5)
    # beyond the source, and as far as its border continues
    low, high = d.source_bounds(Sampling(grid, grid.part((10, 4, 0), (10, 1, 3))))
    np.testing.assert_allclose([low, high], [(13.25, 4, -0.5), (19.25, 4, 0.5)], atol=1e-5)
    low, high = d.source_bounds(Sampling(grid, grid.part((17, 4, 6), (3, 4, 5))))
    assert (low == np.inf).all()
    assert (high == -np.inf).all()


def test_parts_of_parts(grid):
    part = grid.part((2, 3, 4), (9, 8, 7)).part((1, 1, 1), (2, 2, 2))
    assert part.whole is grid
    assert part.first == (3, 4, 5)
    np.testing.assert_array_equal(part.points(), grid.at(part.indices() + part.first))
    with pytest.raises(ValueError, match=r"`first` and `dimensions` must select a part of the"):
        grid.part((0, 0, 18), (2, 2, 2))


# Equal points have equal answers, whatever else is asked in the same call

CUTS = {"none": ()} | {name: SHAPES[name] for name in ("half-plane", "polygon", "plane")}
KINDS = [
    ("rigid", 1),
    ("affine", 1),
    *rare(("similarity", 1), ("polynomial", 2), ("polynomial", 3)),
]
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
