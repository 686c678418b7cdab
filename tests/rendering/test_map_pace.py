"""Maps are as fine as the mouse allows."""

import pytest

from vtk_mls.rendering.map_pace import MapPace


@pytest.mark.parametrize(
    ("seconds", "moving", "resting"),
    [(0.008, 64, 128), (0.06, 64, 128), (0.48, 32, 72), (60, 24, 64)],
)
def test_nodes_follow_what_the_last_map_took(seconds, moving, resting):
    pace = MapPace(most=128)
    pace.note_map(64, seconds)
    assert (pace.nodes_while_moving(), pace.nodes_at_rest()) == (moving, resting)


def test_before_the_first_map_they_are_as_many_as_may_be():
    pace = MapPace(most=128)
    assert (pace.nodes_while_moving(), pace.nodes_at_rest()) == (64, 128)
