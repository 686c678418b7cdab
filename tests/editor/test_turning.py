"""Handles that a box turns together, and their path."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from hands import MIDDLE, Hands, ball_mesh

from vtk_mls import CurveHandle
from vtk_mls.editor import State

TURNED = 9  # handles of the lattice in the upper half
FREE_PIXELS = 10  # from a handle, which the mouse would take


@pytest.fixture
def hands():
    """A ball whose upper handles can be turned."""
    hands = Hands(ball_mesh(), pixels=400)
    hands.editor.select(np.flatnonzero(hands.state.rest[:, 2] > MIDDLE + 1))
    assert len(hands.editor.selected) == TURNED
    hands.press("u")
    return hands


def turn(hands, by):
    """Drag the box from a pixel near its middle, beside handles."""
    (x, y, _), *_ = hands.pixels(hands.editor.document.group.bounds.mean(axis=0)[None])
    pixels = np.stack(np.meshgrid(x + np.arange(-40, 41, 4), y + np.arange(-12, 13, 4)), axis=-1)
    pixels = pixels.reshape(-1, 2)
    handles = hands.pixels(hands.state.deformed)[:, :2]
    distances = np.linalg.norm(pixels[:, None] - handles, axis=2).min(axis=1)
    free = pixels[distances > FREE_PIXELS]
    hands.drag(min(free, key=lambda p: np.hypot(*(p - (x, y)))), by, steps=20)


def angles(places):
    """Of the rotations from each of the places (k, n, 3) to the next, in degrees."""
    found = []
    for before, after in itertools.pairwise(places):
        covariance = (after - after.mean(axis=0)).T @ (before - before.mean(axis=0))
        left, _, right = np.linalg.svd(covariance)
        found.append(np.degrees(np.arccos(np.clip((np.trace(left @ right) - 1) / 2, -1, 1))))
    return np.array(found)


def test_turns_add_up_to_more_than_a_whole_one(hands):
    rows, rest = hands.editor.selected, hands.state.rest
    for _ in range(5):
        turn(hands, (120, 0))
    state = hands.state
    places = np.stack([rest, *state.path, state.deformed])
    steps = angles(places[:, rows])
    assert steps.sum() > 360
    assert steps.max() < 15.1
    # the shape of the group stays, and the others rest
    sides = np.linalg.norm(places[:, rows] - places[:, np.roll(rows, 1)], axis=2)
    np.testing.assert_allclose(sides, sides[:1].repeat(len(sides), axis=0), rtol=1e-6)
    others = np.setdiff1d(np.arange(len(state)), rows)
    np.testing.assert_allclose(places[:, others], rest[others][None].repeat(len(places), 0))
    deformation = state.deformation()
    assert deformation.steps_used >= len(places) - 1
    assert deformation.smallest_determinant > 0
    hands.press("z")
    assert len(hands.state.path) < len(state.path)
    hands.press("y")
    np.testing.assert_array_equal(hands.state.path, state.path)
    hands.press("0")
    assert len(hands.state.path) == 0
    assert hands.state.is_identity


def test_turning_back_takes_the_path_back(hands):
    group = hands.editor.document.group
    quarter = np.eye(4)
    for degrees in (*range(0, 95, 5), *range(90, 35, -5)):
        c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
        quarter[:2, :2] = (c, -s), (s, c)
        group.turn_to(quarter.copy())
    state = group.turned(hands.state)
    places = np.stack([state.rest, *state.path, state.deformed])[:, group.rows]
    assert angles(places).sum() == pytest.approx(40, abs=1e-6)


def test_a_slight_turn_has_no_path(hands):
    turn(hands, (8, 0))
    assert len(hands.state.path) == 0
    assert not hands.state.is_resting[hands.editor.selected].any()
    hands.editor.select([0, 1])
    assert hands.editor.document.group is None


def test_nodes_of_curves_do_not_turn():
    curve = CurveHandle([(5, 5, 5), (9, 9, 9)], [(5, 5, 5), (9, 9, 9)])
    hands = Hands(ball_mesh(), State([(4, 4, 4)], [(5, 4, 4)], handles=[curve]))
    hands.press("a", "Ctrl")
    hands.press("u")
    assert "Only point handles" in hands.message


def test_edits_keep_the_path(rng):
    rest = rng.random((4, 3))
    path = rest + rng.random((3, 4, 3))
    state = State(rest, rest + 1, path=path)
    moved = state.moved([1], [rest[1] + 2])
    np.testing.assert_allclose(moved.path[:, 1] - path[:, 1], [[k / 4] * 3 for k in (1, 2, 3)])
    np.testing.assert_array_equal(moved.path[:, [0, 2, 3]], path[:, [0, 2, 3]])
    pulled = state.with_rest(2, rest[2] - 1)
    np.testing.assert_allclose(pulled.path[:, 2] - path[:, 2], [[-k / 4] * 3 for k in (3, 2, 1)])
    more = state.with_handle((0, 0, 0), (4, 0, 0))
    np.testing.assert_allclose(more.path[:, 4], [(1, 0, 0), (2, 0, 0), (3, 0, 0)])
    np.testing.assert_array_equal(state.without([0, 3]).path, path[:, 1:3])
    left_out = state.with_enabled([0], False).deformation()
    np.testing.assert_array_equal(left_out.path, path[:, 1:])
