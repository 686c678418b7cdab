"""Progress grows to 1, which it reaches once, and each time the callback can stop the work."""

from dataclasses import replace

import numpy as np
import pytest
from control_point_sets import DEVICES, EVERYWHERE, random_handles

from vtk_mls import Aborted, Deformation, Grid, HalfPlane, Sampling
from vtk_mls.base.progress import whole
from vtk_mls.engine import dispatch
from vtk_mls.engine import opencl_engine as engine

GRID = Grid((15, 14, 12), spacing=(18, 19, 23))
TARGET = Grid((17, 13, 10), (10, 9, 8), (14, 18, 23))
IMAGE = np.sin(GRID.points() @ [0.03, 0.02, 0.04]).reshape(GRID.shape).astype(np.float32)
VECTORS = np.stack([IMAGE, 2 * IMAGE, 1 - IMAGE], axis=-1)
SAMPLING = Sampling(GRID, TARGET)
POINTS = TARGET.points()

QUESTIONS = {
    "backward": lambda d, progress: d.backward(POINTS, progress),
    "forward": lambda d, progress: d.forward(POINTS, progress),
    "forward_field": lambda d, progress: d.forward_field(POINTS, progress).displacement,
    "jacobian": lambda d, progress: d.jacobian(POINTS, progress),
    "void_distance": lambda d, progress: d.void_distance(POINTS, progress),
    "overlap": lambda d, progress: replace(d, cut_frame="rest").overlap(POINTS, progress),
    "overlap_field": lambda d, progress: replace(d, cut_frame="rest").overlap_field(GRID, progress),
    "void": lambda d, progress: d.void(POINTS, progress),
    "displacement_field": lambda d, progress: (
        d.displacement_field(GRID, progress=progress).displacement
    ),
    "void_distance_field": lambda d, progress: d.void_distance_field(GRID, progress),
    "void_field": lambda d, progress: d.void_field(GRID, progress),
    "void_of_cells": lambda d, progress: np.array(d.void_of_cells(GRID, progress=progress)),
    "jacobian_field": lambda d, progress: d.jacobian_field(GRID, progress),
    "resample": lambda d, progress: np.array(d.resample([IMAGE, IMAGE], SAMPLING, progress)),
    "source_bounds": lambda d, progress: np.array(d.source_bounds(SAMPLING, progress)),
    "resample_gradients": lambda d, progress: d.resample_gradients(
        VECTORS, SAMPLING, progress=progress
    ),
    "resample_vectors": lambda d, progress: d.resample_vectors(VECTORS, SAMPLING, progress),
    "corrected_gradient": lambda d, progress: d.corrected_gradient(
        IMAGE, SAMPLING, progress=progress
    ),
    "resample_with_gradient": lambda d, progress: d.resample_with_gradient(
        [IMAGE], IMAGE, SAMPLING, progress=progress
    )[1],
    "without_folds": lambda d, progress: d.without_folds(None, progress).steps,
    "certificate": lambda d, progress: d.certificate(GRID, progress).checked,
    "fitted_grid": lambda d, progress: d.fitted_grid(GRID, progress).points(0, 9),
}


@pytest.fixture(params=EVERYWHERE)
def device(request, monkeypatch):
    """A device on which everything takes some steps."""
    monkeypatch.setattr("vtk_mls.reference.reference_engine._MAX_VALUES", 1 << 15)
    monkeypatch.setattr("vtk_mls.queries.fields.MAX_SLAB_POINTS", 900)
    monkeypatch.setattr("vtk_mls.queries.arrival.FITTED_SAMPLES", 14)
    if request.param != "reference":
        chosen = engine.on(dispatch.choose(request.param))
        monkeypatch.setattr(chosen.memory, "limit", 4 * 12 * 1024)
    return request.param


@pytest.fixture
def deformation(device, rng):
    rest, deformed = random_handles(rng, 12, 4)
    cut = HalfPlane((128, 128, 128), (0.2, 0.1, 1), (1, 0.3, 0))
    # without a search for the origin of each point, which takes most of the reference's time
    frame = "deformed" if device == "reference" else "rest"
    return Deformation(rest, deformed, cuts=[cut], cut_frame=frame, device=device)


class Callback:
    """Records its fractions, and stops at the call `last`."""

    def __init__(self, last=None):
        self.last, self.fractions = last, []

    def __call__(self, fraction):
        self.fractions.append(fraction)
        return len(self.fractions) == self.last


def assert_grows_to_one(fractions):
    assert fractions[0] == 0
    assert fractions == sorted(fractions)
    assert fractions.index(1) == len(fractions) - 1


@pytest.mark.parametrize("question", QUESTIONS)
def test_progress_of_every_method(question, deformation):
    complete = Callback()
    expected = QUESTIONS[question](deformation, complete)
    assert_grows_to_one(complete.fractions)
    assert len(set(complete.fractions)) > 3
    calls = len(complete.fractions)
    for last in sorted({1, calls // 2, calls - 1, calls}):
        stopping = Callback(last)
        with pytest.raises(Aborted, match="as `progress` asked"):
            QUESTIONS[question](deformation, stopping)
        assert stopping.fractions == complete.fractions[:last]
    np.testing.assert_array_equal(QUESTIONS[question](deformation, None), expected)


@pytest.mark.parametrize("device", DEVICES, indirect=True)
def test_progress_of_devices(deformation):
    for question in ("backward", "jacobian", "displacement_field", "jacobian_field", "resample"):
        test_progress_of_every_method(question, deformation)


def test_all_methods_are_covered():
    public = {name for name in dir(Deformation) if callable(getattr(Deformation, name))}
    public = {name for name in public if not name.startswith("_")}
    # residuals are `backward` at the control points
    assert public - {"residuals", "in_steps"} == {*QUESTIONS}


def test_work_on_nothing_ends_too():
    d = Deformation(np.eye(3), np.eye(3) + 1, device="reference")
    for question in (d.backward, d.forward, d.jacobian, d.void):
        complete = Callback()
        question(np.empty((0, 3)), complete)
        assert complete.fractions[-1] == 1
        assert complete.fractions.count(1) == 1
    complete = Callback()
    d.void_distance_field(Grid((2, 3, 4)), complete)  # there is no cut
    assert complete.fractions == [1]


def test_parts_of_parts_grow_to_one(rng):
    def work(progress, depth):
        parts = progress.divided(*rng.uniform(0.1, 3, rng.integers(1, 5)))
        for part in parts:
            if depth:
                work(part, depth - 1)
            else:
                assert list(part.over("abc")) == ["a", "b", "c"]

    for _ in range(50):
        complete = Callback()
        with whole(complete) as progress:
            work(progress, 3)
        assert_grows_to_one(complete.fractions)
        distinct = len(set(complete.fractions))
        assert distinct == len(complete.fractions) or distinct > 3


def test_a_work_that_begins_again_does_not_fall_back():
    complete = Callback()
    with whole(complete) as progress:
        for _ in range(2):
            for _ in progress.over(range(4)):
                pass
    assert complete.fractions == [0, 0.25, 0.5, 0.75, 0.75, 0.75, 0.75, 0.75, 1]


def test_a_part_of_a_work_does_not_end_it():
    complete = Callback()
    with whole(complete) as progress:
        first, second = progress.divided(1, 3)
        for part in (first, second):
            with whole(part) as same:
                assert same is part
                same.report(0.5)
    assert complete.fractions == [0.125, 0.625, 1]


def test_an_error_is_no_end():
    complete = Callback()
    with pytest.raises(ZeroDivisionError), whole(complete) as progress:
        progress.report(1 / 0)
    assert complete.fractions == []
