"""Pairs of landmarks as data: placed, renamed, left out, deleted, undone, restored."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from hands import SIZE, Hands, ball_image, ball_mesh
from pairwise import one_of

from vtk_mls import Ball, Deformation, Plane, RegionHandle
from vtk_mls.editor import State
from vtk_mls.editor.autosave import Autosave
from vtk_mls.editor.matching.pairs import MOVING, TARGET, table_of, with_pair
from vtk_mls.editor.matching.target import MODES, Target
from vtk_mls.landmarks import report


def state_of(rng, count=8, **options):
    rest = rng.uniform(0, 10, (count, 3))
    return State(rest, rest + rng.normal(0, 1, (count, 3)), device="reference", **options)


def test_names_stay_when_pairs_are_deleted():
    state = State([], [])
    for number in range(3):
        state = with_pair(state, (number, 0, 0), (number, 1, 0))
    state = with_pair(state.without([0]), (5, 0, 0), (5, 1, 0))
    assert len(set(state.labels)) == 3
    assert state.labels[:2] == ("2", "3")


def test_pairs_that_are_off_do_not_move_anything(rng):
    state, points = state_of(rng, weights=rng.uniform(1, 2, 8)), rng.uniform(0, 10, (20, 3))
    off = state.with_enabled([2, 5], False)
    np.testing.assert_array_equal(
        off.deformation().backward(points), state.without([2, 5]).deformation().backward(points)
    )
    assert len(off) == 8
    assert state.with_enabled(range(8), False).is_identity


def test_the_table_has_the_errors_of_maps_without_each_pair(rng):
    state = state_of(rng).with_enabled([3], False)
    table = table_of(state)
    used = [i for i in range(8) if i != 3]
    for i in used:
        others = [j for j in used if j != i]
        options = {"alpha": state.alpha, "device": "reference"}
        value = Deformation(state.rest[others], state.deformed[others], **options)
        error = np.linalg.norm(value.backward(state.deformed[[i]]) - state.rest[i])
        assert table.errors[i] == pytest.approx(error)
    assert np.isnan(table.errors[3])
    assert table.median_error == pytest.approx(np.median(table.errors[used]))


def test_pairs_have_no_errors_if_the_map_depends_on_more_than_pairs(rng):
    region = RegionHandle(Ball((0, 0, 0), 1), np.eye(4))
    others = {"cuts": [Plane((0, 0, 0), (1, 0, 0))], "handles": [region]}
    for name, value in {**others, "deformed": np.ones((8, 3))}.items():
        table = table_of(state_of(rng).changed(**{name: value}))
        assert table.median_error is None
        assert np.isnan(table.errors).all()


@pytest.mark.parametrize("count", [4, 5, 30])
def test_automatic_splines_begin_with_five_pairs_and_keep_their_settings_in_a_drag(count, rng):
    q = rng.uniform(4, SIZE - 4, (count, 3))
    state = State(q * (1.0, 0.5, 1.5) + rng.normal(0, 0.1, q.shape), q, kind="auto")
    hands = Hands(ball_mesh(), state, target=ball_image(), pixels=120)
    table, document = table_of(state), hands.editor.document
    if count < 5:
        assert table.choice == ""
        assert state.deformation().kind == "rigid"
        return
    deformation = state.deformation()
    assert table.choice.startswith(f"spline of order {deformation.order_used}")
    np.testing.assert_allclose(table.errors, deformation.left_out_errors, rtol=1e-6)
    document.start_drag([0], 0)
    document.drag_to([q[0] + 1])
    settings = document.state.kind, document.state.order, document.state.smoothing
    assert settings == ("spline", deformation.order_used, deformation.smoothing_used)
    document.end_drag()
    assert (hands.state.kind, hands.state.order, hands.state.smoothing) == ("auto", 0, 0)
    np.testing.assert_array_equal(hands.state.deformed[0], q[0] + 1)


def test_outliers_are_those_of_the_report(rng):
    q = rng.uniform(0, 100, (20, 3))
    p = q * (1.05, 0.95, 1) + rng.normal(0, 0.3, q.shape)
    p[7] += 25
    state = State(p, q, device="reference").with_enabled([2], False)
    is_outlier = table_of(state).are_outliers
    assert np.flatnonzero(is_outlier).tolist() == [7]
    used = state.enabled
    np.testing.assert_array_equal(is_outlier[used], report(p[used], q[used]).outlier)
    assert not table_of(state.without(range(17))).are_outliers.any()


def test_wrong_values_are_reported():
    hands = Hands(ball_mesh(), target=ball_image())
    with pytest.raises(ValueError, match="`share` must be a number from 0 to 1, got 2"):
        hands.editor.set_comparison(share=2)


def random_edits(hands, rng):
    """Functions that edit pairs at random, as a table and the mouse do, by their names."""
    editor, keys = hands.editor, ["z", "y", "Escape", "z", "k", "b", "0"]
    targets = itertools.cycle([ball_mesh(), Target(ball_image(), "b.vti"), None])

    def row():
        return rng.choice(len(editor.state), 1, replace=False)

    def place():
        editor.place(MOVING if rng.random() < 0.5 else TARGET, rng.uniform(4, SIZE - 4, 3))

    def replace_target():
        editor.set_target(next(targets))
        editor.set_comparison(mode=str(rng.choice(MODES)))

    return {
        "place": place,
        "rename": lambda: editor.set_name(int(row()[0]), f"n{rng.integers(5)}"),
        "turn_off": lambda: editor.set_enabled(row(), False),
        "turn_on": lambda: editor.set_enabled(row(), True),
        "delete": lambda: editor.delete_pairs(row()),
        "jump": lambda: editor.jump_by(1),
        "press_keys": lambda: hands.press(rng.choice(keys)),
        "replace_target": replace_target,
    }


@pytest.mark.parametrize("seed", one_of(4, range(4)))
def test_no_random_edit_loses_a_pair(seed, tmp_path):
    rng = np.random.default_rng(seed)
    autosave = Autosave("ball.vtp", tmp_path)
    state = State([], [], device="reference")
    hands = Hands(ball_mesh(), state, target=ball_image(), autosave=autosave, pixels=120)
    edits = random_edits(hands, rng)
    needs_rows = {"rename", "turn_off", "turn_on", "delete"}
    names = ["place"] * 5 + [*needs_rows, "jump", "press_keys", "replace_target"]
    for _ in range(25):
        name = str(rng.choice(names))
        before = hands.state
        if name in needs_rows and not len(before):
            continue
        edits[name]()
        after = hands.state
        if name in ("rename", "turn_off", "turn_on", "jump", "replace_target"):
            np.testing.assert_array_equal(after.rest, before.rest)
            np.testing.assert_array_equal(after.deformed, before.deformed)
        if name == "delete":
            assert len(after) == len(before) - 1
        if name == "place":
            assert len(after) == len(before) + 1
        assert len(table_of(after).errors) == len(after)
        offered = Autosave("ball.vtp", tmp_path).offered
        if offered is not None:
            assert offered.labels == after.labels
            assert offered.enabled.tolist() == after.enabled.tolist()
    while hands.message != "There is nothing to undo.":
        hands.press("z")
    assert len(hands.state) == 0
