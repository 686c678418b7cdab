"""Names of landmarks on both sides, in 3-D views and slices: none over another."""

from __future__ import annotations

import numpy as np
import pytest
from hands import SIZE, Hands, ball_mesh

from vtk_mls.editor import State

_MIDDLE = (SIZE - 1) / 2
_BLANK = "\N{NO-BREAK SPACE}"
_NAMES = "frontal", "insula"


@pytest.mark.parametrize("selected", [0, 1])
def test_of_names_that_overlap_that_of_the_selected_landmark_is_drawn(selected):
    points = _MIDDLE + np.array([(0.0, 0, 0), (0.3, 0, 0)])
    state = State(points, points, labels=("", ""), device="reference")
    hands = Hands(ball_mesh(), state, target=ball_mesh(), pixels=480)
    hands.press("m")
    hands.editor.select([selected])
    pictures = {}
    for labels in (_NAMES, (_BLANK,) * 2, (_NAMES[0], _BLANK), (_BLANK, _NAMES[1])):
        hands.editor.change(hands.state.changed(labels=labels))
        pictures[labels] = hands.picture()
    alone = tuple(name if row == selected else _BLANK for row, name in enumerate(_NAMES))
    np.testing.assert_array_equal(pictures[_NAMES], pictures[alone])
    is_name = (pictures[alone] != pictures[(_BLANK,) * 2]).any(axis=2)
    for quarter in (is_name[:240, :240], is_name[:240, 240:], is_name[240:, :240]):
        assert quarter.any()


def test_a_name_follows_the_camera():
    place = np.full(3, _MIDDLE)
    state = State([place], [place], labels=[""], device="reference")
    hands = Hands(ball_mesh(), state, target=ball_mesh(), pixels=480)
    view, where = hands.editor.view, []
    for look_at in (place, place + (0, 0, 5)):
        view.center_on(look_at)
        pictures = []
        for name in ("insula", _BLANK):
            hands.editor.change(hands.state.changed(labels=[name]))
            pictures.append(hands.picture())
        is_name = (pictures[0] != pictures[1]).any(axis=2)
        is_name[:, 240:] = False  # the target
        where.append((np.mean(np.nonzero(is_name)[::-1], axis=1), hands.pixels(place[None])[0, :2]))
    (first, first_pixel), (second, second_pixel) = where
    np.testing.assert_allclose(second - first, second_pixel - first_pixel, atol=2)
